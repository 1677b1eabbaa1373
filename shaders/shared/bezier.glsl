// Reflection points on a bicubic patch by Fermat's principle. Common subset of GLSL and C++ with GLM (render/bezier/bezier_shared.h
// compiles it in float and in double). Parameters run over [-1, 1]^2, x = 2 u - 1: centred powers keep the precision of floats, and the
// coefficients are relative to an origin on the patch, so that precision does not depend on the size of the scene.
// Source: Mueller et al. 2007, "Towards predictive virtual prototyping", Sec. 11.1 (path length, Newton, line search).
// Differs: mirror step first, modified Hessian, linear extension beyond the domain, certificate of uniqueness.
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif
#ifdef GL_core_profile
#define Real float
#endif

// S(x, y) = sum of c[4 j + i] x^i y^j, metres.
struct BezierSurface {
  vec3 c[16];
};

// A cubic power basis with its derivatives. Beyond [-1, 1] every power continues along its tangent: the surface is then C1 everywhere,
// has no additional inflexion, and cannot fold back outside its domain (Fig. 11.4 c of the source).
struct CubicBasis {
  vec4 value, first, second;
};

MAQUETTE_FN CubicBasis cubic_basis(Real x) {
  Real c = clamp(x, Real(-1.0f), Real(1.0f)), d = x - c, c2 = c * c;
  Real inside = d == Real(0.0f) ? Real(1.0f) : Real(0.0f);
  CubicBasis b;
  b.value = vec4(Real(1.0f), x, c2 + Real(2.0f) * c * d, c2 * (c + Real(3.0f) * d));
  b.first = vec4(Real(0.0f), Real(1.0f), Real(2.0f) * c, Real(3.0f) * c2);
  b.second = vec4(Real(0.0f), Real(0.0f), Real(2.0f) * inside, Real(6.0f) * c * inside);
  return b;
}

// Position with its first and second derivatives.
struct SurfaceJet {
  vec3 p, dx, dy, dxx, dxy, dyy;
};

MAQUETTE_FN vec3 bezier_row(BezierSurface s, int j, vec4 b) {
  return s.c[4 * j] * b[0] + s.c[4 * j + 1] * b[1] + s.c[4 * j + 2] * b[2] + s.c[4 * j + 3] * b[3];
}

MAQUETTE_FN vec3 bezier_position(BezierSurface s, vec2 x) {
  CubicBasis bx = cubic_basis(x[0]), by = cubic_basis(x[1]);
  return bezier_row(s, 0, bx.value) + bezier_row(s, 1, bx.value) * by.value[1] + bezier_row(s, 2, bx.value) * by.value[2] +
         bezier_row(s, 3, bx.value) * by.value[3];
}

MAQUETTE_FN SurfaceJet bezier_jet(BezierSurface s, vec2 x) {
  CubicBasis bx = cubic_basis(x[0]), by = cubic_basis(x[1]);
  SurfaceJet jet;
  jet.p = jet.dx = jet.dy = jet.dxx = jet.dxy = jet.dyy = vec3(Real(0.0f));
  for (int j = 0; j < 4; ++j) {
    vec3 row = bezier_row(s, j, bx.value);
    vec3 slope = s.c[4 * j + 1] + s.c[4 * j + 2] * bx.first[2] + s.c[4 * j + 3] * bx.first[3];
    vec3 bend = s.c[4 * j + 2] * bx.second[2] + s.c[4 * j + 3] * bx.second[3];
    jet.p += row * by.value[j];
    jet.dx += slope * by.value[j];
    jet.dy += row * by.first[j];
    jet.dxx += bend * by.value[j];
    jet.dxy += slope * by.first[j];
    jet.dyy += row * by.second[j];
  }
  return jet;
}

MAQUETTE_FN Real path_length(vec3 surface_point, vec3 eye, vec3 p) { return length(surface_point - eye) + length(surface_point - p); }

// Newton stops when the law of reflection holds to about this angle (rad).
const Real kLawGoal = Real(1.0e-5f);
const Real kLawLimit = Real(5.0e-5f);  // with a larger error it is no reflection point
const Real kRounding = Real(2.0e-7f);

// Terms of Newton's method at one point: the path length, its gradient, and its Hessian in two parts. `spread` comes from the two
// distances and is positive semidefinite; `bend` comes from the surface's curvature and is negative on the concave side.
struct PathTerms {
  Real length_m;
  Real eye_distance, object_distance;
  vec2 gradient;
  vec3 spread, bend;  // xx, xy, yy
  // Errors of the law of reflection: difference of the cosines to the normal, and the component of the object's direction out of the plane of
  // incidence. Both are 0 at a reflection point; on a straight line through the surface the first is not.
  Real cosines, across;
  Real along;  // tangential part of both unit directions' sum in the plane of incidence: 0 where the path is stationary
  Real sum;    // length of that sum: twice the cosine of incidence at a reflection point, 0 on a straight line
  Real noise;  // rounding error of the directions, rad; largest for near points
};

MAQUETTE_FN Real not_zero(Real x) { return max(x, Real(1.0e-18f)); }

// Difference of the path lengths via `to` and via `from`, without subtracting two long lengths, which would lose it to rounding.
MAQUETTE_FN Real path_change(vec3 from, vec3 to, vec3 eye, vec3 p) {
  vec3 a = from - eye, b = from - p, c = to - eye, d = to - p;
  return dot(to - from, (a + c) / not_zero(length(a) + length(c)) + (b + d) / not_zero(length(b) + length(d)));
}

MAQUETTE_FN PathTerms path_terms(SurfaceJet jet, vec3 eye, vec3 p) {
  vec3 a = jet.p - eye, b = jet.p - p;
  Real la = length(a), lb = length(b), ia = Real(1.0f) / not_zero(la), ib = Real(1.0f) / not_zero(lb);
  vec3 ua = a * ia, ub = b * ib, sum = ua + ub;
  vec3 n = cross(jet.dx, jet.dy);
  n = n / not_zero(length(n));
  Real ca = dot(n, ua), cb = dot(n, ub);
  vec3 tangent = ua - n * ca;
  Real sa = length(tangent);
  tangent = tangent / not_zero(sa);
  vec3 side = cross(n, tangent);
  Real b_along = dot(ub, tangent);
  PathTerms t;
  t.cosines = cb - ca;
  t.across = dot(ub, side);
  // sa + b_along cancels at grazing incidence; the equivalent expression with the cosines does not.
  t.along = sa + b_along;
  if (sa - b_along > Real(1.0f)) t.along = (t.cosines * (cb + ca) + t.across * t.across) / (sa - b_along);
  vec2 ta = vec2(dot(jet.dx, ua), dot(jet.dy, ua)), tb = vec2(dot(jet.dx, ub), dot(jet.dy, ub));
  vec3 metric = vec3(dot(jet.dx, jet.dx), dot(jet.dx, jet.dy), dot(jet.dy, jet.dy));
  t.length_m = la + lb;
  t.eye_distance = la;
  t.object_distance = lb;
  t.gradient = vec2(dot(jet.dx, tangent) * t.along + dot(jet.dx, side) * t.across,
                    dot(jet.dy, tangent) * t.along + dot(jet.dy, side) * t.across);
  t.spread = (metric - vec3(ta[0] * ta[0], ta[0] * ta[1], ta[1] * ta[1])) * ia +
             (metric - vec3(tb[0] * tb[0], tb[0] * tb[1], tb[1] * tb[1])) * ib;
  t.bend = vec3(dot(jet.dxx, sum), dot(jet.dxy, sum), dot(jet.dyy, sum));
  t.sum = length(sum);
  t.noise = kRounding * (Real(1.0f) + length(jet.p) * max(ia, ib));
  return t;
}

// Error of the law of reflection, rad.
MAQUETTE_FN Real law_error(PathTerms t) { return max(abs(t.along) / not_zero(Real(0.5f) * t.sum), abs(t.across)); }

MAQUETTE_FN bool law_holds(PathTerms t) {
  Real goal = max(kLawGoal, t.noise);
  return abs(t.along) < max(goal * Real(0.5f) * t.sum, t.sum < Real(1.0e-4f) ? t.noise : Real(0.0f)) && abs(t.across) < goal;
}

// -H^-1 g for a symmetric H = (xx, xy, yy); a small part of the trace is added to the diagonal where H is nearly singular.
MAQUETTE_FN vec2 solve_step(vec3 h, vec2 g) {
  Real trace = h[0] + h[2];
  Real det = h[0] * h[2] - h[1] * h[1];
  Real ridge = det > Real(1.0e-6f) * trace * trace ? Real(0.0f) : Real(1.0e-3f) * trace;
  Real xx = h[0] + ridge, yy = h[2] + ridge;
  Real inverse = Real(1.0f) / not_zero(xx * yy - h[1] * h[1]);
  return vec2(h[1] * g[1] - yy * g[0], h[1] * g[0] - xx * g[1]) * inverse;
}

MAQUETTE_FN bool positive_definite(vec3 h) { return h[0] > Real(0.0f) && h[0] * h[2] - h[1] * h[1] > Real(1.0e-5f) * h[0] * h[2]; }

// Step to the reflection point in the tangent plane. Exact on a plane, even near the eye or the object and at grazing angles, whereas
// the quadratic model of the path length is accurate only over distances shorter than those to eye and object.
MAQUETTE_FN vec2 mirror_step(SurfaceJet jet, vec3 eye, vec3 p) {
  vec3 n = cross(jet.dx, jet.dy);
  Real ha = abs(dot(eye - jet.p, n)), hb = abs(dot(p - jet.p, n));
  vec3 d = (eye - jet.p) + (p - eye) * (ha / not_zero(ha + hb));
  vec3 metric = vec3(dot(jet.dx, jet.dx), dot(jet.dx, jet.dy), dot(jet.dy, jet.dy));
  return solve_step(metric, vec2(-dot(jet.dx, d), -dot(jet.dy, d)));
}

MAQUETTE_FN vec2 limited(vec2 step, Real limit) {
  Real size = max(abs(step[0]), abs(step[1]));
  return size > limit ? step * (limit / size) : step;
}

// The next step, before the line search. At the border |x| = limit a coordinate whose descent direction points outwards is fixed; if only the
// step points outwards, each coordinate descends separately.
MAQUETTE_FN vec2 next_step(SurfaceJet jet, PathTerms t, vec3 eye, vec3 p, vec2 x, Real limit) {
  vec3 h = t.spread + t.bend;
  if (!positive_definite(h)) h = positive_definite(t.spread - t.bend) ? t.spread - t.bend : t.spread;
  vec2 step = mirror_step(jet, eye, p);
  if (length(jet.dx * step[0] + jet.dy * step[1]) < Real(0.5f) * min(t.eye_distance, t.object_distance))
    step = solve_step(h, t.gradient);
  bool border_x = abs(x[0]) >= limit, border_y = abs(x[1]) >= limit;
  bool held_x = border_x && t.gradient[0] * x[0] < Real(0.0f), held_y = border_y && t.gradient[1] * x[1] < Real(0.0f);
  bool leads_out = (border_x && step[0] * x[0] > Real(0.0f)) || (border_y && step[1] * x[1] > Real(0.0f));
  if (held_x || held_y || leads_out) {
    step[0] = held_x ? Real(0.0f) : -t.gradient[0] / not_zero(abs(h[0]));
    step[1] = held_y ? Real(0.0f) : -t.gradient[1] / not_zero(abs(h[2]));
  }
  return limited(step, Real(1.0f));
}

// End point of the step, within +-limit. The paper's line search, for long steps only: halve while the half step gives a
// shorter path. Differs: halve also while the path is longer than before the step.
MAQUETTE_FN vec2 search_line(BezierSurface s, vec3 at, vec3 eye, vec3 p, vec2 x, vec2 step, Real limit) {
  vec2 to = clamp(x + step, vec2(-limit), vec2(limit));
  if (max(abs(step[0]), abs(step[1])) < Real(0.02f)) return to;
  Real full = path_change(at, bezier_position(s, to), eye, p);
  for (int k = 0; k < 10; ++k) {
    step = step * Real(0.5f);
    vec2 shorter = clamp(x + step, vec2(-limit), vec2(limit));
    Real half_way = path_change(at, bezier_position(s, shorter), eye, p);
    if (full <= half_way && full <= Real(0.0f)) break;
    to = shorter;
    full = half_way;
  }
  return to;
}

const int kReflectionInside = 0;   // a reflection point of the patch
const int kReflectionOutside = 1;  // of its extension
const int kReflectionBehind = 2;   // eye and object on two sides of the tangent plane: a straight line, no reflection
const int kReflectionLost = 3;     // not converged, or no minimum of the path: a saddle of the concave side

struct ReflectionPoint {
  vec2 x;
  vec3 position;
  vec3 normal;    // unit, towards the eye
  Real length_m;    // of the path, m
  Real height;    // of the object above the tangent plane, m; negative behind
  Real residual;  // of the reflection law, rad
  int steps;      // of Newton's method, the mirror steps among them
  int status;
  bool converged;
};

const Real kParameterLimit = Real(4.0f);
const Real kStill = Real(1.0e-5f);  // a step at the border shorter than this ends the search
const Real kDomain = Real(1.02f);  // limit of the first steps: the extension is only for objects without a reflection on the patch

MAQUETTE_FN ReflectionPoint describe(SurfaceJet jet, PathTerms t, vec3 eye, vec3 p, vec2 x) {
  ReflectionPoint r;
  vec3 n = cross(jet.dx, jet.dy);
  n = n / not_zero(length(n));
  n = dot(eye - jet.p, n) < Real(0.0f) ? -n : n;
  r.x = x;
  r.position = jet.p;
  r.normal = n;
  r.length_m = t.length_m;
  r.height = dot(p - jet.p, n);
  r.residual = law_error(t);
  r.steps = 0;
  r.converged = law_holds(t);
  bool inside = max(abs(x[0]), abs(x[1])) <= Real(1.0f);
  r.status = inside ? kReflectionInside : kReflectionOutside;
  if (r.height <= Real(0.0f)) r.status = kReflectionBehind;
  else if (inside && (r.residual > max(kLawLimit, Real(4.0f) * t.noise) || !positive_definite(t.spread + t.bend))) r.status = kReflectionLost;
  return r;
}

// Shortest path eye - patch - p from `start`, with parameters within +-limit. On a convex patch such a point, with both ends
// in front of its tangent plane, is unique: the ellipsoid of equal path lengths touches the patch from outside, and the tangent
// plane separates them. For other patches see BezierStart::certified.
MAQUETTE_FN ReflectionPoint reflect_from(BezierSurface s, vec3 eye, vec3 p, vec2 start, Real limit, int max_steps) {
  vec2 x = start;
  SurfaceJet jet = bezier_jet(s, x);
  PathTerms t = path_terms(jet, eye, p);
  int steps = 0;
  for (; steps < max_steps; ++steps) {
    bool border = max(abs(x[0]), abs(x[1])) >= limit;
    if (law_holds(t) && !(border && steps == 0)) break;  // at the border one step shows on which side the solution is
    vec2 step = next_step(jet, t, eye, p, x, limit);
    if (border && max(abs(step[0]), abs(step[1])) < kStill) break;  // the border's own minimum
    Real bound = steps < 2 ? min(limit, kDomain) : limit;
    x = clamp(search_line(s, jet.p, eye, p, x, step, limit), vec2(-bound), vec2(bound));
    jet = bezier_jet(s, x);
    t = path_terms(jet, eye, p);
  }
  ReflectionPoint r = describe(jet, t, eye, p, x);
  r.steps = steps;
  return r;
}

// Derivatives of a reflection point's parameters by the object's position, 1/m. The path length stays stationary: H dx + d(gradient) = 0.
struct ReflectionDerivative {
  vec3 x, y;
};

MAQUETTE_FN ReflectionDerivative reflection_derivative(BezierSurface s, vec3 eye, vec3 p, vec2 x) {
  SurfaceJet jet = bezier_jet(s, x);
  PathTerms t = path_terms(jet, eye, p);
  vec3 h = t.spread + t.bend, ub = (jet.p - p) / not_zero(t.object_distance);
  vec3 mx = (jet.dx - ub * dot(jet.dx, ub)) / not_zero(t.object_distance), my = (jet.dy - ub * dot(jet.dy, ub)) / not_zero(t.object_distance);
  Real determinant = h[0] * h[2] - h[1] * h[1];
  Real inverse = abs(determinant) > Real(1.0e-18f) ? Real(1.0f) / determinant : Real(0.0f);
  ReflectionDerivative d;
  d.x = (mx * h[2] - my * h[1]) * inverse;
  d.y = (my * h[0] - mx * h[1]) * inverse;
  return d;
}

// One of the starting points spread over the patch, with quantities that depend only on patch and eye.
struct BezierNode {
  vec2 x;
  vec3 position;
  vec3 normal;             // unit, towards the eye
  Real height;             // of the eye above the tangent plane, m
  Real side;               // 1 where the eye is on the side of dS/dx x dS/dy, else -1
  vec3 dual_x, dual_y;     // parameters of a tangential displacement: dot products with it
  vec3 direction;          // unit: the eye's ray after reflection
  Real inverse_focus;      // 1/m; the reflected ray meets a caustic at its reciprocal, 0: never
};

// Largest 1/b, at least 0, for which the Hessian of the path to position + b direction is singular: a generalised eigenvalue of
// the part independent of b and the part divided by b.
MAQUETTE_FN Real inverse_focal_distance(SurfaceJet jet, vec3 eye, vec3 direction) {
  vec3 a = jet.p - eye;
  Real ia = Real(1.0f) / not_zero(length(a));
  vec3 ua = a * ia, sum = ua - direction;
  vec3 metric = vec3(dot(jet.dx, jet.dx), dot(jet.dx, jet.dy), dot(jet.dy, jet.dy));
  vec2 ta = vec2(dot(jet.dx, ua), dot(jet.dy, ua)), tb = vec2(dot(jet.dx, direction), dot(jet.dy, direction));
  vec3 m = metric - vec3(tb[0] * tb[0], tb[0] * tb[1], tb[1] * tb[1]);
  vec3 h = (metric - vec3(ta[0] * ta[0], ta[0] * ta[1], ta[1] * ta[1])) * ia +
           vec3(dot(jet.dxx, sum), dot(jet.dxy, sum), dot(jet.dyy, sum));
  // det(h + z m) = qa z^2 + 2 qb z + qc; its larger root, by the formula that does not cancel.
  Real qa = not_zero(m[0] * m[2] - m[1] * m[1]);
  Real qb = Real(0.5f) * (h[0] * m[2] + h[2] * m[0]) - h[1] * m[1];
  Real qc = h[0] * h[2] - h[1] * h[1];
  Real root = sqrt(max(qb * qb - qa * qc, Real(0.0f)));
  Real z = qb > Real(0.0f) ? -qc / not_zero(qb + root) : (root - qb) / qa;
  return max(z, Real(0.0f));
}

MAQUETTE_FN BezierNode bezier_node(BezierSurface s, vec3 eye, vec2 x) {
  SurfaceJet jet = bezier_jet(s, x);
  vec3 a = jet.p - eye;
  vec3 ua = a / not_zero(length(a));
  vec3 n = cross(jet.dx, jet.dy);
  Real area = not_zero(length(n));
  n = n / area;
  BezierNode node;
  node.x = x;
  node.position = jet.p;
  node.dual_x = cross(jet.dy, n) / area;
  node.dual_y = cross(n, jet.dx) / area;
  node.direction = ua - n * (Real(2.0f) * dot(n, ua));
  node.normal = dot(a, n) > Real(0.0f) ? -n : n;
  node.height = abs(dot(a, n));
  node.side = dot(a, n) > Real(0.0f) ? Real(-1.0f) : Real(1.0f);
  node.inverse_focus = inverse_focal_distance(jet, eye, node.direction);
  return node;
}

// Best start among the nodes considered so far, and whether the object is nearer than the caustics of all nodes: then the
// reflected rays do not cross before the object, and at most one of them hits it.
struct BezierStart {
  vec2 x;
  Real distance2;  // squared displacement that the plane mirror of the node predicts, m^2
  vec2 shortest;   // node of the shortest path
  Real length_m;
  Real side;       // of the patch that reflects: nodes that show their other side to the eye come last
  bool certified;
};

// Whether a point at this distance lies before the caustic of the node's rays, with a margin of a tenth.
MAQUETTE_FN bool is_before_focus(BezierNode node, Real distance) { return distance * node.inverse_focus < Real(0.9f); }

MAQUETTE_FN BezierStart no_start(Real side) {
  BezierStart s;
  s.side = side;
  s.x = s.shortest = vec2(Real(0.0f));
  s.distance2 = s.length_m = Real(1.0e30f);
  s.certified = true;
  return s;
}

// Updates the best start with a node. Mirrored in the node's tangent plane, the object gives an estimate of the distance to the reflection
// point. This is a better criterion than path length or reflected direction, especially near the eye and near the object.
MAQUETTE_FN BezierStart consider_node(BezierStart best, BezierNode node, vec3 eye, vec3 p) {
  vec3 a = eye - node.position, b = p - node.position;
  Real hb = abs(dot(b, node.normal)), lb = length(b);
  vec3 d = a + (b - a) * (node.height / not_zero(node.height + hb));
  Real normal_part = dot(d, node.normal);
  bool seen = node.side * best.side > Real(0.0f);
  Real distance2 = dot(d, d) - normal_part * normal_part + (seen ? Real(0.0f) : Real(1.0e6f));
  if (distance2 < best.distance2) {
    best.distance2 = distance2;
    best.x = clamp(node.x + limited(vec2(dot(d, node.dual_x), dot(d, node.dual_y)), Real(0.75f)), vec2(-kDomain), vec2(kDomain));
  }
  Real path = length(a) + lb + (seen ? Real(0.0f) : Real(1.0e6f));
  if (path < best.length_m) {
    best.length_m = path;
    best.shortest = node.x;
  }
  best.certified = best.certified && is_before_focus(node, lb);
  return best;
}

const int kNewtonSteps = 16;
const int kSearchSteps = 40;
const int kAttempts = 7;

// The reflection point from the best start. `careful`: if the first attempt finds none on the patch, others start from other
// points and stay in the domain. Needed only where the eye sees both sides of the patch, or sees it nearly edge-on.
MAQUETTE_FN ReflectionPoint reflection_point(BezierSurface s, vec3 eye, vec3 p, BezierStart start, bool careful) {
  ReflectionPoint r;
  r.x = start.x;
  for (int k = 0; k <= kAttempts; ++k) {
    bool first = k == 0;
    vec2 from = first || k == 2 ? start.x : (k == 1 ? start.shortest : r.x);
    if (k > 3) from = vec2(k == 5 || k == 7 ? Real(0.6f) : Real(-0.6f), k > 5 ? Real(0.6f) : Real(-0.6f));
    Real limit = first ? kParameterLimit : Real(1.0f);
    vec2 bound = first ? vec2(limit) : vec2(Real(1.0f));
    ReflectionPoint again = reflect_from(s, eye, p, clamp(from, -bound, bound), limit, first ? kNewtonSteps : kSearchSteps);
    bool interior = max(abs(again.x[0]), abs(again.x[1])) < Real(1.0f);
    if (first || (again.status == kReflectionInside && interior)) r = again;
    // The extension may have its own minimum besides one inside the border: search again from there within the domain.
    if (first && max(abs(r.x[0]), abs(r.x[1])) > Real(1.0f)) {
      ReflectionPoint within = reflect_from(s, eye, p, clamp(r.x, vec2(Real(-1.0f)), vec2(Real(1.0f))), Real(1.0f), kNewtonSteps);
      if (within.status == kReflectionInside && within.converged && max(abs(within.x[0]), abs(within.x[1])) < Real(1.0f)) {
        within.steps += r.steps;
        r = within;
      }
    }
    if (r.converged && (!careful || r.status == kReflectionInside)) break;
  }
  return r;
}
