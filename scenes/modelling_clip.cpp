#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <unordered_map>
#include <utility>

#include "scenes/modelling.h"

namespace maquette::modelling {

namespace {

class Clipper {
 public:
  Clipper(const Primitive& surface, const Field& field) : surface_(surface), field_(field) {
    values_.reserve(surface.positions.size());
    for (const glm::vec3& p : surface.positions) values_.push_back(field(Vec3(p)));
    kept_.assign(surface.positions.size(), -1);
  }

  Primitive run(const Rim* rim) {
    for (std::size_t i = 0; i + 2 < surface_.indices.size(); i += 3) clip_triangle(&surface_.indices[i]);
    if (rim != nullptr) finish_rim(*rim);
    return std::move(result_);
  }

 private:
  std::uint32_t keep(std::uint32_t i) {
    if (kept_[i] < 0) {
      kept_[i] = static_cast<std::int64_t>(result_.positions.size());
      result_.positions.push_back(surface_.positions[i]);
      result_.normals.push_back(surface_.normals[i]);
      result_.uvs[0].push_back(surface_.uvs[0][i]);
    }
    return static_cast<std::uint32_t>(kept_[i]);
  }

  /// Vertex at the zero of the field on the edge from i (inside) to j (outside).
  std::uint32_t cross(std::uint32_t i, std::uint32_t j) {
    const std::uint64_t key = (std::uint64_t{std::min(i, j)} << 32) | std::max(i, j);
    const auto [entry, added] = crossings_.try_emplace(key, 0u);
    if (!added) return entry->second;
    const Vec3 a(surface_.positions[i]), b(surface_.positions[j]);
    double t0 = 0.0, t1 = 1.0, f0 = values_[i], f1 = values_[j], t = 0.5;
    for (int step = 0; step < 3; ++step) {
      t = t0 - f0 * (t1 - t0) / (f1 - f0);
      const double f = field_(a + t * (b - a));
      (f < 0.0 ? t0 : t1) = t;
      (f < 0.0 ? f0 : f1) = f;
    }
    const auto s = static_cast<float>(t);
    entry->second = static_cast<std::uint32_t>(result_.positions.size());
    result_.positions.emplace_back(a + t * (b - a));
    result_.normals.push_back(glm::normalize(glm::mix(surface_.normals[i], surface_.normals[j], s)));
    result_.uvs[0].push_back(glm::mix(surface_.uvs[0][i], surface_.uvs[0][j], s));
    return entry->second;
  }

  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const std::vector<glm::vec3>& p = result_.positions;
    const glm::vec3 area = glm::cross(p[b] - p[a], p[c] - p[a]);
    if (glm::dot(area, area) > 1e-18f) result_.indices.insert(result_.indices.end(), {a, b, c});
  }

  void clip_triangle(const std::uint32_t* corner) {
    int inside = 0;
    for (int k = 0; k < 3; ++k) inside += values_[corner[k]] < 0.0 ? 1 : 0;
    if (inside == 0) return;
    if (inside == 3) {
      add(keep(corner[0]), keep(corner[1]), keep(corner[2]));
      return;
    }
    // Rotates the corners so that the odd one is first; the cut runs counter-clockwise with the kept side on its left.
    int odd = 0;
    while ((values_[corner[odd]] < 0.0) != (inside == 1)) ++odd;
    const std::uint32_t o = corner[odd], n = corner[(odd + 1) % 3], p = corner[(odd + 2) % 3];
    if (inside == 1) {
      const std::uint32_t a = cross(o, n), b = cross(o, p);
      add(keep(o), a, b);
      cuts_.emplace_back(a, b);
    } else {
      const std::uint32_t a = cross(n, o), b = cross(p, o);
      add(a, keep(n), keep(p));
      add(a, keep(p), b);
      cuts_.emplace_back(b, a);
    }
  }

  void finish_rim(const Rim& rim) {
    std::unordered_map<std::uint32_t, std::uint32_t> first_of;
    const int rings = rim.segments + 2;
    for (const auto& [a, b] : cuts_)
      for (const std::uint32_t i : {a, b})
        if (first_of.try_emplace(i, static_cast<std::uint32_t>(result_.positions.size())).second)
          add_rim_vertices(i, rim);
    for (const auto& [a, b] : cuts_) {
      if (a == b) continue;
      const std::uint32_t fa = first_of[a], fb = first_of[b];
      for (int k = 0; k + 1 < rings; ++k) {
        const auto u = static_cast<std::uint32_t>(k);
        add(fa + u, fa + u + 1, fb + u + 1);
        add(fa + u, fb + u + 1, fb + u);
      }
    }
  }

  void add_rim_vertices(std::uint32_t i, const Rim& rim) {
    const Vec3 p(result_.positions[i]), n(result_.normals[i]);
    const glm::vec2 uv = result_.uvs[0][i];
    const double h = 1e-4;
    const Vec3 gradient(field_(p + Vec3(h, 0, 0)) - field_(p - Vec3(h, 0, 0)),
                        field_(p + Vec3(0, h, 0)) - field_(p - Vec3(0, h, 0)),
                        field_(p + Vec3(0, 0, h)) - field_(p - Vec3(0, 0, h)));
    Vec3 out = gradient - n * glm::dot(gradient, n);
    out = glm::length(out) > 1e-12 ? glm::normalize(out) : Vec3(0.0);
    const auto put = [&](const Vec3& position, const Vec3& normal) {
      result_.positions.emplace_back(position);
      result_.normals.emplace_back(normal);
      result_.uvs[0].push_back(uv);
    };
    for (int k = 0; k <= rim.segments; ++k) {
      const double a = std::numbers::pi / 2.0 * k / rim.segments, c = std::cos(a), s = std::sin(a);
      put(p + rim.radius_m * (s * out - (1.0 - c) * n), glm::normalize(c * n + s * out + 1e-9 * n));
    }
    put(p + rim.radius_m * out - (rim.radius_m + rim.depth_m) * n, glm::length(out) > 0.0 ? out : n);
  }

  const Primitive& surface_;
  const Field& field_;
  std::vector<double> values_;
  std::vector<std::int64_t> kept_;
  std::unordered_map<std::uint64_t, std::uint32_t> crossings_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> cuts_;
  Primitive result_;
};

}  // namespace

Primitive clip(const Primitive& surface, const Field& field, const Rim* rim) {
  return Clipper(surface, field).run(rim);
}

Primitive clip_band(const Primitive& surface, const Field& field, double from, double to, const Rim* rim) {
  const Field below = [&](const Vec3& p) { return field(p) - to; };
  const Field above = [&](const Vec3& p) { return from - field(p); };
  return clip(clip(surface, below, rim), above, rim);
}

void split_long_edges(Primitive* surface, double longest_m) {
  std::unordered_map<std::uint64_t, std::uint32_t> middles;
  for (bool again = true; again;) {
    again = false;
    middles.clear();
    /// Vertex in the middle of an edge that is too long, the same for both triangles; else the first end.
    const auto middle = [&](std::uint32_t i, std::uint32_t j) {
      const Vec3 a(surface->positions[i]), b(surface->positions[j]);
      if (glm::distance(a, b) <= longest_m) return i;
      const std::uint64_t key = (std::uint64_t{std::min(i, j)} << 32) | std::max(i, j);
      const auto [entry, added] = middles.try_emplace(key, static_cast<std::uint32_t>(surface->positions.size()));
      if (added) {
        surface->positions.emplace_back(0.5 * (a + b));
        surface->normals.push_back(glm::normalize(surface->normals[i] + surface->normals[j]));
        surface->uvs[0].push_back(0.5f * (surface->uvs[0][i] + surface->uvs[0][j]));
      }
      return entry->second;
    };
    std::vector<std::uint32_t> divided;
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      if (a != b && b != c && c != a) divided.insert(divided.end(), {a, b, c});
    };
    for (std::size_t i = 0; i + 2 < surface->indices.size(); i += 3) {
      std::array<std::uint32_t, 3> v{surface->indices[i], surface->indices[i + 1], surface->indices[i + 2]}, m{};
      // An edge that stays comes last, or, of two, first.
      for (int turn = 0; turn < 3; ++turn) {
        for (std::size_t k = 0; k < 3; ++k) m[k] = middle(v[k], v[(k + 1) % 3]);
        const bool cut0 = m[0] != v[0], cut1 = m[1] != v[1], cut2 = m[2] != v[2];
        if (cut0 == cut1 && cut1 == cut2) break;
        if (cut0 && !cut2) break;
        std::rotate(v.begin(), v.begin() + 1, v.end());
      }
      const bool cut0 = m[0] != v[0], cut1 = m[1] != v[1], cut2 = m[2] != v[2];
      again = again || cut0;
      if (!cut0) {
        add(v[0], v[1], v[2]);
      } else if (!cut1) {
        add(v[0], m[0], v[2]);
        add(m[0], v[1], v[2]);
      } else if (!cut2) {
        add(m[0], v[1], m[1]);
        add(v[0], m[0], m[1]);
        add(v[0], m[1], v[2]);
      } else {
        add(v[0], m[0], m[2]);
        add(m[0], v[1], m[1]);
        add(m[1], v[2], m[2]);
        add(m[0], m[1], m[2]);
      }
    }
    surface->indices = std::move(divided);
  }
}

Primitive offset(const Primitive& surface, double distance_m) {
  Primitive moved = surface;
  for (std::size_t i = 0; i < moved.positions.size(); ++i)
    moved.positions[i] += static_cast<float>(distance_m) * moved.normals[i];
  return moved;
}

}  // namespace maquette::modelling
