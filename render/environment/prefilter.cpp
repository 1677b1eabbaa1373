#include "render/environment/prefilter.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <functional>
#include <numbers>
#include <span>

#include "render/environment/octahedral_pyramid.h"
#include "scenes/files.h"
#include "scenes/parallel.h"

namespace maquette {
namespace {

constexpr int kSampleCount = 192;
/// Each sample averages over this multiple of its share of the lobe, so that neighbours overlap and leave no pattern.
constexpr double kOverlap = 2.0;
constexpr int kPrefilterVersion = 2;
/// Cells along a side: each sample of a cosine lobe averages over at least 2 pi / kSampleCount sr, which is 43 of these
/// cells.
constexpr int kDiffuseCells = 128;

/// A direction of the lobe around +Z and the solid angle that it represents.
struct LobeSample {
  glm::vec3 direction{};
  float solid_angle_sr;
};

/// kSampleCount directions of equal weight for a lobe of density `kernel(theta)` per solid angle (any scale) up to
/// `theta_max`: uniform in the lobe's cumulative energy, golden angles in azimuth. Filtered importance sampling: each
/// averages over its share of the sphere. Source: Krivanek and Colbert 2008, "Real-time Shading with Filtered
/// Importance Sampling".
std::vector<LobeSample> sample_lobe(const std::function<double(double)>& kernel, double theta_max) {
  constexpr int kSteps = 8192;
  // Steps grow quadratically, to resolve the centre of sharp lobes.
  const auto theta_at = [&](double t) { return theta_max * t * t; };
  std::vector<double> cumulated(kSteps + 1, 0.0);
  for (int i = 0; i < kSteps; ++i) {
    const double begin = theta_at(static_cast<double>(i) / kSteps), end = theta_at(static_cast<double>(i + 1) / kSteps);
    const double middle = 0.5 * (begin + end);
    cumulated[static_cast<std::size_t>(i) + 1] =
        cumulated[static_cast<std::size_t>(i)] +
        2.0 * std::numbers::pi * kernel(middle) * std::sin(middle) * (end - begin);
  }
  const double total = cumulated.back();
  std::vector<LobeSample> samples;
  std::size_t step = 0;
  for (int i = 0; i < kSampleCount; ++i) {
    const double target = total * (i + 0.5) / kSampleCount;
    while (cumulated[step + 1] < target) ++step;
    const double part = (target - cumulated[step]) / (cumulated[step + 1] - cumulated[step]);
    const double theta = theta_at((static_cast<double>(step) + part) / kSteps);
    const double phi = std::numbers::pi * (3.0 - std::sqrt(5.0)) * i;
    samples.push_back(
        {glm::vec3(glm::dvec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta))),
         static_cast<float>(kOverlap * total / (kSampleCount * std::max(kernel(theta), 1e-300 * total)))});
  }
  return samples;
}

Image convolve(const OctahedralPyramid& pyramid, const std::vector<LobeSample>& lobe, int width) {
  const int height = width / 2;
  Image image(width, height, 3);
  parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const glm::vec3 n(direction_from_latlong(x + 0.5, y + 0.5, width, height));
      const glm::vec3 tangent =
          glm::normalize(std::abs(n.y) < 0.9f ? glm::cross(glm::vec3(0, 1, 0), n) : glm::cross(glm::vec3(1, 0, 0), n));
      const glm::vec3 bitangent = glm::cross(n, tangent);
      glm::vec3 sum(0.0f);
      for (const LobeSample& s : lobe)
        sum +=
            pyramid.lookup(tangent * s.direction.x + bitangent * s.direction.y + n * s.direction.z, s.solid_angle_sr);
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = sum[c] / kSampleCount;
    }
  });
  return image;
}

/// Power of two with about one texel per lobe width.
int map_width(double lobe_rad, int largest) {
  const double texels = std::min(2.0 * std::numbers::pi / lobe_rad, 65536.0);
  return std::clamp(static_cast<int>(std::bit_ceil(static_cast<unsigned>(texels))), 32, largest);
}

/// The environment at no more than 1024 x 512, averaged over area.
Image mirror_map(const Environment& environment) {
  const int factor = (environment.width + 1023) / 1024;
  const int width = std::max(1, environment.width / factor), height = std::max(1, environment.height / factor);
  Image image(width, height, 3);
  parallel_for(0, height, [&](int y) {
    const int begin_y = static_cast<int>(static_cast<long long>(y) * environment.height / height);
    const int end_y =
        std::max(begin_y + 1, static_cast<int>(static_cast<long long>(y + 1) * environment.height / height));
    for (int x = 0; x < width; ++x) {
      const int begin_x = static_cast<int>(static_cast<long long>(x) * environment.width / width);
      const int end_x =
          std::max(begin_x + 1, static_cast<int>(static_cast<long long>(x + 1) * environment.width / width));
      glm::dvec3 sum(0.0);
      for (int sy = begin_y; sy < end_y; ++sy)
        for (int sx = begin_x; sx < end_x; ++sx)
          sum += glm::dvec3(environment.rgb[static_cast<std::size_t>(sy) * static_cast<std::size_t>(environment.width) +
                                            static_cast<std::size_t>(sx)]);
      for (int c = 0; c < 3; ++c)
        image.at(x, y, c) = static_cast<float>(sum[c] / ((end_y - begin_y) * (end_x - begin_x)));
    }
  });
  return image;
}

/// Cached bytes: for each map two int32 (width, height), then its floats.
std::vector<std::byte> pack(const std::vector<Image>& maps) {
  std::vector<std::byte> bytes;
  for (const Image& map : maps) {
    const std::int32_t size[2] = {map.width, map.height};
    const auto header = std::as_bytes(std::span(size));
    const auto values = std::as_bytes(std::span(map.data));
    bytes.insert(bytes.end(), header.begin(), header.end());
    bytes.insert(bytes.end(), values.begin(), values.end());
  }
  return bytes;
}

/// Empty when the bytes are not `count` maps.
std::vector<Image> unpack(const std::vector<std::byte>& bytes, std::size_t count) {
  std::vector<Image> maps;
  std::size_t position = 0;
  for (std::size_t i = 0; i < count; ++i) {
    std::int32_t size[2] = {0, 0};
    if (bytes.size() - position < sizeof size) return {};
    std::memcpy(size, bytes.data() + position, sizeof size);
    position += sizeof size;
    if (size[0] < 1 || size[1] < 1 || size[0] > 4096 || size[1] > 4096) return {};
    Image map(size[0], size[1], 3);
    const std::size_t map_bytes = map.data.size() * sizeof(float);
    if (bytes.size() - position < map_bytes) return {};
    std::memcpy(map.data.data(), bytes.data() + position, map_bytes);
    position += map_bytes;
    maps.push_back(std::move(map));
  }
  return position == bytes.size() ? maps : std::vector<Image>{};
}

std::vector<Image> through_cache(const char* kind, const Environment& environment, std::span<const float> parameters,
                                 const std::function<std::vector<Image>()>& compute) {
  const std::uint64_t key = content_hash(std::as_bytes(parameters), content_key(environment));
  if (const auto bytes = cache_load(kind, kPrefilterVersion, key)) {
    std::vector<Image> maps = unpack(*bytes, parameters.size());
    if (!maps.empty()) return maps;
  }
  std::vector<Image> maps = compute();
  cache_store(kind, kPrefilterVersion, key, pack(maps));
  return maps;
}

/// Smith masking of one direction in the form without Lambda. Source: Walter et al. 2007, Eq. 34.
double smith_g1(double cosine, double alpha) {
  const double a2 = alpha * alpha;
  return 2.0 * cosine / (cosine + std::sqrt(a2 + (1.0 - a2) * cosine * cosine));
}

}  // namespace

std::vector<Image> prefilter_ggx(const Environment& environment, int level_count) {
  assert(level_count >= 2);
  std::vector<float> alphas;
  for (int i = 0; i < level_count; ++i) {
    const float roughness = static_cast<float>(i) / static_cast<float>(level_count - 1);
    alphas.push_back(roughness * roughness);
  }
  return through_cache("prefilter-ggx", environment, alphas, [&] {
    const OctahedralPyramid pyramid(environment);
    std::vector<Image> maps = {mirror_map(environment)};
    for (std::size_t i = 1; i < alphas.size(); ++i) {
      const double a2 = static_cast<double>(alphas[i]) * static_cast<double>(alphas[i]);
      // The half vector stands at half the angle of l; its density D cos(h) becomes D / 4 over l, times n.l.
      const auto kernel = [a2](double theta) {
        const double c = std::cos(0.5 * theta), d = c * c * (a2 - 1.0) + 1.0;
        return a2 / (d * d) * std::max(0.0, std::cos(theta));
      };
      maps.push_back(convolve(pyramid, sample_lobe(kernel, std::numbers::pi / 2.0),
                              map_width(static_cast<double>(alphas[i]), 256)));
    }
    return maps;
  });
}

std::vector<Image> prefilter_sg(const Environment& environment, const std::vector<float>& sharpness) {
  return through_cache("prefilter-sg", environment, sharpness, [&] {
    const OctahedralPyramid pyramid(environment);
    std::vector<Image> maps;
    for (const float value : sharpness) {
      assert(value > 0.0f);
      const double lambda = static_cast<double>(value);
      // Beyond 1 - cos = 30 / sharpness the lobe is negligible.
      const double theta_max = std::acos(std::max(-1.0, 1.0 - 30.0 / lambda));
      const auto kernel = [lambda](double theta) {
        return std::exp(-2.0 * lambda * std::pow(std::sin(0.5 * theta), 2));
      };
      maps.push_back(convolve(pyramid, sample_lobe(kernel, theta_max), map_width(1.0 / std::sqrt(lambda), 512)));
    }
    return maps;
  });
}

Image prefilter_diffuse(const Environment& environment) {
  const float parameters[1] = {0.0f};
  return through_cache("prefilter-diffuse", environment, parameters, [&] {
    const auto kernel = [](double theta) { return std::cos(theta); };
    return std::vector<Image>{
        convolve(OctahedralPyramid(environment, kDiffuseCells), sample_lobe(kernel, std::numbers::pi / 2.0), 32)};
  })[0];
}

Image split_sum_table(int size) {
  constexpr int kSamples = 512;
  Image table(size, size, 2);
  parallel_for(0, size, [&](int y) {
    const double roughness = (y + 0.5) / size, alpha = roughness * roughness;
    for (int x = 0; x < size; ++x) {
      const double nv = (x + 0.5) / size;
      const glm::dvec3 view(std::sqrt(1.0 - nv * nv), 0.0, nv);
      double scale = 0.0, bias = 0.0;
      for (int i = 0; i < kSamples; ++i) {
        // Half vectors with density D cos(h): uniform in the cumulative energy, golden angles in azimuth.
        const double u = (i + 0.5) / kSamples, phi = std::numbers::pi * (3.0 - std::sqrt(5.0)) * i;
        const double cos_h = std::sqrt((1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u)),
                     sin_h = std::sqrt(1.0 - cos_h * cos_h);
        const glm::dvec3 h(sin_h * std::cos(phi), sin_h * std::sin(phi), cos_h);
        const double vh = glm::dot(view, h), nl = 2.0 * vh * h.z - view.z;
        if (vh <= 0.0 || nl <= 0.0) continue;
        const double weight = smith_g1(nl, alpha) * smith_g1(nv, alpha) * vh / (cos_h * nv);
        const double fresnel = std::pow(1.0 - vh, 5.0);
        scale += (1.0 - fresnel) * weight;
        bias += fresnel * weight;
      }
      table.at(x, y, 0) = static_cast<float>(scale / kSamples);
      table.at(x, y, 1) = static_cast<float>(bias / kSamples);
    }
  });
  return table;
}

}  // namespace maquette
