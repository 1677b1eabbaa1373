#include "render/bandwidth/accumulation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "render/environment/environment_buffers.h"
#include "render/gl/bindings.h"
#include "render/math/shared_formulas.h"
#include "render/views/read_texture.h"

namespace maquette {

namespace {

const ShaderVariant kMeasure{"bandwidth/measure.comp", "", {}},
    kInterpolationError{"bandwidth/interpolation_error.comp", "", {}},
    kResetPoints{"bandwidth/reset_points.comp", "", {}};

/// Share of the mean deviation that every point gets on top of its own.
constexpr float kLeastShare = 0.1f;
/// A frame adds this share of the samples so far, so that what was measured is soon put to use; but no less and no more
/// than these shares of the grid's base count, because what a frame costs besides its samples grows with the grid.
constexpr double kGrowth = 0.6, kLeastFrameShare = 0.15, kMostFrameShare = 0.5;
/// Share of all items that points which used up the list of light samples have, from which on it is theirs.
constexpr double kHungryShare = 0.25;

constexpr int kRates = 8;                    // as shaders/bandwidth/interpolation_error.comp
constexpr double kRateStep = 1.41421356237;  // the same

/// The rate at which `wanted` items come together, between those that were tried: the sum is convex in the rate.
double rate_for(double wanted, double first_rate, const std::array<double, kRates>& items) {
  double rate = first_rate;
  for (int k = 0; k + 1 < kRates; ++k, rate *= kRateStep) {
    const auto i = static_cast<std::size_t>(k);
    if (items[i + 1] < wanted) continue;
    const double t = (wanted - items[i]) / std::max(items[i + 1] - items[i], 1e-9);
    return rate * (1.0 + std::clamp(t, 0.0, 1.0) * (kRateStep - 1.0));
  }
  return rate;
}

std::vector<glm::vec4> read_all(const Buffer& buffer) {
  std::vector<glm::vec4> values(buffer.bytes() / sizeof(glm::vec4));
  buffer.read(0, buffer.bytes(), values.data());
  return values;
}

/// Before the first measurement the prediction is believed: what it filled is as good there as it can be.
float believed_kappa(int layer) { return layer % shared::kClasses == 1 ? 0.0f : shared::kNeverInterpolate; }

}  // namespace

std::vector<float> Accumulation::typical_kappas() const {
  const std::size_t layers = static_cast<std::size_t>(shared::kClasses * levels_);
  const std::size_t tiles =
      static_cast<std::size_t>(residuals_.width()) * static_cast<std::size_t>(residuals_.height());
  std::vector<glm::vec4> measured(tiles * (layers + shared::kClasses));
  glGetTextureImage(residuals_.get(), 0, GL_RGBA, GL_FLOAT, static_cast<GLsizei>(measured.size() * sizeof(glm::vec4)),
                    measured.data());
  std::vector<float> typical, of_tiles;
  for (std::size_t layer = 0; layer < layers; ++layer) {
    of_tiles.clear();
    for (std::size_t i = layer * tiles; i < (layer + 1) * tiles; ++i)
      if (measured[i].w > 0.0f && measured[i].z > 0.0f)
        of_tiles.push_back((measured[i].x - measured[i].y) / measured[i].z);
    typical.push_back(believed_kappa(static_cast<int>(layer)));
    if (of_tiles.empty()) continue;
    const auto middle = of_tiles.begin() + static_cast<std::ptrdiff_t>(of_tiles.size() / 2);
    std::nth_element(of_tiles.begin(), middle, of_tiles.end());
    typical.back() = std::max(*middle, 0.0f);
  }
  return typical;
}

std::vector<ShaderVariant> Accumulation::shader_variants() { return {kMeasure, kInterpolationError, kResetPoints}; }

Accumulation::Accumulation(const GridSize& size, std::size_t tile_count, int levels, bool textures)
    : levels_(levels), spread_format_(textures ? GL_RG32F : GL_R32F) {
  const int w = size.grid_width(), h = size.grid_height();
  const int tiles_x = group_count(w, kTileSide), tiles_y = group_count(h, kTileSide);
  mean_ = Texture::make_2d("accumulated mean", GL_RGBA32F, w, h);
  spread_ = Texture::make_2d("accumulated spread", spread_format_, w, h);
  deviation_ = Texture::make_2d("measured deviation", GL_R32F, w, h);
  residual_ = Texture::make_2d("interpolation residual", GL_R32F, w, h);
  const int layers = shared::kClasses * (levels + 1);  // the coarsest level is never interpolated
  residuals_ = Texture::make_2d_array("interpolation residuals", GL_RGBA32F, tiles_x, tiles_y, layers);
  worth_ = Texture::make_2d_array("interpolation worth", GL_RG32F, tiles_x, tiles_y, layers);
  sums_ = Buffer("sums of deviations", tile_count * 2 * sizeof(glm::vec4));
  clear();
}

void Accumulation::clear() {
  const float zero[4] = {}, none[4] = {-1.0f, -1.0f, -1.0f, -1.0f};
  glClearTexImage(mean_.get(), 0, GL_RGBA, GL_FLOAT, zero);
  glClearTexImage(spread_.get(), 0, GL_RGBA, GL_FLOAT, zero);
  glClearTexImage(deviation_.get(), 0, GL_RED, GL_FLOAT, zero);
  glClearTexImage(residual_.get(), 0, GL_RED, GL_FLOAT, none);
  glClearTexImage(residuals_.get(), 0, GL_RGBA, GL_FLOAT, zero);  // tiles without surfaces stay so
  for (int layer = 0; layer < shared::kClasses * (levels_ + 1); ++layer) {
    const float unmeasured[2] = {believed_kappa(layer), 1.0f};
    glClearTexSubImage(worth_.get(), 0, 0, 0, layer, worth_.width(), worth_.height(), 1, GL_RG, GL_FLOAT, unmeasured);
  }
  rate_ = rounds_ = 0.0;
}

void Accumulation::forget(const TileList& tiles, ProgramCache* programs) {
  glBindImageTexture(kImageForgottenMean, mean_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(kImageForgottenSpread, spread_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, spread_format_);
  glBindImageTexture(kImageForgottenDeviation, deviation_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  glBindImageTexture(kImageForgottenResidual, residual_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  dispatch_tiles(programs->get(kResetPoints), tiles, kPerPoint);
  rate_ = 0.0;
}

void Accumulation::bind_for_gathering() const {
  glBindImageTexture(kImageMean, mean_.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  glBindImageTexture(kImageSpread, spread_.get(), 0, GL_FALSE, 0, GL_READ_WRITE, spread_format_);
}

void Accumulation::bind_for_marking() const { glBindTextureUnit(kUnitSpread, spread_.get()); }

void Accumulation::bind_for_filling() const {
  glBindTextureUnit(kUnitMean, mean_.get());
  glBindTextureUnit(kUnitDeviation, deviation_.get());
  glBindTextureUnit(kUnitWorth, worth_.get());
  glBindImageTexture(kImageResidual, residual_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
}

bool Accumulation::needs_new_light_samples(double rounds) {
  if (rounds < rounds_ + 1.0) return false;
  rounds_ = rounds;
  return true;
}

std::vector<float> Accumulation::borrowed_shares(const std::vector<std::uint8_t>& marks, int samples_per_item) const {
  const std::size_t w = static_cast<std::size_t>(mean_.width()), count = marks.size() / 4;
  std::vector<float> shares(count);
  for (std::size_t i = 0; i < count; ++i) shares[i] = marks[4 * i] != 0 ? 0.0f : 1.0f;
  const auto read = [](const Texture& texture, GLenum format) {
    std::vector<float> values(texture.bytes() / sizeof(float));
    glGetTextureImage(texture.get(), 0, format, GL_FLOAT, static_cast<GLsizei>(texture.bytes()), values.data());
    return values;
  };
  const std::vector<float> mean = read(mean_, GL_RGBA), residual = read(residual_, GL_RED),
                           deviation = read(deviation_, GL_RED), worth = read(worth_, GL_RG);
  const std::size_t tiles_x = static_cast<std::size_t>(worth_.width());
  const std::size_t tiles = tiles_x * static_cast<std::size_t>(worth_.height());
  for (std::size_t i = 0; i < count; ++i) {
    if (marks[4 * i] == 0 || residual[i] < 0.0f) continue;
    const std::size_t x = i % w, y = i / w;
    const int enters = shared::level_entered(static_cast<int>(x), static_cast<int>(y), levels_);
    const auto layer = static_cast<std::size_t>(shared::worth_layer(enters, marks[4 * i + 1]));
    const float around = worth[2 * (layer * tiles + y / kTileSide * tiles_x + x / kTileSide)];
    const float items = mean[4 * i + 3], item_variance = shared::item_variance(deviation[i], samples_per_item);
    const float kappa = shared::point_kappa(around, items, residual[i], item_variance);
    if (enters < levels_) shares[i] = 1.0f - shared::own_weight(items, kappa);
  }
  return shares;
}

RefineRates Accumulation::measure(const LayerContext& layer, const Texture& pyramid, const Texture& marks,
                                  std::size_t visible) {
  const glm::ivec4 sampling = layer.constants.sampling;
  ProgramCache& programs = layer.frame.programs;
  glBindTextureUnit(kUnitMean, mean_.get());
  glBindTextureUnit(kUnitSpread, spread_.get());
  glBindTextureUnit(kUnitPyramid, pyramid.get());
  glBindTextureUnit(kUnitMarks, marks.get());
  glBindTextureUnit(kUnitResidual, residual_.get());
  glBindImageTexture(kImageDeviation, deviation_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  glBindImageTexture(kImageResiduals, residuals_.get(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferTileSums, sums_.get());
  sums_.clear_to_zero();
  dispatch_tiles(programs.get(kMeasure), layer.surfaces.tiles(), kPerTile);
  double deviation = 0.0, share = 0.0, items = 0.0, hungry = 0.0, hungry_items = 0.0;
  const std::vector<glm::vec4> measured = read_all(sums_);
  for (std::size_t i = 0; i + 1 < measured.size(); i += 2) {
    deviation += measured[i].x;
    share += measured[i].y;
    hungry += measured[i].z;
    items += measured[i].w;
    hungry_items += measured[i + 1].x;
  }
  if (!(deviation > 0.0)) return {};
  const double grid_items = static_cast<double>(marks.width()) * marks.height() * sampling.x / std::max(sampling.y, 1);
  const double frame_items = std::clamp(kGrowth * items, kLeastFrameShare * grid_items, kMostFrameShare * grid_items);
  const double least = kLeastShare * deviation / share;
  const double first_rate = rate_ > 0.0 ? rate_ : items / (deviation + least * share);

  glBindTextureUnit(kUnitDeviation, deviation_.get());
  glBindTextureUnit(kUnitWorth, worth_.get());
  glBindTextureUnit(kUnitResiduals, residuals_.get());
  glBindImageTexture(kImageWorth, worth_.get(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RG32F);
  sums_.clear_to_zero();
  const Program& weigh = programs.get(kInterpolationError);
  weigh.set("u_items_per_deviation", static_cast<float>(first_rate));
  weigh.set("u_least_deviation", static_cast<float>(least));
  const std::vector<float> typical = typical_kappas();
  for (std::size_t k = 0; k < typical.size(); ++k) weigh.set("u_typical[" + std::to_string(k) + "]", typical[k]);
  dispatch_tiles(weigh, layer.surfaces.tiles(), kPerTile);
  std::array<double, kRates> wanted_at{};
  const std::vector<glm::vec4> sums = read_all(sums_);
  for (std::size_t i = 0; i < sums.size(); ++i)
    for (int k = 0; k < 4; ++k) wanted_at[4 * (i % 2) + static_cast<std::size_t>(k)] += sums[i][k];
  const double rate = rate_for(frame_items, first_rate, wanted_at);

  rate_ = rate;
  RefineRates rates;
  rates.items_per_deviation = static_cast<float>(rate);
  rates.least_deviation = static_cast<float>(least);
  rates.most_items = static_cast<unsigned>(std::max(2.0 * frame_items, 4096.0));
  // Of the typical point; of the hungry ones, where they are where the samples go.
  double points = static_cast<double>(std::max<std::size_t>(visible, 1)), seen = items;
  if (hungry_items > kHungryShare * items) points = hungry, seen = hungry_items;
  rates.light_rounds = seen / points * sampling.y / EnvironmentBuffers::kListLength;
  return rates;
}

}  // namespace maquette
