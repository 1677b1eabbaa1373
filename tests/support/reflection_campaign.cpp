#include "tests/support/reflection_campaign.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <mutex>
#include <optional>
#include <random>
#include <sstream>

#include "render/bezier/reflector_patch.h"
#include "scenes/parallel.h"
#include "tests/support/campaign_random.h"

namespace maquette {

namespace {

using test::kEnough;
using test::Random;

using bezier_double::bezier_jet;
using bezier_double::SurfaceJet;
using Patch = ReflectorPatch;

constexpr double kNearest_m = 0.01;  // nearer, a float does not hold the direction to 1e-4 rad
constexpr double kGrazing =
    0.003;  // cosine of incidence, 89.83 degrees: beyond, a float's straight line is a reflection
constexpr double kBorder = 0.999;  // nearer to the border than this, either answer is accepted

/// Converts from powers of x = 2 u - 1 to Bernstein form, the inverse of make_reflector_patch.
std::array<glm::dvec3, 4> bernstein(const std::array<glm::dvec3, 4>& c) {
  return {c[0] - c[1] + c[2] - c[3], c[0] - c[1] / 3.0 - c[2] / 3.0 + c[3], c[0] + c[1] / 3.0 - c[2] / 3.0 - c[3],
          c[0] + c[1] + c[2] + c[3]};
}

/// A tapered, skewed, slightly uneven piece of an elliptic paraboloid, anywhere in space; nothing when not convex.
std::optional<Patch> random_patch(Random& random) {
  const double r1 = random.log_uniform(0.2, 20.0), r2 = std::clamp(r1 * random.log_uniform(0.3, 3.0), 0.2, 20.0);
  const double hx = std::min(random.log_uniform(0.05, 1.0), 0.9 * r1);
  const double hy = std::min(hx * random.log_uniform(0.4, 2.5), 0.9 * r2);
  const double taper = random.uniform(-0.25, 0.25), skew = random.uniform(-0.2, 0.2);
  const glm::dvec3 ex = random.direction(), ey = glm::normalize(glm::cross(ex, random.direction())),
                   ez = glm::cross(ex, ey);
  std::array<glm::dvec3, 16> c{};
  const auto add = [&](std::size_t i, std::size_t j, const glm::dvec3& v) { c[4 * j + i] += v; };
  const double a = -hx * hx / (2.0 * r1), b = -hy * hy / (2.0 * r2);
  c[0] = random.uniform(-2.0, 2.0) * random.direction();
  add(1, 0, hx * ex + hy * skew * ey);
  add(1, 1, hx * taper * ex + 2.0 * b * skew * ez);
  add(0, 1, hy * ey);
  add(2, 0, (a + b * skew * skew) * ez);
  add(2, 1, 2.0 * a * taper * ez);
  add(2, 2, a * taper * taper * ez);
  add(0, 2, b * ez);
  const double uneven = random.uniform(0.0, 0.12) * std::min(-a, -b);
  for (std::size_t j = 0; j < 4; ++j)
    for (std::size_t i = 0; i < 4; ++i)
      if (i + j >= 2) add(i, j, uneven * (random.uniform(-1.0, 1.0) * ez + random.uniform(-0.3, 0.3) * ex));
  std::array<std::array<glm::dvec3, 4>, 4> rows{};
  std::array<glm::dvec3, 16> points{};
  for (std::size_t j = 0; j < 4; ++j) rows[j] = bernstein({c[4 * j], c[4 * j + 1], c[4 * j + 2], c[4 * j + 3]});
  for (std::size_t i = 0; i < 4; ++i) {
    const std::array<glm::dvec3, 4> column = bernstein({rows[0][i], rows[1][i], rows[2][i], rows[3][i]});
    for (std::size_t j = 0; j < 4; ++j) points[4 * j + i] = glm::dvec3(glm::vec3(column[j]));
  }
  Patch patch = make_reflector_patch(points);
  // The reference uses the rounded coefficients, as the float code does.
  for (std::size_t k = 0; k < 16; ++k) patch.exact.c[k] = glm::dvec3(patch.single.c[k]);
  if (patch.convex_side == 0.0 || patch.flat) return std::nullopt;
  return patch;
}

struct Setup {
  Patch patch;
  glm::dvec3 eye{0.0};
  double side = 1.0;  ///< that is tested
  ReflectorNodes nodes;
};

std::optional<Setup> random_setup(Random& random, bool concave) {
  std::optional<Patch> patch = random_patch(random);
  if (!patch) return std::nullopt;
  Setup setup{*patch, {}, concave ? -patch->convex_side : patch->convex_side, {}};
  const SurfaceJet jet = bezier_jet(patch->exact, {random.uniform(-1.3, 1.3), random.uniform(-1.3, 1.3)});
  const glm::dvec3 normal = setup.side * glm::normalize(glm::cross(jet.dx, jet.dy));
  const glm::dvec3 t = glm::normalize(jet.dx), s = glm::cross(normal, t);
  const double cosine = random.uniform(0, 1) < 0.2 ? random.log_uniform(0.01, 0.3) : random.uniform(0.1, 1.0);
  const double phi = random.uniform(0.0, 6.283185307179586), sine = std::sqrt(1.0 - cosine * cosine);
  const glm::dvec3 direction = cosine * normal + sine * (std::cos(phi) * t + std::sin(phi) * s);
  setup.eye = glm::dvec3(glm::vec3(jet.p + random.log_uniform(0.05, 10.0) * direction));
  for (const ReflectorNodes& nodes : make_reflector_nodes(setup.patch, setup.eye))
    if (nodes.side == static_cast<float>(setup.side)) setup.nodes = nodes;
  if (setup.nodes.nodes.empty()) return std::nullopt;  // the eye sees this side from no node
  return setup;
}

glm::dvec3 random_object(Random& random, const Setup& setup) {
  if (random.uniform(0.0, 1.0) > 0.667)
    return glm::dvec3(glm::vec3(random.log_uniform(0.05, 5.0) * random.direction()));
  const bezier_double::BezierNode at =
      bezier_node(setup.patch.exact, setup.eye, {random.uniform(-1.05, 1.05), random.uniform(-1.05, 1.05)});
  return glm::dvec3(glm::vec3(at.position + random.log_uniform(0.02, 10.0) * at.direction));
}

bool on_side(const Setup& setup, const glm::dvec2& x) {
  const SurfaceJet jet = bezier_jet(setup.patch.exact, x);
  return glm::dot(setup.eye - jet.p, glm::cross(jet.dx, jet.dy)) * setup.side > 0.0;
}

/// Angle between the ray that the patch reflects at x and the direction to the object, in double.
double law_error_rad(const Setup& setup, const glm::dvec2& x, const glm::dvec3& p) {
  const SurfaceJet jet = bezier_jet(setup.patch.exact, x);
  const glm::dvec3 n = glm::normalize(glm::cross(jet.dx, jet.dy)), in = glm::normalize(jet.p - setup.eye);
  const glm::dvec3 out = in - 2.0 * glm::dot(in, n) * n, to = glm::normalize(p - jet.p);
  return std::atan2(glm::length(glm::cross(out, to)), glm::dot(out, to));
}

/// Newton's method from the end of the descent in double, to the last digits. Leaves `x` unchanged if it does not
/// converge.
glm::dvec2 polished(const Setup& setup, const glm::dvec3& p, const glm::dvec2& x) {
  glm::dvec2 at = x;
  for (int k = 0; k < 30; ++k) {
    const auto t = path_terms(bezier_jet(setup.patch.exact, at), setup.eye, p);
    const glm::dvec3 h = t.spread + t.bend;
    const double determinant = h[0] * h[2] - h[1] * h[1];
    if (determinant <= 0.0) return x;
    const glm::dvec2 step =
        glm::dvec2(h[1] * t.gradient[1] - h[2] * t.gradient[0], h[1] * t.gradient[0] - h[0] * t.gradient[1]) /
        determinant;
    at += step;
    if (glm::length(at - x) > 0.1) return x;
    if (glm::length(step) < 1e-13) return at;
  }
  return x;
}

/// Every reflection point that is a minimum: descent in double from each grid point that is lower than its neighbours.
std::vector<bezier_double::ReflectionPoint> exhaustive_minima(const Setup& setup, const glm::dvec3& p) {
  constexpr int kGrid = 25;
  std::array<double, static_cast<std::size_t>(kGrid) * kGrid> length;
  const auto parameter = [](int i, int j) {
    return glm::dvec2(-1.0 + 2.0 * i / (kGrid - 1), -1.0 + 2.0 * j / (kGrid - 1));
  };
  const auto at = [&](int i, int j) -> double& { return length[static_cast<std::size_t>(j * kGrid + i)]; };
  for (int j = 0; j < kGrid; ++j)
    for (int i = 0; i < kGrid; ++i)
      at(i, j) = bezier_double::path_length(bezier_position(setup.patch.exact, parameter(i, j)), setup.eye, p);
  std::vector<bezier_double::ReflectionPoint> found;
  for (int j = 0; j < kGrid; ++j)
    for (int i = 0; i < kGrid; ++i) {
      bool lowest = true;
      for (int dj = -1; dj <= 1; ++dj)
        for (int di = -1; di <= 1; ++di)
          if (i + di >= 0 && i + di < kGrid && j + dj >= 0 && j + dj < kGrid) lowest &= at(i, j) <= at(i + di, j + dj);
      if (!lowest) continue;
      auto r = bezier_double::reflect_from(setup.patch.exact, setup.eye, p, parameter(i, j), 1.0, 200);
      if (r.status != bezier_double::kReflectionInside) continue;
      r.x = polished(setup, p, r.x);
      if (std::max(std::abs(r.x.x), std::abs(r.x.y)) >= 1.0) continue;
      if (law_error_rad(setup, r.x, p) > 1e-5 || !on_side(setup, r.x)) continue;
      const bool known =
          std::any_of(found.begin(), found.end(), [&](const auto& other) { return glm::length(other.x - r.x) < 0.02; });
      if (!known) found.push_back(r);
    }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.length_m < b.length_m; });
  return found;
}

bool too_near_or_grazing(const Setup& setup, const glm::dvec2& x, const glm::dvec3& p) {
  const SurfaceJet jet = bezier_jet(setup.patch.exact, x);
  const glm::dvec3 n = glm::normalize(glm::cross(jet.dx, jet.dy)), in = glm::normalize(jet.p - setup.eye);
  return glm::length(p - jet.p) < kNearest_m || std::abs(glm::dot(in, n)) < kGrazing;
}

void note_failure(const char* what, const Setup& setup, const glm::dvec3& p, const bezier_float::ReflectionPoint& r,
                  BezierCampaign* out) {
  if (out->failures.size() > kEnough) return;
  std::ostringstream text;
  text.precision(9);
  text << what << ": status " << r.status << " x " << r.x.x << " " << r.x.y << " steps " << r.steps << " residual "
       << r.residual << " eye " << setup.eye.x << " " << setup.eye.y << " " << setup.eye.z << " object " << p.x << " "
       << p.y << " " << p.z << (setup.nodes.unique ? " convex" : " concave");
  for (const auto& m : exhaustive_minima(setup, p)) text << " | minimum " << m.x.x << " " << m.x.y;
  out->failures += text.str() + '\n';
}

/// False when the case lies beyond a caustic: it is then counted as uncertified only.
bool judge(const Setup& setup, const glm::dvec3& p, BezierCampaign* out) {
  const glm::vec3 eye(setup.eye), object(p);
  const bezier_float::BezierStart start = best_start(setup.nodes, eye, object);
  if (!start.certified) {
    ++out->uncertified;
    return false;
  }
  const auto r = reflection_point(setup.patch.single, eye, object, start, setup.nodes.careful);
  ++out->cases;
  if (!std::isfinite(r.x.x + r.x.y + r.position.x + r.position.y + r.position.z + r.length_m)) ++out->not_finite;
  const auto minima = exhaustive_minima(setup, p);
  if (too_near_or_grazing(setup, glm::dvec2(r.x), p)) return true;
  const bool inside = r.status == bezier_float::kReflectionInside && on_side(setup, glm::dvec2(r.x));
  const auto interior = [](const glm::dvec2& x) { return std::max(std::abs(x.x), std::abs(x.y)) < kBorder; };
  if (!minima.empty() && too_near_or_grazing(setup, minima[0].x, p)) return true;
  if (minima.size() > 1) {
    ++out->several;
    note_failure("several", setup, p, r, out);
  }
  if (!minima.empty() && interior(minima[0].x)) {
    ++out->inside;
    out->steps[static_cast<std::size_t>(std::min(r.steps, 49))]++;
    const double law = inside ? law_error_rad(setup, glm::dvec2(r.x), p) : 3.2;
    // The same point, by its parameter or, where the minimum is flat, by the path length.
    const bool same = inside && (glm::length(glm::dvec2(r.x) - minima[0].x) < 0.02 ||
                                 static_cast<double>(r.length_m) < minima[0].length_m * (1.0 + 1e-6));
    if (!same) {
      ++out->wrong;
      note_failure("wrong", setup, p, r, out);
    } else if (law > 1e-4) {
      ++out->law_broken;
      note_failure("law", setup, p, r, out);
    }
    if (same) out->worst_law_rad = std::max(out->worst_law_rad, law);
  } else if (minima.empty() && inside && interior(glm::dvec2(r.x)) && law_error_rad(setup, glm::dvec2(r.x), p) > 1e-4) {
    ++out->wrong;  // no reflection there
    note_failure("one too many", setup, p, r, out);
  }
  return true;
}

void add(const BezierCampaign& part, BezierCampaign* sum) {
  sum->cases += part.cases;
  sum->inside += part.inside;
  sum->uncertified += part.uncertified;
  sum->wrong += part.wrong;
  sum->law_broken += part.law_broken;
  sum->several += part.several;
  sum->not_finite += part.not_finite;
  sum->worst_law_rad = std::max(sum->worst_law_rad, part.worst_law_rad);
  for (std::size_t i = 0; i < sum->steps.size(); ++i) sum->steps[i] += part.steps[i];
  if (sum->failures.size() <= kEnough) sum->failures += part.failures;
}

}  // namespace

int BezierCampaign::steps_quantile(double q) const {
  std::size_t seen = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    seen += steps[i];
    if (static_cast<double>(seen) >= q * static_cast<double>(inside)) return static_cast<int>(i);
  }
  return static_cast<int>(steps.size());
}

BezierCampaign run_bezier_campaign(std::size_t cases, std::uint64_t seed) {
  constexpr std::size_t kBatch = 500, kObjects = 5;
  const std::size_t batches = std::max<std::size_t>(2, (cases + kBatch - 1) / kBatch);
  const std::size_t each = (cases + batches - 1) / batches;
  BezierCampaign sum;
  sum.steps.assign(50, 0);
  std::mutex guard;
  parallel_for(std::size_t{0}, batches, [&](std::size_t batch) {
    Random random{std::mt19937_64(seed * 1000003u + batch)};
    BezierCampaign part;
    part.steps.assign(50, 0);
    while (part.cases < each) {
      const std::optional<Setup> setup = random_setup(random, batch % 2 == 1);
      if (!setup) continue;
      for (std::size_t k = 0; k < kObjects && part.cases < each; ++k)
        judge(*setup, random_object(random, *setup), &part);
    }
    const std::lock_guard lock(guard);
    add(part, &sum);
  });
  return sum;
}

}  // namespace maquette
