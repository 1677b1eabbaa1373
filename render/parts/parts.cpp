#include "render/parts/parts.h"

#include <algorithm>
#include <functional>

#include "render/gl/bindings.h"
#include "scenes/error.h"
#include "scenes/node_paths.h"
#include "scenes/suggest.h"

namespace maquette {

namespace {

const ShaderVariant kSplit{"parts/split.comp", "", {{"DEPTHS", "0"}}},
    kSplitHits{"parts/split.comp", "", {{"DEPTHS", "1"}}}, kMerge{"parts/merge.comp", "", {}};

}  // namespace

std::string node_path(const Scene& scene, int node) {
  std::string path = scene.nodes[static_cast<std::size_t>(node)].name;
  int above = scene.nodes[static_cast<std::size_t>(node)].parent;
  for (std::size_t steps = 0; above >= 0 && steps < scene.nodes.size(); ++steps) {
    const Node& n = scene.nodes[static_cast<std::size_t>(above)];
    path = n.name + "/" + path;
    above = n.parent;
  }
  return path;
}

std::vector<int> find_nodes(const Scene& scene, const std::string& call) {
  std::vector<int> found;
  for (int i = 0; i < static_cast<int>(scene.nodes.size()); ++i)
    if (scene.nodes[static_cast<std::size_t>(i)].name == call || node_path(scene, i) == call) found.push_back(i);
  if (found.empty() && call.starts_with('/')) found = called_nodes(scene, node_paths(scene), call);
  if (!found.empty()) return found;
  std::vector<std::string> known;
  for (const Node& node : scene.nodes) known.push_back(node.name);
  for (int i = 0; i < static_cast<int>(scene.nodes.size()); ++i) known.push_back(node_path(scene, i));
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  throw UsageError("node " + call, "the scene has no node of that name", did_you_mean(call, known));
}

std::vector<int> layers_of_nodes(const Scene& scene, const std::vector<PartMode>& part_modes,
                                 const std::vector<std::string>& layer_modes) {
  std::vector<int> named(scene.nodes.size(), -1), layers(scene.nodes.size(), 0);
  if (part_modes.empty()) return layers;
  for (const PartMode& part : part_modes) {
    const auto layer = std::find(layer_modes.begin(), layer_modes.end(), part.mode) - layer_modes.begin();
    for (const int node : part.index >= 0 ? std::vector<int>{part.index} : find_nodes(scene, part.node))
      named[static_cast<std::size_t>(node)] = static_cast<int>(layer);
  }
  const std::function<void(int, int)> inherit = [&](int node, int layer) {
    const auto i = static_cast<std::size_t>(node);
    if (named[i] >= 0) layer = named[i];
    layers[i] = layer;
    for (const int child : scene.nodes[i].children) inherit(child, layer);
  };
  for (const int root : scene.roots) inherit(root, 0);
  return layers;
}

std::vector<ShaderVariant> Parts::shader_variants() { return {kSplit, kSplitHits, kMerge}; }

void Parts::update(const SceneState& scene, const std::vector<PartMode>& part_modes,
                   const std::vector<std::string>& layer_modes) {
  Key key = Key::of(scene.revisions().geometry, layer_modes);
  for (const PartMode& part : part_modes) {
    key.add(part.node);
    key.add(part.mode);
  }
  if (key_ == key) return;
  const std::vector<int> nodes = layers_of_nodes(scene.scene(), part_modes, layer_modes);  // may throw
  key_ = key;
  ++revision_;
  layers_ = Buffer();
  layer_view_ = Texture();
  layer_of_item_.clear();
  if (layer_modes.size() < 2) return;
  const FlatGeometry& geometry = scene.geometry();
  std::vector<std::uint32_t> of_triangles(geometry.indices.size() / 3 + 1, 0u);
  for (const DrawItem& item : geometry.items) {
    const int layer = item.node < 0 ? 0 : nodes[static_cast<std::size_t>(item.node)];
    layer_of_item_.push_back(layer);
    for (std::uint32_t k = item.first_index / 3; k < (item.first_index + item.index_count) / 3; ++k)
      of_triangles[k] = static_cast<std::uint32_t>(layer);
  }
  layers_ = Buffer::from("layer of triangles", of_triangles);
  layer_view_ = Texture::make_buffer("layer of triangles", GL_R32UI, layers_);
}

void Parts::split(const Texture& triangles, int layer, Texture* own, ProgramCache* programs) const {
  if (!*own || own->width() != triangles.width() || own->height() != triangles.height())
    *own = Texture::make_2d("triangles of a layer", GL_R32UI, triangles.width(), triangles.height());
  const Program& program = programs->get(kSplit);
  program.set("u_layer", layer);
  glBindTextureUnit(kUnitTriangle, triangles.get());
  glBindTextureUnit(kUnitTriangleLayers, layer_view_.get());
  glBindImageTexture(kImageTriangle, own->get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32UI);
  dispatch(program, group_count(own->width(), 8), group_count(own->height(), 8));
}

void Parts::split_hits(const Texture& triangles, const Texture& depths, int layer, Texture* own,
                       ProgramCache* programs) const {
  if (!*own || own->width() != triangles.width() || own->height() != triangles.height())
    *own = Texture::make_2d("depths of a layer", GL_R32F, triangles.width(), triangles.height());
  const Program& program = programs->get(kSplitHits);
  program.set("u_layer", layer);
  glBindTextureUnit(kUnitTriangle, triangles.get());
  glBindTextureUnit(kUnitTriangleLayers, layer_view_.get());
  glBindTextureUnit(kUnitDepth, depths.get());
  glBindImageTexture(kImageLayerDepth, own->get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  dispatch(program, group_count(own->width(), 8), group_count(own->height(), 8));
}

void Parts::merge(const TileList& tiles, const Texture& depth, const Texture& radiance, const Texture& all_radiance,
                  const Texture& all_depth, ProgramCache* programs) {
  glBindTextureUnit(kUnitDepth, depth.get());
  glBindTextureUnit(kUnitRadiance, radiance.get());
  glBindImageTexture(kImageRadiance, all_radiance.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(kImageDepth, all_depth.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  dispatch_tiles(programs->get(kMerge), tiles, kPerPoint);
}

}  // namespace maquette
