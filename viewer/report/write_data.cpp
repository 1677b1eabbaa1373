#include "viewer/report/write_data.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "review/json_text.h"
#include "viewer/json_values.h"
#include "viewer/report/figures.h"
#include "viewer/report/journal.h"

namespace maquette::report {

using Json = nlohmann::ordered_json;

namespace {

Json front_json(const std::vector<Curve>& curves) {
  Json json = Json::array();
  for (const FrontPoint& point : pareto_front(curves))
    json.push_back({{"technique", point.technique},
                    {"quality", point.quality},
                    {"time_ms", number(point.time_ms)},
                    {"error", number(point.error)}});
  return json;
}

template <std::size_t N>
Json times_json(const std::vector<Curve>& curves, const double (&targets)[N]) {
  Json json = Json::object();
  const double floor = noise_floor(curves);
  for (const Curve& curve : curves) {
    Json times = Json::object();
    for (const double target : targets) {
      char name[16];
      std::snprintf(name, sizeof name, "%g", target);
      times[name] = number(time_to_error(curve, target, floor));
    }
    json[curve.technique] = {{"best_error", number(best_error(curve))}, {"time_ms_to_error", times}};
  }
  return json;
}

Json curves_json(const Report& report, const std::string& camera, Scope scope) {
  const auto of = [&](Metric metric) {
    return camera.empty() ? mean_curves(report, scope, metric) : curves_of(report, camera, scope, metric);
  };
  const std::vector<Curve> relative = of(Metric::relative_rmse), flip = of(Metric::flip);
  return {{"relative_rmse",
           {{"pareto_front", front_json(relative)}, {"techniques", times_json(relative, kRelativeTargets)}}},
          {"flip", {{"pareto_front", front_json(flip)}, {"techniques", times_json(flip, kFlipTargets)}}}};
}

std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string cell(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string cell(const std::optional<double>& value) { return value ? cell(*value) : ""; }

}  // namespace

std::string report_json_text(const Report& report) {
  Json json = {{"scene", report.scene},
               {"environment", report.environment},
               {"command", report.command},
               {"size", {report.width, report.height}},
               {"budget_s", number(report.budget_s)},
               {"seconds", number(report.seconds)},
               {"interrupted", report.interrupted}};
  json["machine"] = Json::object();
  for (const NamedValue& entry : report.machine) json["machine"][entry.name] = entry.value;
  json["cameras"] = Json::array();
  for (const CameraEntry& camera : report.cameras) json["cameras"].push_back(camera.name);
  json["techniques"] = Json::array();
  for (const TechniqueEntry& technique : report.techniques)
    json["techniques"].push_back({{"name", technique.name}, {"help", technique.help}});
  json["references"] = Json::array();
  for (const ReferenceEntry& entry : report.references) json["references"].push_back(reference_json(entry));
  json["points"] = Json::array();
  for (const Point& point : report.points) json["points"].push_back(point_json(point));
  json["curves"] = Json::object();
  for (const Scope scope : kScopes) {
    Json cameras = Json::object();
    for (const CameraEntry& camera : report.cameras) cameras[camera.name] = curves_json(report, camera.name, scope);
    json["curves"][scope_name(scope)] = {{"all_cameras", curves_json(report, {}, scope)}, {"cameras", cameras}};
  }
  json["left_out"] = Json::array();
  for (const LeftOutEntry& entry : report.left_out)
    json["left_out"].push_back({{"technique", entry.technique}, {"what", entry.what}, {"why", entry.why}});
  json["not_measured"] = report.skipped;
  return json_text(json, 2) + "\n";
}

std::string report_csv_text(const Report& report) {
  std::string text =
      "camera,technique,quality,scope,repeats,time_ms,time_ms_low,time_ms_high,cpu_ms,relative_rmse,relative_rmse_low,"
      "relative_rmse_high,below_reference_noise,rmse,psnr,relmse,flip,flip_ldr,ssim,gpu_bytes,shading_samples\n";
  for (const Point& p : report.points) {
    const std::optional<Spread>& e = p.relative_rmse;
    for (const std::string& value :
         {cell(p.camera), cell(p.technique), cell(p.quality), cell(scope_name(p.scope)),
          cell(static_cast<double>(p.repeats)), cell(p.time_ms.median), cell(p.time_ms.low), cell(p.time_ms.high),
          cell(p.cpu_ms), e ? cell(e->median) : "", e ? cell(e->low) : "", e ? cell(e->high) : "",
          std::string(p.below_noise ? "1" : "0"), cell(p.figures.rmse), cell(p.figures.psnr), cell(p.figures.relmse),
          cell(p.figures.flip), cell(p.figures.flip_ldr), cell(p.figures.ssim)})
      text += value + ",";
    text += std::to_string(p.gpu_bytes) + "," + std::to_string(p.shading_samples) + "\n";
  }
  return text;
}

}  // namespace maquette::report
