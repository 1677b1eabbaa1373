#include "viewer/report/content_key.h"

#include <cstdio>
#include <cstring>

#include "render/btf/btf_source.h"
#include "render/scene_state/geometry.h"
#include "scenes/files.h"

namespace maquette::report {

ContentKey& ContentKey::mix_bytes(std::span<const std::byte> bytes) {
  const std::uint64_t size = bytes.size();
  value_ = content_hash(std::as_bytes(std::span(&size, 1)), value_);
  value_ = content_hash(bytes, value_);
  return *this;
}

ContentKey& ContentKey::mix(std::string_view text) { return mix_bytes(std::as_bytes(std::span(text))); }

ContentKey& ContentKey::mix(double value) { return mix_bytes(std::as_bytes(std::span(&value, 1))); }

std::string ContentKey::text() const {
  char digits[20];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(value_));
  return digits;
}

namespace {

void mix_vector(const auto& v, int count, ContentKey* key) {
  for (int i = 0; i < count; ++i) key->mix(static_cast<double>(v[i]));
}

void mix_material(const Material& m, ContentKey* key) {
  key->mix(m.name).mix(m.measured);
  if (!m.measured.empty() && !m.measured.starts_with("builtin:"))
    key->mix(std::to_string(material_source_key(m.measured)));
  for (const float number : numbers_of(m)) key->mix(static_cast<double>(number));
}

}  // namespace

ContentKey scene_key(const Scene& scene) {
  ContentKey key;
  key.mix(MAQUETTE_VERSION);
  const FlatGeometry g = flatten(scene);
  key.mix_all(g.positions).mix_all(g.normals).mix_all(g.uv0).mix_all(g.uv1).mix_all(g.colors).mix_all(g.indices);
  for (const DrawItem& item : g.items) {
    key.mix(static_cast<double>(item.first_index)).mix(static_cast<double>(item.node));
    if (item.patch >= 0) key.mix(static_cast<double>(scene.patches[static_cast<std::size_t>(item.patch)].material));
    if (item.mesh < 0) continue;
    const Mesh& mesh = scene.meshes[static_cast<std::size_t>(item.mesh)];
    const Primitive& primitive = mesh.primitives[static_cast<std::size_t>(item.primitive)];
    key.mix(static_cast<double>(primitive.material));
    for (const auto& [variant, material] : primitive.variant_materials)
      key.mix(static_cast<double>(variant)).mix(static_cast<double>(material));
  }
  for (const Material& material : scene.materials) mix_material(material, &key);
  for (const TextureImage& image : scene.images)
    key.mix(static_cast<double>(image.width)).mix_all(image.rgba).mix_all(image.rgba16);
  for (const Animation& animation : scene.animations) {
    key.mix(animation.name).mix(animation.duration_s);
    for (const AnimatedNode& node : animation.nodes) {
      key.mix(static_cast<double>(node.node)).mix_bytes(std::as_bytes(std::span(node.rest)));
      for (const AnimationTrack& track : node.tracks)
        key.mix(static_cast<double>(track.interpolation)).mix_all(track.times_s).mix_all(track.values);
    }
  }
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    if (scene.nodes[i].light < 0) continue;
    const PunctualLight& light = scene.lights[static_cast<std::size_t>(scene.nodes[i].light)];
    mix_vector(light.color, 3, &key);
    for (const float v : {light.intensity, light.range_m, light.inner_cone_rad, light.outer_cone_rad})
      key.mix(static_cast<double>(v));
    key.mix(static_cast<double>(light.kind)).mix_bytes(std::as_bytes(std::span(&world[i], 1)));
  }
  return key;
}

void mix_request(const FrameRequest& request, ContentKey* key) {
  mix_vector(request.camera.eye, 3, key);
  mix_vector(request.camera.target, 3, key);
  mix_vector(request.camera.up, 3, key);
  for (const double v : {static_cast<double>(request.camera.fov_y_rad), static_cast<double>(request.camera.height_m),
                         static_cast<double>(request.width), static_cast<double>(request.height),
                         static_cast<double>(request.msaa), static_cast<double>(request.samples),
                         static_cast<double>(request.seed), static_cast<double>(request.env_rotation_rad),
                         static_cast<double>(request.env_scale), static_cast<double>(request.variant)})
    key->mix(v);
  key->mix(request.mode);
  if (request.reflections != kNoReflections) {
    key->mix(request.reflections);
    for (const std::string& node : request.reflectors) key->mix(node);
  }
  for (const auto& [name, value] : request.settings.changed()) key->mix(name).mix(to_text(value));
}

}  // namespace maquette::report
