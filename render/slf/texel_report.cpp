#include "render/slf/texel_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "render/reference/path_scene.h"
#include "render/slf/parabolic.h"

namespace maquette {

namespace {

constexpr int kDisc = 96;  ///< pixels of a lumisphere's side

Image draw_disc(const std::function<glm::vec3(const glm::vec3& direction)>& value) {
  Image image(kDisc, kDisc, 4);
  for (int y = 0; y < kDisc; ++y)
    for (int x = 0; x < kDisc; ++x) {
      const glm::vec2 p((2.0f * static_cast<float>(x) + 1.0f) / kDisc - 1.0f,
                        1.0f - (2.0f * static_cast<float>(y) + 1.0f) / kDisc);
      if (glm::dot(p, p) >= 1.0f) continue;
      const glm::vec3 v = value(shared::direction_from_parabolic(p));
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = v[c];
      image.at(x, y, 3) = 1.0f;
    }
  return image;
}

glm::vec3 read(const DirectionSpline& spline, const Eigen::VectorXf& light, const glm::vec3& direction) {
  glm::vec3 sum(0.0f);
  for (const DirectionSpline::Share& share : spline.shares(direction))
    for (int c = 0; c < 3; ++c) sum[c] += share.weight * light[3 * share.bin + c];
  return sum;
}

std::string text_of(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

Eigen::VectorXf outgoing_light(const LightField& field, std::size_t texel) {
  if (field.outgoing) return field.outgoing->radiance.col(static_cast<Eigen::Index>(texel));
  return outgoing_of_texels(field, std::span(&texel, 1), std::atomic<bool>{false})->radiance.col(0);
}

void add_codes(const LightField& field, std::size_t texel, PointReport* report) {
  if (field.interactions) {
    const InteractionCodes& table = field.interactions->codes;
    report->values.emplace_back("Clusters", "light " + std::to_string(table.light_cluster[texel]) + ", material " +
                                                std::to_string(table.material_cluster[texel]));
    return;
  }
  if (!field.compressed()) {
    report->values.emplace_back("Compression", "none");
    return;
  }
  report->values.emplace_back(
      "Cluster", std::to_string(field.fit.owner[texel]) + " of " + std::to_string(field.fit.pca.cluster_count()));
  std::string weights;
  for (Eigen::Index c = 0; c < field.fit.weights.rows(); ++c)
    weights += (c > 0 ? ", " : "") +
               text_of("%.3g", static_cast<double>(field.fit.weights(c, static_cast<Eigen::Index>(texel))));
  report->values.emplace_back("Weights", weights.empty() ? "none: means alone" : weights);
}

}  // namespace

std::optional<std::size_t> texel_at(const LightFieldAtlas& atlas, const FlatGeometry& geometry, std::uint32_t triangle,
                                    bool back, const glm::vec3& position) {
  const auto side = std::find_if(atlas.sides.begin(), atlas.sides.end(),
                                 [&](const AtlasSide& s) { return s.triangle == triangle && s.back == back; });
  if (side == atlas.sides.end()) return std::nullopt;
  const glm::dvec3 a(geometry.positions[side->vertices[0]]), b(geometry.positions[side->vertices[1]]),
      c(geometry.positions[side->vertices[2]]), p(position);
  const glm::dvec3 area = glm::cross(b - a, c - a);
  const double all = glm::dot(area, area);
  if (!(all > 0.0)) return std::nullopt;
  const double u = std::clamp(glm::dot(glm::cross(p - a, c - a), area) / all, 0.0, 1.0),
               v = std::clamp(glm::dot(glm::cross(b - a, p - a), area) / all, 0.0, 1.0 - u);
  const glm::dvec2 at =
      glm::dvec2(side->at[0]) * (1.0 - u - v) + glm::dvec2(side->at[1]) * u + glm::dvec2(side->at[2]) * v;
  const int x = std::clamp(static_cast<int>(at.x), 0, atlas.side - 1),
            y = std::clamp(static_cast<int>(at.y), 0, atlas.side - 1);
  const std::uint32_t texel = atlas.texel_of_cell[static_cast<std::size_t>(y * atlas.side + x)];
  if (texel == LightFieldAtlas::kNone) return std::nullopt;
  return texel;
}

PointReport describe_texel(const LightField& field, std::size_t texel) {
  const Lumisphere lumisphere(field.side);
  const DirectionSpline spline(lumisphere);
  const AtlasTexel& place = field.atlas.texels[texel];
  PointReport report;
  report.values.emplace_back("Texel", std::to_string(place.x) + ", " + std::to_string(place.y) + " of " +
                                          std::to_string(field.atlas.side) + " x " + std::to_string(field.atlas.side) +
                                          ", chart " + std::to_string(field.atlas.sides[place.side].chart));
  const std::span<const float> arriving = field.incident->field.texel(texel);
  glm::dvec3 irradiance(0.0);
  for (int b = 0; b < lumisphere.count(); ++b)
    for (int c = 0; c < 3; ++c)
      irradiance[c] += lumisphere.projected(b) * static_cast<double>(arriving[static_cast<std::size_t>(3 * b + c)]);
  report.values.emplace_back("Illuminance",
                             text_of("%.4g lx", 0.2126 * irradiance.x + 0.7152 * irradiance.y + 0.0722 * irradiance.z));
  if (field.incident->field.masked[texel]) report.values.emplace_back("Inside", "another body; its neighbour is shown");
  add_codes(field, texel, &report);
  const Eigen::VectorXf computed = outgoing_light(field, texel);
  const Eigen::VectorXf drawn = field.interactions ? field.interactions->decode(texel) : decode_texel(field, texel);
  const auto towards = [&](const glm::vec3& d) {
    return read(spline, drawn, field.interactions ? field.interactions->codes.turns[texel].to_btf(d) : d);
  };
  double squares = 0.0, light = 0.0, all = 0.0;
  for (int b = 0; b < lumisphere.count(); ++b) {
    const glm::dvec3 truth(read(spline, computed, lumisphere.direction(b)));
    const glm::dvec3 gap = glm::dvec3(towards(lumisphere.direction(b))) - truth;
    squares += lumisphere.solid_angle(b) * glm::dot(gap, gap);
    light += lumisphere.solid_angle(b) * (truth.x + truth.y + truth.z);
    all += 3.0 * lumisphere.solid_angle(b);
  }
  if (light > 0.0)
    report.values.emplace_back("Error",
                               text_of("%.3g %% RMS by compression", 100.0 * std::sqrt(squares / all) / (light / all)));
  report.pictures.push_back({"arriving", draw_disc([&](const glm::vec3& d) {
                               const float* bin = arriving.data() + 3 * lumisphere.bin_of(d);
                               return glm::vec3(bin[0], bin[1], bin[2]);
                             })});
  report.pictures.push_back({"leaving", draw_disc([&](const glm::vec3& d) { return read(spline, computed, d); })});
  report.pictures.push_back({"as drawn", draw_disc(towards)});
  report.pictures.push_back(
      {"difference", draw_disc([&](const glm::vec3& d) { return glm::abs(towards(d) - read(spline, computed, d)); })});
  return report;
}

}  // namespace maquette
