#include "render/splitsum/tables.h"

#include "render/environment/prefilter.h"
#include "render/gl/bindings.h"
#include "render/prefilter/fit_table.h"
#include "render/prefilter/prefiltered_maps.h"
#include "render/prefilter/reflectance_tables.h"
#include "render/splitsum/fit.h"

namespace maquette {

namespace {

constexpr int kGgxLevels = 17;  // as in shaders/splitsum/shade.comp

/// The irradiance map comes first, then the levels.
std::vector<Image> make_maps(const Environment& environment) {
  std::vector<Image> maps = {prefilter_diffuse(environment)};
  for (Image& level : prefilter_ggx(environment, kGgxLevels)) maps.push_back(std::move(level));
  return maps;
}

class SplitsumTables : public LookupTables {
 public:
  explicit SplitsumTables(const Environment& environment)
      : maps_("GGX maps", make_maps(environment)),
        reflectance_(reflectance_table()),
        table_(upload_table("reflectance", reflectance_)) {}

  void update(MaterialStore& materials) override {
    fits_.update(materials.count(), [&](int slot, std::vector<glm::vec4>* texels) {
      const SplitsumFit fit = fit_energy(materials.ggx(slot), materials.albedo(slot), reflectance_);
      texels->emplace_back(fit.diffuse, fit.alpha);
      texels->emplace_back(fit.f0, 0.0f);
      texels->emplace_back(fit.f90, 0.0f);
    });
  }

  void bind() const override {
    maps_.bind(kUnitPrefilteredMaps);
    glBindTextureUnit(kUnitReflectance, table_.get());
    fits_.bind();
  }

  std::size_t bytes() const override { return maps_.bytes() + table_.bytes() + fits_.bytes(); }

 private:
  PrefilteredMaps maps_;
  Image reflectance_;
  Texture table_;
  FitTable fits_{"GGX fits"};  ///< three texels a slot
};

}  // namespace

std::unique_ptr<LookupTables> make_splitsum_tables(const Environment& environment) {
  return std::make_unique<SplitsumTables>(environment);
}

}  // namespace maquette
