#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "scenes/brdf.h"

namespace maquette {

/// A bin of the table as input of the fits. Weight: cos(theta_i) cos(theta_o); bins below the horizon are left out.
struct FitSample {
  int theta_h_bin = 0;
  double cos_h = 1.0, cos_d = 1.0, cos_i = 1.0, cos_o = 1.0;
  double weight = 0.0;
  glm::dvec3 root{
      0.0};  ///< cube root of the value, so that bright lobes do not dominate. Source: Low et al. 2012, Sec. 5
};
/// Every theta_h bin, each ninth theta_d and four phi_d; about 3,000 samples.
std::vector<FitSample> fit_samples(const BrdfTable& brdf);

}  // namespace maquette
