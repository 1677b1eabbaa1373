#include "viewer/window_inspection.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "render/inspection/light_on_pane.h"
#include "render/reference/path_scene.h"
#include "scenes/angles.h"
#include "scenes/error.h"
#include "scenes/luminance.h"
#include "viewer/inspection_options.h"
#include "viewer/measure/measure_run.h"

namespace maquette {

namespace {

constexpr double kRead_s = 0.4;  // between two readings of the picture
constexpr int kProbePaths = 64, kRegionPaths = 4, kBatches = 8;
constexpr std::size_t kRegionPixels = 600;  // of a region that are traced
constexpr double kDegrees = 180.0 / std::numbers::pi;

std::string text_of(const char* format, double value) {
  char text[96];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string polarised_text(const Polarised& p) {
  char text[96];
  std::snprintf(text, sizeof text, "%.4f (s %.4f, p %.4f)", p.mean(), p.s, p.p);
  return text;
}

std::string name_of(const Scene& scene, const Met& met) {
  if (!met.surface) return "sky";
  std::string text = scene.nodes[static_cast<std::size_t>(met.node)].name;
  if (met.material >= 0 && static_cast<std::size_t>(met.material) < scene.materials.size())
    text += ", " + scene.materials[static_cast<std::size_t>(met.material)].name;
  return text + text_of(", %.3f m", met.distance_m);
}

PathOptions path_options(const FrameRequest& request) {
  PathOptions options;
  options.env_rotation_rad = request.env_rotation_rad;
  options.env_scale = request.env_scale;
  return options;
}

struct LayerMeans {
  Interval reflected, transmitted;
  std::vector<double> reflected_each;  ///< of the pixels, cd/m2
};

/// Path-traced means over pixels, with intervals from independent batches.
LayerMeans trace_means(const PathScene& paths, const FrameRequest& request, const EyeRays& rays,
                       const std::vector<std::size_t>& pixels, const std::vector<Sight>& sights, int count,
                       Polarisation polarisation) {
  std::vector<double> reflected, transmitted;
  std::vector<double> each(pixels.size(), 0.0);
  for (int batch = 0; batch < kBatches; ++batch) {
    const LayerPictures layers =
        trace_layers(paths, path_options(request), rays, pixels, {request.width, request.height}, count,
                     static_cast<std::uint32_t>(batch));
    double r = 0.0, t = 0.0;
    for (std::size_t k = 0; k < pixels.size(); ++k) {
      const int x = static_cast<int>(pixels[k] % static_cast<std::size_t>(request.width)),
                y = static_cast<int>(pixels[k] / static_cast<std::size_t>(request.width));
      const double mirrored =
          luminance(layers.reflected, x, y) * polarisation_factor(sights[k].pane, polarisation, true);
      each[k] += mirrored / kBatches;
      r += mirrored;
      t += luminance(layers.transmitted, x, y) * polarisation_factor(sights[k].pane, polarisation, false);
    }
    reflected.push_back(r / static_cast<double>(pixels.size()));
    transmitted.push_back(t / static_cast<double>(pixels.size()));
  }
  return {confidence_interval(reflected), confidence_interval(transmitted), std::move(each)};
}

/// The contrast that an object of the options' luminance keeps, or what is seen behind these pixels.
std::pair<std::string, std::string> contrast_row(const MeasureOptions& options, const std::vector<Sight>& sights,
                                                 const LayerMeans& means) {
  if (!options.background_cdm2)
    return {"Contrast kept", text_of("%.1f %%", 100.0 * contrast_kept(means.transmitted.mean, means.reflected.mean))};
  double share = 0.0;
  for (std::size_t k = 0; k < sights.size(); ++k)
    share += contrast_kept(*background_through(options, sights[k]), means.reflected_each[k]);
  return {"Contrast kept", text_of("%.1f %%", 100.0 * share / static_cast<double>(sights.size())) + " of " +
                               plain_number(*options.background_cdm2) + " cd/m2"};
}

/// Whether probe and regions tell the same under both.
bool same_figures(const InspectionSetup& a, const InspectionSetup& b) {
  return a.threshold_cdm2 == b.threshold_cdm2 && a.polarisation == b.polarisation &&
         a.background_given == b.background_given && a.background_cdm2 == b.background_cdm2;
}

/// What a region's pixels have.
std::vector<std::pair<std::string, std::string>> statistics_rows(const char* name, const RegionStatistics& s) {
  char middle[128], ends[128];
  std::snprintf(middle, sizeof middle, "mean %s, median %s", plain_number(s.mean).c_str(),
                plain_number(s.median).c_str());
  std::snprintf(ends, sizeof ends, "%s to %s, sigma %s", plain_number(s.min).c_str(), plain_number(s.max).c_str(),
                plain_number(s.sigma).c_str());
  return {{name, middle}, {"", ends}, {"over threshold", text_of("%.1f %%", 100.0 * s.share_over)}};
}

}  // namespace

WindowInspection::~WindowInspection() {
  if (job_) job_->cancel = true;
}

void WindowInspection::take_scene(WindowSession* session, const WindowPicture& picture) {
  if (is_ready(tracing_)) {
    try {
      traced_ = tracing_.get();
    } catch (const std::exception& error) {
      session->add_message(MessageLevel::error, std::string("inspection: ") + error.what());
    }
  }
  const std::uint64_t now = 256 * session->revision() + static_cast<std::uint64_t>(picture.drawn().variant + 1);
  if (revision_ == now || tracing_.valid()) return;
  revision_ = now;
  traced_.reset();
  auto snapshot = std::make_shared<Renderer::PathSnapshot>(session->renderer().path_snapshot());
  tracing_ = std::async(std::launch::async, [snapshot, variant = picture.drawn().variant] {
    Traced traced{std::shared_ptr<const Scene>(snapshot, &snapshot->scene), snapshot->environment, nullptr};
    traced.paths = build_path_scene({.scene = snapshot->scene,
                                     .environment = snapshot->environment,
                                     .variant = variant,
                                     .geometry = &snapshot->geometry,
                                     .library = nullptr});
    return traced;
  });
}

void WindowInspection::read_picture(WindowSession* session, const WindowPicture& picture, double now_s) {
  const bool other = !(seen_ == picture.drawn());
  if (!other && picture.stats()->accumulated_frames == read_frames_) return;
  if (!other && now_s - read_s_ < kRead_s) return;
  seen_ = picture.drawn();
  read_frames_ = picture.stats()->accumulated_frames;
  read_s_ = now_s;
  picture_ = session->renderer().read_radiance();
  colors_stale_ = true;
  if (other) forget_probe();
}

/// What was under the mouse in another picture is not in this one.
void WindowInspection::forget_probe() {
  probed_px_ = glm::ivec2(-1);
  probe_.clear();
}

void WindowInspection::update(WindowSession* session, const WindowPicture& picture, const Rect& rect, glm::vec2 mouse,
                              double now_s) {
  finish_job(session);
  const InspectionView& view = session->state.inspection;
  if (!view.open) return;
  status_.clear();
  if (!picture.still() || session->loading()) {
    status_ = "It waits until nothing moves.";
    forget_probe();
    return;
  }
  take_scene(session, picture);
  read_picture(session, picture, now_s);
  update_texture(view);
  if (!traced_) {
    status_ = "The scene is prepared for its rays ...";
    return;
  }
  const SunPlace sun = find_sun(*traced_->environment, static_cast<double>(picture.drawn().env_rotation_rad));
  sun_ = sun.found ? text_of("Sun: elevation %.1f deg, ", sun.elevation_deg) +
                         text_of("azimuth %.1f deg from +Z towards +X", sun.azimuth_deg)
                   : "";
  probe(*session, picture, rect, mouse);
  measure_regions(*session, picture);
}

void WindowInspection::probe(const WindowSession& session, const WindowPicture& picture, const Rect& rect,
                             glm::vec2 mouse) {
  if (!rect.contains(mouse.x, mouse.y)) return;
  const FrameRequest& request = picture.drawn();
  const glm::ivec2 px(
      std::clamp(static_cast<int>((mouse.x - rect.x) / rect.width * static_cast<float>(request.width)), 0,
                 request.width - 1),
      std::clamp(static_cast<int>((mouse.y - rect.y) / rect.height * static_cast<float>(request.height)), 0,
                 request.height - 1));
  const InspectionView& view = session.state.inspection;
  const bool probed = px == probed_px_ && same_figures(probed_setup_, view);
  if (probed || picture_.width != request.width || picture_.height != request.height) return;
  probed_px_ = px;
  probed_setup_ = view;
  const EyeRays rays = eye_rays(request.camera, request.width, request.height, traced_->paths->bounds);
  const std::size_t pixel =
      static_cast<std::size_t>(px.y) * static_cast<std::size_t>(request.width) + static_cast<std::size_t>(px.x);
  const Sight sight = look_along(*traced_->paths, rays.at(pixel), glm::dvec3(glm::normalize(request.camera.up)));
  const double sum = luminance(picture_, px.x, px.y);
  char text[96];
  probe_.clear();
  std::snprintf(text, sizeof text, "%d, %d of %d x %d", px.x, px.y, request.width, request.height);
  probe_.emplace_back("Pixel", text);
  std::snprintf(text, sizeof text, "%s cd/m2, %.2f EV", plain_number(sum).c_str(),
                static_cast<double>(ev100_of(static_cast<float>(sum))));
  probe_.emplace_back("Picture", text);
  probe_.emplace_back("Behind", name_of(*traced_->scene, sight.behind));
  if (!sight.pane) return;
  const PaneSight& pane = *sight.pane;
  const LayerMeans means = trace_means(*traced_->paths, request, rays, {pixel}, {sight}, kProbePaths / kBatches,
                                       static_cast<Polarisation>(view.polarisation));
  probe_.emplace_back(
      "Pane", traced_->scene->nodes[static_cast<std::size_t>(pane.node)].name + text_of(", %.3f m", pane.distance_m));
  probe_.emplace_back("Incidence", text_of("%.2f deg", pane.incidence_rad * kDegrees));
  probe_.emplace_back("R of a face", polarised_text(pane.optics.surface));
  probe_.emplace_back("R of the pane", polarised_text(pane.optics.reflected));
  probe_.emplace_back("T of the pane", polarised_text(pane.optics.transmitted));
  const std::optional<PaneLight> light = light_on_pane(*traced_->paths, *traced_->environment, request.env_rotation_rad,
                                                       request.env_scale, pane.node, glm::dvec3(request.camera.eye));
  if (light) probe_.emplace_back("On the glass", plain_number(light->illuminance_lx) + " lx from outside");
  probe_.emplace_back("Mirrors", name_of(*traced_->scene, pane.mirrored));
  probe_.emplace_back("Reflected", interval_text(means.reflected));
  probe_.emplace_back("Transmitted", interval_text(means.transmitted));
  probe_.push_back(contrast_row(measure_options_of(view), {sight}, means));
  const Settings& settings = session.state.settings;
  const GlassSheet sheet{glm::dvec3(request.camera.eye), 1e-3 * settings.get_double("reflections.thickness"),
                         1e-3 * settings.get_double("reflections.wedge")};
  if (sheet.thickness_m > 0.0)
    probe_.emplace_back("Ghost angle", text_of("%.2f arc minutes", ghost_arcmin(pane, sheet)));
}

void WindowInspection::measure_regions(const WindowSession& session, const WindowPicture& picture) {
  const InspectionView& view = session.state.inspection;
  if (is_ready(region_job_)) regions_ = region_job_.get();
  if (region_job_.valid()) return;
  const bool current =
      regions_.regions == view.regions && regions_of_ == picture.drawn() && same_figures(regions_setup_, view);
  if (current || picture_.width != picture.drawn().width || session.state.tool == Tool::region) return;
  regions_of_ = picture.drawn();
  regions_setup_ = view;
  region_job_ = std::async(std::launch::async, [request = picture.drawn(), traced = *traced_, regions = view.regions,
                                                shown = picture_, options = measure_options_of(view)] {
    RegionJob out{regions, {}};
    const EyeRays rays = eye_rays(request.camera, request.width, request.height, traced.paths->bounds);
    for (const InspectedRegion& region : regions) {
      const glm::ivec4 box = pixels_of(region, request.width, request.height);
      std::vector<double> sums;
      std::vector<std::size_t> pixels;
      std::vector<Sight> sights;
      const std::size_t all = static_cast<std::size_t>(box.z) * static_cast<std::size_t>(box.w);
      const std::size_t stride = std::max<std::size_t>(1, all / kRegionPixels);
      std::vector<double> incidence;
      for (std::size_t k = 0; k < all; ++k) {
        const int x = std::min(box.x + static_cast<int>(k % static_cast<std::size_t>(box.z)), request.width - 1),
                  y = std::min(box.y + static_cast<int>(k / static_cast<std::size_t>(box.z)), request.height - 1);
        sums.push_back(luminance(shown, x, y));
        if (k % stride != 0) continue;
        const std::size_t pixel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(request.width) + static_cast<std::size_t>(x);
        const Sight sight = look_along(*traced.paths, rays.at(pixel), glm::dvec3(glm::normalize(request.camera.up)));
        if (!sight.pane) continue;
        incidence.push_back(sight.pane->incidence_rad * kDegrees);
        pixels.push_back(pixel);
        sights.push_back(sight);
      }
      InspectionFacts::Region values;
      const auto add = [&](const char* name, const RegionStatistics& s) {
        for (auto& row : statistics_rows(name, s)) values.values.push_back(std::move(row));
      };
      add("Picture, cd/m2", region_statistics(sums, options.threshold_cdm2));
      if (!pixels.empty()) {
        const LayerMeans means =
            trace_means(*traced.paths, request, rays, pixels, sights, kRegionPaths, options.polarisation);
        values.values.emplace_back("Incidence",
                                   text_of("%.1f deg in the mean", region_statistics(incidence, 0.0).mean));
        values.values.emplace_back("Reflected", interval_text(means.reflected));
        add("its pixels", region_statistics(means.reflected_each, options.threshold_cdm2));
        values.values.emplace_back("Transmitted", interval_text(means.transmitted));
        values.values.push_back(contrast_row(options, sights, means));
      } else {
        values.values.emplace_back("Pane", "none in this region");
      }
      out.values.push_back(std::move(values));
    }
    return out;
  });
}

void WindowInspection::carry_out(const InspectionActions& actions, WindowSession* session) {
  try {
    if (actions.cancel && job_) job_->cancel = true;
    if (actions.run_sweep) start_job(session, false);
    if (actions.export_files) start_job(session, true);
    if (actions.eye_point == 0) return;
    const InspectionView& view = session->state.inspection;
    MeasureOptions options;
    if (!has_r_point(session->scene()))
      options.r_point_m = glm::dvec3(view.r_point_m[0], view.r_point_m[1], view.r_point_m[2]);
    const VehicleAxes axes = vehicle_axes(options.axes);
    const glm::dvec3 eye = eye_of_button(actions.eye_point, view, r_point_of(session->scene(), options), axes);
    session->put_camera(camera_at_eye(session->state.camera, eye, axes));
  } catch (const Error& error) {
    session->add_message(MessageLevel::error, error.what());
  }
}

void WindowInspection::fill_facts(const WindowSession& session, InspectionFacts* facts) const {
  *facts = {};
  facts->sweep_names = sweep_names();
  if (!session.state.inspection.open) return;
  facts->status = status_;
  facts->sun = !sun_.empty() ? sun_ : traced_ ? "No sun in this environment" : "";
  facts->regions = regions_.values;
  facts->sweep_measure = sweep_of_ghost_ ? "arc minutes" : "cd/m2";
  static const char* const kUnits[] = {"degrees", "degrees", "degrees from the vertical", "share of the light",
                                       "mrad",    "mm"};
  facts->sweep_unit = kUnits[std::clamp(session.state.inspection.sweep, 0, 5)];
  facts->sweep_y = sweep_y_;
  facts->sweep_x = sweep_x_;
  facts->sweep_title = sweep_title_;
  facts->worst = worst_;
  if (job_) {
    facts->job = job_->what;
    facts->job_share = job_->share;
    const std::chrono::duration<double> past = std::chrono::steady_clock::now() - job_->begin;
    const auto share = static_cast<double>(facts->job_share);
    if (share > 0.0) facts->job_seconds_left = past.count() * (1.0 - share) / share;
    facts->sweep_y.clear();
  }
  facts->has_r_point = has_r_point(session.scene());
}

void WindowInspection::update_texture(const InspectionView& view) {
  const bool same = colors_of_.low_cdm2 == view.low_cdm2 && colors_of_.high_cdm2 == view.high_cdm2;
  if (!view.false_color || picture_.width == 0 || (same && !colors_stale_)) return;
  colors_of_ = view;
  colors_stale_ = false;
  std::vector<std::uint8_t> bytes(4 * picture_.data.size() / static_cast<std::size_t>(picture_.channels), 255);
  for (int y = 0; y < picture_.height; ++y)
    for (int x = 0; x < picture_.width; ++x) {
      const auto c = luminance_color(static_cast<float>(luminance(picture_, x, y)), view.low_cdm2, view.high_cdm2);
      const std::size_t at =
          4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.width) + static_cast<std::size_t>(x));
      for (std::size_t k = 0; k < 3; ++k) bytes[at + k] = static_cast<std::uint8_t>(255.0f * c[k] + 0.5f);
    }
  colors_ = Texture::make_2d("false colours", GL_RGBA8, picture_.width, picture_.height);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(colors_.get(), 0, 0, 0, picture_.width, picture_.height, GL_RGBA, GL_UNSIGNED_BYTE, bytes.data());
  for (const GLenum name : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTextureParameteri(colors_.get(), name, GL_NEAREST);
}

/// What the pixel under the mouse shows, at the lower left of the picture, where nothing moves.
void WindowInspection::draw_probe(const Rect& picture) const {
  if (probe_.empty()) return;
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  const float line = ImGui::GetTextLineHeight(), pad = 0.4f * line, column = 7.0f * line;
  // What is too wide for a small picture goes on in the next line.
  const float room = std::max(picture.width - column - 4.0f * pad, 4.0f * line);
  float width = 0.0f, height = 0.0f;
  for (const auto& [name, value] : probe_) {
    const ImVec2 size = ImGui::CalcTextSize(value.c_str(), nullptr, false, room);
    width = std::max(width, size.x);
    height += size.y;
  }
  const float bottom = picture.y + picture.height - pad;
  const ImVec2 low(picture.x + pad, std::max(bottom - height - 2.0f * pad, picture.y));
  list->PushClipRect({picture.x, picture.y}, {picture.x + picture.width, picture.y + picture.height});
  list->AddRectFilled(low, {low.x + column + width + 2.0f * pad, bottom}, IM_COL32(16, 16, 18, 215), 4.0f);
  float y = low.y + pad;
  for (const auto& [name, value] : probe_) {
    list->AddText({low.x + pad, y}, IM_COL32(160, 160, 165, 255), name.c_str());
    list->AddText(ImGui::GetFont(), ImGui::GetFontSize(), {low.x + pad + column, y}, IM_COL32(240, 240, 240, 255),
                  value.c_str(), nullptr, room);
    y += ImGui::CalcTextSize(value.c_str(), nullptr, false, room).y;
  }
  list->PopClipRect();
}

void WindowInspection::draw_overlay(const WindowSession& session, const Rect& picture) {
  const InspectionView& view = session.state.inspection;
  if (!view.open || picture.empty()) return;
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  if (view.false_color && colors_ && status_ != "It waits until nothing moves.")
    list->AddImage(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(colors_.get())), {picture.x, picture.y},
                   {picture.x + picture.width, picture.y + picture.height});
  for (std::size_t i = 0; i < view.regions.size(); ++i) {
    const InspectedRegion& r = view.regions[i];
    const ImVec2 low(picture.x + r.x * picture.width, picture.y + r.y * picture.height);
    const ImVec2 high(low.x + r.width * picture.width, low.y + r.height * picture.height);
    list->AddRect({low.x - 1.0f, low.y - 1.0f}, {high.x + 1.0f, high.y + 1.0f}, IM_COL32(0, 0, 0, 200));
    list->AddRect(low, high, IM_COL32(255, 255, 255, 230));
    const std::string label = std::to_string(i + 1);
    list->AddText({low.x + 4.0f, low.y + 2.0f}, IM_COL32(255, 255, 255, 255), label.c_str());
  }
  draw_probe(picture);
}

}  // namespace maquette
