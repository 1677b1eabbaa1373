#pragma once

#include <map>
#include <memory>
#include <set>
#include <vector>

#include "review/look.h"
#include "scenes/scene.h"
#include "scenes/subdivision.h"

namespace maquette {

/// Subdivision surfaces of a scene with dents pressed into them, one after the other: each is pressed against the
/// normal of what those before it left. The state after every dent is kept, so that the last one can be dragged.
class DentedSurfaces {
 public:
  /// `scene`: without dents; outlives this.
  explicit DentedSurfaces(const Scene* scene) : scene_(scene) {}

  struct Surface {
    std::vector<glm::vec3> points;              ///< of the cage
    std::vector<glm::vec3> positions, normals;  ///< of the limit surface, node space
  };
  /// Replaces the dents that were pressed before. Returns the meshes that have changed since. Throws Error for a dent
  /// that touches nothing, and for a part that is not there; the dents are then those of before.
  std::set<int> press(const std::vector<Dent>& dents);
  /// Null for a mesh without a dent.
  const Surface* surface(int mesh) const;
  /// Of every dented mesh.
  std::set<int> meshes() const;

 private:
  using Surfaces = std::map<int, std::shared_ptr<const Surface>>;
  struct Step {
    Dent dent;
    Surfaces after;
  };
  Surfaces pressed(const Surfaces& before, const Dent& dent);
  const SubdivisionEvaluator& evaluator(int mesh);

  const Scene* scene_;
  std::vector<Step> steps_;
  std::map<int, SubdivisionEvaluator> evaluators_;
};

/// Presses dents into the scene itself. Throws Error as DentedSurfaces::press.
void press_dents(Scene* scene, const std::vector<Dent>& dents);

}  // namespace maquette
