#include "render/materials/material_store.h"

#include <algorithm>
#include <cmath>

#include "render/btf/btf_source.h"
#include "render/gl/bindings.h"
#include "render/materials/lobes.h"
#include "render/math/shared_formulas.h"
#include "scenes/luminance.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr int kBrdfBias = 20;  // as in shaders/shading/point.glsl
constexpr std::size_t kThetaTexels = static_cast<std::size_t>(kElevationCount) * kThetaCellCount;
constexpr std::size_t kPhiTexels = kThetaTexels * kPhiCellCount;

std::vector<std::uint32_t> pack(const BrdfTable& brdf) {
  std::vector<std::uint32_t> words(brdf.rgb.size());
  parallel_ranges<std::size_t>(0, words.size(), 16200, [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) words[i] = shared::pack_rgb9e5(brdf.rgb[i], kBrdfBias);
  });
  return words;
}

/// A larger buffer with the contents of `old`.
Buffer grow(const std::string& label, const Buffer& old, std::size_t bytes) {
  Buffer buffer(label, bytes);
  if (old) glCopyNamedBufferSubData(old.get(), buffer.get(), 0, 0, static_cast<GLsizeiptr>(old.bytes()));
  return buffer;
}

}  // namespace

float effective_solid_angle(const BrdfTables& tables, int elevation) {
  const double theta_o = (elevation + 0.5) / kElevationCount * 1.5707963267948966;
  double integral = 0.0;
  for (int k = 0; k < kThetaCellCount; ++k) {
    const std::size_t cell = static_cast<std::size_t>(elevation * kThetaCellCount + k);
    const glm::vec2 t = tables.theta_cells[cell];
    const double mass =
        k < 32 ? 1.0 / 64.0 : 0.5 * std::exp2(-(k - 32) / 8.0) * (k == 95 ? 1.0 : 1.0 - std::exp2(-0.125));
    for (int j = 0; j < kPhiCellCount; ++j) {
      const glm::vec2 phi = tables.phi_cells[cell * kPhiCellCount + static_cast<std::size_t>(j)];
      const double part = mass / kPhiCellCount;
      const double area = 2.0 * (t.y - t.x) * (phi.y - phi.x) * 4.0 * std::max(std::cos(theta_o), 0.2);
      if (area > 1e-14) integral += part * part / area;
    }
  }
  return static_cast<float>(1.0 / std::max(integral, 1e-9));
}

void MaterialStore::reserve(std::size_t slots) {
  if (slots <= capacity_) return;
  capacity_ = std::max(slots, capacity_ + capacity_ / 2);
  words_ = grow("BRDF tables", words_, capacity_ * kBrdfEntryCount * 4);
  theta_ = grow("theta cells", theta_, capacity_ * kThetaTexels * sizeof(glm::vec2));
  phi_ = grow("phi cells", phi_, capacity_ * kPhiTexels * sizeof(glm::vec2));
  albedo_ = grow("albedo", albedo_, capacity_ * kAlbedoCount * sizeof(float));
  bandwidth_ = grow("BRDF bandwidth", bandwidth_, capacity_ * 8100 * sizeof(float));
  lobes_ = grow("BRDF lobes", lobes_, capacity_ * kAlbedoCount * 4 * sizeof(glm::vec4));
  word_view_ = Texture::make_buffer("BRDF tables", GL_R32UI, words_);
  lobe_view_ = Texture::make_buffer("BRDF lobes", GL_RGBA32F, lobes_);
  theta_view_ = Texture::make_buffer("theta cells", GL_RG32F, theta_);
  phi_view_ = Texture::make_buffer("phi cells", GL_RG32F, phi_);
  albedo_view_ = Texture::make_buffer("albedo", GL_R32F, albedo_);
  bandwidth_view_ = Texture::make_buffer("BRDF bandwidth", GL_R32F, bandwidth_);
}

int MaterialStore::slot_of(const std::string& source) {
  const std::uint64_t stamp = material_source_stamp(source);
  for (std::size_t i = 0; i < entries_.size(); ++i)
    if (entries_[i].source == source && entries_[i].stamp == stamp) return static_cast<int>(i);
  const BrdfTable brdf = load_material_table(source);
  const BrdfTables tables = load_brdf_tables(brdf);
  const std::size_t slot = entries_.size();
  reserve(slot + 1);
  const auto words = pack(brdf);
  words_.update(slot * kBrdfEntryCount * 4, words.size() * 4, words.data());
  theta_.update(slot * kThetaTexels * sizeof(glm::vec2), tables.theta_cells.size() * sizeof(glm::vec2),
                tables.theta_cells.data());
  phi_.update(slot * kPhiTexels * sizeof(glm::vec2), tables.phi_cells.size() * sizeof(glm::vec2),
              tables.phi_cells.data());
  std::vector<float> albedo;
  for (const glm::vec3& a : tables.albedo) albedo.push_back(luminance(a));
  albedo_.update(slot * kAlbedoCount * sizeof(float), albedo.size() * sizeof(float), albedo.data());
  bandwidth_.update(slot * 8100 * sizeof(float), tables.bandwidth.size() * sizeof(float), tables.bandwidth.data());
  const std::vector<BrdfLobe> rows = compute_lobes(brdf, tables);
  const float roughness = mirror_roughness(rows);
  std::vector<glm::vec4> lobes;  // layout of shaders/shading/lobes.glsl
  for (std::size_t i = 0; i < rows.size(); ++i) {
    lobes.emplace_back(tables.albedo[i], roughness);
    lobes.emplace_back(rows[i].direction, 0.0f);
    lobes.emplace_back(rows[i].mirror_albedo, rows[i].mirror_half_angle_rad);
    lobes.emplace_back(rows[i].mirror_direction, 0.0f);
  }
  lobes_.update(slot * lobes.size() * sizeof(glm::vec4), lobes.size() * sizeof(glm::vec4), lobes.data());
  Entry entry;
  entry.source = source;
  entry.stamp = stamp;
  entry.hash = brdf.hash;
  entry.albedo = tables.albedo;
  entry.bandwidth_limit = *std::max_element(tables.bandwidth.begin(), tables.bandwidth.end());
  entry.lobe_sr = effective_solid_angle(tables, 12);
  entry.roughness = roughness;
  entries_.push_back(std::move(entry));
  return static_cast<int>(slot);
}

float MaterialStore::brdf_share(int slot, float environment_sr) const {
  const float lobe = std::sqrt(entries_[static_cast<std::size_t>(slot)].lobe_sr);
  const float light = std::sqrt(std::max(environment_sr, 1e-6f));
  // A sun may dominate the density of the lights; at least half of the samples of a narrow lobe follow the BRDF.
  return std::clamp(light / (light + lobe), lobe < 0.15f ? 0.5f : 0.2f, 0.75f);
}

BrdfTable MaterialStore::read_table(std::size_t slot) const {
  std::vector<std::uint32_t> words(kBrdfEntryCount);
  words_.read(slot * kBrdfEntryCount * 4, words.size() * 4, words.data());
  BrdfTable brdf;
  brdf.name = entries_[slot].source;
  brdf.hash = entries_[slot].hash;
  brdf.rgb.resize(words.size());
  parallel_ranges<std::size_t>(0, words.size(), 16200, [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) brdf.rgb[i] = shared::unpack_rgb9e5(words[i], kBrdfBias);
  });
  return brdf;
}

const GgxFit& MaterialStore::ggx(int slot) {
  const auto i = static_cast<std::size_t>(slot);
  if (!entries_[i].has_ggx) entries_[i].ggx = fit_ggx(read_table(i));
  entries_[i].has_ggx = true;
  return entries_[i].ggx;
}

const SgFit& MaterialStore::sg(int slot) {
  const auto i = static_cast<std::size_t>(slot);
  if (!entries_[i].has_sg) entries_[i].sg = fit_sg(read_table(i));
  entries_[i].has_sg = true;
  return entries_[i].sg;
}

const LobeBound& MaterialStore::lobe_bound(int slot) {
  const auto i = static_cast<std::size_t>(slot);
  if (!entries_[i].has_bound) {
    const BrdfTable table = read_table(i);
    entries_[i].bound = make_lobe_bound([&](const glm::vec3& wi, const glm::vec3& wo) {
      const glm::dvec3 f = evaluate_brdf(table, wi, wo);
      return static_cast<float>(std::max({f.x, f.y, f.z}));
    });
  }
  entries_[i].has_bound = true;
  return entries_[i].bound;
}

void MaterialStore::bind() const {
  glBindTextureUnit(kUnitBrdf, word_view_.get());
  glBindTextureUnit(kUnitThetaCells, theta_view_.get());
  glBindTextureUnit(kUnitPhiCells, phi_view_.get());
  glBindTextureUnit(kUnitAlbedo, albedo_view_.get());
  glBindTextureUnit(kUnitBrdfBandwidth, bandwidth_view_.get());
  glBindTextureUnit(kUnitLobes, lobe_view_.get());
}

}  // namespace maquette
