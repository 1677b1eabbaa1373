#include "render/triangle/triangle_mirror.h"

namespace maquette {

namespace {

struct Split {
  glm::vec3 value{}, rest{};
};

Split split(const glm::dvec3& v) {
  const glm::dvec3 value = glm::dvec3(glm::vec3(v));
  return {glm::vec3(value), glm::vec3(v - value)};
}

}  // namespace

mirror::TriangleMirror make_triangle_mirror(const glm::vec3 (&vertices)[3], const glm::vec3 (&directions)[3]) {
  const glm::dvec3 t1(vertices[0]), e1 = glm::dvec3(vertices[1]) - t1, e2 = glm::dvec3(vertices[2]) - t1;
  const glm::dvec3 d1(directions[0]), f1 = glm::dvec3(directions[1]) - d1, f2 = glm::dvec3(directions[2]) - d1;
  const glm::dvec3 n0 = glm::cross(e1, e2), n1 = glm::cross(e1, f2) + glm::cross(f1, e2), n2 = glm::cross(f1, f2);
  mirror::TriangleMirror m{};
  m.t1 = vertices[0];
  m.e1 = glm::vec3(e1);
  m.e2 = glm::vec3(e2);
  m.d1 = directions[0];
  m.f1 = glm::vec3(f1);
  m.f2 = glm::vec3(f2);
  const Split a = split(n0), b = split(n1), c = split(n2);
  m.n0 = a.value;
  m.n1 = b.value;
  m.n2 = c.value;
  m.n0_rest = a.rest;
  m.n1_rest = b.rest;
  m.n2_rest = c.rest;
  const Split g = split({glm::dot(n0, d1), glm::dot(n1, d1), glm::dot(n2, d1)});
  m.g = g.value;
  m.g_rest = g.rest;
  return m;
}

}  // namespace maquette
