#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/bezier/patch_fit_store.h"
#include "render/frame/request.h"
#include "render/frame/status.h"
#include "render/reflections/coarse_patches.h"
#include "render/reflections/reflectors.h"
#include "render/scene_state/scene_state.h"
#include "render/technique/technique.h"

namespace maquette {

/// The surfaces that mirror the scene in this frame, with the patches fitted to curved ones, and what draws them.
class ReflectorSet {
 public:
  /// Finds the reflectors that `request` names or the scene marks. `technique`: null: none. `fits_patches`: curved
  /// meshes are to be projected into. Throws Error for what cannot be a reflector.
  void update(const SceneState& scene, const FrameRequest& request, const Technique* technique, bool fits_patches);
  /// Until the next update() none of them is drawn: mirrors are opaque surfaces like others.
  void set_drawn(bool drawn) { drawn_ = drawn; }

  const std::vector<Reflector>& all() const { return reflectors_; }
  /// Index of the reflector that an item is, or -1.
  int of_item(std::size_t item) const;
  /// Opaque reflectors are drawn with the panes, not with the opaque surfaces.
  bool is_mirror(std::size_t item) const;
  bool has_mirrors() const;
  bool has_panes() const;
  bool any_fitted() const;
  int in_view(const SceneState& scene, const glm::mat4& clip_from_world) const;
  /// Grows with the patches that have been fitted.
  std::uint32_t fits_revision() const { return fits_revision_; }
  /// Changes when the set or what is drawn of it does.
  Key key() const { return Key::of(revision_, drawn_); }

  const Buffer& block() const { return block_; }
  const Texture& fit_triangles() const { return fit_triangle_view_; }
  /// Patches and meshes, of the scene as it is.
  void update_coarse_patches(const SceneState& scene);
  const CoarsePatches& coarse_patches() const { return coarse_patches_; }
  /// With the bound program and vertex array: an item's own triangles, or a coarser level of its patch.
  void draw_level(const SceneState& scene, std::size_t item, const CoarsePatch::Level* level) const;

  PatchFitStore& patch_fits() { return patch_fits_; }
  const PatchFitStore& patch_fits() const { return patch_fits_; }
  /// What the fits are worth, for the plan.
  void report(FrameStatus* status) const;
  std::size_t bytes() const { return coarse_indices_.bytes(); }

 private:
  void forget();
  void fit_curved(const SceneState& scene, const std::string& option);
  void upload(const SceneState& scene, const std::string& option);

  std::vector<Reflector> reflectors_;
  std::optional<Key> key_;  ///< what they were found for
  std::uint32_t revision_ = 0;
  bool drawn_ = true;
  Buffer block_;  ///< patches of the reflectors, std140
  CoarsePatches coarse_patches_;
  std::optional<std::uint32_t> coarse_of_;  ///< geometry's revision that they are of
  Buffer coarse_indices_;
  PatchFitStore patch_fits_;
  std::uint32_t fits_revision_ = 0;
  std::string fitting_;   ///< names of reflectors that are left out until theirs are there
  Buffer fit_triangles_;  ///< [triangle of fitted meshes], as shaders/reflections/rays.comp has them
  Texture fit_triangle_view_;
};

/// [item] opaque, and what of it mirrors is no rougher; mirrors that are reflectors too.
std::vector<bool> glossy_items(const SceneState& scene, float roughness);

}  // namespace maquette
