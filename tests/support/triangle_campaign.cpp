#include "tests/support/triangle_campaign.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <random>
#include <sstream>
#include <vector>

#include "render/triangle/triangle_mirror.h"
#include "scenes/parallel.h"
#include "tests/support/campaign_random.h"

namespace maquette {

namespace {

using test::kEnough;
using test::Random;

using Long = long double;
using Vec = glm::vec<3, Long, glm::defaultp>;

constexpr Long kSimple = 1e3L;

struct Case {
  glm::vec3 vertices[3]{}, directions[3]{}, object{};
};

glm::dvec3 mirrored(const glm::dvec3& eye, const glm::dvec3& t, const glm::dvec3& n) {
  const glm::dvec3 in = glm::normalize(t - eye);
  return in - 2.0 * glm::dot(in, n) * n;
}

/// Triangles of 1 mm to 1 m, with a share for every kind of degeneracy.
Case random_case(Random& random) {
  const int kind = static_cast<int>(random.uniform(0.0, 8.0));
  const double size = random.log_uniform(1e-3, 1.0);
  glm::dvec3 t[3]{}, n[3]{};
  const glm::dvec3 center = random.uniform(0.0, 3.0) * random.direction();
  const glm::dvec3 ex = random.direction(), ez = glm::normalize(glm::cross(ex, random.direction())),
                   ey = glm::cross(ez, ex);
  t[0] = center;
  t[1] = center + size * ex;
  t[2] = center + size * (random.uniform(-0.5, 1.5) * ex + random.uniform(0.2, 1.5) * ey);
  if (kind == 1)
    t[2] = center + size * (random.uniform(0.1, 0.9) * ex + random.log_uniform(1e-5, 1e-2) * ey);  // sliver
  const double spread = kind == 2 ? 0.0 : kind == 3 ? random.log_uniform(1e-7, 1e-3) : random.log_uniform(1e-3, 0.6);
  for (glm::dvec3& normal : n) normal = glm::normalize(ez + spread * random.direction());
  const double cosine = random.uniform(0.0, 1.0) < 0.2 ? random.log_uniform(1e-3, 0.1) : random.uniform(0.05, 1.0);
  const double phi = random.uniform(0.0, 6.283185307179586), sine = std::sqrt(1.0 - cosine * cosine);
  const glm::dvec3 eye =
      center + random.log_uniform(0.05, 10.0) * (cosine * ez + sine * (std::cos(phi) * ex + std::sin(phi) * ey));
  glm::dvec3 d[3]{};
  for (int i = 0; i < 3; ++i) d[i] = kind == 4 ? random.direction() : mirrored(eye, t[i], n[i]);
  if (kind == 5) d[2] = glm::normalize(0.5 * (d[0] + d[1]) + random.log_uniform(1e-8, 1e-3) * random.direction());
  const double k = random.log_uniform(1e-3, 10.0);
  const double a = random.uniform(-0.5, 1.2), b = random.uniform(-0.5, 1.2);
  glm::dvec3 p = t[0] + a * (t[1] - t[0]) + b * (t[2] - t[0]);
  if (kind != 6) p += k * (d[0] + a * (d[1] - d[0]) + b * (d[2] - d[0]));  // kind 6: in the triangle's plane
  if (kind == 7) p = center + random.log_uniform(1e-2, 10.0) * random.direction();
  Case out;
  for (int i = 0; i < 3; ++i) {
    out.vertices[i] = glm::vec3(t[i]);
    out.directions[i] = glm::vec3(d[i]);
  }
  out.object = glm::vec3(p);
  return out;
}

/// The cubic in long double, from the float data.
struct Reference {
  Vec e1, e2, f1, f2, d1, q, n0, n1, n2;
  std::array<Long, 4> c;
  explicit Reference(const Case& x) {
    const Vec t1(x.vertices[0]);
    e1 = Vec(x.vertices[1]) - t1;
    e2 = Vec(x.vertices[2]) - t1;
    d1 = Vec(x.directions[0]);
    f1 = Vec(x.directions[1]) - d1;
    f2 = Vec(x.directions[2]) - d1;
    q = Vec(x.object) - t1;
    n0 = glm::cross(e1, e2);
    n1 = glm::cross(e1, f2) + glm::cross(f1, e2);
    n2 = glm::cross(f1, f2);
    c = {glm::dot(n0, q), glm::dot(n1, q) - glm::dot(n0, d1), glm::dot(n2, q) - glm::dot(n1, d1), -glm::dot(n2, d1)};
  }
  Long value(Long k) const { return c[0] + k * (c[1] + k * (c[2] + k * c[3])); }
  Long slope(Long k) const { return c[1] + k * (2 * c[2] + 3 * k * c[3]); }
  /// Condition number of a root: relative change of k over relative change of the cubic's terms, before they cancel in
  /// its coefficients.
  Long condition(Long k) const {
    const auto terms = [](const Vec& a, const Vec& b) { return glm::dot(glm::abs(a), glm::abs(b)); };
    const Long s = std::abs(k * slope(k));
    const Long sum =
        terms(n0, q) + k * (terms(n1, q) + terms(n0, d1) + k * (terms(n2, q) + terms(n1, d1) + k * terms(n2, d1)));
    return s > 0 ? sum / s : INFINITY;
  }
  /// Distance of the object from the plane of the projected triangle at k.
  Long residual(Long k) const {
    const Vec n = n0 + k * (n1 + k * n2);
    const Long length = glm::length(n);
    return length > 0 ? std::abs(value(k)) / length : 0;
  }
  /// Size of the projected triangle at k.
  Long size_at(Long k) const { return std::max(glm::length(e1 + k * f1), glm::length(e2 + k * f2)); }
  Long outside(Long k) const {
    const Vec a = e1 + k * f1, b = e2 + k * f2, r = q - k * d1, n = glm::cross(a, b);
    const Long nn = glm::dot(n, n), alpha = glm::dot(glm::cross(r, b), n) / nn,
               beta = glm::dot(glm::cross(a, r), n) / nn;
    return std::max({-alpha, -beta, alpha + beta - 1});
  }
  /// Roots by bisection between the extrema, in k up to 1 and in 1 / k beyond: shares no formula with the code under
  /// test.
  std::vector<Long> positive_roots() const {
    std::vector<Long> roots;
    for (int reversed = 0; reversed < 2; ++reversed) {
      const std::array<Long, 4> p = reversed ? std::array<Long, 4>{c[3], c[2], c[1], c[0]} : c;
      const auto f = [&](Long x) { return p[0] + x * (p[1] + x * (p[2] + x * p[3])); };
      std::vector<Long> cuts{0, 1};
      const Long disc = p[2] * p[2] - 3 * p[1] * p[3];
      if (disc > 0) {
        const Long w = -(p[2] + std::copysign(std::sqrt(disc), p[2]));
        for (const Long x : {w / (3 * p[3]), p[1] / w})
          if (x > 0 && x < 1) cuts.push_back(x);
      }
      std::sort(cuts.begin(), cuts.end());
      for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
        Long lo = cuts[i], hi = cuts[i + 1];
        if ((f(lo) > 0) == (f(hi) > 0)) continue;
        const bool rising = f(hi) > f(lo);
        for (int n = 0; n < 200; ++n) {
          const Long mid = (lo + hi) / 2;
          ((f(mid) > 0) == rising ? hi : lo) = mid;
        }
        if (lo > 0) roots.push_back(reversed ? 1 / lo : lo);
      }
    }
    return roots;
  }
};

void judge(const Case& x, TriangleCampaign* out) {
  const mirror::TriangleMirror m = make_triangle_mirror(x.vertices, x.directions);
  const mirror::CubicRoots found = mirror::positive_roots(mirror::mirror_cubic(m, x.object));
  const mirror::MirrorPoint chosen = mirror::mirror_point(m, x.object);
  const Reference reference(x);
  ++out->cases;
  const auto note = [&](const char* what, Long k) {
    if (out->failures.size() > kEnough) return;
    std::ostringstream text;
    text << what << " at k " << k << ", condition " << reference.condition(k) << ", coefficients";
    for (const Long c : reference.c) text << " " << c;
    text << ", found";
    for (int i = 0; i < found.count; ++i) text << " " << found.k[i];
    out->failures += text.str() + '\n';
  };
  if (!std::isfinite(chosen.alpha + chosen.beta + chosen.k)) ++out->not_finite;
  bool inside = false;
  for (const Long k : reference.positive_roots()) {
    if (reference.condition(k) > kSimple) continue;
    ++out->simple_roots;
    Long error = 1;
    for (int i = 0; i < found.count; ++i) error = std::min(error, std::abs(static_cast<Long>(found.k[i]) - k) / k);
    out->worst_simple = std::max(out->worst_simple, static_cast<double>(error));
    if (error > 1e-4L) {
      ++out->missed;
      note("missed", k);
    }
    inside |= reference.outside(k) < -1e-2L;
  }
  for (int i = 0; i < found.count; ++i) {
    const auto k = static_cast<Long>(found.k[i]);
    if (!std::isfinite(found.k[i])) {
      ++out->not_finite;
    } else if (reference.condition(k) > kSimple) {
      ++out->other_roots;
      // A float k is only accurate to its last bit, however long the ray.
      const Long residual = std::max<Long>(reference.residual(k) - k * 0x1p-23L, 0) / reference.size_at(k);
      out->worst_stray = std::max(out->worst_stray, static_cast<double>(residual));
      if (residual > 1e-4L) {
        ++out->stray;
        note("stray", k);
      }
    }
  }
  if (inside && !(chosen.k > 0.0f && chosen.outside <= 1e-2f)) {
    ++out->wrong_choice;
    note("choice", static_cast<Long>(chosen.k));
  }
}

}  // namespace

TriangleCampaign run_triangle_campaign(std::size_t cases, std::uint64_t seed) {
  constexpr std::size_t kBatch = 2000;
  const std::size_t batches = (cases + kBatch - 1) / kBatch;
  TriangleCampaign sum;
  std::mutex guard;
  parallel_for(std::size_t{0}, batches, [&](std::size_t batch) {
    Random random{std::mt19937_64(seed * 1000003u + batch)};
    TriangleCampaign part;
    for (std::size_t i = batch * kBatch; i < std::min(cases, (batch + 1) * kBatch); ++i)
      judge(random_case(random), &part);
    const std::lock_guard lock(guard);
    sum.cases += part.cases;
    sum.simple_roots += part.simple_roots;
    sum.missed += part.missed;
    sum.other_roots += part.other_roots;
    sum.stray += part.stray;
    sum.wrong_choice += part.wrong_choice;
    sum.not_finite += part.not_finite;
    sum.worst_simple = std::max(sum.worst_simple, part.worst_simple);
    sum.worst_stray = std::max(sum.worst_stray, part.worst_stray);
    if (sum.failures.size() <= kEnough) sum.failures += part.failures;
  });
  return sum;
}

}  // namespace maquette
