#include "viewer/window_stored_light.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/picture/tonemap.h"
#include "scenes/error.h"
#include "viewer/overlay_texture.h"

namespace maquette {

namespace {

/// One exposure for all: the brightest twentieth of what is stored may clip.
float exposure_of(const PointReport& report) {
  std::vector<float> light;
  for (const PointReport::Picture& picture : report.pictures)
    for (std::size_t i = 0; i < picture.image.data.size(); i += 4)
      if (picture.image.data[i + 3] > 0.0f) light.push_back(picture.image.data[i + 1]);
  if (light.empty()) return 0.0f;
  const auto at = light.begin() + static_cast<std::ptrdiff_t>(light.size() * 19 / 20);
  std::nth_element(light.begin(), at, light.end());
  return -std::log2(std::max(*at, 1e-9f));
}

bool draws_with_bake(const WindowPicture& picture) {
  if (!picture.stats()) return false;
  const std::vector<ShadingPlan>& layers = picture.stats()->plan.layers;
  return std::any_of(layers.begin(), layers.end(), [](const ShadingPlan& layer) { return !layer.own_bake.empty(); });
}

}  // namespace

WindowStoredLight::WindowStoredLight()
    : tabulator_([](const CompressionTableJob& job, const BackgroundTask<CompressionTable>& task) {
        return job(task.cancel, task.progress);
      }) {}

void WindowStoredLight::carry_out(const InspectionActions& actions, WindowSession* session) {
  if (actions.stop_tabulating) tabulator_.cancel();
  CompressionTableJob job = actions.tabulate_stored ? session->renderer().compression_table() : CompressionTableJob();
  if (!job) return;
  table_.reset();
  tabulated_ = session->revision();
  tabulator_.submit(std::move(job));
}

void WindowStoredLight::update_table(WindowSession* session) {
  can_tabulate_ = facts_.any && session->renderer().compression_table();
  if (tabulated_ != session->revision()) {
    if (tabulator_.busy()) tabulator_.cancel();
    table_.reset();
  }
  try {
    if (auto table = tabulator_.take()) table_ = std::move(table);
  } catch (const Error& error) {
    session->add_message(MessageLevel::error, error.what());
  }
}

void WindowStoredLight::update(WindowSession* session, const WindowPicture& picture) {
  retired_.clear();
  facts_.any = draws_with_bake(picture);
  update_table(session);
  const std::optional<glm::vec2>& at = session->state.inspection.stored_at;
  if (!facts_.any || !at) {
    facts_ = StoredLightFacts();
    facts_.any = draws_with_bake(picture);
    retired_ = std::exchange(textures_, {});
    shown_.reset();
    return;
  }
  if (!picture.still() || session->loading()) return;
  if (shown_ == at && revision_ == session->revision() && seen_ == picture.drawn()) return;
  shown_ = at;
  revision_ = session->revision();
  seen_ = picture.drawn();
  describe(session, picture, *at);
}

void WindowStoredLight::describe(WindowSession* session, const WindowPicture& picture, const glm::vec2& at) {
  const glm::ivec2 size(picture.drawn().width, picture.drawn().height);
  const glm::ivec2 px = glm::clamp(glm::ivec2(at * glm::vec2(size)), glm::ivec2(0), size - 1);
  facts_ = StoredLightFacts();
  facts_.any = true;
  retired_ = std::exchange(textures_, {});
  try {
    const std::optional<PointReport> report = session->renderer().describe(session->renderer().pick(px.x, px.y));
    if (!report) {
      facts_.status = "Nothing is stored for this point.";
      return;
    }
    facts_.values = report->values;
    const float exposure_ev = exposure_of(*report);
    for (const PointReport::Picture& stored : report->pictures) {
      Image shown = tone_map(stored.image, exposure_ev, "linear");
      Image display(shown.width, shown.height, 4);
      for (int y = 0; y < shown.height; ++y)
        for (int x = 0; x < shown.width; ++x) {
          for (int c = 0; c < 3; ++c) display.at(x, y, c) = shown.at(x, y, c);
          display.at(x, y, 3) = stored.image.at(x, y, 3);
        }
      textures_.push_back(overlay_texture(display, "stored light", GL_LINEAR));
      facts_.pictures.push_back({stored.name, textures_.back().get()});
    }
  } catch (const Error& error) {
    facts_.status = error.what();
  }
}

void WindowStoredLight::fill_facts(StoredLightFacts* facts) const {
  *facts = facts_;
  facts->can_tabulate = can_tabulate_;
  facts->table = table_;
  if (tabulator_.busy()) facts->tabulating = tabulator_.progress();
}

}  // namespace maquette
