#include "render/parts/parts.h"

#include <algorithm>
#include <functional>

#include "render/gl/bindings.h"
#include "scenes/error.h"
#include "scenes/suggest.h"

namespace maquette {

namespace {

const ShaderVariant kSplit{"parts/split.comp", "", {{"DEPTHS", "0"}}},
    kSplitHits{"parts/split.comp", "", {{"DEPTHS", "1"}}}, kMerge{"parts/merge.comp", "", {}};

/// Walks the nodes below `node` with their paths.
void walk(const Scene& scene, int node, const std::string& above,
          const std::function<void(int, const std::string&)>& visit) {
  const Node& n = scene.nodes[static_cast<std::size_t>(node)];
  const std::string path = above.empty() ? n.name : above + "/" + n.name;
  visit(node, path);
  for (const int child : n.children) walk(scene, child, path, visit);
}

}  // namespace

std::string node_path(const Scene& scene, int node) {
  std::string path;
  for (int i = node, steps = 0; i >= 0 && steps <= static_cast<int>(scene.nodes.size()); ++steps) {
    const Node& n = scene.nodes[static_cast<std::size_t>(i)];
    path = path.empty() ? n.name : n.name + "/" + path;
    i = n.parent;
  }
  return path;
}

std::vector<int> layers_of_nodes(const Scene& scene, const std::vector<PartMode>& part_modes,
                                 const std::vector<std::string>& layer_modes) {
  std::vector<int> named(scene.nodes.size(), -1), layers(scene.nodes.size(), 0);
  std::vector<std::string> known;
  std::vector<bool> found(part_modes.size(), false);
  const auto name_nodes = [&](int node, const std::string& path) {
    const std::string& name = scene.nodes[static_cast<std::size_t>(node)].name;
    for (const std::string& call : {name, path})
      if (std::find(known.begin(), known.end(), call) == known.end()) known.push_back(call);
    for (std::size_t k = 0; k < part_modes.size(); ++k) {
      if (part_modes[k].node != name && part_modes[k].node != path) continue;
      found[k] = true;
      const auto layer = std::find(layer_modes.begin(), layer_modes.end(), part_modes[k].mode);
      named[static_cast<std::size_t>(node)] = static_cast<int>(layer - layer_modes.begin());
    }
  };
  for (const int root : scene.roots) walk(scene, root, "", name_nodes);
  for (std::size_t k = 0; k < part_modes.size(); ++k)
    if (!found[k])
      throw UsageError("--mode-of", "the scene has no node '" + part_modes[k].node + "'",
                       did_you_mean(part_modes[k].node, known));
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
