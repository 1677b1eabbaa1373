#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "render/bake/scene_bake.h"
#include "render/frame/key.h"
#include "render/frame/plan.h"
#include "render/frame/request.h"
#include "render/indirect/indirect_buffers.h"
#include "render/octree/octree_store.h"
#include "render/scene_state/scene_state.h"
#include "render/shadow_rays/shadow_scene.h"
#include "render/visibility/visibility_buffers.h"

namespace maquette {

/// The bakes that frames of a scene draw with, and what starts, takes over and drops them as plans ask for them: four
/// that several techniques share, and those that techniques declare for themselves. Another shared one needs a line in
/// clear, all, list, report, finish, bind and add_bytes.
class SceneBakes {
 public:
  explicit SceneBakes(const Registry& registry) : registry_(registry) {}
  /// In a window: bakes prepare for a light that may rotate, and an octree stays while nothing goes through it for a
  /// moment.
  void set_interactive(bool interactive);
  /// Forgets all: another scene.
  void clear();

  void update_visibility(const SceneState& scene);
  void update_shadow_rays(const SceneState& scene, const FrameRequest& request);
  void drop_shadow_rays() { shadow_scene_.clear(); }
  /// Needs the bake of visibility; does nothing before it is there.
  void update_indirect(const SceneState& scene, const FrameRequest& request);
  void update_octree(const SceneState& scene, const FrameRequest& request);
  void update_cells(const SceneState& scene, const FrameRequest& request, bool wanted);
  /// Of a layer's technique, if it declares one.
  void update_own(const ShadingPlan& layer, const SceneState& scene, const FrameRequest& request);
  /// Nothing in view goes through the octree: it is dropped, or kept for some frames where `may_return`. True when it
  /// is kept.
  bool release_octree(bool may_return);

  /// Says in `status` what of `wanted` is there.
  void report(const FramePlan& wanted, const SceneState& scene, FrameStatus* status) const;
  /// The key (BakeKeys) of a bake for the scene as it is now, without making it; empty: it is not kept by one, or none
  /// of the layers draws with it. Throws Error.
  std::string key(const std::string& bake, const FramePlan& wanted, const SceneState& scene,
                  const FrameRequest& request);
  /// Starts what `wanted` needs and waits until it is there. False when something could not be made.
  bool finish(const FramePlan& wanted, const SceneState& scene, const FrameRequest& request);

  const VisibilityBuffers& visibility() const { return visibility_; }
  const IndirectBuffers& indirect() const { return indirect_; }
  const OctreeStore& octree() const { return octree_; }
  const ShadowScene& shadow_scene() const { return shadow_scene_; }
  /// Of a technique, by Technique::own_bake; null: no plan wanted it yet.
  const SceneBake* own(const std::string& name) const {
    const auto found = own_.find(name);
    return found == own_.end() ? nullptr : found->second.get();
  }
  std::uint32_t visibility_revision() const { return visibility_revision_; }
  /// Of all that points depend on besides indirect light; shadows of the sky come once that is there.
  Key without_indirect() const {
    return Key::of(visibility_revision_, octree_revision_, own_revision_, shadow_scene_.ready(), indirect_.ready());
  }
  Key all() const { return Key::of(without_indirect(), indirect_revision_, shadow_revision_); }

  /// All of them, for the status line and those who wait.
  std::vector<const Bake*> list() const;

  void bind() const;
  void add_bytes(std::map<std::string, std::size_t>* bytes) const;
  void add_counters(std::map<std::string, double>* counters) const;

 private:
  OctreeJob make_octree_job(const SceneState& scene, const OctreeState& state, const std::string& folder) const;
  std::shared_ptr<const IndirectInput> make_indirect_input(const SceneState& scene, int variant) const;
  /// What the input of indirect light is made of.
  static Key indirect_key(const SceneState& scene, const FrameRequest& request);
  IndirectJob make_indirect_job(const SceneState& scene, const FrameRequest& request) const;
  SceneBake& own_of(const ShadingPlan& layer);

  bool interactive_ = false;
  VisibilityBuffers visibility_;
  IndirectBuffers indirect_;
  std::optional<Key> indirect_of_;  ///< what the input of indirect light was made of
  OctreeStore octree_;
  ShadowScene shadow_scene_;
  std::uint32_t shadow_revision_ = 0;
  const Registry& registry_;
  std::map<std::string, std::unique_ptr<SceneBake>> own_;  ///< by Technique::own_bake
  std::uint32_t own_revision_ = 0;
  int frames_without_octree_ = 0;                                                        ///< since a plan wanted it
  std::uint32_t visibility_revision_ = 0, indirect_revision_ = 0, octree_revision_ = 0;  ///< grow with what is drawn
};

}  // namespace maquette
