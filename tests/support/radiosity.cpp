#include "tests/support/radiosity.h"

#include <embree3/rtcore.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "scenes/parallel.h"

namespace maquette::test {
namespace {

/// Rays start this far from the surface, as a share of the scene's extent.
constexpr double kOffset = 2e-6;

struct Element {
  glm::dvec3 corners[3]{};
  glm::dvec3 normal{0.0};
  std::uint32_t triangle = 0;
};

constexpr std::size_t kDimensions = 6;  // direction, point on the element, point on a light

/// Additive recurrence of the generalised golden ratio in six dimensions. Source: Roberts 2018, "The Unreasonable
/// Effectiveness of Quasirandom Sequences".
std::array<double, kDimensions> point_of_sequence(std::uint64_t index, std::uint64_t seed) {
  constexpr double kRatio = 1.1127756842787055;  // x^7 = x + 1
  std::array<double, kDimensions> u{};
  std::uint64_t h = seed * 0x9e3779b97f4a7c15ull + 0x632be59bd9b4e019ull;
  double power = 1.0;
  for (double& coordinate : u) {
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ull;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebull;
    power /= kRatio;
    coordinate = std::fmod(static_cast<double>(h >> 11) * 0x1p-53 + static_cast<double>(index) * power, 1.0);
  }
  return u;
}

glm::dvec3 point_of_triangle(const glm::dvec3* corners, double u, double v) {
  const double root = std::sqrt(u);
  return corners[0] + (corners[1] - corners[0]) * (root * (1.0 - v)) + (corners[2] - corners[0]) * (root * v);
}

glm::dvec3 cosine_direction(const glm::dvec3& n, double u, double v) {
  const glm::dvec3 any = std::abs(n.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 t = glm::normalize(glm::cross(any, n)), b = glm::cross(n, t);
  const double r = std::sqrt(u), phi = 2.0 * std::numbers::pi * v;
  return glm::normalize(t * (r * std::cos(phi)) + b * (r * std::sin(phi)) + n * std::sqrt(std::max(1.0 - u, 0.0)));
}

/// Irradiance from a triangle of unit radiance, clipped to the horizon. Source: Baum et al. 1989, Eq. 5 (Lambert 1760).
double triangle_irradiance(const glm::dvec3& p, const glm::dvec3& n, const std::array<glm::dvec3, 3>& corners) {
  std::array<glm::dvec3, 5> polygon{};
  std::size_t count = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const glm::dvec3 a = corners[k] - p, b = corners[(k + 1) % 3] - p;
    const double ha = glm::dot(a, n), hb = glm::dot(b, n);
    if (ha >= 0.0) polygon[count++] = a;
    if (ha * hb < 0.0) polygon[count++] = a + (b - a) * (ha / (ha - hb));
  }
  double sum = 0.0;
  for (std::size_t k = 0; count >= 3 && k < count; ++k) {
    const glm::dvec3 a = polygon[k], b = polygon[(k + 1) % count];
    const glm::dvec3 axis = glm::cross(a, b);
    const double length = glm::length(axis);
    if (length > 0.0) sum += std::atan2(length, glm::dot(a, b)) * glm::dot(axis, n) / length;
  }
  return 0.5 * std::abs(sum);
}

}  // namespace

struct Radiosity::Impl {
  std::vector<DiffuseTriangle> triangles;
  std::vector<Element> elements;
  std::vector<glm::dvec3> indirect;   ///< irradiance of each element less its direct part
  std::vector<std::uint32_t> lights;  ///< emitting triangles
  RadiosityOptions options;
  double extent = 1.0, residual = 0.0;
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scene = rtcNewScene(device);

  ~Impl() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }

  void split() {
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
      if (triangles[t].emission != glm::dvec3(0.0)) lights.push_back(t);
      const glm::dvec3 a = triangles[t].corners[0], e1 = triangles[t].corners[1] - a, e2 = triangles[t].corners[2] - a;
      const glm::dvec3 normal = glm::cross(e1, e2);
      if (!(glm::length(normal) > 0.0)) continue;
      const double longest = std::max({glm::length(e1), glm::length(e2), glm::length(e2 - e1)});
      const int n = static_cast<int>(std::ceil(longest / options.largest_edge));
      for (int i = 0; i < n; ++i) {
        for (int j = 0; i + j < n; ++j) {
          for (int inverted = 0; inverted < (i + j + 1 < n ? 2 : 1); ++inverted) {
            const auto at = [&](int x, int y) { return a + e1 * (double(x) / n) + e2 * (double(y) / n); };
            Element element{{at(i + inverted, j + inverted), at(i + 1, j), at(i, j + 1)}, glm::normalize(normal), t};
            if (inverted) std::swap(element.corners[1], element.corners[2]);
            elements.push_back(element);
          }
        }
      }
    }
  }

  void build() {
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    auto* positions = static_cast<float*>(
        rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * elements.size()));
    auto* indices = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, elements.size()));
    if (!positions || !indices) throw std::runtime_error("radiosity: the ray tracer ran out of memory");
    glm::dvec3 low(1e300), high(-1e300);
    for (std::size_t i = 0; i < elements.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const glm::dvec3& p = elements[i].corners[k];
        low = glm::min(low, p);
        high = glm::max(high, p);
        for (int c = 0; c < 3; ++c) positions[9 * i + 3 * k + static_cast<std::size_t>(c)] = static_cast<float>(p[c]);
        indices[3 * i + k] = static_cast<std::uint32_t>(3 * i + k);
      }
    }
    extent = glm::length(high - low);
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(scene, mesh);
    rtcReleaseGeometry(mesh);
    rtcCommitScene(scene);
  }

  struct Hit {
    std::int64_t element = -1;
    double distance = 0.0;
  };
  Hit trace(const glm::dvec3& origin, const glm::dvec3& direction) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit ray{};
    ray.ray = {static_cast<float>(origin.x),
               static_cast<float>(origin.y),
               static_cast<float>(origin.z),
               0.0f,
               static_cast<float>(direction.x),
               static_cast<float>(direction.y),
               static_cast<float>(direction.z),
               0.0f,
               std::numeric_limits<float>::infinity(),
               0xffffffffu,
               0u,
               0u};
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &context, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
    return {ray.hit.primID, static_cast<double>(ray.ray.tfar)};
  }
  bool is_unoccluded(const glm::dvec3& from, const glm::dvec3& to) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    const glm::dvec3 d = to - from;
    RTCRay ray{static_cast<float>(from.x),
               static_cast<float>(from.y),
               static_cast<float>(from.z),
               0.0f,
               static_cast<float>(d.x),
               static_cast<float>(d.y),
               static_cast<float>(d.z),
               0.0f,
               static_cast<float>(1.0 - 2.0 * kOffset * extent / glm::length(d)),
               0xffffffffu,
               0u,
               0u};
    rtcOccluded1(scene, &context, &ray);
    return ray.tfar >= 0.0f;
  }

  glm::dvec3 direct(const glm::dvec3& p, const glm::dvec3& n) const {
    const glm::dvec3 origin = p + n * (kOffset * extent);
    glm::dvec3 sum(0.0);
    const int cells = options.light_cells;
    for (const std::uint32_t t : lights) {
      const DiffuseTriangle& light = triangles[t];
      const glm::dvec3 a = light.corners[0], e1 = light.corners[1] - a, e2 = light.corners[2] - a;
      if (glm::dot(glm::cross(e1, e2), p - a) <= 0.0) continue;
      const auto at = [&](double x, double y) { return a + e1 * (x / cells) + e2 * (y / cells); };
      for (int i = 0; i < cells; ++i) {
        for (int j = 0; i + j < cells; ++j) {
          for (int k = 0; k < (i + j + 1 < cells ? 2 : 1); ++k) {
            const double third = k ? 2.0 / 3.0 : 1.0 / 3.0;
            const double share = triangle_irradiance(p, n, {at(i + k, j + k), at(i + 1, j), at(i, j + 1)});
            if (share > 0.0 && is_unoccluded(origin, at(i + third, j + third))) sum += light.emission * share;
          }
        }
      }
    }
    return sum;
  }

  /// One point of one light, sampled uniformly.
  glm::dvec3 sample_direct(const glm::dvec3& p, const glm::dvec3& n, double u, double v) const {
    if (lights.empty()) return glm::dvec3(0.0);
    const auto count = static_cast<double>(lights.size());
    const auto k = std::min(static_cast<std::size_t>(u * count), lights.size() - 1);
    const DiffuseTriangle& light = triangles[lights[k]];
    const glm::dvec3 doubled = glm::cross(light.corners[1] - light.corners[0], light.corners[2] - light.corners[0]);
    const glm::dvec3 to = point_of_triangle(light.corners, u * count - static_cast<double>(k), v) - p;
    const double d2 = glm::dot(to, to), facing = -glm::dot(doubled, to), above = glm::dot(n, to);
    if (facing <= 0.0 || above <= 0.0 || !is_unoccluded(p + n * (kOffset * extent), p + to)) return glm::dvec3(0.0);
    return light.emission * (0.5 * count * facing * above / (d2 * d2));
  }

  struct Seen {
    std::int64_t element = -1;
    bool back = false;  ///< back face of a surface: inside a solid that stands on this one
    glm::dvec3 position{0.0};
  };
  /// What a cosine-distributed ray hits on the visible side.
  Seen see(const glm::dvec3& p, const glm::dvec3& n, double u, double v) const {
    const glm::dvec3 d = cosine_direction(n, u, v), origin = p + n * (kOffset * extent);
    const Hit hit = trace(origin, d);
    if (hit.element < 0) return {};
    if (glm::dot(elements[static_cast<std::size_t>(hit.element)].normal, d) >= 0.0) return {-1, true, {}};
    return {hit.element, false, origin + d * hit.distance};
  }

  void solve() {
    const bool sampled = options.far_lights;
    const auto count = static_cast<Eigen::Index>(elements.size());
    Eigen::MatrixXf factors = Eigen::MatrixXf::Zero(count, count);  // column i: what element i sees
    Eigen::MatrixX3d source(count, 3), albedo(count, 3);
    parallel_for(std::size_t{0}, elements.size(), [&](std::size_t i) {
      const Element& e = elements[i];
      const auto row = static_cast<Eigen::Index>(i);
      glm::dvec3 arriving(0.0);
      int valid = 0;
      for (int r = 0; r < options.rays; ++r) {
        const auto u = point_of_sequence(static_cast<std::uint64_t>(r), (std::uint64_t{options.seed} << 32) + i);
        const glm::dvec3 p = point_of_triangle(e.corners, u[2], u[3]);
        const Seen seen = see(p, e.normal, u[0], u[1]);
        // The part of the floor under a box is not visible and must not darken the rest of its element.
        if (seen.back) continue;
        ++valid;
        arriving += sampled ? sample_direct(p, e.normal, u[4], u[5]) : r < 16 ? direct(p, e.normal) : glm::dvec3(0.0);
        if (seen.element >= 0) factors(static_cast<Eigen::Index>(seen.element), row) += 1.0f;
      }
      factors.col(row) /= static_cast<float>(std::max(valid, 1));
      arriving /= static_cast<double>(std::max(sampled ? valid : std::min(valid, 16), 1));
      const glm::dvec3 rho = triangles[e.triangle].albedo;
      source.row(row) << arriving.x, arriving.y, arriving.z;
      albedo.row(row) << rho.x, rho.y, rho.z;
    });
    // The norm of transport times albedo is below 0.8: the Neumann series gains a digit in ten steps.
    Eigen::MatrixX3d solution = source;
    for (int step = 0; step < 400; ++step) {
      const Eigen::MatrixX3f sent = albedo.cwiseProduct(solution).cast<float>();
      const Eigen::MatrixX3d next = source + (factors.transpose() * sent).cast<double>();
      residual = (next - solution).norm() / source.norm();
      solution = next;
      if (residual < 1e-7) break;  // of float
    }
    solution -= source;
    indirect.resize(elements.size());
    for (std::size_t i = 0; i < elements.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      indirect[i] = {solution(row, 0), solution(row, 1), solution(row, 2)};
    }
  }
};

Radiosity::Radiosity(const std::vector<DiffuseTriangle>& triangles, const RadiosityOptions& options)
    : impl_(std::make_unique<Impl>()) {
  impl_->triangles = triangles;
  impl_->options = options;
  impl_->split();
  impl_->build();
  impl_->solve();
}

Radiosity::~Radiosity() = default;

glm::dvec3 Radiosity::direct_irradiance(const glm::dvec3& position, const glm::dvec3& normal) const {
  return impl_->direct(position, normal);
}

glm::dvec3 Radiosity::irradiance(const glm::dvec3& position, const glm::dvec3& normal, int rays) const {
  glm::dvec3 gathered(0.0);
  for (int r = 0; r < rays; ++r) {
    const auto u = point_of_sequence(static_cast<std::uint64_t>(r), 0x5bd1e995u + impl_->options.seed);
    const Impl::Seen seen = impl_->see(position, normal, u[0], u[1]);
    if (seen.element < 0) continue;
    const auto i = static_cast<std::size_t>(seen.element);
    const glm::dvec3& n = impl_->elements[i].normal;
    const glm::dvec3 arriving =
        impl_->indirect[i] + (impl_->options.far_lights ? impl_->sample_direct(seen.position, n, u[4], u[5])
                                                        : impl_->direct(seen.position, n));
    gathered += impl_->triangles[impl_->elements[i].triangle].albedo * arriving;
  }
  return impl_->direct(position, normal) + gathered / static_cast<double>(rays);
}

std::optional<SurfaceHit> Radiosity::first_hit(const glm::dvec3& origin, const glm::dvec3& direction) const {
  const Impl::Hit hit = impl_->trace(origin, direction);
  if (hit.element < 0) return std::nullopt;
  const Element& e = impl_->elements[static_cast<std::size_t>(hit.element)];
  const DiffuseTriangle& t = impl_->triangles[e.triangle];
  const glm::dvec3 d = glm::normalize(direction);
  // The plane's distance in double, not the ray tracer's float.
  const double distance = glm::dot(e.corners[0] - origin, e.normal) / glm::dot(d, e.normal);
  return SurfaceHit{origin + d * distance, e.normal, t.albedo, t.emission, glm::dot(d, e.normal) < 0.0};
}

std::size_t Radiosity::element_count() const { return impl_->elements.size(); }
double Radiosity::residual() const { return impl_->residual; }

}  // namespace maquette::test
