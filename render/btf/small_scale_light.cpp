#include "render/btf/small_scale_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/math/low_discrepancy.h"
#include "render/raytraced/embree_ray.h"
#include "render/raytraced/ray_device.h"
#include "scenes/error.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

/// Rays begin this share of a cell above the surface.
constexpr float kLift = 0.01f;
/// Rays that pass over this many tiles without a hit run along the surface.
constexpr int kMostTiles = 64;
constexpr std::size_t kCellsABlock = 1024;
/// Bounces end when one adds less than this share of the light.
constexpr double kLastBounce = 1e-3;

glm::vec3 cosine_direction(float u, float v) {
  const float r = std::sqrt(u), phi = 2.0f * std::numbers::pi_v<float> * v;
  return {r * std::cos(phi), r * std::sin(phi), std::sqrt(std::max(0.0f, 1.0f - u))};
}

/// Source: Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
glm::vec3 to_world(const glm::vec3& n, const glm::vec3& w) {
  const float sign = std::copysign(1.0f, n.z), a = -1.0f / (sign + n.z), b = n.x * n.y * a;
  const glm::vec3 t(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x), s(b, sign + n.y * n.y * a, -n.y);
  return t * w.x + s * w.y + n * w.z;
}

template <typename Body>
void for_blocks(std::size_t count, const Body& body) {
  parallel_for(std::size_t{0}, (count + kCellsABlock - 1) / kCellsABlock, [&](std::size_t block) {
    for (std::size_t i = block * kCellsABlock; i < std::min(count, (block + 1) * kCellsABlock); ++i) body(i);
  });
}

}  // namespace

TileRays::TileRays(const SmallGeometry& geometry)
    : side_(geometry.side), border_(std::max(4, geometry.side / 8)), device_(new_ray_device()) {
  if (!device_) throw Error("btf", "the ray tracer does not start", "see `maquette doctor`");
  build_cells(geometry);
  scene_.reset(rtcNewScene(device_.get()));
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
  RTCGeometry mesh = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_QUAD);
  const auto row = static_cast<std::size_t>(side_ + 2 * border_), corners = row + 1;
  auto* vertices = static_cast<float*>(
      rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, corners * corners));
  auto* quads = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 16, row * row));
  if (!vertices || !quads) throw Error("btf", "not enough memory for its rays", "use fewer texels");
  const float scale = 1.0f / static_cast<float>(side_);
  for (int y = -border_; y <= side_ + border_; ++y)
    for (int x = -border_; x <= side_ + border_; ++x) {
      *vertices++ = static_cast<float>(x) * scale;
      *vertices++ = static_cast<float>(y) * scale;
      *vertices++ = geometry.height(x, y);
    }
  for (std::size_t y = 0; y < row; ++y)
    for (std::size_t x = 0; x < row; ++x) {
      const auto first = static_cast<std::uint32_t>(y * corners + x), up = static_cast<std::uint32_t>(corners);
      for (const std::uint32_t corner : {first, first + 1, first + 1 + up, first + up}) *quads++ = corner;
    }
  rtcCommitGeometry(mesh);
  rtcAttachGeometry(scene_.get(), mesh);
  rtcReleaseGeometry(mesh);
  rtcCommitScene(scene_.get());
}

void TileRays::build_cells(const SmallGeometry& geometry) {
  const float scale = 1.0f / static_cast<float>(side_);
  const auto [low, high] = std::minmax_element(geometry.heights.begin(), geometry.heights.end());
  lowest_ = *low;
  highest_ = *high;
  for (int y = 0; y < side_; ++y)
    for (int x = 0; x < side_; ++x) {
      const float h00 = geometry.height(x, y), h10 = geometry.height(x + 1, y), h11 = geometry.height(x + 1, y + 1),
                  h01 = geometry.height(x, y + 1);
      // Half the cross product of the diagonals is the area vector of both triangles together.
      const glm::vec3 n =
          glm::normalize(glm::cross(glm::vec3(scale, scale, h11 - h00), glm::vec3(-scale, scale, h01 - h10)));
      normals_.push_back(n);
      // The ray tracer splits the quad along this diagonal: its middle lies on the surface.
      const glm::vec3 middle((static_cast<float>(x) + 0.5f) * scale, (static_cast<float>(y) + 0.5f) * scale,
                             0.5f * (h10 + h01));
      origins_.push_back(middle + n * (kLift * scale));
    }
}

std::uint32_t TileRays::first_cell(const glm::vec3& origin, const glm::vec3& direction) const {
  const float border = static_cast<float>(border_) / static_cast<float>(side_);
  const float step_back = 0.25f / static_cast<float>(side_);
  glm::vec3 o = origin;
  const float top = direction.z > 0.0f ? (highest_ - o.z) / direction.z : std::numeric_limits<float>::infinity();
  float passed = 0.0f;
  for (int tile = 0; tile < kMostTiles; ++tile) {
    o.x -= std::floor(o.x);
    o.y -= std::floor(o.y);
    float leave = std::numeric_limits<float>::infinity();
    for (int axis = 0; axis < 2; ++axis)
      if (direction[axis] != 0.0f)
        leave = std::min(leave, ((direction[axis] > 0.0f ? 1.0f + border : -border) - o[axis]) / direction[axis]);
    const float far = std::min(leave, top - passed + step_back);
    if (!(far > 0.0f)) return kNone;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit hit;
    hit.ray = embree_ray(o, direction, 0.0f, far);
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_.get(), &context, &hit);
    if (hit.hit.geomID != RTC_INVALID_GEOMETRY_ID) {
      const auto row = static_cast<std::uint32_t>(side_ + 2 * border_);
      const auto x =
          (hit.hit.primID % row + static_cast<std::uint32_t>(2 * side_ - border_)) % static_cast<std::uint32_t>(side_);
      const auto y =
          (hit.hit.primID / row + static_cast<std::uint32_t>(2 * side_ - border_)) % static_cast<std::uint32_t>(side_);
      return y * static_cast<std::uint32_t>(side_) + x;
    }
    if (far < leave || std::isinf(leave)) return kNone;
    const float step = leave - step_back;
    o += direction * step;
    passed += step;
  }
  return kNone;
}

std::uint32_t TileRays::seen_cell(const glm::vec2& point, const glm::vec3& wo) const {
  const float above = (highest_ + 1e-3f) / wo.z;  // may be negative: the base plane lies above all
  return first_cell(glm::vec3(point, 0.0f) + wo * above, -wo);
}

SmallScaleLight::SmallScaleLight(const SmallGeometry& geometry, const TileRays& rays, std::vector<glm::dvec3> lights,
                                 const SmallLightOptions& options, const BtfTask& task)
    : geometry_(geometry), rays_(rays), directions_(lights.begin(), lights.end()) {
  for (const glm::vec3& d : directions_) {
    x_.push_back(d.x);
    y_.push_back(d.y);
    z_.push_back(d.z);
  }
  visible_.assign(rays.cell_count() * directions_.size(), 0);
  radiance_.assign(rays.cell_count() * directions_.size(), glm::vec3(0.0f));
  light_directly();
  task.check("btf");
  if (options.gather_rays > 0) gather(options, task);
}

void SmallScaleLight::light_directly() {
  const std::size_t count = directions_.size();
  for_blocks(rays_.cell_count(), [&](std::size_t cell) {
    const auto c = static_cast<std::uint32_t>(cell);
    for (std::size_t l = 0; l < count; ++l) {
      const float cosine = glm::dot(rays_.normal(c), directions_[l]);
      if (!(cosine > 0.0f) || rays_.first_cell(rays_.origin(c), directions_[l]) != TileRays::kNone) continue;
      visible_[cell * count + l] = 1;
      radiance_[cell * count + l] = geometry_.diffuse[cell] * (cosine / std::numbers::pi_v<float>);
    }
  });
}

void SmallScaleLight::gather(const SmallLightOptions& options, const BtfTask& task) {
  const std::size_t cells = rays_.cell_count(), count = directions_.size();
  const auto rays = static_cast<std::size_t>(options.gather_rays);
  std::vector<std::uint32_t> hits(cells * rays);
  for_blocks(cells, [&](std::size_t cell) {
    const auto c = static_cast<std::uint32_t>(cell);
    const std::uint32_t seed = mix_seed(options.seed, c);
    for (std::size_t k = 0; k < rays; ++k) {
      const std::uint32_t index = owen_scramble(static_cast<std::uint32_t>(k), seed);
      const auto u = reverse_bits(owen_scramble_reversed(index, mix_seed(seed, 1)));
      const auto v = reverse_bits(owen_scramble_reversed(sobol_second_reversed(index), mix_seed(seed, 2)));
      const glm::vec3 w =
          cosine_direction(static_cast<float>(u >> 8) * 0x1p-24f, static_cast<float>(v >> 8) * 0x1p-24f);
      hits[cell * rays + k] = rays_.first_cell(rays_.origin(c), to_world(rays_.normal(c), w));
    }
    // In the order of memory; the sum does not depend on it.
    std::sort(hits.begin() + static_cast<std::ptrdiff_t>(cell * rays),
              hits.begin() + static_cast<std::ptrdiff_t>((cell + 1) * rays));
  });
  // Blocks of lights, so that few copies of the field are in memory.
  constexpr std::size_t kLightsABlock = 27;
  for (std::size_t first = 0; first < count; first += kLightsABlock) {
    const std::size_t width = std::min(kLightsABlock, count - first);
    std::vector<glm::vec3> sent(cells * width), next(cells * width);
    for_blocks(cells,
               [&](std::size_t cell) { std::copy_n(&radiance_[cell * count + first], width, &sent[cell * width]); });
    for (int bounce = 0; bounce < options.most_bounces; ++bounce) {
      task.check("btf");
      std::vector<double> added(cells / kCellsABlock + 1, 0.0), all(cells / kCellsABlock + 1, 0.0);
      for_blocks(cells, [&](std::size_t cell) {
        glm::vec3* to = &next[cell * width];
        std::fill_n(to, width, glm::vec3(0.0f));
        for (std::size_t k = 0; k < rays; ++k) {
          const std::uint32_t hit = hits[cell * rays + k];
          if (hit == TileRays::kNone) break;  // the last ones
          const glm::vec3* from = &sent[hit * width];
          for (std::size_t l = 0; l < width; ++l) to[l] += from[l];
        }
        const glm::vec3 factor = geometry_.diffuse[cell] / static_cast<float>(rays);
        const glm::vec3* direct = &radiance_[cell * count + first];
        for (std::size_t l = 0; l < width; ++l) {
          to[l] = direct[l] + factor * to[l];
          const glm::vec3 change = glm::abs(to[l] - sent[cell * width + l]);
          added[cell / kCellsABlock] += static_cast<double>(change.x + change.y + change.z);
          all[cell / kCellsABlock] += static_cast<double>(to[l].x + to[l].y + to[l].z);
        }
      });
      std::swap(sent, next);
      double change = 0.0, total = 0.0;
      for (std::size_t i = 0; i < added.size(); ++i) {
        change += added[i];
        total += all[i];
      }
      if (change <= kLastBounce * total) break;
    }
    for_blocks(cells,
               [&](std::size_t cell) { std::copy_n(&sent[cell * width], width, &radiance_[cell * count + first]); });
  }
}

void SmallScaleLight::add_radiance(std::uint32_t cell, const glm::vec3& wo, float share, glm::vec3* sums) const {
  const std::size_t count = directions_.size();
  const glm::vec3 n = rays_.normal(cell);
  const float no = glm::dot(n, wo);
  if (!(no > 0.0f)) return;
  const glm::vec3* diffuse = &radiance_[cell * count];
  for (std::size_t l = 0; l < count; ++l) sums[l] += share * diffuse[l];
  const float specular = geometry_.specular[cell];
  if (!(specular > 0.0f)) return;
  const std::uint8_t* visible = &visible_[cell * count];
  const float a2 = geometry_.alpha * geometry_.alpha, root_o = std::sqrt(a2 + (1.0f - a2) * no * no);
  const float scale = share * a2 * 0.5f / std::numbers::pi_v<float>;
  // ggx_lobe for all lights at once, times the cosine.
#pragma omp simd
  for (std::size_t l = 0; l < count; ++l) {
    const float ni = std::max(n.x * x_[l] + n.y * y_[l] + n.z * z_[l], 0.0f);
    const float io = wo.x * x_[l] + wo.y * y_[l] + wo.z * z_[l];
    const float half_length = std::sqrt(2.0f + 2.0f * io);  // of wi + wo
    const float nh = (ni + no) / half_length, c = 1.0f - 0.5f * half_length;
    const float d = nh * nh * (a2 - 1.0f) + 1.0f;
    const float masking = no * std::sqrt(a2 + (1.0f - a2) * ni * ni) + ni * root_o;
    const float fresnel = specular + (1.0f - specular) * c * c * c * c * c;
    const float value = static_cast<float>(visible[l]) * scale * fresnel * ni / (d * d * masking);
    sums[l].x += value;
    sums[l].y += value;
    sums[l].z += value;
  }
}

}  // namespace maquette
