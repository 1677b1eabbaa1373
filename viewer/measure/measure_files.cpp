#include "viewer/measure/measure_files.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>

#include "review/json_text.h"
#include "scenes/error.h"
#include "scenes/image_io.h"
#include "scenes/suggest.h"
#include "ui/inspection_state.h"
#include "viewer/json_values.h"
#include "viewer/measure/measure_run.h"

namespace maquette {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegrees = 180.0 / std::numbers::pi;

Json point_json(const glm::dvec3& p) { return {number(p.x), number(p.y), number(p.z)}; }

Json statistics_json(const RegionStatistics& r, bool threshold) {
  Json json = {{"min", number(r.min)},
               {"mean", number(r.mean)},
               {"median", number(r.median)},
               {"max", number(r.max)},
               {"sigma", number(r.sigma)}};
  if (threshold) json["share_over_threshold"] = number(r.share_over);
  return json;
}

Json interval_json(const Interval& i) {
  return {
      {"mean", number(i.mean)}, {"low_95", number(i.mean - i.half_width)}, {"high_95", number(i.mean + i.half_width)}};
}

Json polarised_json(const Polarised& p) { return {{"s", number(p.s)}, {"p", number(p.p)}, {"mean", number(p.mean())}}; }

Json region_json(const RegionValues& r) {
  Json json = {{"name", r.name},
               {"box_px", {r.box.x, r.box.y, r.box.width, r.box.height}},
               {"pane_pixels", r.pane_pixels},
               {"reflected_cdm2", statistics_json(r.reflected, true)},
               {"transmitted_cdm2", statistics_json(r.transmitted, true)},
               {"sum_cdm2", statistics_json(r.sum, true)},
               {"incidence_deg", statistics_json(r.incidence_deg, false)},
               {"pane_reflectance", statistics_json(r.reflectance, false)},
               {"surface_reflectance_mean", number(r.surface_reflectance)},
               {"contrast_kept_mean", number(r.contrast)}};
  if (r.veil_per_lux) json["veil_per_lux_cdm2"] = number(*r.veil_per_lux);
  if (r.flat_estimate_cdm2) {
    json["flat_estimate_cdm2"] = number(*r.flat_estimate_cdm2);
    json["reflected_over_flat_estimate"] = number(r.reflected.mean / *r.flat_estimate_cdm2);
  }
  if (r.ghost_arcmin) json["ghost_angle_arcmin"] = statistics_json(*r.ghost_arcmin, false);
  if (r.traced)
    json["path_traced"] = {{"paths_per_pixel", r.traced->paths},
                           {"reflected_cdm2", interval_json(r.traced->reflected)},
                           {"transmitted_cdm2", interval_json(r.traced->transmitted)}};
  json["mirrored"] = Json::object();
  for (const auto& [name, share] : r.mirrored) json["mirrored"][name.empty() ? "(unnamed)" : name] = number(share);
  return json;
}

Json probe_json(const ProbeValues& p) {
  Json json = {{"pixel", {p.pixel.x, p.pixel.y}},
               {"reflected_cdm2", number(p.reflected)},
               {"transmitted_cdm2", number(p.transmitted)},
               {"sum_cdm2", number(p.reflected + p.transmitted)},
               {"behind", p.behind},
               {"behind_distance_m", p.sight.behind.surface ? number(p.sight.behind.distance_m) : Json(nullptr)}};
  if (const std::optional<PaneSight>& pane = p.sight.pane) {
    json["pane"] = {
        {"what", p.pane},
        {"distance_m", number(pane->distance_m)},
        {"position_m", point_json(pane->position)},
        {"incidence_deg", number(pane->incidence_rad * kDegrees)},
        {"surface_reflectance", polarised_json(pane->optics.surface)},
        {"pane_reflectance", polarised_json(pane->optics.reflected)},
        {"pane_transmittance", polarised_json(pane->optics.transmitted)},
        {"mirrors", p.mirrored},
        {"mirrored_distance_m", pane->mirrored.surface ? number(pane->mirrored.distance_m) : Json(nullptr)}};
    if (p.ghost_arcmin) json["pane"]["ghost_angle_arcmin"] = number(*p.ghost_arcmin);
  }
  return json;
}

Json eye_json(const EyeValues& e) {
  Json json = {{"eye", e.eye}, {"position_m", point_json(e.position)}, {"looks_through_pane", e.looks_through}};
  for (const auto& [name, value] : e.step) json["step"][name] = number(value);
  if (e.sun)
    json["sun"] = {{"elevation_deg", number(e.sun->elevation_deg)}, {"azimuth_deg", number(e.sun->azimuth_deg)}};
  if (e.light)
    json["light_on_glass"] = {{"illuminance_lx", number(e.light->illuminance_lx)},
                              {"without_shadows_lx", number(e.light->unshadowed_lx)},
                              {"transmitted_share", number(e.light->transmitted_share)},
                              {"rake_deg", number(e.light->rake_deg)}};
  json["regions"] = Json::array();
  for (const RegionValues& region : e.regions) json["regions"].push_back(region_json(region));
  if (!e.probes.empty()) json["probes"] = Json::array();
  for (const ProbeValues& probe : e.probes) json["probes"].push_back(probe_json(probe));
  return json;
}

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string cell(double value) {
  if (!std::isfinite(value)) return "";
  char text[32];
  std::snprintf(text, sizeof text, "%.7g", value);
  return text;
}

void add_statistics(const RegionStatistics& r, bool threshold, std::string* line) {
  for (const double value : {r.min, r.mean, r.median, r.max, r.sigma}) *line += "," + cell(value);
  if (threshold) *line += "," + cell(r.share_over);
}

std::string statistics_names(const std::string& name, bool threshold) {
  std::string text;
  for (const char* part : {"min", "mean", "median", "max", "sigma"}) text += "," + name + "_" + part;
  return text + (threshold ? "," + name + "_share_over_threshold" : "");
}

/// What both tables begin with.
std::string line_begin(const char* kind, const EyeValues& e) {
  std::string line = kind + ("," + quoted(e.eye));
  for (int c = 0; c < 3; ++c) line += "," + cell(e.position[c]);
  for (const auto& [name, value] : e.step) line += "," + cell(value);
  return line;
}

std::string region_line(const EyeValues& e, const RegionValues& r) {
  std::string line = line_begin("region", e);
  line += "," + quoted(r.name) + "," + std::to_string(r.pane_pixels) + (e.looks_through ? ",1," : ",0,") +
          cell(e.light ? e.light->illuminance_lx : NAN);
  add_statistics(r.reflected, true, &line);
  add_statistics(r.transmitted, true, &line);
  add_statistics(r.sum, true, &line);
  add_statistics(r.incidence_deg, false, &line);
  add_statistics(r.reflectance, false, &line);
  line += "," + cell(r.contrast) + "," + cell(r.veil_per_lux.value_or(NAN)) + "," +
          cell(r.flat_estimate_cdm2.value_or(NAN)) + "," + cell(r.ghost_arcmin ? r.ghost_arcmin->mean : NAN) + "," +
          cell(r.ghost_arcmin ? r.ghost_arcmin->max : NAN);
  if (r.traced)
    for (const Interval& i : {r.traced->reflected, r.traced->transmitted})
      line += "," + cell(i.mean) + "," + cell(i.mean - i.half_width) + "," + cell(i.mean + i.half_width);
  return line + "\n";
}

std::string probe_line(const EyeValues& e, const ProbeValues& p) {
  std::string line = line_begin("probe", e);
  line += "," + std::to_string(p.pixel.x) + "," + std::to_string(p.pixel.y) + "," + cell(p.reflected) + "," +
          cell(p.transmitted) + "," + cell(p.reflected + p.transmitted);
  const std::optional<PaneSight>& pane = p.sight.pane;
  for (const double value : {pane ? pane->incidence_rad * kDegrees : NAN, pane ? pane->optics.surface.s : NAN,
                             pane ? pane->optics.surface.p : NAN, pane ? pane->optics.surface.mean() : NAN,
                             pane ? pane->optics.reflected.s : NAN, pane ? pane->optics.reflected.p : NAN,
                             pane ? pane->optics.reflected.mean() : NAN, pane ? pane->optics.transmitted.mean() : NAN,
                             p.ghost_arcmin.value_or(NAN), pane ? pane->distance_m : NAN})
    line += "," + cell(value);
  return line + "," + quoted(p.pane) + "," + quoted(p.mirrored) + "," + quoted(p.behind) + "\n";
}

}  // namespace

std::string measurement_json(const Measurement& m) {
  Json json;
  json["assumptions"] = Json::object();
  for (const auto& [name, value] : m.assumptions) json["assumptions"][name] = value;
  json["not_modelled"] = m.not_modelled;
  json["eyes"] = Json::array();
  for (const EyeValues& eye : m.eyes) json["eyes"].push_back(eye_json(eye));
  if (m.eyes.size() > 1 && m.eyes[m.worst].looks_through) {
    json["worst"] = {{"eye", m.eyes[m.worst].eye},
                     {"reflected_cdm2", number(m.eyes[m.worst].regions.front().reflected.mean)}};
    if (const auto& ghost = m.eyes[m.worst].regions.front().ghost_arcmin)
      json["worst"]["ghost_angle_arcmin"] = number(ghost->mean);
    for (const auto& [name, value] : m.eyes[m.worst].step) json["worst"]["step"][name] = number(value);
  }
  return json_text(json, 2) + "\n";
}

std::string measurement_csv(const Measurement& m) {
  std::string text, steps = ",eye_x_m,eye_y_m,eye_z_m";
  for (const auto& [name, value] : m.assumptions) text += "# " + name + ": " + value + "\n";
  for (const std::string& line : m.not_modelled) text += "# not modelled: " + line + "\n";
  for (const auto& [name, value] : m.eyes.front().step) steps += "," + name;
  text += "kind,eye" + steps + ",region,pane_pixels,looks_through_pane,lux_on_glass" +
          statistics_names("reflected_cdm2", true) + statistics_names("transmitted_cdm2", true) +
          statistics_names("sum_cdm2", true) + statistics_names("incidence_deg", false) +
          statistics_names("pane_reflectance", false) +
          ",contrast_kept_mean,veil_per_lux_cdm2,flat_estimate_cdm2,ghost_arcmin_mean,ghost_arcmin_max";
  if (m.eyes.front().regions.front().traced)
    text +=
        ",traced_reflected_mean,traced_reflected_low_95,traced_reflected_high_95,traced_transmitted_mean,"
        "traced_transmitted_low_95,traced_transmitted_high_95";
  text += "\n";
  for (const EyeValues& eye : m.eyes)
    for (const RegionValues& region : eye.regions) text += region_line(eye, region);
  if (m.eyes.front().probes.empty()) return text;
  text += "kind,eye" + steps +
          ",x,y,reflected_cdm2,transmitted_cdm2,sum_cdm2,incidence_deg,surface_reflectance_s,surface_reflectance_p,"
          "surface_reflectance,pane_reflectance_s,pane_reflectance_p,pane_reflectance,pane_transmittance,ghost_arcmin,"
          "pane_distance_m,pane,mirrors,behind\n";
  for (const EyeValues& eye : m.eyes)
    for (const ProbeValues& probe : eye.probes) text += probe_line(eye, probe);
  return text;
}

std::string measurement_text(const Measurement& m) {
  std::string text;
  char line[512];
  for (std::size_t i = 0; i < m.eyes.size(); ++i) {
    const EyeValues& e = m.eyes[i];
    std::string where = e.eye;
    for (const auto& [name, value] : e.step) where += ", " + name + " " + cell(value);
    if (!e.looks_through)
      where += " (does not look through the pane)";
    else if (m.eyes.size() > 1 && i == m.worst)
      where += " (the worst)";
    text += where + "\n";
    if (e.light) {
      std::snprintf(line, sizeof line, "  light on the glass %.0f lx, %.0f %% of it passes; rake %.1f deg\n",
                    e.light->illuminance_lx, 100.0 * e.light->transmitted_share, e.light->rake_deg);
      text += line;
    }
    for (const RegionValues& r : e.regions) {
      std::snprintf(line, sizeof line,
                    "  region %s (%zu pixels): reflected %s cd/m2 (%s to %s, median %s), transmitted %s, "
                    "incidence %.1f deg, R %.3f, contrast kept %.1f %%\n",
                    r.name.c_str(), r.pane_pixels, plain_number(r.reflected.mean).c_str(),
                    plain_number(r.reflected.min).c_str(), plain_number(r.reflected.max).c_str(),
                    plain_number(r.reflected.median).c_str(), plain_number(r.transmitted.mean).c_str(),
                    r.incidence_deg.mean, r.reflectance.mean, 100.0 * r.contrast);
      text += line;
      if (r.flat_estimate_cdm2) {
        std::snprintf(line, sizeof line, "    flat estimate %s cd/m2, measured %.2f times\n",
                      plain_number(*r.flat_estimate_cdm2).c_str(), r.reflected.mean / *r.flat_estimate_cdm2);
        text += line;
      }
      if (r.ghost_arcmin) {
        std::snprintf(line, sizeof line, "    ghost angle %.2f arc minutes (at most %.2f)\n", r.ghost_arcmin->mean,
                      r.ghost_arcmin->max);
        text += line;
      }
      if (r.traced) {
        std::snprintf(line, sizeof line,
                      "    path traced, %d paths a pixel: reflected %s +- %.2g, transmitted %s +- %.2g (95 %%)\n",
                      r.traced->paths, plain_number(r.traced->reflected.mean).c_str(), r.traced->reflected.half_width,
                      plain_number(r.traced->transmitted.mean).c_str(), r.traced->transmitted.half_width);
        text += line;
      }
    }
    for (const ProbeValues& p : e.probes) {
      std::snprintf(line, sizeof line, "  pixel %d,%d: reflected %s cd/m2, transmitted %s, sum %s; behind: %s\n",
                    p.pixel.x, p.pixel.y, plain_number(p.reflected).c_str(), plain_number(p.transmitted).c_str(),
                    plain_number(p.reflected + p.transmitted).c_str(), p.behind.c_str());
      text += line;
      if (!p.sight.pane) continue;
      const PaneOptics& o = p.sight.pane->optics;
      std::snprintf(line, sizeof line,
                    "    %s at %.3f m: incidence %.2f deg, surface R_s %.4f R_p %.4f R %.4f, pane R_s %.4f R_p %.4f R "
                    "%.4f; mirrors %s\n",
                    p.pane.c_str(), p.sight.pane->distance_m, p.sight.pane->incidence_rad * kDegrees, o.surface.s,
                    o.surface.p, o.surface.mean(), o.reflected.s, o.reflected.p, o.reflected.mean(),
                    p.mirrored.c_str());
      text += line;
    }
  }
  text += "not modelled: " + join(m.not_modelled, "; ") + "\n";
  return text;
}

namespace {

/// What is of the last eye alone: where it is, and what the sweeps' last step is.
std::vector<std::pair<std::string, std::string>> last_lines(const Measurement& m, const LastEye& last) {
  const auto point = [](const glm::vec3& p) {
    return cell(static_cast<double>(p.x)) + ", " + cell(static_cast<double>(p.y)) + ", " +
           cell(static_cast<double>(p.z));
  };
  const EyeValues& eye = m.eyes.back();
  std::string steps;
  for (const auto& [name, value] : eye.step) steps += (steps.empty() ? "" : ", ") + name + " " + cell(value);
  std::vector<std::pair<std::string, std::string>> lines = {
      {"camera", eye.eye + ": eye " + point(last.options.eye.value_or(glm::vec3(eye.position))) + " m, target " +
                     point(last.options.target.value_or(glm::vec3(0.0f))) + " m, up " +
                     point(last.options.up.value_or(glm::vec3(0.0f, 1.0f, 0.0f)))}};
  if (last.options.fov_deg)
    lines.back().second += ", " + cell(static_cast<double>(*last.options.fov_deg)) + " degrees high";
  if (!steps.empty()) lines.emplace_back("step", steps);
  if (eye.light) lines.emplace_back("light on the glass", cell(eye.light->illuminance_lx) + " lx");
  return lines;
}

}  // namespace

void write_layers(const std::string& path, const Measurement& measurement, const LastEye& last) {
  const Image& reflected = last.pictures.reflected;
  Image sum(reflected.width, reflected.height, 4, 1.0f), angles(reflected.width, reflected.height, 3);
  const auto rgb = [&](const Image& image) {
    Image out(image.width, image.height, 3);
    for (std::size_t i = 0; i < out.data.size() / 3; ++i)
      for (std::size_t c = 0; c < 3; ++c)
        out.data[3 * i + c] = image.data[i * static_cast<std::size_t>(image.channels) + c];
    return out;
  };
  const Image plain = rgb(reflected), transmitted = rgb(last.pictures.transmitted);
  for (std::size_t i = 0; i < last.sights.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) sum.data[4 * i + c] = plain.data[3 * i + c] + transmitted.data[3 * i + c];
    if (!last.sights[i].pane) continue;
    const PaneSight& pane = *last.sights[i].pane;
    angles.data[3 * i] = static_cast<float>(pane.incidence_rad * kDegrees);
    angles.data[3 * i + 1] = static_cast<float>(pane.optics.surface.mean());
    angles.data[3 * i + 2] = static_cast<float>(pane.optics.reflected.mean());
  }
  ImageLayers layers = {{"reflected", plain}, {"transmitted", transmitted}, {"angles", angles}};
  if (last.pictures.ghost) layers.emplace("ghost", rgb(*last.pictures.ghost));
  std::map<std::string, std::string> attributes;
  for (const auto& [name, value] : measurement.assumptions) attributes["maquette." + name] = value;
  for (const auto& [name, value] : last_lines(measurement, last)) attributes["maquette." + name] = value;
  attributes["maquette.not modelled"] = join(measurement.not_modelled, "; ");
  attributes["maquette.angles"] = "R: incidence in degrees, G: reflectance of the front face, B: of the pane";
  save_exr(path, sum, attributes, layers);
}

}  // namespace maquette
