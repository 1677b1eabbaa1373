#include "render/environment/environment_buffers.h"

#include <algorithm>
#include <cmath>

#include "render/environment/importance.h"
#include "render/gl/bindings.h"
#include "scenes/luminance.h"

namespace maquette {

namespace {

/// 1 / integral of p^2, p the density proportional to luminance: the effective solid angle of the light.
float effective_solid_angle(const Environment& e, double integral) {
  if (integral <= 0.0) return 12.566f;
  double sum = 0.0;
  for (int y = 0; y < e.height; ++y) {
    const double texel_sr = std::cos(1.5707963 - 3.14159265 * (y + 0.5) / e.height) * 6.2831853 * 3.14159265 /
                            (static_cast<double>(e.width) * e.height);
    for (int x = 0; x < e.width; ++x) {
      const glm::vec3& c =
          e.rgb[static_cast<std::size_t>(y) * static_cast<std::size_t>(e.width) + static_cast<std::size_t>(x)];
      const double p = luminance(glm::dvec3(c)) / integral;
      sum += p * p * texel_sr;
    }
  }
  return static_cast<float>(1.0 / std::max(sum, 1e-9));
}

/// [cell][kSeenBandwidthCount + 1]: bandwidth through each lobe, then nu_L itself, so that one fetch reads both.
std::vector<float> cell_bandwidths(const EnvironmentTables& tables) {
  std::vector<float> values;
  values.reserve(tables.bandwidth.size() + tables.seen_bandwidth.size());
  auto seen = tables.seen_bandwidth.begin();
  for (const float own : tables.bandwidth) {
    values.insert(values.end(), seen, seen + kSeenBandwidthCount);
    values.push_back(own);
    seen += kSeenBandwidthCount;
  }
  return values;
}

}  // namespace

EnvironmentBuffers::EnvironmentBuffers(std::shared_ptr<const Environment> environment)
    : environment_(std::move(environment)), tables_(load_environment_tables(*environment_)) {
  bias_ = packing_bias(*environment_);
  sky_ = pack_sky(*environment_, bias_, 1);
  words_ = Buffer::from("environment", sky_.words);
  word_view_ = Texture::make_buffer("environment", GL_R32UI, words_);
  if (const int refinement = sky_refinement(*environment_, kMaxNodes); refinement > 1) {
    sky_ = pack_sky(*environment_, bias_, refinement);
    nodes_ = Buffer::from("environment nodes", sky_.words);
    node_view_ = Texture::make_buffer("environment nodes", GL_R32UI, nodes_);
  }
  bandwidth_ = Buffer::from("environment bandwidth", cell_bandwidths(tables_));
  bandwidth_view_ = Texture::make_buffer("environment bandwidth", GL_R32F, bandwidth_);
  effective_sr_ = effective_solid_angle(*environment_, tables_.luminance_integral);
  sun_luminance_ = mean_sun_luminance(*environment_, tables_.luminance_integral);
  list_ = Buffer("light samples", kListLength * sizeof(EnvironmentSample));
  list_view_ = Texture::make_buffer("light samples", GL_RGBA32F, list_);
  resample(0);
}

namespace {

SunBuffers make_sun_buffers(const Sun& sun, int bias) {
  SunBuffers b;
  b.least_luminance = sun.least_luminance;
  b.compact = sun.compact;
  b.sun_sr = sun.solid_angle_sr;
  b.rest = sun.rest;
  compute_importance(*sun.rest, b.rest_tables);
  b.rest_integral = b.rest_tables.luminance_integral;
  b.rest_sky = pack_sky(*sun.rest, bias, 1);
  for (const EnvironmentSample& sample : sun.samples) b.sun_directions.push_back(sample.direction);
  b.sun_list = Buffer::from("sun samples", sun.samples);
  b.sun_view = Texture::make_buffer("sun samples", GL_RGBA32F, b.sun_list);
  b.rest_list = Buffer("light samples without the sun", EnvironmentBuffers::kListLength * sizeof(EnvironmentSample));
  b.rest_view = Texture::make_buffer("light samples without the sun", GL_RGBA32F, b.rest_list);
  b.resample(0);
  return b;
}

}  // namespace

void SunBuffers::resample(std::uint32_t seed) {
  constexpr auto kLength = static_cast<std::size_t>(EnvironmentBuffers::kListLength);
  std::vector<EnvironmentSample> samples = sample_environment(*rest, rest_tables, rest_sky, seed, kLength);
  samples.resize(kLength);  // all zero when the rest is black
  rest_list.update(0, kLength * sizeof(EnvironmentSample), samples.data());
}

void SunBuffers::bind() const {
  glBindTextureUnit(kUnitLightSamples, rest_view.get());
  glBindTextureUnit(kUnitSunSamples, sun_view.get());
}

const SunBuffers* EnvironmentBuffers::sun() {
  if (!sun_sought_) {
    const auto count = static_cast<std::size_t>(SunBuffers::kListLength);
    if (const auto sun = find_sun(*environment_, tables_.luminance_integral, bias_, count))
      sun_ = make_sun_buffers(*sun, bias_);
    sun_sought_ = true;
  }
  return sun_ ? &*sun_ : nullptr;
}

void EnvironmentBuffers::resample(std::uint32_t seed) {
  const std::vector<EnvironmentSample> samples = sample_environment(*environment_, tables_, sky_, seed, kListLength);
  if (!samples.empty()) list_.update(0, samples.size() * sizeof(EnvironmentSample), samples.data());
  if (sun_) sun_->resample(seed);
}

void EnvironmentBuffers::bind() const {
  glBindTextureUnit(kUnitEnvironment, word_view_.get());
  glBindTextureUnit(kUnitLightSamples, list_view_.get());
  glBindTextureUnit(kUnitEnvironmentBandwidth, bandwidth_view_.get());
  glBindTextureUnit(kUnitSkyNodes, (node_view_ ? node_view_ : word_view_).get());
}

}  // namespace maquette
