#include "render/slf/buffers.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>

#include "render/gl/bindings.h"
#include "render/math/shared_formulas.h"
#include "render/slf/direction_spline.h"
#include "scenes/error.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr float kLargestStored = 1024.0f;  ///< well within half floats

float largest_of(const LightField& field) {
  float largest = 0.0f;
  if (field.interactions) {
    largest = field.interactions->table.cwiseAbs().maxCoeff();
  } else if (field.compressed()) {
    for (int k = 0; k < field.fit.pca.cluster_count(); ++k)
      largest = std::max(largest, field.fit.pca.mean(k).cwiseAbs().maxCoeff());
    if (field.fit.weights.size() > 0) largest = std::max(largest, field.fit.weights.cwiseAbs().maxCoeff());
  } else if (field.outgoing && field.outgoing->radiance.size() > 0) {
    largest = field.outgoing->radiance.maxCoeff();
  }
  return largest;
}

/// Clusters side by side, as in shaders/slf/light_field.glsl.
constexpr int kLumisphereColumns = 16;

/// The splines at the texels of a tile: of lumisphere_table_side and a border of one.
std::vector<std::array<DirectionSpline::Share, 9>> table_of_splines(const Lumisphere& sphere) {
  const int fine = lumisphere_table_side(sphere.side());
  const auto side = static_cast<float>(sphere.side());
  const float step = side / static_cast<float>(fine);
  const auto at = [&](int i) { return std::clamp((static_cast<float>(i) + 0.5f) * step, 0.0f, side); };
  std::vector<std::array<DirectionSpline::Share, 9>> table;
  for (int y = -1; y <= fine; ++y)
    for (int x = -1; x <= fine; ++x) table.push_back(DirectionSpline::shares_at(sphere, {at(x), at(y)}, step));
  return table;
}

}  // namespace

LightFieldBuffers::LightFieldBuffers(const LightField& field, std::size_t triangles) {
  const float largest = largest_of(field);
  scale_ = largest > 0.0f ? largest / kLargestStored : 1.0f;
  upload_sides(field, triangles);
  if (field.atlas.side == 0) return;
  if (field.interactions) {
    upload_interactions(field);
    return;
  }
  upload_codes(field);
  if (field.compressed())
    upload_lumispheres(field);
  else
    upload_stored(field);
}

void LightFieldBuffers::upload_sides(const LightField& field, std::size_t triangles) {
  std::vector<std::uint32_t> slots(2 * std::max<std::size_t>(triangles, 1), 0u);
  const float components = field.compressed() ? static_cast<float>(field.fit.weights.rows()) : 0.0f;
  std::vector<glm::vec4> sides{
      glm::vec4(scale_, static_cast<float>(field.side), components, field.compressed() ? 1.0f : 0.0f),
      glm::vec4(static_cast<float>(std::max(field.atlas.side, 1)), 0.0f, 0.0f, 0.0f)};
  if (const InteractionCodes* i = field.interactions ? &field.interactions->codes : nullptr)
    sides[1] = glm::vec4(sides[1].x, static_cast<float>(i->light_terms), static_cast<float>(i->material_terms),
                         static_cast<float>(i->material_clusters));
  for (std::size_t s = 0; s < field.atlas.sides.size(); ++s) {
    const AtlasSide& side = field.atlas.sides[s];
    slots[2 * static_cast<std::size_t>(side.triangle) + (side.back ? 1 : 0)] = static_cast<std::uint32_t>(s + 1);
    sides.emplace_back(side.at[0], side.at[1]);
    sides.emplace_back(side.at[2], static_cast<float>(side.chart), 0.0f);
    sides.emplace_back(field.atlas.axes[side.chart], 0.0f);
  }
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &largest);
  if (std::max(slots.size(), sides.size()) > static_cast<std::size_t>(largest))
    throw Error("surface light field",
                std::to_string(field.atlas.sides.size()) + " triangles are more than this driver can address",
                "choose fewer parts (slf.parts)");
  slots_ = Buffer::from("light field slots", slots);
  sides_ = Buffer::from("light field sides", sides);
  slot_view_ = Texture::make_buffer("light field slots", GL_R32UI, slots_);
  side_view_ = Texture::make_buffer("light field sides", GL_RGBA32F, sides_);
}

void LightFieldBuffers::upload_codes(const LightField& field) {
  const int side = field.atlas.side;
  const std::size_t cells = field.atlas.texel_of_cell.size();
  std::vector<std::uint16_t> errors(cells, 0);
  std::vector<std::uint8_t> clusters(cells, 0);
  const Eigen::Index components = field.compressed() ? field.fit.weights.rows() : 0;
  const int layers = std::max(static_cast<int>((components + 3) / 4), 1);
  std::vector<std::uint64_t> weights(field.compressed() ? cells * static_cast<std::size_t>(layers) : 0, 0);
  for (std::size_t c = 0; c < cells; ++c) {
    const std::uint32_t t = field.atlas.texel_of_cell[c];
    if (t == LightFieldAtlas::kNone) continue;
    errors[c] = glm::packHalf1x16(field.errors[t]);
    if (!field.compressed()) continue;
    clusters[c] = static_cast<std::uint8_t>(field.fit.owner[t]);
    for (int l = 0; l < layers; ++l) {
      glm::vec4 four(0.0f);
      for (int k = 0; k < 4 && 4 * l + k < components; ++k) four[k] = field.fit.weights(4 * l + k, t) / scale_;
      weights[static_cast<std::size_t>(l) * cells + c] = glm::packHalf4x16(four);
    }
  }
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  upload_clusters(field, clusters);
  errors_ = Texture::make_2d("light field errors", GL_R16F, side, side);
  errors_.upload(0, side, side, GL_RED, GL_HALF_FLOAT, errors.data());
  if (!field.compressed()) return;
  weights_ = Texture::make_2d_array("light field weights", GL_RGBA16F, side, side, layers);
  weights_.set_filter(GL_LINEAR, GL_LINEAR);
  for (int l = 0; l < layers; ++l)
    glTextureSubImage3D(weights_.get(), 0, 0, 0, l, side, side, 1, GL_RGBA, GL_HALF_FLOAT,
                        weights.data() + static_cast<std::size_t>(l) * cells);
}

void LightFieldBuffers::upload_clusters(const LightField& field, const std::vector<std::uint8_t>& clusters) {
  const FlatGeometry& geometry = *field.made_from.incident.geometry;
  std::vector<std::uint32_t> cells(clusters.size(), 0u);
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const std::uint32_t t = field.atlas.texel_of_cell[c];
    if (t == LightFieldAtlas::kNone) continue;
    const glm::vec3 n = frame_of_texel(geometry, field.atlas, t).n;
    const glm::uvec2 normal(glm::round(shared::octahedral_from_direction(n) * 4095.0f));
    cells[c] = clusters[c] | normal.x << 8u | normal.y << 20u;
  }
  clusters_ = Texture::make_2d("light field clusters and normals", GL_R32UI, field.atlas.side, field.atlas.side);
  clusters_.upload(0, field.atlas.side, field.atlas.side, GL_RED_INTEGER, GL_UNSIGNED_INT, cells.data());
}

void LightFieldBuffers::upload_lumispheres(const LightField& field) {
  const Lumisphere sphere(field.side);
  const auto table = table_of_splines(sphere);
  const int tile = lumisphere_table_side(field.side) + 2, count = field.fit.pca.cluster_count();
  const int terms = static_cast<int>(field.fit.weights.rows()) + 1;
  const int width = kLumisphereColumns * tile, height = (count + kLumisphereColumns - 1) / kLumisphereColumns * tile;
  const std::size_t layer = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  std::vector<std::uint64_t> texels(layer * static_cast<std::size_t>(terms), 0);
  parallel_for(0, count, [&](int k) {
    Eigen::MatrixXf values(3 * sphere.count(), terms), sum(3, terms);
    values.col(0) = field.fit.pca.mean(k) / scale_;
    if (terms > 1) values.rightCols(terms - 1) = field.fit.pca.components(k);
    const int left = k % kLumisphereColumns * tile, top = k / kLumisphereColumns * tile;
    for (int i = 0; i < tile * tile; ++i) {
      sum.setZero();
      for (const DirectionSpline::Share& share : table[static_cast<std::size_t>(i)])
        sum += share.weight * values.middleRows(3 * share.bin, 3);
      const std::size_t at = static_cast<std::size_t>(top + i / tile) * static_cast<std::size_t>(width) +
                             static_cast<std::size_t>(left + i % tile);
      for (int term = 0; term < terms; ++term)
        texels[static_cast<std::size_t>(term) * layer + at] =
            glm::packHalf4x16({sum(0, term), sum(1, term), sum(2, term), 0.0f});
    }
  });
  lumispheres_ = Texture::make_2d_array("light field lumispheres", GL_RGBA16F, width, height, terms);
  glTextureSubImage3D(lumispheres_.get(), 0, 0, 0, 0, width, height, terms, GL_RGBA, GL_HALF_FLOAT, texels.data());
  lumispheres_.set_filter(GL_LINEAR, GL_LINEAR);
}

void LightFieldBuffers::upload_coefficients(const char* name, const Eigen::MatrixXf& columns, int side) {
  const Lumisphere sphere(side);
  const auto cells = static_cast<std::size_t>(side * side);
  std::vector<std::uint64_t> words(cells * static_cast<std::size_t>(columns.cols()));
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &largest);
  if (words.size() > static_cast<std::size_t>(largest))
    throw Error("surface light field", std::to_string(words.size()) + " values are more than this driver can address",
                "compress them: --set slf.clusters=128");
  std::vector<Eigen::Index> rows;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) rows.push_back(3 * sphere.bin_near_cell(x, y));
  for (Eigen::Index t = 0; t < columns.cols(); ++t)
    for (std::size_t c = 0; c < cells; ++c)
      words[static_cast<std::size_t>(t) * cells + c] = glm::packHalf4x16(
          glm::vec4(columns(rows[c], t), columns(rows[c] + 1, t), columns(rows[c] + 2, t), 0.0f) / scale_);
  radiance_ = Buffer::from(name, words);
  radiance_view_ = Texture::make_buffer(name, GL_RG32UI, radiance_);
}

void LightFieldBuffers::upload_interactions(const LightField& field) {
  const InteractionCodes& i = field.interactions->codes;
  upload_coefficients("light field table", field.interactions->table, field.side);
  const int side = field.atlas.side, light_layers = (i.light_terms + 2) / 4;
  const std::size_t cells = field.atlas.texel_of_cell.size();
  std::vector<std::uint32_t> codes(cells, 0);
  std::vector<std::uint64_t> weights(cells * static_cast<std::size_t>(light_layers + i.material_terms), 0);
  for (std::size_t c = 0; c < cells; ++c) {
    const std::uint32_t t = field.atlas.texel_of_cell[c];
    if (t == LightFieldAtlas::kNone) continue;
    const BtfTurn& turn = i.turns[t];
    codes[c] = static_cast<std::uint32_t>(i.light_cluster[t]) |
               static_cast<std::uint32_t>(i.material_cluster[t]) << 8u | static_cast<std::uint32_t>(turn.step) << 16u |
               (turn.mirrored ? 1u << 24u : 0u);
    for (int l = 0; l < light_layers + i.material_terms; ++l) {
      glm::vec4 four(0.0f);
      const int term = l - light_layers;
      for (int k = 0; k < 4; ++k) {
        if (term >= 0 && k < 3) four[k] = i.material_weights(3 * term + k, t);
        if (term < 0 && 4 * l + k < i.light_weights.rows()) four[k] = i.light_weights(4 * l + k, t);
      }
      weights[static_cast<std::size_t>(l) * cells + c] = glm::packHalf4x16(four);
    }
  }
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  cells_ = Texture::make_2d("light field codes", GL_R32UI, side, side);
  cells_.upload(0, side, side, GL_RED_INTEGER, GL_UNSIGNED_INT, codes.data());
  weights_ = Texture::make_2d_array("light field weights", GL_RGBA16F, side, side, light_layers + i.material_terms);
  for (int l = 0; l < light_layers + i.material_terms; ++l)
    glTextureSubImage3D(weights_.get(), 0, 0, 0, l, side, side, 1, GL_RGBA, GL_HALF_FLOAT,
                        weights.data() + static_cast<std::size_t>(l) * cells);
  std::vector<std::uint8_t> clusters(cells);
  std::transform(codes.begin(), codes.end(), clusters.begin(), [](std::uint32_t code) { return code & 255u; });
  upload_clusters(field, clusters);
  errors_ = Texture::make_2d("light field errors", GL_R16F, side, side);
}

void LightFieldBuffers::upload_stored(const LightField& field) {
  upload_coefficients("light field radiance", field.outgoing->radiance, field.side);
  std::vector<std::uint32_t> texels = field.atlas.texel_of_cell;
  std::replace(texels.begin(), texels.end(), LightFieldAtlas::kNone, 0u);
  cells_ = Texture::make_2d("light field cells", GL_R32UI, field.atlas.side, field.atlas.side);
  cells_.upload(0, field.atlas.side, field.atlas.side, GL_RED_INTEGER, GL_UNSIGNED_INT, texels.data());
}

void LightFieldBuffers::bind() const {
  glBindTextureUnit(kUnitLightFieldSlots, slot_view_.get());
  glBindTextureUnit(kUnitLightFieldSides, side_view_.get());
  glBindTextureUnit(kUnitLightFieldClusters, clusters_.get());
  glBindTextureUnit(kUnitLightFieldWeights, weights_.get());
  glBindTextureUnit(kUnitLightFieldLumispheres, lumispheres_.get());
  glBindTextureUnit(kUnitLightFieldCells, cells_.get());
  glBindTextureUnit(kUnitLightFieldRadiance, radiance_view_.get());
  glBindTextureUnit(kUnitLightFieldErrors, errors_.get());
}

std::size_t LightFieldBuffers::bytes() const {
  return slots_.bytes() + sides_.bytes() + radiance_.bytes() + clusters_.bytes() + weights_.bytes() +
         lumispheres_.bytes() + cells_.bytes() + errors_.bytes();
}

}  // namespace maquette
