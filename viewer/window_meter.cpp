#include "viewer/window_meter.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "render/technique/registry.h"
#include "render/views/false_color.h"
#include "scenes/error.h"
#include "scenes/percent.h"
#include "viewer/overlay_texture.h"

namespace maquette {

namespace {

constexpr double kJudge_s = 0.4;          // between two measurements: reading the picture back is slow
constexpr double kLongFrame_ms = 1500.0;  // the last frame of a measured curve
constexpr float kHeatRange = 4.0f;        // the top of the scale, in mean errors

/// Empty: the mode takes none.
const std::string& samples_setting(const std::string& mode) {
  return builtin_registry().find_mode(mode).samples_setting;
}

}  // namespace

ErrorMeter::View WindowMeter::view_of(const WindowSession& session, const WindowPicture& picture) const {
  const FrameRequest& drawn = picture.drawn();
  ErrorMeter::View view;
  view.camera = drawn.camera;
  view.width = drawn.width;
  view.height = drawn.height;
  view.paths.transport = session.state.error_view.all_light ? Transport::full : Transport::direct;
  view.paths.env_rotation_rad = drawn.env_rotation_rad;
  view.paths.env_scale = drawn.env_scale;
  view.scene_revision = 256 * session.revision() + static_cast<std::uint64_t>(drawn.variant + 1);
  return view;
}

void WindowMeter::take_snapshot(WindowSession* session, std::uint64_t revision, int variant) {
  if (snapshot_revision_ == revision) return;
  snapshot_revision_ = revision;
  measured_.clear();
  known_ = std::make_shared<Known>();
  auto snapshot = std::make_shared<Renderer::PathSnapshot>(session->renderer().path_snapshot());
  make_scene_ = [snapshot, variant, known = known_] {
    BudgetCurves curves = load_curves(curves_key(snapshot->scene, *snapshot->environment));
    {
      const std::lock_guard lock(known->mutex);
      known->curves = std::move(curves);
    }
    return build_path_scene({.scene = snapshot->scene,
                             .environment = snapshot->environment,
                             .variant = variant,
                             .geometry = &snapshot->geometry,
                             .library = nullptr});
  };
}

void WindowMeter::update(WindowSession* session, const WindowPicture& picture, double now_s) {
  moving_ = !picture.still();
  if (!session->state.error_view.open || moving_ || session->loading()) {
    meter_.cancel();
    error_.reset();
    reference_.reset();
    curve_step_ = reflector_step_ = -1;
    return;
  }
  const ErrorMeter::View view = view_of(*session, picture);
  take_snapshot(session, view.scene_revision, picture.drawn().variant);
  if (meter_.watch(view, make_scene_)) {
    begin_s_ = now_s;
    error_.reset();
    reference_.reset();
    reflectors_.clear();
    judged_s_ = -1e9;
  }
  picture_width_ = view.width;
  picture_height_ = view.height;
  std::uint64_t version = 0;
  std::shared_ptr<const GridReference> newest = meter_.newest(&version);
  const bool new_result = version != version_ && newest;
  if (new_result) {
    reference_ = std::move(newest);
    version_ = version;
  }
  const bool better = picture.stats() && picture.stats()->accumulated_frames != judged_frames_;
  if (reference_ && (new_result || better) && now_s - judged_s_ > kJudge_s) judge(session, picture, now_s);
  if (reference_ && curve_step_ >= 0) continue_curve(session, picture);
  if (reference_ && reflector_step_ >= 0) continue_reflectors(session, picture);
  update_textures(*session);
}

void WindowMeter::judge(WindowSession* session, const WindowPicture& picture, double now_s) {
  error_ = meter_error(session->renderer().read_radiance(), *reference_);
  judged_s_ = now_s;
  judged_frames_ = picture.stats()->accumulated_frames;
  figure_s_ = now_s - begin_s_;
  picture_s_ = 1e-3 * picture.stats()->frame_ms * picture.stats()->accumulated_frames;
  textures_stale_ = true;
}

void WindowMeter::continue_curve(WindowSession* session, const WindowPicture& picture) {
  const Technique& mode = builtin_registry().find_mode(picture.drawn().mode);
  if (curve_step_ == 0) curve_ = {"this view, just measured", {}};
  bool over = mode.quality_steps.empty() || mode.quality_steps.front().samples == 0;
  FrameRequest request = picture.drawn();
  if (!over) request.samples = mode.quality_steps[static_cast<std::size_t>(curve_step_)].samples;
  try {
    const FrameStats stats = session->renderer().render(request);
    if (const auto error = meter_error(session->renderer().read_radiance(), *reference_))
      curve_.points.push_back({request.samples, stats.frame_ms, std::max(error->error, 1e-6)});
    over = over || stats.frame_ms > kLongFrame_ms;
  } catch (const Error& problem) {
    session->add_message(MessageLevel::error, problem.what());
    over = true;
  }
  ++curve_step_;
  if (!over && curve_step_ < static_cast<int>(mode.quality_steps.size())) return;
  curve_step_ = -1;
  measured_[curve_name(mode.name, session->state.error_view.all_light)] = curve_;
}

void WindowMeter::continue_reflectors(WindowSession* session, const WindowPicture& picture) {
  const std::vector<std::string> names = builtin_registry().names(TechniqueKind::reflector);
  if (reflector_step_ >= static_cast<int>(names.size())) {
    reflector_step_ = -1;
    return;
  }
  MeterFacts::Reflector result;
  result.name = names[static_cast<std::size_t>(reflector_step_)];
  FrameRequest request = picture.drawn();
  request.reflections = result.name;
  try {
    const FrameStats stats = session->renderer().render(request);
    // What it needs is made in the background: it is drawn again until that is there.
    if (!session->renderer().background_work().empty()) return;
    const auto error = meter_error(session->renderer().read_radiance(), *reference_);
    result.time_ms = stats.frame_ms;
    result.error = error ? error->error : 0.0;
  } catch (const Error& problem) {
    result.why = problem.what();
  }
  ++reflector_step_;
  reflectors_.push_back(result);
}

/// Where the path tracer would have less error by noise after the time that this picture took.
std::string WindowMeter::reference_answer() const {
  if (!error_ || !reference_ || reference_->paths < 8) return "";
  const double paths = reference_paths(*reference_, picture_s_, picture_width_, picture_height_);
  const double noise = paths > 0.0 ? reference_noise(*reference_, paths) : 0.0;
  if (paths < 1.0 || !(noise < error_->low)) return "";
  char text[160];
  std::snprintf(text, sizeof text,
                "mode reference would be better after the same time: about %s by %.0f paths a pixel in %.1f s",
                percent_text(noise).c_str(), paths, picture_s_);
  return text;
}

/// The path tracer's noise falls to any budget.
std::string WindowMeter::what_keeps(double budget) const {
  if (!reference_ || reference_->paths < 8 || !(budget > 0.0)) return "";
  const double noise = reference_noise(*reference_, 1.0);
  const double in_a_second = reference_paths(*reference_, 1.0, picture_width_, picture_height_);
  if (!(noise > 0.0) || !(in_a_second > 0.0)) return "";
  const double paths = std::max(std::ceil(noise * noise / (budget * budget)), 1.0);
  char text[128];
  std::snprintf(text, sizeof text, " Mode reference keeps it: about %.0f paths a pixel, %.3g s.", paths,
                paths / in_a_second);
  return text;
}

std::optional<BudgetCurve> WindowMeter::find_curve(const WindowSession& session) const {
  const std::string name = curve_name(session.state.mode, session.state.error_view.all_light);
  if (const auto found = measured_.find(name); found != measured_.end()) return found->second;
  const std::lock_guard lock(known_->mutex);
  if (const auto found = known_->curves.find(name); found != known_->curves.end()) return found->second;
  return std::nullopt;
}

void WindowMeter::fill_facts(const WindowSession& session, MeterFacts* facts) const {
  *facts = {};
  if (!session.state.error_view.open) return;
  facts->measuring_curve = curve_step_ >= 0;
  facts->comparing_reflectors = reflector_step_ >= 0;
  facts->reflectors = reflectors_;
  facts->reference_answer = reference_answer();
  const std::string problem = meter_.problem();
  if (!problem.empty())
    facts->status = problem;
  else if (moving_)
    facts->status = "It waits until nothing moves.";
  else if (!reference_)
    facts->status = "The reference is being traced ...";
  else if (!error_)
    facts->status = "No lit surface is visible: there is nothing to compare.";
  if (error_) {
    facts->has_error = true;
    facts->error = error_->error;
    facts->low = error_->low;
    facts->high = error_->high;
    facts->pixels = error_->pixels;
    facts->paths = reference_->paths;
    facts->seconds = figure_s_;
  }
  const std::optional<BudgetCurve> curve = find_curve(session);
  if (!curve) {
    facts->budget_answer = "No error of mode " + session.state.mode +
                           " was measured in this scene: measure this view, or run maquette report.";
    return;
  }
  facts->curve = curve->source;
  std::string why;
  const std::optional<BudgetPoint> choice = samples_for_budget(*curve, session.state.error_view.budget, &why);
  if (!choice) {
    facts->budget_answer = why;
    if (session.state.error_view.all_light) facts->budget_answer += what_keeps(session.state.error_view.budget);
    return;
  }
  facts->can_apply = !samples_setting(session.state.mode).empty();
  char text[96];
  std::snprintf(text, sizeof text, "%d samples, about %.0f ms a frame, error %s", choice->samples, choice->time_ms,
                percent_text(choice->error).c_str());
  facts->budget_answer = text;
}

void WindowMeter::apply_budget(WindowSession* session) const {
  const std::optional<BudgetCurve> curve = find_curve(*session);
  std::string why;
  const std::optional<BudgetPoint> choice =
      curve ? samples_for_budget(*curve, session->state.error_view.budget, &why) : std::nullopt;
  const std::string setting = samples_setting(session->state.mode);
  if (choice && !setting.empty()) session->state.settings.set(setting, choice->samples);
}

void WindowMeter::update_textures(const WindowSession& session) {
  const EditorState& state = session.state;
  textures_stale_ |= shown_tonemap_ != state.tonemap || shown_exposure_ev_ != state.exposure_ev;
  if (!error_ || !reference_ || !textures_stale_ || state.error_view.show == ErrorView::Show::picture) return;
  const float top = kHeatRange * static_cast<float>(std::max(error_->error, 1e-6));
  Image heat = false_color_image(error_->map, FalseColorRange{0.0f, top});
  for (int y = 0; y < heat.height; ++y)
    for (int x = 0; x < heat.width; ++x)
      if (error_->map.at(x, y) < 0.0f) heat.at(x, y, 3) = 0.0f;
  heat_ = overlay_texture(heat, "error heat map", GL_NEAREST);
  Image truth = reference_->halves[0];
  for (std::size_t i = 0; i < truth.data.size(); ++i)
    truth.data[i] = 0.5f * (truth.data[i] + reference_->halves[1].data[i]);
  truth = tone_map(truth, state.exposure_ev, state.tonemap);
  for (std::size_t i = 3; i < truth.data.size(); i += 4) truth.data[i] = 1.0f;
  truth_ = overlay_texture(truth, "error reference", GL_LINEAR);
  shown_tonemap_ = state.tonemap;
  shown_exposure_ev_ = state.exposure_ev;
  textures_stale_ = false;
}

void WindowMeter::draw_overlay(const WindowSession& session, const Rect& picture) {
  const ErrorView& view = session.state.error_view;
  if (!view.open || !error_ || !reference_ || view.show == ErrorView::Show::picture || !heat_ || picture.empty())
    return;
  const PixelGrid& grid = reference_->grid;
  const float sx = picture.width / static_cast<float>(picture_width_);
  const float sy = picture.height / static_cast<float>(picture_height_);
  const ImVec2 low(picture.x + sx * static_cast<float>(grid.x), picture.y + sy * static_cast<float>(grid.y));
  const ImVec2 high(low.x + sx * static_cast<float>(grid.width * grid.factor),
                    low.y + sy * static_cast<float>(grid.height * grid.factor));
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  if (view.show == ErrorView::Show::heat) {
    list->AddImage(texture_id(heat_), low, high, {0.0f, 0.0f}, {1.0f, 1.0f}, IM_COL32(255, 255, 255, 225));
    return;
  }
  const float x = std::clamp(picture.x + view.wiper * picture.width, low.x, high.x);
  const float u = (x - low.x) / std::max(high.x - low.x, 1.0f);
  list->AddImage(texture_id(truth_), {x, low.y}, high, {u, 0.0f}, {1.0f, 1.0f});
  const float middle = picture.y + 0.5f * picture.height;
  list->AddLine({x, picture.y}, {x, picture.y + picture.height}, IM_COL32(255, 255, 255, 200), 2.0f);
  // The wiper's handle.
  list->AddRectFilled({x - 5.0f, middle - 18.0f}, {x + 5.0f, middle + 18.0f}, IM_COL32(255, 255, 255, 230), 5.0f);
  const float y = picture.y + picture.height - 1.6f * ImGui::GetFontSize();
  const auto label = [&](float at, const std::string& text) {
    const ImVec2 size = ImGui::CalcTextSize(text.c_str());
    list->AddRectFilled({at - 4.0f, y - 2.0f}, {at + size.x + 4.0f, y + size.y + 2.0f}, IM_COL32(0, 0, 0, 150), 3.0f);
    list->AddText({at, y}, IM_COL32(255, 255, 255, 230), text.c_str());
  };
  label(x + 10.0f, session.state.error_view.all_light ? "all paths" : "direct light");
  label(x - 10.0f - ImGui::CalcTextSize(session.state.mode.c_str()).x, session.state.mode);
}

}  // namespace maquette
