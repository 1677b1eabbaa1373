#include "viewer/budget_curve.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <span>

#include "scenes/files.h"
#include "scenes/percent.h"
#include "viewer/report/content_key.h"

namespace maquette {

namespace {

constexpr const char* kKind = "error-curves";
constexpr int kVersion = 1;

}  // namespace

std::string curve_name(const std::string& mode, bool all_light) { return mode + (all_light ? "/all" : "/direct"); }

std::optional<BudgetPoint> samples_for_budget(const BudgetCurve& curve, double budget, std::string* why) {
  if (curve.points.empty()) {
    *why = "Nothing was measured.";
    return std::nullopt;
  }
  std::vector<BudgetPoint> points = curve.points;
  std::sort(points.begin(), points.end(),
            [](const BudgetPoint& a, const BudgetPoint& b) { return a.samples < b.samples; });
  const BudgetPoint best = *std::min_element(
      points.begin(), points.end(), [](const BudgetPoint& a, const BudgetPoint& b) { return a.error < b.error; });
  if (best.samples == 0) {
    *why = "This mode has no setting that trades time for error; its error is " + percent_text(best.error) + ".";
    return std::nullopt;
  }
  if (best.error > budget) {
    *why = "It cannot be kept: the smallest error measured is " + percent_text(best.error) + " (" +
           std::to_string(best.samples) + " samples)";
    // Noise alone would halve with four times the samples.
    constexpr double kFlat = 0.8;
    const bool flat = std::ranges::any_of(points, [&](const BudgetPoint& p) {
      return p.samples >= 2 * best.samples || (2 * p.samples <= best.samples && kFlat * p.error < best.error);
    });
    *why += flat ? ". More samples hardly lower it: what is left is light that the mode does not compute."
                 : ". More samples would lower it further.";
    return std::nullopt;
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].error > budget) continue;
    if (i == 0) return points[0];
    const BudgetPoint &a = points[i - 1], &b = points[i];
    const double share = std::log(a.error / budget) / std::log(a.error / b.error);
    const double samples = a.samples * std::pow(static_cast<double>(b.samples) / a.samples, share);
    // Rounded up, so that the budget is kept.
    return BudgetPoint{std::min(static_cast<int>(std::ceil(samples * (1.0 - 1e-9))), b.samples),
                       a.time_ms * std::pow(b.time_ms / a.time_ms, share), budget};
  }
  return best;
}

std::uint64_t curves_key(const Scene& scene, const Environment& environment) {
  const std::string text = report::scene_key(scene).text();
  return content_hash(std::as_bytes(std::span(text)), content_key(environment));
}

void store_curves(std::uint64_t key, const BudgetCurves& curves) {
  nlohmann::json json;
  for (const auto& [name, curve] : curves) {
    nlohmann::json points = nlohmann::json::array();
    for (const BudgetPoint& p : curve.points) points.push_back({p.samples, p.time_ms, p.error});
    json[name] = {{"source", curve.source}, {"points", points}};
  }
  const std::string text = json.dump();
  cache_store(kKind, kVersion, key, std::as_bytes(std::span(text)));
}

BudgetCurves load_curves(std::uint64_t key) {
  BudgetCurves curves;
  const std::optional<std::vector<std::byte>> bytes = cache_load(kKind, kVersion, key);
  if (!bytes) return curves;
  try {
    const auto* text = reinterpret_cast<const char*>(bytes->data());
    const nlohmann::json json = nlohmann::json::parse(text, text + bytes->size());
    for (const auto& [name, curve] : json.items()) {
      curves[name].source = curve.at("source");
      for (const auto& p : curve.at("points")) curves[name].points.push_back({p.at(0), p.at(1), p.at(2)});
    }
  } catch (const nlohmann::json::exception&) {
    curves.clear();  // as if there were none
  }
  return curves;
}

}  // namespace maquette
