#include "viewer/json_values.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace maquette {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json number(const std::optional<double>& value) { return value ? number(*value) : Json(nullptr); }

Json plan_json(const FramePlan& plan) {
  Json json = Json::array();
  const auto add_passes = [&](const std::vector<PlannedPass>& passes) {
    for (const PlannedPass& pass : passes) {
      Json entry = {{"pass", pass.name}, {"reason", pass.reason}};
      if (plan.layers.size() > 1 && pass.layer >= 0)
        entry["mode"] = plan.layers[static_cast<std::size_t>(pass.layer)].mode;
      if (!pass.reads.empty()) entry["reads"] = pass.reads;
      if (!pass.writes.empty()) entry["writes"] = pass.writes;
      json.push_back(entry);
    }
  };
  add_passes(plan.preparations);
  add_passes(plan.passes);
  for (const Feature& feature : plan.features) json.push_back({{"feature", feature.name}, {"reason", feature.reason}});
  return json;
}

Json status_json(const FrameStatus& status) {
  Json json = {{"bakes", Json::object()}};
  static const char* const kStates[] = {"absent", "running", "partial", "ready", "failed"};
  for (const auto& [name, bake] : status.bakes()) {
    json["bakes"][name] = {{"state", kStates[static_cast<std::size_t>(bake.state)]},
                           {"progress", number(bake.progress)}};
    if (!bake.notes.empty()) json["bakes"][name]["notes"] = bake.notes;
  }
  if (!status.fitting.empty())
    json["bakes"]["patch_fit"] = {{"state", "running"}, {"progress", number(status.fit_progress)}};
  json["frames_before"] = status.accumulated;
  json["light_rotated"] = status.light_rotated;
  json["tables_swapped"] = status.tables_swapped;
  return json;
}

Json skipped_json(const FramePlan& plan, const std::vector<SkippedPass>& skipped) {
  Json json = Json::array();
  for (const SkippedPass& pass : skipped)
    json.push_back({{"pass", plan.pass_title(pass.name, pass.layer)}, {"why", pass.why}});
  return json;
}

Json modes_json(const FramePlan& plan) {
  Json json = {{"*", plan.shading().mode}};
  for (const ShadingPlan& layer : plan.layers)
    for (const std::string& node : layer.nodes) json[node] = layer.mode;
  return json;
}

Json left_out_json(const FramePlan& plan) {
  Json json = Json::array();
  for (const LeftOut& left_out : plan.left_out) json.push_back({{"what", left_out.what}, {"why", left_out.why}});
  return json;
}

Json error_json(const ErrorFigures& figures) {
  Json json = {{"rmse", number(figures.rmse)},  {"relative_rmse", number(figures.relative_rmse)},
               {"psnr", number(figures.psnr)},  {"relmse", number(figures.relmse)},
               {"flip", number(figures.flip)},  {"flip_ldr", number(figures.flip_ldr)},
               {"ssim", number(figures.ssim)},  {"display_ev", number(figures.display_ev)},
               {"pixels", figures.pixel_count}, {"invalid", figures.invalid_count}};
  if (!figures.notes.empty()) json["notes"] = figures.notes;
  return json;
}

}  // namespace maquette
