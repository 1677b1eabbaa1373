#include <gtest/gtest.h>

#include "render/materials/brdf_tables.h"
#include "render/materials/symmetric_brdf.h"

namespace {

using namespace maquette;

TEST(BrdfLibraryEnergy, NoMaterialReflectsMoreThanItReceives) {
  for (const BuiltinBrdf& entry : builtin_brdfs()) {
    BrdfTables tables;
    compute_albedo(SymmetricBrdf(make_builtin_brdf(entry.name)), tables);
    for (std::size_t i = 0; i < tables.albedo.size(); ++i) {
      const glm::vec3& albedo = tables.albedo[i];
      EXPECT_LE(std::max({albedo.x, albedo.y, albedo.z}), 1.0f) << entry.name << " at " << i;
      EXPECT_GE(std::min({albedo.x, albedo.y, albedo.z}), 0.01f) << entry.name << " at " << i;
    }
  }
}

}  // namespace
