#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/matrix_inverse.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>
#include <utility>

#include "scenes/angles.h"
#include "scenes/modelling.h"

namespace maquette::modelling {

void append(Primitive* into, const Primitive& other) {
  const auto base = static_cast<std::uint32_t>(into->positions.size());
  into->positions.insert(into->positions.end(), other.positions.begin(), other.positions.end());
  into->normals.insert(into->normals.end(), other.normals.begin(), other.normals.end());
  into->uvs[0].insert(into->uvs[0].end(), other.uvs[0].begin(), other.uvs[0].end());
  for (const std::uint32_t i : other.indices) into->indices.push_back(base + i);
}

Primitive merged(const std::vector<Primitive>& parts) {
  Primitive all;
  for (const Primitive& part : parts) append(&all, part);
  return all;
}

Primitive transformed(const Primitive& primitive, const glm::dmat4& matrix) {
  Primitive p = primitive;
  const glm::dmat3 normal_matrix = glm::inverseTranspose(glm::dmat3(matrix));
  for (glm::vec3& position : p.positions) position = glm::vec3(matrix * glm::dvec4(glm::dvec3(position), 1.0));
  for (glm::vec3& normal : p.normals) normal = glm::vec3(glm::normalize(normal_matrix * glm::dvec3(normal)));
  if (glm::determinant(glm::dmat3(matrix)) < 0.0)
    for (std::size_t i = 0; i + 2 < p.indices.size(); i += 3) std::swap(p.indices[i + 1], p.indices[i + 2]);
  return p;
}

Primitive flipped(const Primitive& primitive) {
  Primitive p = primitive;
  for (glm::vec3& normal : p.normals) normal = -normal;
  for (std::size_t i = 0; i + 2 < p.indices.size(); i += 3) std::swap(p.indices[i + 1], p.indices[i + 2]);
  return p;
}

Primitive mirrored_x(const Primitive& primitive) {
  Primitive p = primitive;
  for (glm::vec3& position : p.positions) position.x = -position.x;
  for (glm::vec3& normal : p.normals) normal.x = -normal.x;
  for (std::size_t i = 0; i + 2 < p.indices.size(); i += 3) std::swap(p.indices[i + 1], p.indices[i + 2]);
  return p;
}

void map_box_uvs(Primitive* primitive, double scale) {
  primitive->uvs[0].resize(primitive->positions.size());
  for (std::size_t i = 0; i < primitive->positions.size(); ++i) {
    const glm::vec3 p = primitive->positions[i] * static_cast<float>(scale), n = glm::abs(primitive->normals[i]);
    primitive->uvs[0][i] = n.y >= n.x && n.y >= n.z ? glm::vec2(p.x, p.z)
                           : n.x >= n.z             ? glm::vec2(p.z, -p.y)
                                                    : glm::vec2(p.x, -p.y);
  }
}

glm::dmat4 translation(double x, double y, double z) { return glm::translate(glm::dmat4(1.0), Vec3(x, y, z)); }

glm::dmat4 rotation(double degrees, const Vec3& axis) { return glm::rotate(glm::dmat4(1.0), radians(degrees), axis); }

glm::dmat4 look_at_frame(const Vec3& origin, const Vec3& target, const Vec3& up) {
  const Vec3 back = glm::normalize(origin - target), right = glm::normalize(glm::cross(up, back));
  return {glm::dvec4(right, 0.0), glm::dvec4(glm::cross(back, right), 0.0), glm::dvec4(back, 0.0),
          glm::dvec4(origin, 1.0)};
}

int SceneBuilder::add_node(Node node) {
  const int index = static_cast<int>(scene_.nodes.size());
  scene_.nodes.push_back(std::move(node));
  scene_.roots.push_back(index);
  return index;
}

int SceneBuilder::add_material(const Material& material) {
  scene_.materials.push_back(material);
  return static_cast<int>(scene_.materials.size()) - 1;
}

int SceneBuilder::material(const std::string& name) const {
  const auto found =
      std::find_if(scene_.materials.begin(), scene_.materials.end(), [&](const Material& m) { return m.name == name; });
  return found == scene_.materials.end() ? -1 : static_cast<int>(found - scene_.materials.begin());
}

int SceneBuilder::add_image(const TextureImage& image) {
  scene_.images.push_back(image);
  return static_cast<int>(scene_.images.size()) - 1;
}

int SceneBuilder::add_part(const std::string& name, Primitive primitive, int material, const glm::dmat4& pose) {
  Mesh mesh;
  mesh.name = name;
  primitive.material = material;
  mesh.primitives.push_back(std::move(primitive));
  scene_.meshes.push_back(std::move(mesh));
  Node node;
  node.name = name;
  node.mesh = static_cast<int>(scene_.meshes.size()) - 1;
  node.local = glm::mat4(pose);
  return add_node(std::move(node));
}

int SceneBuilder::add_instance(const std::string& name, int node, const glm::dmat4& pose) {
  Node instance;
  instance.name = name;
  instance.mesh = scene_.nodes[static_cast<std::size_t>(node)].mesh;
  instance.local = glm::mat4(pose);
  return add_node(std::move(instance));
}

int SceneBuilder::add_patch(const BezierPatch& patch) {
  scene_.patches.push_back(patch);
  Node node;
  node.name = patch.name;
  node.patch = static_cast<int>(scene_.patches.size()) - 1;
  node.reflector = patch.reflector;
  return add_node(std::move(node));
}

void SceneBuilder::add_camera(const std::string& name, const Vec3& eye, const Vec3& target, double fov_y_deg) {
  Camera camera;
  camera.name = name;
  camera.fov_y_rad = static_cast<float>(radians(fov_y_deg));
  camera.aspect = 16.0f / 9.0f;
  scene_.cameras.push_back(camera);
  Node node;
  node.name = name;
  node.camera = static_cast<int>(scene_.cameras.size()) - 1;
  node.local = glm::mat4(look_at_frame(eye, target));
  add_node(std::move(node));
}

void SceneBuilder::add_empty(const std::string& name, const Vec3& position) {
  Node node;
  node.name = name;
  node.local = glm::mat4(translation(position.x, position.y, position.z));
  add_node(std::move(node));
}

Material plain_material(const std::string& name, const glm::vec3& base_color, float metallic, float roughness) {
  Material material;
  material.name = name;
  material.base_color = glm::vec4(base_color, 1.0f);
  material.metallic = metallic;
  material.roughness = roughness;
  return material;
}

Material measured_material(const std::string& name, const std::string& library_name, const glm::vec3& base_color,
                           float metallic, float roughness) {
  Material material = plain_material(name, base_color, metallic, roughness);
  material.measured = "builtin:" + library_name;
  return material;
}

namespace {

/// Unit gradient of lattice cell (x, y): one of 16 directions, by an integer hash.
Vec2 lattice_gradient(int x, int y, unsigned seed) {
  static const std::array<Vec2, 16> kDirections = [] {
    std::array<Vec2, 16> directions{};
    for (std::size_t i = 0; i < 16; ++i)
      directions[i] = {std::cos(std::numbers::pi * static_cast<double>(i) / 8.0),
                       std::sin(std::numbers::pi * static_cast<double>(i) / 8.0)};
    return directions;
  }();
  unsigned h = static_cast<unsigned>(x) * 0x9e3779b1u ^ static_cast<unsigned>(y) * 0x85ebca6bu ^ seed * 0xc2b2ae35u;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return kDirections[(h ^ (h >> 15)) & 15u];
}

}  // namespace

double tileable_noise(double x, double y, int period, unsigned seed) {
  const double fx = std::floor(x), fy = std::floor(y);
  const auto wrap = [&](double c) { return ((static_cast<int>(c) % period) + period) % period; };
  const Vec2 t(x - fx, y - fy);
  const auto corner = [&](int i, int j) {
    return glm::dot(lattice_gradient(wrap(fx + i), wrap(fy + j), seed), t - Vec2(i, j));
  };
  const double u = smoother(0.0, 1.0, t.x), v = smoother(0.0, 1.0, t.y);
  return 1.4 * mix(mix(corner(0, 0), corner(1, 0), u), mix(corner(0, 1), corner(1, 1), u), v);
}

double tileable_fbm(double x, double y, int period, int octaves, unsigned seed) {
  double sum = 0.0, amplitude = 0.5;
  for (int i = 0; i < octaves; ++i, amplitude *= 0.5, x *= 2.0, y *= 2.0, period *= 2)
    sum += amplitude * tileable_noise(x, y, period, seed + static_cast<unsigned>(i));
  return sum;
}

}  // namespace maquette::modelling
