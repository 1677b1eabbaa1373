// What the figures of a measurement rest on, in words.
#include <cstdio>

#include "render/inspection/not_modelled.h"
#include "render/scene_state/material_overrides.h"
#include "render/technique/registry.h"
#include "scenes/suggest.h"
#include "viewer/measure/measure_run.h"
#include "viewer/session.h"

namespace maquette {

namespace {

std::string number_text(double value) { return to_text(SettingValue(value)); }
std::string number_text(int value) { return std::to_string(value); }

std::string short_number(float value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", static_cast<double>(value));
  return text;
}

std::string point_text(const glm::vec3& p) {
  return short_number(p.x) + ", " + short_number(p.y) + ", " + short_number(p.z);
}

std::string dent_text(const Dent& d) {
  return short_number(d.depth_m) + " m deep, radius " + short_number(d.radius_m) + " m, at " + point_text(d.center) +
         (d.part.empty() ? "" : " of " + d.part);
}

using Lines = std::vector<std::pair<std::string, std::string>>;

/// What was changed of the scene's file. Light and camera are said elsewhere.
Lines edit_lines(const Edits& e) {
  std::vector<std::string> materials, dents, turns;
  for (const auto& [name, source] : e.materials) materials.push_back(name + "=" + source);
  for (const Dent& dent : e.dents) dents.push_back(dent_text(dent));
  for (const NodeTurn& turn : e.turns)
    turns.push_back(turn.node + " by " + number_text(static_cast<double>(turn.angle_deg)) + " degrees about " +
                    point_text(turn.axis));
  const std::vector<std::string> hidden(e.hidden_nodes.begin(), e.hidden_nodes.end()),
      reflectors(e.reflectors.begin(), e.reflectors.end());
  Lines lines = {{"variant", e.variant},
                 {"materials", join(materials, "; ")},
                 {"dents", join(dents, "; ")},
                 {"turned parts", join(turns, "; ")},
                 {"hidden parts", join(hidden, "; ")},
                 {"reflectors", join(reflectors, "; ")}};
  if (!e.animation.name.empty())
    lines.emplace_back("animation", e.animation.name + " at " + number_text(e.animation.time_s) + " s");
  if (e.section != glm::vec4(0.0f))
    lines.emplace_back("section plane", "what is seen has p . (" + point_text(glm::vec3(e.section)) +
                                            ") <= " + short_number(e.section.w) + " m");
  std::erase_if(lines, [](const auto& line) { return line.second.empty(); });
  return lines;
}

std::string changed_settings(const Settings& settings) {
  std::vector<std::string> texts;
  for (const auto& [name, value] : settings.changed()) texts.push_back(name + "=" + to_text(value));
  return texts.empty() ? "as declared" : join(texts, ", ");
}

/// How often each pixel's light was estimated.
std::string samples_text(const SceneOptions& s, bool paths) {
  if (paths) return number_text(s.samples > 0 ? s.samples : kPathsOfAPixel) + " paths a pixel and side of the pane";
  return (s.samples > 0 ? number_text(s.samples) : std::string("the mode's own number of")) + " samples, mean of " +
         number_text(s.frames > 0 ? s.frames : kFramesOfLayer) + " frames";
}

}  // namespace

void add_assumptions(const SceneOptions& s, const MeasureOptions& o, const Scene& scene, int pane,
                     const std::string& dash, Measurement* m) {
  const auto add = [&](const std::string& name, const std::string& value) { m->assumptions.emplace_back(name, value); };
  const bool paths = builtin_registry().find_mode(s.mode).can.traces_picture;
  add("scene", s.scene + (s.scene_of_file.empty() ? "" : ", its scene " + s.scene_of_file));
  Edits edits = o.edits ? *o.edits : look_of_options(scene, s).edits;
  if (!o.edits) edits.hidden_nodes = s.hidden;
  for (const auto& [name, value] : edit_lines(edits)) add(name, value);
  add("environment",
      s.environment + ", rotated by " + number_text(static_cast<double>(s.env_rotation_deg)) + " degrees");
  add("light", o.night          ? "no light from outside"
               : o.lux_on_glass ? "the environment is scaled to " + number_text(*o.lux_on_glass) +
                                      " lx on the pane's outer face (mean of 16 points, shadowed by the scene's opaque "
                                      "surfaces, nothing reflected by them)"
                                : "the environment times " + number_text(static_cast<double>(s.env_scale)));
  add("mode", s.mode + (paths ? ", paths that begin with the reflected or transmitted ray of the nearest pane"
                              : ", reflections by " + s.reflections));
  add("picture", std::to_string(s.width) + "x" + std::to_string(s.height) + ", rays through pixel centres");
  add("samples", samples_text(s, paths) + ", seed " + number_text(static_cast<int>(s.seed)));
  add("settings", changed_settings(s.settings));
  add("eye",
      o.eye ? o.eye->point + " from the R-point" + (o.right_hand_drive ? ", right-hand drive" : ", left-hand drive")
            : "camera " + (s.camera.empty() ? std::string("of the options") : s.camera));
  if (o.grid_columns * o.grid_rows > 1)
    add("eye box", number_text(o.eye_box_mm.x) + " x " + number_text(o.eye_box_mm.y) + " mm around it, " +
                       std::to_string(o.grid_columns) + " x " + std::to_string(o.grid_rows) + " eyes");
  add("vehicle axes", o.axes + " are rearward, right, up in the scene");
  if (o.eye) add("R-point", point_text(glm::vec3(r_point_of(scene, o))) + " m");
  add("pane", scene.nodes[static_cast<std::size_t>(pane)].name);
  add("pane formula",
      "both faces with all bounces, incoherent, each polarisation by itself, then averaged; internal transmittance is "
      "the base colour, the same at all angles");
  add("polarisation", o.polarisation == Polarisation::all ? "both, the light at the pane unpolarised"
                      : o.polarisation == Polarisation::s ? "s alone"
                      : o.polarisation == Polarisation::p
                          ? "p alone"
                          : "through an ideal polariser, its axis upright before the eye; the light at the pane "
                            "unpolarised");
  if (o.dash_reflectance || !o.dash.empty())
    add("dashboard", dash + (o.dash_reflectance ? ", Lambertian, reflectance " + number_text(*o.dash_reflectance)
                                                : std::string(", reflectance by the sweep")));
  add("flat estimate",
      "E tau rho / pi R: illuminance on the glass, its transmitted share, the dashboard's reflectance, R at "
      "each pixel's own incidence");
  add("veil per lux",
      "mean reflected luminance over the illuminance on the glass: an index of this program, no standard");
  add("contrast kept", o.background_cdm2
                           ? "of an object of " + number_text(*o.background_cdm2) + " cd/m2 seen through the pane"
                           : std::string("of what each pixel shows through the pane"));
  add("ghost angle", "between both images of what the pixel mirrors, pane locally flat; thickness " +
                         number_text(s.settings.get_double("reflections.thickness")) + " mm, wedge " +
                         number_text(s.settings.get_double("reflections.wedge")) + " mrad upwards");
  add("threshold", number_text(o.threshold_cdm2) + " cd/m2");
  m->not_modelled.assign(kNotModelled.begin(), kNotModelled.end());
}

}  // namespace maquette
