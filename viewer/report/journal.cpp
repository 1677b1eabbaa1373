#include "viewer/report/journal.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "review/json_text.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/json_fault.h"
#include "viewer/json_values.h"
#include "viewer/outputs.h"

namespace maquette::report {

using Json = nlohmann::ordered_json;

namespace {

constexpr int kFormat = 2;

Json spread_json(const Spread& spread) {
  return {{"median", number(spread.median)}, {"low", number(spread.low)}, {"high", number(spread.high)}};
}

Spread spread_from_json(const Json& json) { return {json.at("median"), json.at("low"), json.at("high")}; }

std::optional<double> number_from_json(const Json& json, const char* key) {
  if (!json.contains(key) || json.at(key).is_null()) return std::nullopt;
  return json.at(key).get<double>();
}

ErrorFigures figures_from_json(const Json& json) {
  ErrorFigures f;
  f.rmse = number_from_json(json, "rmse");
  f.relative_rmse = number_from_json(json, "relative_rmse");
  f.psnr = number_from_json(json, "psnr");
  f.relmse = number_from_json(json, "relmse");
  f.flip = number_from_json(json, "flip");
  f.flip_ldr = number_from_json(json, "flip_ldr");
  f.ssim = number_from_json(json, "ssim");
  f.display_ev = number_from_json(json, "display_ev");
  f.pixel_count = json.at("pixels");
  f.invalid_count = json.at("invalid");
  if (json.contains("notes")) f.notes = json.at("notes").get<std::vector<std::string>>();
  return f;
}

ReferenceEntry reference_from_json(const Json& json) {
  ReferenceEntry entry;
  entry.camera = json.at("camera");
  entry.scope = scope_from_name(json.at("scope"));
  entry.file = json.at("file");
  entry.made_by = json.at("made_by");
  entry.samples = json.at("samples");
  entry.noise = json.at("noise");
  entry.seconds = json.at("seconds");
  return entry;
}

}  // namespace

Json point_json(const Point& p) {
  return {{"camera", p.camera},
          {"technique", p.technique},
          {"quality", p.quality},
          {"scope", scope_name(p.scope)},
          {"samples", p.samples},
          {"step", p.step},
          {"repeats", p.repeats},
          {"time_ms", spread_json(p.time_ms)},
          {"cpu_ms", number(p.cpu_ms)},
          {"gpu_bytes", p.gpu_bytes},
          {"shading_samples", p.shading_samples},
          {"relative_rmse", p.relative_rmse ? spread_json(*p.relative_rmse) : Json(nullptr)},
          {"below_noise", p.below_noise},
          {"error", error_json(p.figures)},
          {"picture", p.picture},
          {"difference", p.difference}};
}

Point point_from_json(const Json& json) {
  Point p;
  p.camera = json.at("camera");
  p.technique = json.at("technique");
  p.quality = json.at("quality");
  p.scope = scope_from_name(json.at("scope"));
  p.samples = json.at("samples");
  p.step = json.at("step");
  p.repeats = json.at("repeats");
  p.time_ms = spread_from_json(json.at("time_ms"));
  p.cpu_ms = json.at("cpu_ms");
  p.gpu_bytes = json.at("gpu_bytes");
  p.shading_samples = json.at("shading_samples");
  if (!json.at("relative_rmse").is_null()) p.relative_rmse = spread_from_json(json.at("relative_rmse"));
  p.below_noise = json.at("below_noise");
  p.figures = figures_from_json(json.at("error"));
  p.picture = json.at("picture");
  p.difference = json.at("difference");
  return p;
}

Json reference_json(const ReferenceEntry& entry) {
  return {{"camera", entry.camera},          {"scope", scope_name(entry.scope)}, {"file", entry.file},
          {"made_by", entry.made_by},        {"samples", entry.samples},         {"noise", number(entry.noise)},
          {"seconds", number(entry.seconds)}};
}

Journal::Journal(const std::string& folder) : path_(folder + "/progress.json") {
  if (!std::filesystem::exists(path_)) return;
  try {
    const std::vector<std::byte> bytes = read_file(path_);
    const auto* text = reinterpret_cast<const char*>(bytes.data());
    const Json json = json_from_text<Json>({text, bytes.size()});
    if (json.at("format") != kFormat) throw Error(path_, "it is of another version of the program");
    for (const auto& [key, point] : json.at("points").items()) points_[key] = point_from_json(point);
    for (const auto& [key, entry] : json.at("references").items()) references_[key] = reference_from_json(entry);
  } catch (const std::exception& problem) {
    points_.clear();
    references_.clear();
    std::error_code ignored;
    std::filesystem::rename(path_, path_ + ".damaged", ignored);
    note_ = path_ + ": earlier results cannot be read and were set aside as progress.json.damaged (" +
            json_fault(problem.what()) + ")";
  }
}

std::optional<Point> Journal::find_point(const std::string& key) const {
  const auto found = points_.find(key);
  return found == points_.end() ? std::nullopt : std::optional(found->second);
}

std::optional<ReferenceEntry> Journal::find_reference(const std::string& key) const {
  const auto found = references_.find(key);
  return found == references_.end() ? std::nullopt : std::optional(found->second);
}

void Journal::add_point(const std::string& key, const Point& point) {
  points_[key] = point;
  save();
}

void Journal::add_reference(const std::string& key, const ReferenceEntry& entry) {
  references_[key] = entry;
  save();
}

void Journal::save() const {
  Json json = {{"format", kFormat}, {"references", Json::object()}, {"points", Json::object()}};
  for (const auto& [key, entry] : references_) json["references"][key] = reference_json(entry);
  for (const auto& [key, point] : points_) json["points"][key] = point_json(point);
  write_text(path_, json_text(json, 1) + "\n");
}

}  // namespace maquette::report
