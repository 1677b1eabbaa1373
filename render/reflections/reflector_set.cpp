#include "render/reflections/reflector_set.h"

#include <xxhash.h>

#include <algorithm>
#include <glm/gtc/packing.hpp>
#include <memory>

#include "render/bezier/patch_fit.h"
#include "render/bezier/reflector_patch.h"
#include "scenes/error.h"

namespace maquette {

namespace {

/// std140 twin of the block in shaders/reflections/reflectors.glsl.
struct ReflectorBlock {
  glm::ivec4 mirrors[kMaxReflectors]{};
  PatchRecord patches[kMaxPatches]{};
};

/// An item as it is in the scene, wherever it stands in the arrays.
PatchFitPart part_of(const Scene& scene, const FlatGeometry& geometry, const DrawItem& item) {
  PatchFitPart part;
  const auto copy = [&](const auto& all, auto* own) {
    const auto begin = all.begin() + item.first_vertex;
    own->assign(begin, begin + item.vertex_count);
    part.hash = XXH3_64bits_withSeed(own->data(), own->size() * sizeof(*own->data()), part.hash);
  };
  copy(geometry.positions, &part.positions);
  copy(geometry.normals, &part.normals);
  copy(geometry.uv0, &part.uvs);
  for (std::uint32_t k = 0; k < item.index_count; ++k)
    part.indices.push_back(geometry.indices[item.first_index + k] - item.first_vertex);
  part.hash = XXH3_64bits_withSeed(part.indices.data(), part.indices.size() * sizeof(std::uint32_t), part.hash);
  if (const Mesh& mesh = scene.meshes[static_cast<std::size_t>(item.mesh)]; mesh.cage && item.primitive == 0) {
    part.cage = mesh.cage;
    part.world_from_node = compute_world_transforms(scene)[static_cast<std::size_t>(item.node)];
  }
  return part;
}

std::string fit_line(const Reflector& reflector) { return "'" + reflector.name + "': " + fit_text(*reflector.fit); }

}  // namespace

void ReflectorSet::forget() {
  if (!reflectors_.empty()) ++revision_;  // mirrors are opaque surfaces again
  reflectors_.clear();
  fitting_.clear();
  key_.reset();
}

void ReflectorSet::update(const SceneState& scene, const FrameRequest& request, const Technique* technique,
                          bool fits_patches) {
  drawn_ = true;
  if (!technique) {
    patch_fits_.cancel();
    forget();
    coarse_of_.reset();
    coarse_patches_ = {};
    coarse_indices_ = Buffer();
    return;
  }
  if (!fits_patches) patch_fits_.cancel();
  if (fits_patches && patch_fits_.update()) ++fits_revision_;
  const Key now = Key::of(scene.revisions().all(), request.reflectors, fits_patches,
                          static_cast<bool>(technique->make_glossy), fits_revision_, request.variant);
  if (key_ == now) return;
  std::vector<const Material*> materials;
  for (std::size_t i = 0; i < scene.geometry().items.size(); ++i) materials.push_back(&scene.material_of_item(i));
  forget();  // what is refused below is refused in every frame
  reflectors_ =
      find_reflectors(scene.scene(), scene.geometry(), materials, request.reflectors,
                      technique->make_glossy ? glossy_items(scene, kMaxGlossyRoughness) : std::vector<bool>());
  ++revision_;
  const std::string option = "--reflections " + technique->name;
  if (fits_patches) fit_curved(scene, option);
  upload(scene, option);
  key_ = now;
}

void ReflectorSet::fit_curved(const SceneState& scene, const std::string& option) {
  const FlatGeometry& geometry = scene.geometry();
  std::vector<Reflector*> curved;
  std::vector<PatchFitPart> parts;
  std::vector<std::uint64_t> hashes;
  for (Reflector& reflector : reflectors_) {
    if (reflector.patch || reflector.plane) continue;
    curved.push_back(&reflector);
    parts.push_back(part_of(scene.scene(), geometry, geometry.items[reflector.item]));
    hashes.push_back(parts.back().hash);
  }
  patch_fits_.want(hashes, [&](std::size_t i) { return std::move(parts[i]); });
  for (std::size_t i = 0; i < curved.size(); ++i) {
    Reflector& reflector = *curved[i];
    reflector.fit = patch_fits_.find(hashes[i]);
    if (!reflector.fit) {
      fitting_ += (fitting_.empty() ? "'" : ", '") + reflector.name + "'";
    } else if (reflector.fit->patches.empty()) {
      throw Error(option, "no patch fits '" + reflector.name + "': " + reflector.fit->why,
                  "correct the mesh, or use another reflector technique");
    }
  }
  std::erase_if(reflectors_, [](const Reflector& r) { return !r.patch && !r.plane && !r.fit; });
}

void ReflectorSet::upload(const SceneState& scene, const std::string& option) {
  auto block = std::make_unique<ReflectorBlock>();
  std::vector<glm::uvec4> triangles;
  std::size_t count = 0;
  std::string names;
  for (std::size_t i = 0; i < reflectors_.size(); ++i) {
    Reflector& reflector = reflectors_[i];
    glm::ivec4& mirror = block->mirrors[i];
    mirror = {-1, 0, 0, 0};
    std::vector<ReflectorPatch> patches;
    if (reflector.patch) patches.push_back(make_reflector_patch(reflector.points));
    if (reflector.patch && patches[0].degenerate) continue;
    if (reflector.fit) {
      for (const FittedPatch& patch : reflector.fit->patches) patches.push_back(make_reflector_patch(patch.points));
      const DrawItem& item = scene.geometry().items[reflector.item];
      mirror.y = 1;
      mirror.z = static_cast<int>(triangles.size()) - static_cast<int>(item.first_index / 3);
      for (const FittedTriangle& t : reflector.fit->triangles) {
        const auto packed = [&](int k) { return glm::packSnorm2x16(glm::vec2(t.x[static_cast<std::size_t>(k)])); };
        const bool placed = t.patch >= 0 && !patches[static_cast<std::size_t>(t.patch)].degenerate;
        triangles.emplace_back(placed ? static_cast<unsigned>(count) + static_cast<unsigned>(t.patch) + 1u : 0u,
                               packed(0), packed(1), packed(2));
      }
      names += (names.empty() ? "" : ", ") + fit_line(reflector);
    }
    if (patches.empty()) continue;
    reflector.first_patch = static_cast<int>(count);
    if (reflector.patch) mirror.x = reflector.first_patch;
    for (const ReflectorPatch& patch : patches)
      if (count++ < kMaxPatches) block->patches[count - 1] = make_patch_record(patch);
  }
  if (count > kMaxPatches)
    throw Error(option,
                std::to_string(count) + " patches are more than the " + std::to_string(kMaxPatches) +
                    " that are drawn at once (" + names + ")",
                "name fewer with --reflector, or use another reflector technique");
  block_ = Buffer("reflectors", sizeof *block, block.get());
  if (triangles.empty()) triangles.emplace_back(0u);
  fit_triangles_ = Buffer::from("fitted triangles", triangles);
  fit_triangle_view_ = Texture::make_buffer("fitted triangles", GL_RGBA32UI, fit_triangles_);
}

int ReflectorSet::of_item(std::size_t item) const {
  if (!drawn_) return -1;
  for (std::size_t k = 0; k < reflectors_.size(); ++k)
    if (reflectors_[k].item == item) return static_cast<int>(k);
  return -1;
}

bool ReflectorSet::is_mirror(std::size_t item) const {
  const int k = of_item(item);
  return k >= 0 && reflectors_[static_cast<std::size_t>(k)].mirror;
}

bool ReflectorSet::has_mirrors() const {
  return std::any_of(reflectors_.begin(), reflectors_.end(), [](const Reflector& r) { return r.mirror; });
}

bool ReflectorSet::has_panes() const {
  return std::any_of(reflectors_.begin(), reflectors_.end(), [](const Reflector& r) { return !r.mirror; });
}

bool ReflectorSet::any_fitted() const {
  return std::any_of(reflectors_.begin(), reflectors_.end(), [](const Reflector& r) { return r.fit; });
}

int ReflectorSet::in_view(const SceneState& scene, const glm::mat4& clip) const {
  int count = 0;
  for (const Reflector& reflector : reflectors_)
    count += scene.buffers().visible(reflector.item) && may_be_seen(clip, scene.buffers().bounds(reflector.item));
  return count;
}

void ReflectorSet::update_coarse_patches(const SceneState& scene) {
  if (coarse_of_ == scene.revisions().geometry) return;
  coarse_of_ = scene.revisions().geometry;
  coarse_patches_ = make_coarse_patches(scene.geometry());
  const std::vector<std::uint32_t>& indices = coarse_patches_.indices;
  coarse_indices_ = indices.empty() ? Buffer() : Buffer::from("coarse patches", indices);
}

void ReflectorSet::draw_level(const SceneState& scene, std::size_t i, const CoarsePatch::Level* level) const {
  const SceneBuffers& buffers = scene.buffers();
  const DrawItem& item = scene.geometry().items[i];
  const std::uint32_t first = level ? level->first_index : item.first_index,
                      count = level ? level->index_count : item.index_count;
  if (level) glVertexArrayElementBuffer(buffers.vertex_array(), coarse_indices_.get());
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(count), GL_UNSIGNED_INT,
                 reinterpret_cast<const void*>(static_cast<std::uintptr_t>(first) * 4));
  if (level) glVertexArrayElementBuffer(buffers.vertex_array(), buffers.indices());
}

void ReflectorSet::report(FrameStatus* status) const {
  status->fitting = fitting_;
  status->all_fitting = !fitting_.empty() && reflectors_.empty();
  status->fit_progress = patch_fits_.progress();
  for (const Reflector& reflector : reflectors_)
    if (reflector.fit) (reflector.fit->met ? status->fitted : status->misfitted).push_back(fit_line(reflector));
}

std::vector<bool> glossy_items(const SceneState& scene, float roughness) {
  std::vector<bool> smooth;
  for (std::size_t i = 0; i < scene.geometry().items.size(); ++i) {
    const Material& m = scene.material_of_item(i);
    const int slot = scene.slots()[static_cast<std::size_t>(scene.buffers().material(i))];
    const bool opaque = !scene.is_transparent(i) && !m.unlit;
    smooth.push_back(opaque && (slot >= 0 ? scene.materials().roughness(slot) : least_roughness(m)) <= roughness);
  }
  return smooth;
}

}  // namespace maquette
