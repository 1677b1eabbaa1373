#include "scenes/modelling.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/srgb.h"

namespace maquette::modelling {

glm::vec3 srgb(int r, int g, int b) {
  const auto linear = [](int c) { return static_cast<float>(linear_from_srgb(c / 255.0)); };
  return {linear(r), linear(g), linear(b)};
}

double smoother(double edge0, double edge1, double x) {
  const double t = std::clamp((x - edge0) / (edge1 - edge0), 0.0, 1.0);
  return t * t * t * (t * (6.0 * t - 15.0) + 10.0);
}

double mix(double a, double b, double t) { return a + (b - a) * t; }

double smooth_max(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::max(a, b) + h * h * h * k / 6.0;
}

double smooth_min(double a, double b, double k) { return -smooth_max(-a, -b, k); }

Curve::Curve(std::initializer_list<Vec2> knots) : knots_(knots), second_derivatives_(knots.size(), 0.0) {
  // Thomas algorithm for the tridiagonal system of second derivatives with free ends.
  const std::size_t n = knots_.size();
  std::vector<double> upper(n, 0.0), right(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double h0 = knots_[i].x - knots_[i - 1].x, h1 = knots_[i + 1].x - knots_[i].x;
    const double rise = (knots_[i + 1].y - knots_[i].y) / h1 - (knots_[i].y - knots_[i - 1].y) / h0;
    const double pivot = 2.0 * (h0 + h1) - h0 * upper[i - 1];
    upper[i] = h1 / pivot;
    right[i] = (6.0 * rise - h0 * right[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) second_derivatives_[i] = right[i] - upper[i] * second_derivatives_[i + 1];
}

double Curve::operator()(double x) const {
  const std::size_t n = knots_.size();
  std::size_t i = 0;
  while (i + 2 < n && x > knots_[i + 1].x) ++i;
  const Vec2 a = knots_[i], b = knots_[i + 1];
  const double h = b.x - a.x, secant = (b.y - a.y) / h;
  if (x < a.x)
    return a.y + (x - a.x) * (secant - h * (2.0 * second_derivatives_[i] + second_derivatives_[i + 1]) / 6.0);
  if (x > b.x)
    return b.y + (x - b.x) * (secant + h * (second_derivatives_[i] + 2.0 * second_derivatives_[i + 1]) / 6.0);
  const double p = (b.x - x) / h, q = (x - a.x) / h;
  return p * a.y + q * b.y +
         h * h / 6.0 * ((p * p * p - p) * second_derivatives_[i] + (q * q * q - q) * second_derivatives_[i + 1]);
}

Vec3 b_spline(const std::vector<Vec3>& points, double t) {
  const int n = static_cast<int>(points.size());
  // Phantom ends reflect the second point in the first, so that the curve starts there.
  const auto control = [&](int i) {
    if (i < 0) return 2.0 * points[0] - points[1];
    if (i >= n) return 2.0 * points[static_cast<std::size_t>(n - 1)] - points[static_cast<std::size_t>(n - 2)];
    return points[static_cast<std::size_t>(i)];
  };
  const double x = std::clamp(t, 0.0, 1.0) * (n - 1);
  const int i = std::min(static_cast<int>(x), n - 2);
  const double s = x - i, r = 1.0 - s;
  return (r * r * r * control(i - 1) + (3.0 * s * s * s - 6.0 * s * s + 4.0) * control(i) +
          (3.0 * r * r * r - 6.0 * r * r + 4.0) * control(i + 1) + s * s * s * control(i + 2)) /
         6.0;
}

namespace {

Vec3 grid_normal(const SurfaceFunction& f, double u, double v) {
  const double h = 1e-4;
  for (double inset = 0.0; inset < 0.1; inset = inset == 0.0 ? 1e-3 : inset * 3.0) {
    const double uc = std::clamp(u, inset, 1.0 - inset), vc = std::clamp(v, inset, 1.0 - inset);
    const double u0 = std::max(uc - h, 0.0), u1 = std::min(uc + h, 1.0);
    const double v0 = std::max(vc - h, 0.0), v1 = std::min(vc + h, 1.0);
    const Vec3 du = (f(u1, vc) - f(u0, vc)) / (u1 - u0), dv = (f(uc, v1) - f(uc, v0)) / (v1 - v0);
    const Vec3 n = glm::cross(du, dv);
    const double scale = glm::length(du) * glm::length(dv);
    if (glm::length(n) > 1e-6 * scale && scale > 1e-12) return glm::normalize(n);
  }
  return {0.0, 1.0, 0.0};
}

void add_vertex(Primitive* p, const Vec3& position, const Vec3& normal, const Vec2& uv) {
  p->positions.emplace_back(position);
  p->normals.emplace_back(normal);
  p->uvs[0].emplace_back(uv);
}

/// Two triangles for corners a b c d (counter-clockwise outside), leaving out those without area.
void add_quad(Primitive* p, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d, bool flip) {
  const auto triangle = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    const glm::vec3 area = glm::cross(p->positions[j] - p->positions[i], p->positions[k] - p->positions[i]);
    if (glm::dot(area, area) < 1e-20f) return;
    if (flip) std::swap(j, k);
    p->indices.insert(p->indices.end(), {i, j, k});
  };
  triangle(a, b, c);
  triangle(a, c, d);
}

void add_lattice(Primitive* p, std::uint32_t first, int nu, int nv, bool flip) {
  const auto at = [&](int i, int j) { return first + static_cast<std::uint32_t>(i * (nv + 1) + j); };
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j) add_quad(p, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1), flip);
}

}  // namespace

Primitive make_grid(int nu, int nv, const SurfaceFunction& f, const GridOptions& options) {
  Primitive p;
  const SurfaceFunction wrapped = [&](double u, double v) {
    return f(options.wrap_u ? u - std::floor(u) : u, options.wrap_v ? v - std::floor(v) : v);
  };
  for (int i = 0; i <= nu; ++i) {
    for (int j = 0; j <= nv; ++j) {
      const double u = static_cast<double>(i) / nu, v = static_cast<double>(j) / nv;
      // A wrapped direction shares the normal across its seam.
      const bool u_seam = options.wrap_u && (i == 0 || i == nu), v_seam = options.wrap_v && (j == 0 || j == nv);
      Vec3 n{};
      if (u_seam || v_seam) {
        const double h = 1e-4;
        const double ua = u_seam ? 0.0 : u, va = v_seam ? 0.0 : v;
        const Vec3 du = u_seam ? wrapped(h, va) - wrapped(1.0 - h, va)
                               : wrapped(std::min(ua + h, 1.0), va) - wrapped(std::max(ua - h, 0.0), va);
        const Vec3 dv = v_seam ? wrapped(ua, h) - wrapped(ua, 1.0 - h)
                               : wrapped(ua, std::min(va + h, 1.0)) - wrapped(ua, std::max(va - h, 0.0));
        n = glm::cross(du, dv);
        n = glm::length(n) > 1e-14 ? glm::normalize(n) : grid_normal(f, u, v);
      } else {
        n = grid_normal(f, u, v);
      }
      const Vec3 position = wrapped(options.wrap_u && i == nu ? 0.0 : u, options.wrap_v && j == nv ? 0.0 : v);
      add_vertex(&p, position, options.flip ? -n : n, Vec2(u, v) * options.uv_scale);
    }
  }
  add_lattice(&p, 0, nu, nv, options.flip);
  return p;
}

Primitive make_sphere(double radius, int n) {
  Primitive p;
  const Vec3 axes[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (const Vec3& w : axes) {
    const Vec3 a = std::abs(w.y) > 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    const Vec3 u = glm::normalize(glm::cross(a, w)), v = glm::cross(w, u);
    const auto first = static_cast<std::uint32_t>(p.positions.size());
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j) {
        const double s = std::tan((2.0 * i / n - 1.0) * std::numbers::pi / 4.0),
                     t = std::tan((2.0 * j / n - 1.0) * std::numbers::pi / 4.0);
        const Vec3 d = glm::normalize(w + s * u + t * v);
        const Vec2 uv(std::atan2(d.x, d.z) / (2.0 * std::numbers::pi) + 0.5,
                      0.5 - std::asin(std::clamp(d.y, -1.0, 1.0)) / std::numbers::pi);
        add_vertex(&p, radius * d, d, uv);
      }
    }
    add_lattice(&p, first, n, n, false);
  }
  return p;
}

Primitive make_rounded_box(const Vec3& size, double radius, int k) {
  Primitive p;
  const double r = std::min(radius, 0.499 * std::min({size.x, size.y, size.z}));
  const Vec3 core = 0.5 * size - Vec3(r);
  const Vec3 axes[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  // Rows 0..k form one rounded edge, then the flat, then k+1..2k+1 the other edge.
  const auto angle = [&](int i) {
    return i <= k ? (static_cast<double>(i) / k - 1.0) * std::numbers::pi / 4.0
                  : (i - k - 1.0) / k * std::numbers::pi / 4.0;
  };
  const int n = 2 * k + 1;
  for (const Vec3& w : axes) {
    const Vec3 a = std::abs(w.y) > 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    const Vec3 u = glm::normalize(glm::cross(a, w)), v = glm::cross(w, u);
    const auto first = static_cast<std::uint32_t>(p.positions.size());
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j) {
        const Vec3 d = glm::normalize(w + std::tan(angle(i)) * u + std::tan(angle(j)) * v);
        const Vec3 corner = w + (i <= k ? -u : u) + (j <= k ? -v : v);
        const Vec3 position = corner * core + r * d;
        add_vertex(&p, position, d, {glm::dot(position, u) + 0.5, glm::dot(position, v) + 0.5});
      }
    }
    add_lattice(&p, first, n, n, false);
  }
  return p;
}

Primitive make_quad(const Vec3& origin, const Vec3& a, const Vec3& b, int n, const Vec2& uv_scale) {
  Primitive p;
  const Vec3 normal = glm::normalize(glm::cross(a, b));
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const double u = static_cast<double>(i) / n, v = static_cast<double>(j) / n;
      add_vertex(&p, origin + u * a + v * b, normal, Vec2(u, 1.0 - v) * uv_scale);
    }
  add_lattice(&p, 0, n, n, false);
  return p;
}

Profile round_corners(const std::vector<Vec2>& points, double radius, int k, bool closed) {
  Profile profile;
  const std::size_t n = points.size();
  const auto right = [](const Vec2& d) { return Vec2(d.y, -d.x); };
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 p = points[i], previous = points[(i + n - 1) % n], next = points[(i + 1) % n];
    if (!closed && (i == 0 || i + 1 == n)) {
      profile.push_back({p, right(glm::normalize(i == 0 ? next - p : p - previous))});
      continue;
    }
    const Vec2 in = glm::normalize(p - previous), out = glm::normalize(next - p);
    const double turn = std::atan2(in.x * out.y - in.y * out.x, glm::dot(in, out));
    if (std::abs(turn) < 1e-3) {
      profile.push_back({p, right(glm::normalize(in + out))});
      continue;
    }
    const double room = 0.49 * std::min(glm::length(p - previous), glm::length(next - p));
    const double tangent = std::min(radius * std::tan(std::abs(turn) / 2.0), room);
    const double r = tangent / std::tan(std::abs(turn) / 2.0);
    const double side = turn > 0.0 ? -1.0 : 1.0;
    const Vec2 centre = p - tangent * in + side * r * right(in);
    for (int j = 0; j <= k; ++j) {
      const double a = turn * j / k, c = std::cos(a), s = std::sin(a);
      const Vec2 n0 = right(in), normal(c * n0.x - s * n0.y, s * n0.x + c * n0.y);
      profile.push_back({centre - side * r * normal, normal});
    }
  }
  return profile;
}

Profile make_ellipse(double rx, double ry, int n) {
  Profile profile;
  for (int i = 0; i < n; ++i) {
    const double a = 2.0 * std::numbers::pi * i / n;
    profile.push_back({{rx * std::cos(a), ry * std::sin(a)}, glm::normalize(Vec2(ry * std::cos(a), rx * std::sin(a)))});
  }
  return profile;
}

Primitive revolve(const Profile& profile, int segments, double from_rad, double to_rad) {
  Primitive p;
  const int rows = static_cast<int>(profile.size()) - 1;
  for (int i = 0; i <= segments; ++i) {
    const double a = mix(from_rad, to_rad, static_cast<double>(i) / segments), c = std::cos(a), s = std::sin(a);
    for (int j = 0; j <= rows; ++j) {
      const ProfilePoint& q = profile[static_cast<std::size_t>(j)];
      add_vertex(&p, {q.position.x * s, q.position.y, q.position.x * c},
                 glm::normalize(Vec3(q.normal.x * s, q.normal.y, q.normal.x * c)),
                 {static_cast<double>(i) / segments, static_cast<double>(j) / rows});
    }
  }
  add_lattice(&p, 0, segments, rows, false);
  return p;
}

Primitive sweep(const std::vector<Frame>& frames, const Profile& profile, bool closed_profile, bool closed_path,
                bool caps) {
  Primitive p;
  const int rows = static_cast<int>(frames.size()) - (closed_path ? 0 : 1);
  double advance = 0.0;
  for (std::size_t i = 0; i + 1 < frames.size(); ++i)
    advance += glm::dot(frames[i + 1].origin - frames[i].origin, glm::cross(frames[i].x, frames[i].y));
  const bool forward = advance > 0.0;
  const int columns = static_cast<int>(profile.size()) - (closed_profile ? 0 : 1);
  for (int i = 0; i <= rows; ++i) {
    const Frame& f = frames[static_cast<std::size_t>(i) % frames.size()];
    for (int j = 0; j <= columns; ++j) {
      const ProfilePoint& q = profile[static_cast<std::size_t>(j) % profile.size()];
      const Vec3 normal = glm::normalize(f.x * (q.normal.x / f.scale.x) + f.y * (q.normal.y / f.scale.y));
      add_vertex(&p, f.origin + f.x * (q.position.x * f.scale.x) + f.y * (q.position.y * f.scale.y), normal,
                 {static_cast<double>(i) / rows, static_cast<double>(j) / columns});
    }
  }
  add_lattice(&p, 0, rows, columns, forward);
  if (!caps) return p;
  for (const bool end : {false, true}) {
    const Frame& f = end ? frames.back() : frames.front();
    const Vec3 normal = glm::normalize(glm::cross(f.x, f.y)) * (end == forward ? 1.0 : -1.0);
    const auto first = static_cast<std::uint32_t>(p.positions.size());
    add_vertex(&p, f.origin, normal, {0.5, 0.5});
    for (const ProfilePoint& q : profile)
      add_vertex(&p, f.origin + f.x * (q.position.x * f.scale.x) + f.y * (q.position.y * f.scale.y), normal,
                 q.position);
    const auto n = static_cast<std::uint32_t>(profile.size());
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t a = first + 1 + j, b = first + 1 + (j + 1) % n;
      add_quad(&p, first, a, b, first, end != forward);
    }
  }
  return p;
}

Primitive make_tube(const std::vector<Vec3>& path, double radius_m, int around, int along, bool caps) {
  const auto point = [&](double t) {
    const double x = std::clamp(t, 0.0, 1.0) * static_cast<double>(path.size() - 1);
    const std::size_t i = std::min(static_cast<std::size_t>(x), path.size() - 2);
    const double s = x - static_cast<double>(i);
    const Vec3 b = path[i], c = path[i + 1];
    const Vec3 a = i > 0 ? path[i - 1] : 2.0 * b - c, d = i + 2 < path.size() ? path[i + 2] : 2.0 * c - b;
    return b + 0.5 * s * (c - a + s * (2.0 * a - 5.0 * b + 4.0 * c - d + s * (3.0 * (b - c) + d - a)));
  };
  std::vector<Frame> frames;
  Vec3 x(0.0);
  for (int i = 0; i <= along; ++i) {
    const double t = static_cast<double>(i) / along;
    const Vec3 tangent = glm::normalize(point(t + 1e-4) - point(t - 1e-4));
    if (i == 0) x = std::abs(tangent.y) > 0.9 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    x = glm::normalize(x - tangent * glm::dot(x, tangent));
    frames.push_back({point(t), x, glm::cross(tangent, x)});
  }
  return sweep(frames, make_ellipse(radius_m, radius_m, around), true, false, caps);
}

Primitive extrude(const Profile& outline, double depth, double bevel, int k) {
  Primitive p;
  Vec2 centre(0.0);
  double area = 0.0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2 a = outline[i].position, b = outline[(i + 1) % outline.size()].position;
    const double doubled = a.x * b.y - a.y * b.x;
    centre += (a + b) * (doubled / 3.0);
    area += doubled;
  }
  centre /= area;
  const int n = static_cast<int>(outline.size());
  const auto ring = [&](double inset, double z, double lean, double nz) {
    for (int j = 0; j <= n; ++j) {
      const ProfilePoint& q = outline[static_cast<std::size_t>(j % n)];
      const Vec2 at = q.position - inset * q.normal;
      add_vertex(&p, {at, z}, {q.normal * lean, nz}, at);
    }
  };
  int rings = 0;
  for (const bool top : {false, true}) {
    for (int i = 0; i <= k; ++i) {
      const double a = (top ? i : k - i) * std::numbers::pi / (2.0 * k), s = std::sin(a), c = std::cos(a);
      ring(bevel * (1.0 - c), top ? depth - bevel * (1.0 - s) : bevel * (1.0 - s), c, top ? s : -s);
      ++rings;
    }
  }
  add_lattice(&p, 0, rings - 1, n, true);
  for (const bool top : {false, true}) {
    const auto first = static_cast<std::uint32_t>(p.positions.size());
    const double z = top ? depth : 0.0;
    const Vec3 normal(0.0, 0.0, top ? 1.0 : -1.0);
    add_vertex(&p, {centre, z}, normal, centre);
    for (const ProfilePoint& q : outline) add_vertex(&p, {q.position - bevel * q.normal, z}, normal, q.position);
    for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(n); ++j)
      add_quad(&p, first, first + 1 + j, first + 1 + (j + 1) % static_cast<std::uint32_t>(n), first, !top);
  }
  return p;
}

}  // namespace maquette::modelling
