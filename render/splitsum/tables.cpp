#include "render/splitsum/tables.h"

#include "render/environment/prefilter.h"
#include "render/gl/bindings.h"
#include "render/prefilter/prefiltered_maps.h"
#include "render/prefilter/reflectance_tables.h"
#include "render/splitsum/fit.h"

namespace maquette {

namespace {

constexpr int kGgxLevels = 17;  // as in shaders/splitsum/shade.comp
constexpr int kTableSize = 64;

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
        reflectance_(reflectance_table(kTableSize)),
        table_(upload_table("reflectance", reflectance_)) {}

  void update(MaterialStore& materials) override {
    if (materials.count() == fitted_) return;
    for (std::size_t slot = fitted_; slot < materials.count(); ++slot) {
      const int s = static_cast<int>(slot);
      const SplitsumFit fit = fit_energy(materials.ggx(s), materials.albedo(s), reflectance_);
      fit_texels_.emplace_back(fit.diffuse, fit.alpha);
      fit_texels_.emplace_back(fit.f0, 0.0f);
      fit_texels_.emplace_back(fit.f90, 0.0f);
    }
    fits_ = Buffer::from("GGX fits", fit_texels_);
    fit_view_ = Texture::make_buffer("GGX fits", GL_RGBA32F, fits_);
    fitted_ = materials.count();
  }

  void bind() const override {
    maps_.bind(kUnitPrefilteredMaps);
    glBindTextureUnit(kUnitReflectance, table_.get());
    if (fit_view_) glBindTextureUnit(kUnitLobeFits, fit_view_.get());
  }

  std::size_t bytes() const override { return maps_.bytes() + table_.bytes() + fits_.bytes(); }

 private:
  PrefilteredMaps maps_;
  Image reflectance_;
  Texture table_;
  std::vector<glm::vec4> fit_texels_;  ///< three a slot
  Buffer fits_;
  Texture fit_view_;
  std::size_t fitted_ = 0;
};

}  // namespace

std::unique_ptr<LookupTables> make_splitsum_tables(const Environment& environment) {
  return std::make_unique<SplitsumTables>(environment);
}

}  // namespace maquette
