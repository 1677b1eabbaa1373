#pragma once

#include <memory>

#include "render/environment/environment_tables.h"
#include "render/environment/sun.h"
#include "render/gl/objects.h"

namespace maquette {

/// Lists of light samples for frames that sample the sun apart from the rest of the sky.
struct SunBuffers {
  static constexpr int kListLength = 4096;  ///< a power of two
  float least_luminance = 0.0f;             ///< see Sun::least_luminance
  bool compact = true;
  double sun_sr = 0.0, rest_integral = 0.0;
  std::shared_ptr<const Environment> rest;  ///< without the sun's texels
  EnvironmentTables rest_tables;
  PackedSky rest_sky;
  std::vector<glm::vec3> sun_directions;  ///< of the list
  Buffer sun_list, rest_list;
  Texture sun_view, rest_view;
  void bind() const;  ///< units 15 and 23
  /// Draws the list of the rest anew.
  void resample(std::uint32_t seed);
  std::size_t bytes() const { return sun_list.bytes() + rest_list.bytes(); }
};

/// One environment on the GPU: packed radiance, a list of light samples, local bandwidth. The shaders apply the
/// rotation.
class EnvironmentBuffers {
 public:
  static constexpr std::size_t kMaxNodes = 1u << 22;  ///< of the finer grid that estimators read, 4 bytes each
  static constexpr int kListLength = 65536;           ///< light samples, a power of two
  explicit EnvironmentBuffers(std::shared_ptr<const Environment> environment);
  /// Replaces the light samples by new ones, when progressive rendering has used up the list.
  void resample(std::uint32_t seed);
  void bind() const;  ///< units 14, 15, 17 and 64
  const PackedSky& sky() const { return sky_; }
  int bias() const { return bias_; }
  const Environment& environment() const { return *environment_; }
  const std::shared_ptr<const Environment>& shared_environment() const { return environment_; }
  const EnvironmentTables& tables() const { return tables_; }
  float sun_luminance() const { return sun_luminance_; }  ///< mean_sun_luminance
  float effective_sr() const { return effective_sr_; }
  /// Null when the environment has no sun. Created on first use: 20 ms a million texels.
  const SunBuffers* sun();
  std::size_t bytes() const {
    return words_.bytes() + nodes_.bytes() + list_.bytes() + bandwidth_.bytes() + (sun_ ? sun_->bytes() : 0);
  }

 private:
  std::shared_ptr<const Environment> environment_;
  EnvironmentTables tables_;
  int bias_ = 0;
  float effective_sr_ = 12.56f, sun_luminance_ = 0.0f;
  PackedSky sky_;  ///< nodes for the estimators
  Buffer words_, nodes_, list_, bandwidth_;
  Texture word_view_, node_view_, list_view_, bandwidth_view_;
  bool sun_sought_ = false;
  std::optional<SunBuffers> sun_;
};

}  // namespace maquette
