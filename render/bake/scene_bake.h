#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "render/bake/bake.h"
#include "render/technique/compression_table.h"
#include "render/technique/point_report.h"

namespace maquette {

class SceneState;
struct FrameRequest;
struct ShadingPlan;
class Settings;

/// A bake that a technique of its own draws with (Technique::own_bake): SceneBakes starts it, waits for it and lists
/// it. Its class derives from KeyedBake, too.
class SceneBake {
 public:
  virtual ~SceneBake() = default;
  virtual Bake& bake() = 0;
  /// Starts it when what it depends on has changed, and takes over what a run has made, on the thread of OpenGL. Does
  /// not wait. True when what is drawn with has changed. Throws what made a run fail, once.
  /// `layer`: whose parts it is for.
  virtual bool update(const SceneState& scene, const FrameRequest& request, const ShadingPlan& layer) = 0;
  /// Hash of all that it depends on as the scene is now, by which its files are kept (BakeKeys); empty: they are not.
  /// Nothing is made for it. Throws Error, as a run would.
  virtual std::string key(const SceneState&, const FrameRequest&, const ShadingPlan&) { return {}; }
  /// Whether the files of this key are whole where settings of this scene (its name) have it look for them.
  virtual bool is_kept(const std::string& /*key*/, const std::string& /*scene*/, const Settings&) const {
    return false;
  }
  /// Binds its textures and buffers, before the passes of a layer.
  virtual void bind() const = 0;
  /// What is stored for a point of a triangle's side; nothing where it has none, or nothing to show. Throws Error.
  virtual std::optional<PointReport> describe(const SceneState&, std::uint32_t /*triangle*/, bool /*back*/,
                                              const glm::vec3& /*position*/) const {
    return std::nullopt;
  }
  /// Of what it draws with, how the error follows the strength of compression; null where it compresses nothing.
  virtual CompressionTableJob compression_table() const { return {}; }
  /// What of it is not as the scene is now or cannot be shown as asked, a line each.
  virtual std::vector<std::string> notes() const { return {}; }
};

}  // namespace maquette
