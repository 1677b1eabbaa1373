#include "viewer/inspect_btf.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "render/btf/btf_source.h"
#include "viewer/btf_preparation.h"
#include "viewer/interrupt.h"
#include "viewer/json_values.h"

namespace maquette {

namespace {

using Json = nlohmann::ordered_json;

Json rgb_json(const glm::dvec3& rgb) { return {number(rgb.r), number(rgb.g), number(rgb.b)}; }

/// Share of light from the whole hemisphere that the mean texel sends to a view.
glm::dvec3 albedo_towards(const Btf& btf, const BtfView& view) {
  const std::vector<double> shares = view.lights->quadrature().projected;
  glm::dvec3 albedo(0.0);
  for (std::size_t l = 0; l < shares.size(); ++l)
    albedo += shares[l] * glm::dvec3(evaluate_btf(btf, {glm::vec2(0.5f), 1.0f}, glm::vec3(view.lights->directions()[l]),
                                                  glm::vec3(view.direction)));
  return albedo;
}

Json albedo_json(const Btf& btf) {
  std::vector<const BtfView*> views;
  for (const BtfView& view : btf.views) views.push_back(&view);
  std::sort(views.begin(), views.end(), [](const auto* a, const auto* b) { return a->direction.z > b->direction.z; });
  double highest = 0.0;
  for (const BtfView* view : views) {
    const glm::dvec3 albedo = albedo_towards(btf, *view);
    highest = std::max({highest, albedo.r, albedo.g, albedo.b});
  }
  return {{"of_the_steepest_view", rgb_json(albedo_towards(btf, *views.front()))},
          {"of_the_flattest_view", rgb_json(albedo_towards(btf, *views.back()))},
          {"highest", number(highest)}};
}

/// Mean over the views.
double mean_of(const Btf& btf, double BtfViewFigures::*figure) {
  double sum = 0.0;
  for (const BtfView& view : btf.views) sum += view.figures.*figure;
  return sum / static_cast<double>(btf.views.size());
}

Json kept_json(const Btf& btf) {
  double all = 0.0;
  for (const BtfView& view : btf.views) all += view.figures.energy + view.figures.mean_energy;
  const double varying = mean_of(btf, &BtfViewFigures::energy) * static_cast<double>(btf.views.size());
  Json json = Json::object();
  std::vector<int> counts = {2, 4, 8};
  if (std::find(counts.begin(), counts.end(), btf.components) == counts.end()) counts.push_back(btf.components);
  for (const int count : counts) {
    const double kept = btf_energy_kept(btf, count);
    const double error = all > 0.0 ? std::sqrt((1.0 - kept) * varying / all) : 0.0;
    json["of_" + std::to_string(count) + "_components"] = {{"energy_kept", number(kept)},
                                                           {"relative_error", number(error)}};
  }
  return json;
}

}  // namespace

Json inspect_btf(const std::string& source) {
  const InterruptGuard guard;
  const std::shared_ptr<const Btf> btf = load_btf(source, print_btf_task(InterruptGuard::flag()));
  std::size_t least = btf->views[0].lights->size(), most = least, bytes = 0;
  for (const BtfView& view : btf->views) {
    least = std::min(least, view.lights->size());
    most = std::max(most, view.lights->size());
    bytes += view.factors.size() * sizeof(view.factors[0]) + view.light_weights.size() * sizeof(float);
  }
  Json json;
  json["kind"] = "BTF";
  json["name"] = btf->name;
  json["texels"] = {btf->width, btf->height};
  json["texel_mm"] = number(1e3 * btf->texel_m);
  json["views"] = btf->views.size();
  json["lights_of_a_view"] = least == most ? Json(most) : Json{least, most};
  json["components"] = btf->components;
  for (const auto& [name, value] : btf->provenance) json[name] = value;
  json["factorisation"] = kept_json(*btf);
  json["contrast"] = number(mean_of(*btf, &BtfViewFigures::contrast));
  json["dark_share"] = number(mean_of(*btf, &BtfViewFigures::shadowed));
  json["albedo"] = albedo_json(*btf);
  json["memory_bytes"] = bytes;
  return json;
}

}  // namespace maquette
