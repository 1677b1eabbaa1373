#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "render/bake/bake_runner.h"
#include "render/bake/scene_bake.h"
#include "render/frame/key.h"
#include "render/prt/buffers.h"
#include "render/prt/job.h"

namespace maquette {

/// Makes transfer; keeps the last one, which a turned object shows again.
class TransferKind : public BakeKind<TransferInput, Transfer> {
 public:
  /// The materials' means, until the rest is there.
  bool shows_parts() const override { return true; }
  Baked<Transfer> run(const TransferInput& input, const Baked<Transfer>&, const BakeTask<Transfer>& task) override;

 private:
  TransferMemory memory_;
};

/// The light of an environment, as transfer meets it, and the time that it took.
struct LightUpdate {
  KeptLight kept;
  double left_out = 0.0;  ///< light_left_out
  double ms = 0.0;        ///< from the request to the sums on the device
};

/// The transfer of a scene on the GPU, under the light at hand.
class TransferStore final : public KeyedBake<Key, TransferInput, Transfer>, public SceneBake {
 public:
  TransferStore() : KeyedBake(std::make_shared<TransferKind>()) {}
  const char* name() const override { return "prt"; }
  Bake& bake() override { return *this; }
  bool update(const SceneState& scene, const FrameRequest& request, const ShadingPlan& layer) override;
  std::string key(const SceneState& scene, const FrameRequest& request, const ShadingPlan& layer) override;
  bool is_kept(const std::string& key, const std::string& scene, const Settings& settings) const override;
  void bind() const override { buffers_->bind(); }
  bool ready() const override { return buffers_.has_value(); }
  std::size_t bytes() const override { return buffers_ ? buffers_->bytes() : 0; }

  std::vector<std::string> notes() const override;

  const TransferBuffers& buffers() const { return *buffers_; }
  const Transfer& transfer() const { return *transfer_; }
  const LightUpdate& light() const { return light_; }
  /// What is left of the light by its kept coefficients: radiance of a direction of the world, stored units.
  std::function<glm::vec3(const glm::dvec3&)> kept_sky() const;

 private:
  bool update_light(const SceneState& scene, const FrameRequest& request);

  bool held_ = false;                          ///< prt.run
  std::optional<Key> wanted_, begun_, shown_;  ///< of the last frame, of the last bake begun, of the one shown
  std::string digits_;                         ///< the key of the files, and that for which it was found
  std::optional<Key> digits_of_;
  std::shared_ptr<const Transfer> transfer_;
  std::optional<TransferBuffers> buffers_;
  std::vector<float> importance_;
  std::optional<CubeDirections> cube_;
  CubePyramid pyramid_;
  std::optional<Key> pyramid_of_, light_of_;
  std::vector<glm::vec4> sums_;
  LightUpdate light_;
};

}  // namespace maquette
