#pragma once

#include <memory>
#include <vector>

#include "render/bake/kept_bakes.h"
#include "render/visibility/visibility_bake.h"
#include "render/visibility/visibility_sides.h"

namespace maquette {

struct VisibilityJob {
  FlatGeometry geometry;  ///< positions, normals, indices and items suffice
  std::vector<bool> transmits;
  std::vector<Passage> passages;
};

/// A bake and its visibility maps as shaders read them.
struct DrawnVisibility {
  std::shared_ptr<const VisibilityBake> bake;
  std::vector<VisibilitySides> sides;
};

/// Visibility, kept in the cache.
class VisibilityKind : public CachedBakeKind<VisibilityJob, DrawnVisibility> {
 public:
  VisibilityKind();
  Baked<DrawnVisibility> run(const VisibilityJob&, const Baked<DrawnVisibility>&,
                             const BakeTask<DrawnVisibility>&) override;

 protected:
  std::optional<std::uint64_t> cache_key(const VisibilityJob&) const override;
  std::vector<std::byte> pack(const DrawnVisibility&) const override;
  std::optional<DrawnVisibility> unpack(const VisibilityJob&, const std::vector<std::byte>&) const override;
};

}  // namespace maquette
