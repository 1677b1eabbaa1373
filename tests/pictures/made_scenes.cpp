#include "tests/pictures/made_scenes.h"

#include <cmath>
#include <string>
#include <utility>

namespace maquette::pictures {

namespace {

Material plain(const std::string& name, const glm::vec3& color, float roughness = 0.9f) {
  Material m;
  m.name = name;
  m.base_color = glm::vec4(color, 1.0f);
  m.metallic = 0.0f;
  m.roughness = roughness;
  m.double_sided = true;
  return m;
}

/// `side` x `side` quads from `corner`; normal along cross(u, v).
Primitive make_grid(const glm::vec3& corner, const glm::vec3& u, const glm::vec3& v, int side, int material) {
  Primitive p;
  p.material = material;
  for (int j = 0; j <= side; ++j)
    for (int i = 0; i <= side; ++i) {
      const glm::vec2 uv(static_cast<float>(i) / static_cast<float>(side),
                         static_cast<float>(j) / static_cast<float>(side));
      p.positions.push_back(corner + u * uv.x + v * uv.y);
      p.normals.push_back(glm::normalize(glm::cross(u, v)));
      p.uvs[0].push_back(uv);
    }
  const auto at = [side](int i, int j) { return static_cast<std::uint32_t>(j * (side + 1) + i); };
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i)
      p.indices.insert(p.indices.end(),
                       {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)});
  return p;
}

Primitive make_ball(const glm::vec3& center, float radius, int material) {
  Primitive p = make_grid({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 32, material);
  for (std::size_t i = 0; i < p.positions.size(); ++i) {
    const float phi = 6.2831853f * p.positions[i].x, theta = 3.1415927f * p.positions[i].y;
    p.normals[i] = {std::sin(theta) * std::sin(phi), -std::cos(theta), std::sin(theta) * std::cos(phi)};
    p.positions[i] = center + radius * p.normals[i];
  }
  return p;
}

Node* add_node(Scene* scene, const std::string& name) {
  scene->roots.push_back(static_cast<int>(scene->nodes.size()));
  scene->nodes.emplace_back();
  scene->nodes.back().name = name;
  return &scene->nodes.back();
}

Node* add(Scene* scene, Primitive primitive, const std::string& name) {
  Node* node = add_node(scene, name);
  node->mesh = static_cast<int>(scene->meshes.size());
  scene->meshes.emplace_back();
  scene->meshes.back().primitives.push_back(std::move(primitive));
  return node;
}

void add_box(Scene* scene, const glm::vec3& low, const glm::vec3& high, int material) {
  const glm::vec3 d = high - low, x(d.x, 0, 0), y(0, d.y, 0), z(0, 0, d.z);
  for (const Primitive& side : {make_grid(low, y, x, 2, material), make_grid(low, z, y, 2, material),
                                make_grid(low, x, z, 2, material), make_grid(high, -x, -y, 2, material),
                                make_grid(high, -y, -z, 2, material), make_grid(high, -z, -x, 2, material)})
    add(scene, side, "box");
}

/// 2 m wide and 1.2 m high around (0, 0, `z`), at its sides `bend` metres towards the eye.
void add_patch(Scene* scene, float z, float bend, int material) {
  BezierPatch patch;
  patch.name = "mirror";
  patch.material = material;
  // Control points of the polynomial: a quadratic's are its blossom, raised in degree.
  const auto square = [](int k) { return k == 0 || k == 3 ? 1.0f : -1.0f / 3.0f; };
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      patch.points[static_cast<std::size_t>(4 * j + i)] = {-1.0f + 2.0f * static_cast<float>(i) / 3.0f,
                                                           0.6f * (-1.0f + 2.0f * static_cast<float>(j) / 3.0f),
                                                           z + bend * (square(i) + 0.18f * square(j))};
  add_node(scene, "mirror")->patch = static_cast<int>(scene->patches.size());
  scene->patches.push_back(patch);
}

void add_mesh_mirror(Scene* scene, float bend) {
  Primitive p = make_grid({-1.0f, -0.6f, -1.0f}, {2, 0, 0}, {0, 1.2f, 0}, 24, 3);
  for (std::size_t i = 0; i < p.positions.size(); ++i) {
    glm::vec3& at = p.positions[i];
    at.z += bend * (at.x * at.x + 0.5f * at.y * at.y);
    p.normals[i] = glm::normalize(glm::vec3(-2.0f * bend * at.x, -bend * at.y, 1.0f));
  }
  add(scene, p, "mirror")->reflector = true;
}

/// Materials `grey`, `red`, `blue`, and 3 as given.
Scene room(const Material& third) {
  Scene scene;
  scene.materials = {plain("grey", glm::vec3(0.5f)), plain("red", {0.8f, 0.1f, 0.05f}),
                     plain("blue", {0.1f, 0.2f, 0.7f}), third};
  add(&scene, make_grid({-3.0f, -0.5f, 3.0f}, {3, 0, 0}, {0, 0, -3.9f}, 4, 0), "floor");
  add(&scene, make_grid({0.0f, -0.5f, 3.0f}, {3, 0, 0}, {0, 0, -3.9f}, 4, 2), "floor");
  add_box(&scene, {0.2f, -0.5f, -0.3f}, {0.6f, 0.1f, 0.1f}, 1);
  add_box(&scene, {-0.7f, -0.5f, 0.4f}, {-0.3f, 0.4f, 0.7f}, 2);
  return scene;
}

Scene box_of_three() {
  Scene scene;
  scene.materials = {plain("floor", {0.6f, 0.5f, 0.4f}), plain("back", {0.2f, 0.3f, 0.7f}),
                     plain("sides", {0.5f, 0.6f, 0.5f}), plain("ball", {0.8f, 0.7f, 0.2f}, 0.3f)};
  add(&scene, make_grid({-1, -1, 1}, {2, 0, 0}, {0, 0, -2}, 20, 0), "floor");
  add(&scene, make_grid({-1, -1, -1}, {2, 0, 0}, {0, 2, 0}, 20, 1), "back");
  add(&scene, make_grid({-1, -1, 1}, {0, 0, -2}, {0, 2, 0}, 20, 2), "left");
  add(&scene, make_grid({1, -1, -1}, {0, 0, 2}, {0, 2, 0}, 20, 2), "right");
  add(&scene, make_ball({0.25f, -0.6f, 0.0f}, 0.4f, 3), "ball");
  return scene;
}

/// Squares of two texels; alpha 0 in the dark ones when `holes`.
TextureImage checks(const std::string& name, bool holes) {
  TextureImage image{name, 16, 16, {}};
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) {
      const bool light = (x / 2 + y / 2) % 2 == 0;
      const std::uint8_t v = light ? 250 : 25, alpha = light || !holes ? 255 : 0;
      image.rgba.insert(image.rgba.end(), {v, 120, static_cast<std::uint8_t>(275 - v), alpha});
    }
  return image;
}

/// Normals that lean a little, as waves.
TextureImage waves() {
  TextureImage image{"waves", 32, 32, {}};
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      const auto lean = [](int k) { return static_cast<std::uint8_t>(128.0 + 30.0 * std::sin(0.19635 * 2.0 * k)); };
      image.rgba.insert(image.rgba.end(), {lean(x), lean(y), 250, 255});
    }
  return image;
}

}  // namespace

std::shared_ptr<const Scene> mirror_room(MirrorShape shape) {
  Material metal = plain("mirror", glm::vec3(0.9f), 0.02f);
  metal.metallic = 1.0f;
  Scene scene = room(metal);
  if (shape == MirrorShape::curved_mesh)
    add_mesh_mirror(&scene, 0.15f);
  else
    add_patch(&scene, -1.0f, shape == MirrorShape::curved_patch ? 0.15f : 0.0f, 3);
  return std::make_shared<const Scene>(std::move(scene));
}

std::shared_ptr<const Scene> pane_room() {
  Material pane = plain("pane", {0.95f, 0.97f, 0.96f}, 0.0f);
  pane.transmission = 1.0f;
  pane.ior = 1.52f;
  pane.glass = true;
  Scene scene = room(pane);
  add_patch(&scene, -0.6f, 0.1f, 3);
  return std::make_shared<const Scene>(std::move(scene));
}

std::shared_ptr<const Scene> painted_box() { return std::make_shared<const Scene>(box_of_three()); }

std::shared_ptr<const Scene> textured_box() {
  Scene scene = box_of_three();
  scene.images = {checks("checks", false), checks("holes", true), waves()};
  scene.materials[1].base_color_texture.image = 0;
  scene.materials[1].base_color_texture.scale = {2.0f, 2.0f};
  scene.materials[2].normal_texture.image = 2;
  scene.materials[2].roughness = 0.35f;
  Material grid = plain("grid", {1.0f, 1.0f, 1.0f});
  grid.alpha_mode = AlphaMode::mask;
  grid.base_color_texture.image = 1;
  Material film = plain("film", {0.9f, 0.3f, 0.1f}, 0.2f);
  film.base_color.a = 0.4f;
  film.alpha_mode = AlphaMode::blend;
  scene.materials.push_back(grid);
  scene.materials.push_back(film);
  add(&scene, make_grid({-0.9f, -0.95f, 0.2f}, {0.9f, 0, 0}, {0, 0.9f, 0}, 2, 4), "grid");
  add(&scene, make_grid({0.0f, -0.5f, 0.7f}, {0.8f, 0, 0}, {0, 0.9f, 0}, 2, 5), "film");
  PunctualLight lamp;
  lamp.intensity = 4000.0f;
  lamp.color = {1.0f, 0.8f, 0.6f};
  scene.lights.push_back(lamp);
  Node* node = add_node(&scene, "lamp");
  node->light = 0;
  node->local[3] = glm::vec4(-0.3f, 0.7f, 0.3f, 1.0f);
  return std::make_shared<const Scene>(std::move(scene));
}

}  // namespace maquette::pictures
