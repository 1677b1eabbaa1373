#pragma once

#include <string>
#include <vector>

#include "render/frame/context.h"
#include "render/frame/part_mode.h"

namespace maquette {

/// Names of a node and of those above it, from a root on, joined by '/'.
std::string node_path(const Scene& scene, int node);

/// The nodes of this name, or the one of this path from a root. Throws UsageError with the nearest names where there is
/// none.
std::vector<int> find_nodes(const Scene& scene, const std::string& call);

/// Layer of each node: that of the nearest ancestor, or itself, that `part_modes` name; the first layer's else. A node
/// is named by its name, all that have it, or by its path from a root, names joined by '/'. `layer_modes`: mode of each
/// layer. Throws UsageError for a node that is not in the scene, with the nearest names.
std::vector<int> layers_of_nodes(const Scene& scene, const std::vector<PartMode>& part_modes,
                                 const std::vector<std::string>& layer_modes);

/// Which layer shades what, where several shading modes share a frame; nothing else pays for it.
class Parts {
 public:
  /// Finds the items of each layer; makes nothing where there is one layer.
  void update(const SceneState& scene, const std::vector<PartMode>& part_modes,
              const std::vector<std::string>& layer_modes);
  bool several() const { return static_cast<bool>(layers_); }
  int layer_of_item(std::size_t item) const { return several() ? layer_of_item_[item] : 0; }
  /// Grows with every change of what a layer shades.
  std::uint32_t revision() const { return revision_; }

  /// Writes those of `triangles` (number + 1) that are of the layer, and 0 for the others.
  void split(const Texture& triangles, int layer, Texture* own, ProgramCache* programs) const;
  /// Writes `depths` where the triangle there is of the layer, and 0 elsewhere.
  void split_hits(const Texture& triangles, const Texture& depths, int layer, Texture* own,
                  ProgramCache* programs) const;
  /// Copies to `all` what a layer's points hold, where its depth says that there are some; tiles of `layer`'s surfaces.
  static void merge(const TileList& tiles, const Texture& depth, const Texture& radiance, const Texture& all_radiance,
                    const Texture& all_depth, ProgramCache* programs);
  static std::vector<ShaderVariant> shader_variants();
  std::size_t bytes() const { return layers_.bytes(); }

 private:
  std::vector<int> layer_of_item_;
  std::optional<Key> key_;
  std::uint32_t revision_ = 0;
  Buffer layers_;  ///< [triangle]: layer
  Texture layer_view_;
};

}  // namespace maquette
