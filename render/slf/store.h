#pragma once

#include <memory>
#include <mutex>
#include <optional>

#include "render/bake/bake_runner.h"
#include "render/bake/scene_bake.h"
#include "render/frame/key.h"
#include "render/slf/buffers.h"
#include "render/slf/light_field.h"

namespace maquette {

/// Makes light fields; keeps the incident light of the last one, so that an exchange of materials traces nothing.
class LightFieldKind : public BakeKind<LightFieldJob, LightField> {
 public:
  Baked<LightField> run(const LightFieldJob& job, const Baked<LightField>&, const BakeTask<LightField>& task) override;
  /// What of the run in work will not be shown as asked, before it is done.
  std::vector<std::string> early_notes() const {
    const std::lock_guard lock(mutex_);
    return early_notes_;
  }

 private:
  LightFieldMemory memory_;
  mutable std::mutex mutex_;
  std::vector<std::string> early_notes_;
};

/// The light field of a scene on the GPU.
class LightFieldStore final : public KeyedBake<Key, LightFieldJob, LightField>, public SceneBake {
 public:
  LightFieldStore() : LightFieldStore(std::make_shared<LightFieldKind>()) {}
  const char* name() const override { return "slf"; }
  Bake& bake() override { return *this; }
  bool update(const SceneState& scene, const FrameRequest& request, const ShadingPlan& layer) override;
  std::string key(const SceneState& scene, const FrameRequest& request, const ShadingPlan& layer) override;
  bool is_kept(const std::string& key, const std::string& scene, const Settings& settings) const override;
  void bind() const override { buffers_->bind(); }
  std::optional<PointReport> describe(const SceneState& scene, std::uint32_t triangle, bool back,
                                      const glm::vec3& position) const override;
  CompressionTableJob compression_table() const override;
  std::vector<std::string> notes() const override;
  bool ready() const override { return buffers_.has_value(); }
  std::size_t bytes() const override { return buffers_ ? buffers_->bytes() : 0; }

 private:
  explicit LightFieldStore(std::shared_ptr<LightFieldKind> kind) : KeyedBake(kind), kind_(std::move(kind)) {}

  std::shared_ptr<LightFieldKind> kind_;
  std::shared_ptr<const LightField> field_;  ///< that the buffers hold
  std::optional<LightFieldBuffers> buffers_;
  std::size_t triangles_ = 0;  ///< of the geometry that the buffers are for
  /// While no bake may run: what is no longer as it was in `field_`, and the key for which that was found.
  std::vector<std::string> changes_;
  std::optional<Key> changes_of_;
  std::string digits_;  ///< the key of the files, and that for which it was found
  std::optional<Key> digits_of_;
};

}  // namespace maquette
