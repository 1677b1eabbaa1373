#include "viewer/stats.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "render/frame/vocabulary.h"
#include "review/json_text.h"
#include "viewer/json_values.h"

namespace maquette {

using Json = nlohmann::ordered_json;

namespace {

Json settings_json(const Settings& settings) {
  Json json = Json::object();
  for (const SettingDeclaration& declaration : setting_declarations())
    std::visit([&](const auto& value) { json[declaration.name] = value; }, settings.get(declaration.name));
  return json;
}

Json timing_json(const RenderReport& report) {
  std::vector<double> frame_ms;
  std::map<std::string, std::vector<double>> pass_ms, pass_cpu_ms;
  for (const FrameStats& frame : report.frames) {
    frame_ms.push_back(frame.frame_ms);
    for (const PassTime& pass : frame.passes) {
      const std::string title = frame.plan.pass_title(pass.name, pass.layer);
      pass_ms[title].push_back(pass.ms);
      pass_cpu_ms[title].push_back(pass.cpu_ms);
    }
  }
  Json passes = Json::object(), cpu = Json::object();
  // In the order of the last frame.
  for (const PassTime& pass : report.frames.back().passes) {
    const std::string title = report.frames.back().plan.pass_title(pass.name, pass.layer);
    passes[title] = number(median(pass_ms[title]));
    cpu[title] = number(median(pass_cpu_ms[title]));
  }
  return {{"frame", number(median(frame_ms))}, {"passes", passes}, {"cpu_passes", cpu}};
}

std::size_t peak_rss_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

}  // namespace

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

std::string stats_json(const SceneOptions& options, const FrameRequest& request, const DeviceInfo& device,
                       const RenderReport& report) {
  const FrameStats& last = report.frames.back();
  Json json;
  json["scene"] = options.scene;
  json["environment"] = options.environment;
  json["mode"] = request.mode;
  json["modes"] = modes_json(last.plan);
  json["reflections"] = options.reflections;
  json["size"] = {request.width, request.height};
  json["msaa"] = request.msaa;
  json["samples"] = request.samples;
  json["seed"] = request.seed;
  json["device"] = device.renderer + ", OpenGL " + device.version;
  json["settings"] = settings_json(request.settings);
  json["timing_ms"] = timing_json(report);
  json["frames"] = report.frames.size();
  json["accumulation"] = {{"frames", last.accumulated_frames}, {"seconds", number(report.total_s)}};
  if (report.estimated_error) json["accumulation"]["estimated_relative_rmse"] = number(*report.estimated_error);
  json["memory"] = {{"gpu_bytes", Json(last.gpu_bytes)}, {"peak_rss_bytes", peak_rss_bytes()}};
  json[words::kBandwidth] = {{"visible_pixels", last.visible_pixels},
                             {"shaded_pixels", last.shaded_pixels},
                             {"shading_samples", last.shading_samples}};
  json["technique"] = Json::object();
  for (const auto& [name, value] : last.technique) json["technique"][name] = number(value);
  json["plan"] = plan_json(last.plan);
  json["status"] = status_json(last.status);
  json["skipped"] = skipped_json(last.plan, last.skipped);
  json["left_out"] = left_out_json(last.plan);
  if (report.error) json["error"] = error_json(*report.error);
  return json_text(json, 2) + "\n";
}

}  // namespace maquette
