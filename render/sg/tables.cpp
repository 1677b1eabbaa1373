#include "render/sg/tables.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/environment/prefilter.h"
#include "render/gl/bindings.h"
#include "render/prefilter/fit_table.h"
#include "render/prefilter/prefiltered_maps.h"
#include "render/prefilter/reflectance_tables.h"
#include "render/sg/fit.h"

namespace maquette {

namespace {

constexpr int kMostSgLevels = 14;  // sharpness 2, 4, ... 2^14, then the sky itself
constexpr int kSgTableSize = 64;

/// The irradiance map comes first, then the ladder, then the unfiltered sky. Lobes narrower than half a texel of the
/// sky do not filter it.
std::vector<Image> make_sg_maps(const Environment& environment) {
  const double finest = std::log2(std::max(environment.width, 8) / std::numbers::pi) * 2.0;
  const int levels = std::clamp(static_cast<int>(finest), 1, kMostSgLevels);
  std::vector<float> sharpness;
  for (int i = 1; i <= levels; ++i) sharpness.push_back(std::exp2(static_cast<float>(i)));
  std::vector<Image> maps = {prefilter_diffuse(environment)};
  for (Image& map : prefilter_sg(environment, sharpness)) maps.push_back(std::move(map));
  maps.push_back(std::move(prefilter_ggx(environment, 2)[0]));
  return maps;
}

/// For every environment the same.
const Image& sg_albedos() {
  static const Image table = sg_albedo_table(kSgTableSize);
  return table;
}

class SgTables : public LookupTables {
 public:
  explicit SgTables(const Environment& environment)
      : maps_("SG maps", make_sg_maps(environment)),
        reflectance_(upload_table("reflectance", reflectance_table())),
        albedo_(upload_table("SG albedo", sg_albedos())) {}

  void update(MaterialStore& materials) override {
    fits_.update(materials.count(), [&](int slot, std::vector<glm::vec4>* texels) {
      const std::size_t begin = texels->size();
      const SgFit& fit = materials.sg(slot);
      const SgEnergy energy = fit_energy(fit, materials.albedo(slot));
      texels->emplace_back(energy.diffuse, 0.0f);
      for (const SgFit::Lobe& lobe : fit.lobes) {
        texels->emplace_back(lobe.amplitude, 0.0f);
        texels->emplace_back(lobe.sharpness, 0.0f);
      }
      texels->resize(begin + 7, glm::vec4(0.0f, 0.0f, 0.0f, 1.0f));
      for (const glm::vec3& factor : energy.view_factor) texels->emplace_back(factor, 0.0f);
    });
  }

  void bind() const override {
    maps_.bind(kUnitPrefilteredMaps);
    glBindTextureUnit(kUnitReflectance, reflectance_.get());
    fits_.bind();
    glBindTextureUnit(kUnitSgAlbedo, albedo_.get());
  }

  std::size_t bytes() const override { return maps_.bytes() + reflectance_.bytes() + albedo_.bytes() + fits_.bytes(); }

 private:
  PrefilteredMaps maps_;
  Texture reflectance_, albedo_;
  FitTable fits_{"SG fits"};
};

}  // namespace

std::unique_ptr<LookupTables> make_sg_tables(const Environment& environment) {
  return std::make_unique<SgTables>(environment);
}

}  // namespace maquette
