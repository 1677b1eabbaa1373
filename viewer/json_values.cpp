#include "viewer/json_values.h"

#include <cmath>

namespace maquette {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json number(const std::optional<double>& value) { return value ? number(*value) : Json(nullptr); }

Json plan_json(const FramePlan& plan) {
  Json json = Json::array();
  for (const PlannedPass& pass : plan.passes) json.push_back({{"pass", pass.name}, {"reason", pass.reason}});
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
