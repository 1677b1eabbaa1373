// Frames after the first while nothing moves, mode `bandwidth`: the G-buffer and the prediction stay, every point goes
// on with its own sequence of samples. The deviations measured so far decide who gets how many, and the distance of own
// means from what was interpolated decides where interpolation still serves.
#include "render/bandwidth/progressive.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "render/interpolation_shared.h"
#include "render/renderer_impl.h"

namespace maquette {

namespace {

/// Share of the mean deviation that every point gets on top of its own.
constexpr float kLeastShare = 0.1f;
/// Frames in which all points are shaded at least once, needed or not; coarser levels are through sooner by four.
constexpr float kScoutFrames = 64.0f;
/// A frame adds this share of the samples so far, so that what was measured is soon put to use; but no less and no more
/// than these shares of the grid's base count, because what a frame costs besides its samples grows with the grid.
constexpr double kGrowth = 0.6, kLeastFrameShare = 0.15, kMostFrameShare = 0.5;
/// Share of all items that points which came round the list of light samples have, from which on it is theirs.
constexpr double kHungryShare = 0.25;

constexpr int kRates = 8;                    // as shaders/bandwidth/worth.comp
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

std::vector<float> Progressive::typical_kappas() const {
  const std::size_t layers = static_cast<std::size_t>(shared::kClasses * levels);
  const std::size_t tiles = static_cast<std::size_t>(residuals.width()) * static_cast<std::size_t>(residuals.height());
  std::vector<glm::vec4> measured(tiles * (layers + shared::kClasses));
  glGetTextureImage(residuals.get(), 0, GL_RGBA, GL_FLOAT, static_cast<GLsizei>(measured.size() * sizeof(glm::vec4)),
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

Progressive Progressive::make(const FrameTargets& targets, int levels) {
  const int w = targets.grid_width(), h = targets.grid_height();
  const int tiles_x = (w + FrameTargets::kTile - 1) / FrameTargets::kTile;
  const int tiles_y = (h + FrameTargets::kTile - 1) / FrameTargets::kTile;
  Progressive p;
  p.levels = levels;
  p.mean = Texture::make_2d("accumulated mean", GL_RGBA32F, w, h);
  p.spread = Texture::make_2d("accumulated spread", GL_R32F, w, h);
  p.deviation = Texture::make_2d("measured deviation", GL_R32F, w, h);
  p.residual = Texture::make_2d("interpolation residual", GL_R32F, w, h);
  const int layers = shared::kClasses * (levels + 1);  // the coarsest level is never interpolated
  p.residuals = Texture::make_2d_array("interpolation residuals", GL_RGBA32F, tiles_x, tiles_y, layers);
  p.worth = Texture::make_2d_array("interpolation worth", GL_RG32F, tiles_x, tiles_y, layers);
  p.sums = Buffer("sums of deviations", targets.surface_tiles.tiles.bytes() / sizeof(unsigned) * 2 * sizeof(glm::vec4));
  p.clear();
  return p;
}

void Progressive::clear() {
  const float zero[4] = {}, none[4] = {-1.0f, -1.0f, -1.0f, -1.0f};
  glClearTexImage(mean.get(), 0, GL_RGBA, GL_FLOAT, zero);
  glClearTexImage(spread.get(), 0, GL_RED, GL_FLOAT, zero);
  glClearTexImage(deviation.get(), 0, GL_RED, GL_FLOAT, zero);
  glClearTexImage(residual.get(), 0, GL_RED, GL_FLOAT, none);
  glClearTexImage(residuals.get(), 0, GL_RGBA, GL_FLOAT, zero);  // tiles without surfaces stay so
  for (int layer = 0; layer < shared::kClasses * (levels + 1); ++layer) {
    const float unmeasured[2] = {believed_kappa(layer), 1.0f};
    glClearTexSubImage(worth.get(), 0, 0, 0, layer, worth.width(), worth.height(), 1, GL_RG, GL_FLOAT, unmeasured);
  }
  rate = rounds = 0.0;
}

float Renderer::Impl::scout_share() const { return static_cast<float>(accumulated + 1) / kScoutFrames; }

std::vector<float> Renderer::Impl::borrowed_shares() const {
  const FrameTargets& t = *targets;
  const std::size_t w = static_cast<std::size_t>(t.grid_width()), count = w * static_cast<std::size_t>(t.grid_height());
  std::vector<std::uint8_t> marks(4 * count);
  glGetTextureImage(t.marks.get(), 0, GL_RGBA_INTEGER, GL_UNSIGNED_BYTE, static_cast<GLsizei>(marks.size()),
                    marks.data());
  std::vector<float> shares(count);
  for (std::size_t i = 0; i < count; ++i) shares[i] = marks[4 * i] != 0 ? 0.0f : 1.0f;
  if (!progressive) return shares;
  const Progressive& p = *progressive;
  const auto read = [](const Texture& texture, GLenum format) {
    std::vector<float> values(texture.bytes() / sizeof(float));
    glGetTextureImage(texture.get(), 0, format, GL_FLOAT, static_cast<GLsizei>(texture.bytes()), values.data());
    return values;
  };
  const std::vector<float> mean = read(p.mean, GL_RGBA), residual = read(p.residual, GL_RED),
                           deviation = read(p.deviation, GL_RED), worth = read(p.worth, GL_RG);
  const std::size_t tiles_x = static_cast<std::size_t>(p.worth.width());
  const std::size_t tiles = tiles_x * static_cast<std::size_t>(p.worth.height());
  for (std::size_t i = 0; i < count; ++i) {
    if (marks[4 * i] == 0 || residual[i] < 0.0f) continue;
    const std::size_t x = i % w, y = i / w;
    const int enters = shared::level_entered(static_cast<int>(x), static_cast<int>(y), p.levels);
    const auto layer = static_cast<std::size_t>(shared::worth_layer(enters, marks[4 * i + 1]));
    const float around = worth[2 * (layer * tiles + y / FrameTargets::kTile * tiles_x + x / FrameTargets::kTile)];
    const float items = mean[4 * i + 3], item_variance = shared::item_variance(deviation[i], constants.sampling.y);
    const float kappa = shared::point_kappa(around, items, residual[i], item_variance);
    if (enters < p.levels) shares[i] = 1.0f - shared::own_weight(items, kappa);
  }
  return shares;
}

RefineRates Renderer::Impl::measure_deviations() {
  Progressive& p = *progressive;
  FrameTargets& t = *targets;
  glBindTextureUnit(18, p.mean.get());
  glBindTextureUnit(19, p.spread.get());
  glBindTextureUnit(21, t.pyramid.get());
  glBindTextureUnit(23, t.marks.get());
  glBindTextureUnit(57, p.residual.get());
  glBindImageTexture(0, p.deviation.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  glBindImageTexture(1, p.residuals.get(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, p.sums.get());
  p.sums.clear_to_zero();
  dispatch_tiles(programs.get({"bandwidth/measure.comp", "", {}}), t.surface_tiles, 0);
  double deviation = 0.0, share = 0.0, items = 0.0, hungry = 0.0, hungry_items = 0.0;
  const std::vector<glm::vec4> measured = read_all(p.sums);
  for (std::size_t i = 0; i + 1 < measured.size(); i += 2) {
    deviation += measured[i].x;
    share += measured[i].y;
    hungry += measured[i].z;
    items += measured[i].w;
    hungry_items += measured[i + 1].x;
  }
  if (!(deviation > 0.0)) return {};
  const double grid_items =
      static_cast<double>(t.grid_width()) * t.grid_height() * constants.sampling.x / std::max(constants.sampling.y, 1);
  const double frame_items = std::clamp(kGrowth * items, kLeastFrameShare * grid_items, kMostFrameShare * grid_items);
  const double least = kLeastShare * deviation / share;
  const double first_rate = p.rate > 0.0 ? p.rate : items / (deviation + least * share);

  glBindTextureUnit(19, p.deviation.get());
  glBindTextureUnit(56, p.worth.get());
  glBindTextureUnit(58, p.residuals.get());
  glBindImageTexture(0, p.worth.get(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RG32F);
  p.sums.clear_to_zero();
  const Program& worth = programs.get({"bandwidth/worth.comp", "", {}});
  worth.set("u_items_per_deviation", static_cast<float>(first_rate));
  worth.set("u_least_deviation", static_cast<float>(least));
  const std::vector<float> typical = p.typical_kappas();
  for (std::size_t layer = 0; layer < typical.size(); ++layer)
    worth.set("u_typical[" + std::to_string(layer) + "]", typical[layer]);
  dispatch_tiles(worth, t.surface_tiles, 0);
  std::array<double, kRates> wanted_at{};
  const std::vector<glm::vec4> sums = read_all(p.sums);
  for (std::size_t i = 0; i < sums.size(); ++i)
    for (int k = 0; k < 4; ++k) wanted_at[4 * (i % 2) + static_cast<std::size_t>(k)] += sums[i][k];
  const double rate = rate_for(frame_items, first_rate, wanted_at);

  p.rate = rate;
  RefineRates rates;
  rates.items_per_deviation = static_cast<float>(rate);
  rates.least_deviation = static_cast<float>(least);
  rates.most_items = static_cast<unsigned>(std::max(2.0 * frame_items, 4096.0));
  // Of the typical point; of the hungry ones, where they are where the samples go.
  double points = static_cast<double>(std::max<std::size_t>(visible_points, 1)), seen = items;
  if (hungry_items > kHungryShare * items) points = hungry, seen = hungry_items;
  rates.light_rounds = seen / points * constants.sampling.y / EnvironmentBuffers::kListLength;
  return rates;
}

void Renderer::Impl::renew_light_list_after(double rounds, std::uint32_t seed) {
  if (rounds < progressive->rounds + 1.0) return;
  renew_light_list(seed);
  progressive->rounds = rounds;
}

}  // namespace maquette
