#include "render/prt/material_btf.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "render/reference/scattering.h"
#include "scenes/btf/factorise.h"
#include "scenes/btf/half_floats.h"
#include "scenes/error.h"
#include "scenes/parallel.h"
#include "scenes/srgb.h"

namespace maquette {

namespace {

constexpr int kColorCount = 3;
constexpr double kRingStep = 7.5;  ///< degrees: finer than a texel of 16 x 16 faces is wide
constexpr int kRings = 11;

std::vector<glm::dvec3> fine_directions() {
  std::vector<glm::dvec3> directions{glm::dvec3(0.0, 0.0, 1.0)};
  for (int ring = 1; ring <= kRings; ++ring)
    for (int i = 0; i < 6 * ring; ++i) directions.push_back(direction_of_angles(kRingStep * ring, 60.0 * i / ring));
  return directions;
}

constexpr int kMostTexels = 128;  ///< a side of a textured material

/// Mean of the texels of an image under a texel of `side` x `side`, moved by an offset; linear.
glm::vec3 mean_color(const TextureImage& image, const glm::vec2& offset, int side, int x, int y) {
  const auto place = [](int texel, float shift, int count, int size, int k) {
    const double at = (static_cast<double>(texel) + (k + 0.5) / 4.0) / count + static_cast<double>(shift);
    return static_cast<int>((at - std::floor(at)) * size) % size;
  };
  glm::dvec3 sum(0.0);
  for (int k = 0; k < 16; ++k) {
    const int i = place(x, offset.x, side, image.width, k % 4), j = place(y, offset.y, side, image.height, k / 4);
    const std::uint8_t* texel = image.rgba.data() + 4 * (static_cast<std::size_t>(j * image.width + i));
    for (int c = 0; c < 3; ++c) sum[c] += linear_from_srgb(texel[c] / 255.0);
  }
  return glm::vec3(sum / 16.0);
}

/// What a light weight is made of: values at the lights less their mean, with the mean square 1.
struct CentredWeights {
  double mean = 0.0, deviation = 0.0;
  std::vector<float> weights;
};
CentredWeights centred(const std::vector<double>& values, const std::vector<double>& shares) {
  CentredWeights w;
  for (std::size_t l = 0; l < values.size(); ++l) w.mean += shares[l] * values[l];
  for (std::size_t l = 0; l < values.size(); ++l)
    w.deviation += shares[l] * (values[l] - w.mean) * (values[l] - w.mean);
  w.deviation = std::sqrt(w.deviation);
  for (const double value : values)
    w.weights.push_back(w.deviation > 1e-12 ? static_cast<float>((value - w.mean) / w.deviation) : 0.0f);
  return w;
}

double finite_or_zero(double value) { return std::isfinite(value) ? value : 0.0; }

/// As factorise_btf_view of one texel, by the covariance of its three colours instead of that of all lights.
BtfView factorise_colors(const glm::dvec3& direction, const BtfLights& lights, const std::vector<glm::dvec3>& colors) {
  BtfView view;
  view.direction = direction;
  view.lights = lights.mesh;
  glm::dvec3 mean(0.0);
  for (std::size_t l = 0; l < colors.size(); ++l) mean += lights.shares[l] * colors[l];
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t l = 0; l < colors.size(); ++l) {
    const glm::dvec3 d = colors[l] - mean;
    const Eigen::Vector3d x(d.x, d.y, d.z);
    covariance += lights.shares[l] * x * x.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  view.light_weights.assign(kColorCount * colors.size(), 0.0f);
  for (int c = 0; c < 3; ++c) view.factors.push_back(half_of_float(static_cast<float>(mean[c])));
  for (int k = 0; k < kColorCount; ++k) {
    const Eigen::Vector3d axis = solver.eigenvectors().col(2 - k);
    const double deviation = std::sqrt(std::max(solver.eigenvalues()[2 - k], 0.0));
    const bool counts = deviation > 1e-6 * std::sqrt(std::max(solver.eigenvalues()[2], 0.0)) && deviation > 0.0;
    for (int c = 0; c < 3; ++c)
      view.factors.push_back(counts ? half_of_float(static_cast<float>(deviation * axis[c])) : std::uint16_t{0});
    for (std::size_t l = 0; counts && l < colors.size(); ++l) {
      const glm::dvec3 d = colors[l] - mean;
      view.light_weights[l * kColorCount + static_cast<std::size_t>(k)] =
          static_cast<float>((axis[0] * d.x + axis[1] * d.y + axis[2] * d.z) / deviation);
    }
  }
  return view;
}

/// rho = base(texel) * scaled(light, view) + rest(light, view): two components without a decomposition.
std::shared_ptr<const Btf> make_textured_btf(const SurfacePoint& point, const TextureImage& image) {
  const Material& m = point.material->values;
  auto btf = std::make_shared<Btf>();
  btf->name = m.name;
  btf->components = 2;
  btf->texel_m = 1.0;
  int side = 1;
  while (side < kMostTexels && side < std::max(image.width, image.height)) side *= 2;
  btf->width = btf->height = side;
  std::vector<glm::vec3> colors;
  for (int i = 0; i < side * side; ++i)
    colors.push_back(glm::vec3(m.base_color) *
                     mean_color(image, m.base_color_texture.offset, side, i % side, i / side));
  const std::vector<glm::dvec3> views = ubo_directions(), directions = fine_directions();
  const BtfLights lights = make_btf_lights(directions);
  btf->views.resize(views.size());
  double of_color = 0.0, of_rest = 0.0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    SurfacePoint black = point, white = point;
    black.wo = white.wo = glm::vec3(views[v]);
    black.analytic.diffuse = black.tint = glm::vec3(0.0f);
    white.analytic.diffuse = white.tint = glm::vec3(1.0f);
    std::vector<double> scaled, rest;
    for (const glm::dvec3& light : directions) {
      const glm::vec3 wi(light);
      const glm::vec3 low = evaluate_brdf(black, prepare_brdf(black, wi)),
                      high = evaluate_brdf(white, prepare_brdf(white, wi)) - low;
      rest.push_back(static_cast<double>(low.y));
      scaled.push_back(static_cast<double>(high.y));
      of_rest = std::max(of_rest, static_cast<double>(std::abs(high.y) + low.y));
      of_color = std::max({of_color, static_cast<double>(std::abs(low.x - low.y) + std::abs(low.z - low.y)),
                           static_cast<double>(std::abs(high.x - high.y) + std::abs(high.z - high.y))});
    }
    const CentredWeights a = centred(scaled, lights.shares), b = centred(rest, lights.shares);
    BtfView& view = btf->views[v];
    view.direction = views[v];
    view.lights = lights.mesh;
    for (std::size_t l = 0; l < directions.size(); ++l)
      view.light_weights.insert(view.light_weights.end(), {a.weights[l], b.weights[l]});
    for (const glm::vec3& color : colors)
      for (const glm::dvec3& g :
           {a.mean * glm::dvec3(color) + b.mean, a.deviation * glm::dvec3(color), glm::dvec3(b.deviation)})
        for (int c = 0; c < 3; ++c) view.factors.push_back(half_of_float(static_cast<float>(g[c])));
  }
  if (of_color > 1e-3 * of_rest)
    throw Error("material " + m.name, "precomputed radiance transfer cannot hold a texture beside coloured reflections",
                "shade its parts by another mode (--mode-of), or leave them out (prt.parts)");
  complete_btf(btf.get());
  return btf;
}

}  // namespace

std::string check_transfer_material(const Material& m) {
  for (const auto texture : kMaterialTextures) {
    if (texture == &Material::emissive_texture || texture == &Material::occlusion_texture) continue;
    if (!m.measured.empty() && texture != &Material::normal_texture &&
        !(m.tint_measured && texture == &Material::base_color_texture))
      continue;
    if (!(m.*texture)) continue;
    if (texture != &Material::base_color_texture) return "it has textures besides that of its base colour; take a BTF";
    const TextureRef& t = m.base_color_texture;
    if (m.measured.empty() && m.metallic > 0.0f) return "it is a metal with a texture";
    if (t.uv_set != 0 || t.rotation_rad != 0.0f || t.wrap_s != Wrap::repeat || t.wrap_t != Wrap::repeat)
      return "its texture does not repeat along the first texture coordinates";
    if (t.nearest) return "its texture is not interpolated (NEAREST)";
  }
  if (m.anisotropy > 0.0f && m.measured.empty()) return "it is anisotropic";
  if (m.unlit) return "it is unlit";
  return {};
}

std::shared_ptr<const Btf> make_material_btf(const SurfacePoint& point, const std::vector<TextureImage>& images) {
  if (point.material->btf) return point.material->btf;
  const Material& m = point.material->values;
  if (m.base_color_texture && (m.measured.empty() || m.tint_measured))
    return make_textured_btf(point, images[static_cast<std::size_t>(m.base_color_texture.image)]);
  auto btf = std::make_shared<Btf>();
  btf->name = m.name;
  btf->width = btf->height = 1;
  btf->components = kColorCount;
  btf->texel_m = 1.0;
  const std::vector<glm::dvec3> views = ubo_directions(), directions = fine_directions();
  const BtfLights lights = make_btf_lights(directions);
  btf->views.resize(views.size());
  parallel_for(std::size_t{0}, views.size(), [&](std::size_t v) {
    SurfacePoint p = point;
    p.wo = glm::vec3(views[v]);
    std::vector<glm::dvec3> colors;
    for (const glm::dvec3& light : directions) {
      const glm::vec3 wi(light);
      const glm::dvec3 rho(evaluate_brdf(p, prepare_brdf(p, wi)));
      colors.push_back({finite_or_zero(rho.x), finite_or_zero(rho.y), finite_or_zero(rho.z)});
    }
    btf->views[v] = factorise_colors(views[v], lights, colors);
  });
  complete_btf(btf.get());
  return btf;
}

}  // namespace maquette
