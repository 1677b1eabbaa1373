#include "viewer/swatches.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <random>

#include "render/btf/btf_source.h"
#include "scenes/error.h"

namespace maquette {

namespace {

constexpr int kSamplesPerKind = 20;
constexpr double kAlphas[] = {0.22, 0.04};  // GGX widths that the half vectors are drawn with, besides the cosine

struct Local {
  glm::dvec3 x{}, y{}, z{};
  glm::dvec3 to_world(const glm::dvec3& v) const { return v.x * x + v.y * y + v.z * z; }
};

Local frame_of(const glm::dvec3& n) {
  const glm::dvec3 helper = std::abs(n.y) < 0.9 ? glm::dvec3(0.0, 1.0, 0.0) : glm::dvec3(1.0, 0.0, 0.0);
  const glm::dvec3 x = glm::normalize(glm::cross(helper, n));
  return {x, glm::cross(n, x), n};
}

/// A soft box above on the left, a strip on the right, a floor; view from +Z.
glm::dvec3 studio(const glm::dvec3& d) {
  const auto box = [&](const glm::dvec3& center, double half_width) {
    const double edge = std::acos(std::clamp(glm::dot(d, glm::normalize(center)), -1.0, 1.0));
    return 1.0 - glm::smoothstep(0.7 * half_width, half_width, edge);
  };
  const glm::dvec3 walls = glm::mix(glm::dvec3(0.10, 0.095, 0.09), glm::dvec3(0.42, 0.45, 0.5), 0.5 + 0.5 * d.y);
  return walls + 9.0 * box({-0.6, 0.8, 0.5}, 0.55) + glm::dvec3(2.6, 2.8, 3.2) * box({0.95, 0.1, 0.1}, 0.5);
}

double ggx_density(double cos_h, double alpha) {
  const double a2 = alpha * alpha, t = cos_h * cos_h * (a2 - 1.0) + 1.0;
  return a2 / (glm::pi<double>() * t * t);
}

/// One-sample balance over the cosine and two half-vector densities. Source: Veach 1997, Eq. 9.8; Walter et al. 2007,
/// Eq. 33.
glm::dvec3 reflected(const BrdfTable& table, const Local& local, const glm::dvec3& wo, std::mt19937* random) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto density = [&](const glm::dvec3& wi) {
    const glm::dvec3 h = glm::normalize(wi + wo);
    double sum = std::max(wi.z, 0.0) / glm::pi<double>();
    for (const double alpha : kAlphas)
      sum += ggx_density(h.z, alpha) * h.z / std::max(4.0 * std::abs(glm::dot(h, wo)), 1e-6);
    return kSamplesPerKind * sum;
  };
  glm::dvec3 sum(0.0);
  for (int i = 0; i < 3 * kSamplesPerKind; ++i) {
    const double u = uniform(*random), phi = glm::two_pi<double>() * uniform(*random);
    glm::dvec3 wi{};
    if (i % 3 == 0) {
      const double r = std::sqrt(u);
      wi = {r * std::cos(phi), r * std::sin(phi), std::sqrt(1.0 - u)};
    } else {
      const double a2 = kAlphas[i % 3 - 1] * kAlphas[i % 3 - 1];
      const double z = std::sqrt((1.0 - u) / (1.0 + (a2 - 1.0) * u)), r = std::sqrt(std::max(1.0 - z * z, 0.0));
      const glm::dvec3 h(r * std::cos(phi), r * std::sin(phi), z);
      wi = 2.0 * glm::dot(wo, h) * h - wo;
    }
    if (wi.z <= 1e-4) continue;
    sum += evaluate_brdf(table, wi, wo) * studio(local.to_world(wi)) * (wi.z / density(wi));
  }
  return sum;
}

std::uint8_t encode(double linear) {
  const double x = std::clamp(1.0 - std::exp(-1.25 * std::max(linear, 0.0)), 0.0, 1.0);
  return static_cast<std::uint8_t>(std::lround(255.0 * std::pow(x, 1.0 / 2.2)));
}

}  // namespace

std::vector<std::uint8_t> draw_brdf_ball(const BrdfTable& table, int side) {
  std::vector<std::uint8_t> rgba(static_cast<std::size_t>(side) * static_cast<std::size_t>(side) * 4, 0);
  std::mt19937 random(1);
  const double radius = 0.47 * side;
  for (int py = 0; py < side; ++py) {
    for (int px = 0; px < side; ++px) {
      const double x = (px + 0.5 - 0.5 * side) / radius, y = (0.5 * side - py - 0.5) / radius;
      const double r = std::sqrt(x * x + y * y);
      const double cover = std::clamp((1.0 - r) * radius + 0.5, 0.0, 1.0);
      if (cover <= 0.0) continue;
      const double shrink = r > 0.98 ? 0.98 / r : 1.0;  // the rim itself is seen edge on
      const glm::dvec2 p(x * shrink, y * shrink);
      const Local local = frame_of({p.x, p.y, std::sqrt(1.0 - glm::dot(p, p))});
      const glm::dvec3 wo(local.x.z, local.y.z, local.z.z);
      const glm::dvec3 color = reflected(table, local, wo, &random);
      std::uint8_t* texel =
          &rgba[4 * (static_cast<std::size_t>(py) * static_cast<std::size_t>(side) + static_cast<std::size_t>(px))];
      for (int c = 0; c < 3; ++c) texel[c] = encode(color[c]);
      texel[3] = static_cast<std::uint8_t>(std::lround(255.0 * cover));
    }
  }
  return rgba;
}

void Swatches::add(const Ball& ball) {
  Texture texture = Texture::make_2d("swatch", GL_RGBA8, kSide, kSide);
  texture.set_filter(GL_LINEAR, GL_LINEAR);
  texture.upload(0, kSide, kSide, GL_RGBA, GL_UNSIGNED_BYTE, ball.rgba.data());
  textures_[ball.source] = texture.get();
  owners_.push_back(std::move(texture));
}

void Swatches::update_library() {
  if (!library_) {
    library_ = std::make_unique<Library>(
        [](std::monostate, const BackgroundTask<std::vector<Ball>>& task) -> std::optional<std::vector<Ball>> {
          std::vector<Ball> balls;
          for (const BuiltinBrdf& brdf : builtin_brdfs()) {
            if (task.cancel) return std::nullopt;
            balls.push_back({"builtin:" + brdf.name, draw_brdf_ball(make_builtin_brdf(brdf.name), kSide)});
            task.publish(balls);
          }
          return std::nullopt;
        });
    for (const BuiltinBrdf& brdf : builtin_brdfs()) tried_.insert("builtin:" + brdf.name);
    library_->submit({});
  }
  const std::vector<Ball> balls = library_->take().value_or(std::vector<Ball>());
  for (; of_library_ < balls.size(); ++of_library_) add(balls[of_library_]);
}

void Swatches::update(const std::vector<std::string>& drawn) {
  update_library();
  if (busy_) {
    const std::optional<Ball> ball = others_->take();
    if (!ball) return;
    busy_ = false;
    if (!ball->rgba.empty()) add(*ball);
  }
  for (const std::string& source : drawn) {
    if (!tried_.insert(source).second) continue;
    if (!others_)
      others_ =
          std::make_unique<Others>([](const std::string& wanted, const BackgroundTask<Ball>&) -> std::optional<Ball> {
            try {
              return Ball{wanted, draw_brdf_ball(load_material_table(wanted), kSide)};
            } catch (const Error&) {  // glass, and files that are gone: who draws with them says so
              return Ball{wanted, {}};
            }
          });
    others_->submit(source);
    busy_ = true;
    return;
  }
}

}  // namespace maquette
