#include <algorithm>
#include <functional>
#include <span>
#include <string_view>

#include "scenes/brdf.h"
#include "scenes/brdf_models.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/suggest.h"

namespace maquette {

namespace {

constexpr double kCoatIndex = 1.5;  // polyurethane clear coat and acrylic lacquer: 1.48 to 1.52

// Complex indices at 650, 550 and 450 nm. Source: Rakic et al. 1998 (Al, Cr, Ti).
const glm::dvec3 kAluminiumEta(1.345, 0.965, 0.617), kAluminiumK(7.474, 6.400, 5.303);
const glm::dvec3 kChromiumEta(3.107, 3.181, 2.323), kChromiumK(3.331, 3.329, 3.135);
const glm::dvec3 kTitaniumEta(2.741, 2.542, 2.267), kTitaniumK(3.814, 3.435, 3.039);

struct Entry {
  BuiltinBrdf brdf;
  std::function<LayeredModel()> model;
};

/// Pigment in a binder under clear coat.
LayeredModel solid_paint(const glm::dvec3& pigment) {
  LayeredModel model;
  model.coat_index = kCoatIndex;
  model.diffuse = pigment;
  return model;
}

/// Aluminium flakes in tinted binder under clear coat: flat ones and tilted ones.
LayeredModel metallic_paint(const glm::dvec3& pigment, const glm::dvec3& tint, double coverage, double alpha) {
  LayeredModel model = solid_paint(pigment);
  model.flake_reflectance = conductor_curve(kAluminiumEta, kAluminiumK, kCoatIndex);
  model.flakes = {{alpha, 0.65 * coverage}, {2.2 * alpha, 0.35 * coverage}};
  model.flake_tint = tint;
  return model;
}

/// Interference flakes over a dark or white ground, under clear coat.
LayeredModel flop_paint(const glm::dvec3& ground, const ThinFilm& film, double coverage, double alpha) {
  LayeredModel model = solid_paint(ground);
  model.flake_reflectance = thin_film_curve(film);
  model.flakes = {{alpha, 0.7 * coverage}, {2.0 * alpha, 0.3 * coverage}};
  return model;
}

LayeredModel polymer(const glm::dvec3& diffuse, double alpha, double share, double sigma_rad = 0.0) {
  LayeredModel model;
  model.coat_index = 1.5;
  model.coat_alpha = alpha;
  model.coat_share = share;
  model.diffuse = diffuse;
  model.diffuse_sigma_rad = sigma_rad;
  return model;
}

LayeredModel cloth(const glm::dvec3& diffuse, double sigma_rad, const glm::dvec3& sheen, double sheen_roughness) {
  LayeredModel model;
  model.diffuse = diffuse;
  model.diffuse_sigma_rad = sigma_rad;
  model.sheen = sheen;
  model.sheen_roughness = sheen_roughness;
  return model;
}

LayeredModel bare_metal(const glm::dvec3& eta, const glm::dvec3& k, double alpha, double alpha_across,
                        const glm::dvec3& tint) {
  LayeredModel model;
  model.flakes = {{alpha, 1.0, alpha_across}};
  model.flake_reflectance = conductor_curve(eta, k, 1.0);
  for (glm::vec3& value : model.flake_reflectance) value *= glm::vec3(tint);
  return model;
}

const char* const kSolid =
    "Lambert pigment (interreflection: Saunderson 1942) under a GGX clear coat (n 1.5, alpha 0.012; Walter et al. "
    "2007)";
const char* const kMetallic =
    "two GGX lobes of aluminium flakes (Rakic et al. 1998) in tinted binder (Beer-Lambert) seen by refraction through "
    "a GGX clear "
    "coat (n 1.5, alpha 0.012); layering: Weidlich and Wilkie 2007, car paint: Ershov et al. 2001";
const char* const kFlop =
    "two GGX lobes of thin-film flakes (Airy sum over the spectrum; Gondek et al. 1994) seen by refraction through a "
    "GGX clear coat "
    "(n 1.5, alpha 0.012); layering: Weidlich and Wilkie 2007";
const char* const kPolymer =
    "Lambert or Oren-Nayar 1994 body under a rough GGX dielectric surface (n 1.5; Walter et al. 2007)";
const char* const kCloth = "Oren-Nayar 1994 body with the fibre sheen of Estevez and Kulla 2017";
const char* const kMetal = "GGX facets (Walter et al. 2007) with exact conductor Fresnel (Rakic et al. 1998)";

std::vector<Entry> make_entries() {
  using V = glm::dvec3;
  std::vector<Entry> e;
  const auto add = [&](const char* name, const char* label, const std::string& model,
                       std::function<LayeredModel()> make) {
    e.push_back({{name, label, model}, std::move(make)});
  };
  add("paint-solid-red", "Solid red paint", kSolid, [] { return solid_paint(V(0.58, 0.022, 0.018)); });
  add("paint-solid-white", "Solid white paint", kSolid, [] { return solid_paint(V(0.86, 0.86, 0.83)); });
  add("paint-red-metallic", "Red metallic paint", kMetallic,
      [] { return metallic_paint(V(0.30, 0.006, 0.006), V(0.76, 0.022, 0.02), 0.6, 0.24); });
  add("paint-blue-metallic", "Blue metallic paint", kMetallic,
      [] { return metallic_paint(V(0.004, 0.012, 0.06), V(0.035, 0.13, 0.52), 0.55, 0.25); });
  add("paint-silver-metallic", "Silver metallic paint", kMetallic,
      [] { return metallic_paint(V(0.12, 0.12, 0.125), V(0.88, 0.89, 0.90), 0.75, 0.22); });
  add("paint-black-metallic", "Black metallic paint", kMetallic,
      [] { return metallic_paint(V(0.006, 0.006, 0.007), V(0.55, 0.57, 0.60), 0.12, 0.28); });
  add("paint-pearl-white", "Pearl white paint", kFlop + std::string("; white ground, titania film of 145 nm on mica"),
      [] {
        LayeredModel model = flop_paint(V(0.88, 0.87, 0.84), {2.3, 145.0, 0.3, -0.3, kCoatIndex}, 0.6, 0.2);
        model.flake_transmission = 0.7;
        return model;
      });
  add("paint-flop-green-violet", "Green to violet flop paint",
      kFlop + std::string("; dark ground, magnesium fluoride film (n 1.38) of 380 nm in metal flakes"), [] {
        return flop_paint(V(0.004, 0.004, 0.006), {1.38, 380.0, 0.5, 0.5, kCoatIndex}, 0.75, 0.22);
      });
  add("paint-flop-gold-red", "Red to gold flop paint",
      kFlop + std::string("; dark ground, magnesium fluoride film (n 1.38) of 465 nm in metal flakes, yellow binder"),
      [] {
        LayeredModel model = flop_paint(V(0.006, 0.004, 0.003), {1.38, 465.0, 0.5, 0.5, kCoatIndex}, 0.75, 0.22);
        model.flake_tint = V(1.0, 0.85, 0.25);
        return model;
      });
  add("leather-black", "Black leather", kPolymer, [] { return polymer(V(0.032, 0.030, 0.029), 0.36, 0.75, 0.35); });
  add("leather-tan", "Tan leather", kPolymer, [] { return polymer(V(0.42, 0.21, 0.095), 0.36, 0.75, 0.35); });
  add("fabric-grey", "Grey fabric", kCloth, [] { return cloth(V(0.17, 0.17, 0.175), 0.5, V(0.05), 0.35); });
  add("plastic-matte-black", "Matte black plastic", kPolymer, [] { return polymer(V(0.028), 0.42, 0.9); });
  add("plastic-matte-grey", "Matte grey plastic", kPolymer, [] { return polymer(V(0.24, 0.24, 0.245), 0.42, 0.9); });
  add("plastic-piano-black", "Piano black plastic", kPolymer, [] { return polymer(V(0.004), 0.012, 1.0); });
  add("metal-brushed", "Brushed aluminium",
      kMetal + std::string(", alpha 0.07 along and 0.30 across, azimuths mixed (Heitz 2014)"),
      [] { return bare_metal(kAluminiumEta, kAluminiumK, 0.07, 0.30, V(0.86)); });
  add("metal-chrome", "Chrome", kMetal + std::string(", alpha 0.01"),
      [] { return bare_metal(kChromiumEta, kChromiumK, 0.01, 0.0, V(1.0)); });
  add("metal-gunmetal", "Gunmetal", kMetal + std::string(", titanium darkened by its oxide, alpha 0.2"),
      [] { return bare_metal(kTitaniumEta, kTitaniumK, 0.2, 0.0, V(0.36, 0.38, 0.42)); });
  add("rubber-black", "Black rubber", kPolymer, [] { return polymer(V(0.022), 0.55, 0.6, 0.4); });
  add("carpet-charcoal", "Charcoal carpet", kCloth, [] { return cloth(V(0.032, 0.032, 0.034), 0.7, V(0.025), 0.5); });
  add("wood-satin", "Satin wood", kPolymer, [] { return polymer(V(0.30, 0.145, 0.062), 0.14, 1.0); });
  add("matte-white", "Matte white", "Lambert, albedo 0.8", [] { return cloth(V(0.8), 0.0, V(0.0), 0.5); });
  return e;
}

const std::vector<Entry>& entries() {
  static const std::vector<Entry> kEntries = make_entries();
  return kEntries;
}

}  // namespace

const std::vector<BuiltinBrdf>& builtin_brdfs() {
  static const std::vector<BuiltinBrdf> kBrdfs = [] {
    std::vector<BuiltinBrdf> brdfs;
    for (const Entry& entry : entries()) brdfs.push_back(entry.brdf);
    return brdfs;
  }();
  return kBrdfs;
}

BrdfTable make_builtin_brdf(const std::string& name) {
  for (const Entry& entry : entries()) {
    if (entry.brdf.name != name) continue;
    BrdfTable table;
    table.name = name;
    table.rgb = tabulate_model(entry.model());
    table.hash = content_hash(std::as_bytes(std::span(table.rgb)));
    return table;
  }
  std::vector<std::string> names;
  for (const Entry& entry : entries()) names.push_back(entry.brdf.name);
  throw UsageError("builtin:" + name, "there is no such built-in material", did_you_mean(name, names));
}

BrdfTable load_brdf(const std::string& source) {
  constexpr std::string_view kPrefix = "builtin:";
  if (source.starts_with(kPrefix)) return make_builtin_brdf(source.substr(kPrefix.size()));
  return load_merl(source);
}

}  // namespace maquette
