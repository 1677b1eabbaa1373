#pragma once

#include <memory>

#include "render/bake/kept_bakes.h"
#include "render/indirect/indirect_light.h"

namespace maquette {

struct IndirectJob {
  std::shared_ptr<const IndirectInput> input;
  std::shared_ptr<const VisibilityBake> visibility;
  IndirectSky sky;
  IndirectBounces bounces = IndirectBounces::all;
};

struct IndirectResult {
  IndirectBake bake;
  IndirectSky sky;
  IndirectBounces bounces = IndirectBounces::all;
  std::shared_ptr<const IndirectInput> input;
};

/// Indirect light, kept in the cache by content. Rays are traced only when neither the run before nor the cache has the
/// answer; a first result by few of them, with the maps' sky, comes early. For no bounces it traces them and gives
/// nothing.
class IndirectKind : public CachedBakeKind<IndirectJob, IndirectResult> {
 public:
  IndirectKind();
  Baked<IndirectResult> load(const IndirectJob&) override;
  Baked<IndirectResult> run(const IndirectJob&, const Baked<IndirectResult>&, const BakeTask<IndirectResult>&) override;
  bool shows_parts() const override { return true; }
  /// A newer sky waits for the one in work (a rotating environment all the time would else never be seen); newer
  /// surfaces stop it.
  static bool spares(const IndirectJob& before, const IndirectJob& next) { return before.input == next.input; }

 protected:
  std::optional<std::uint64_t> cache_key(const IndirectJob&) const override;
  std::vector<std::byte> pack(const IndirectResult&) const override;
  std::optional<IndirectResult> unpack(const IndirectJob&, const std::vector<std::byte>&) const override;

 private:
  /// What is kept from run to run of the same input, so that a rotating sky costs no rays.
  struct Memory {
    std::shared_ptr<const IndirectInput> input;
    std::shared_ptr<const IndirectLinks> links;
    IndirectSolution solution;  ///< of the last run
  };
  Memory memory_;
};

}  // namespace maquette
