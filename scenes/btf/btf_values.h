#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "scenes/btf/btf_reading.h"
#include "scenes/btf/factorise.h"

namespace maquette {

/// Most bytes of the images of one view.
inline constexpr std::size_t kMostViewBytes = std::size_t{4} << 30;

/// What stored values are multiplied by to give rho, for a light at `direction`: value = pi rho, times the cosine where
/// it is in the values.
float rho_of_value(bool cosine, const glm::dvec3& direction);

/// Decodes stored values in [0, 1] as `gamma` says, 0: the sRGB curve.
float linear_of_encoded(float value, double gamma);

/// Throws Error unless every value is finite, naming `what`.
void check_finite(const std::string& where, const std::string& what, const float* values, std::size_t count);

/// The lights of views by their directions: views that have the same share one mesh.
class BtfLightSets {
 public:
  const BtfLights& find(const std::vector<glm::dvec3>& directions);

 private:
  std::map<std::vector<double>, BtfLights> sets_;
};

/// `x` with six digits, for messages and provenance.
std::string btf_number(double x);
/// `tl015 pl000` style.
std::string btf_angles_text(const glm::dvec3& direction, char of);

}  // namespace maquette
