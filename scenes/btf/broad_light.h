#pragma once

#include <Eigen/Core>
#include <vector>

#include "scenes/btf/btf.h"

namespace maquette {

/// What functions of the light [light][count] reflect of broad lights: their sums with the light's cosine over caps of
/// 90 degrees about each of ubo_directions, [cap][count]. Caps are as wide as windows and softboxes; errors under
/// single directions would count what no picture under a sky shows.
Eigen::MatrixXd reflect_broad_lights(const DirectionMesh& lights, const std::vector<float>& functions, int count);

/// Sum over the caps of the squares of `reflected` [cap][count] times factors, whose products over texels and colours
/// are summed in `gram` [count][count].
double broad_light_energy(const Eigen::Ref<const Eigen::MatrixXd>& reflected,
                          const Eigen::Ref<const Eigen::MatrixXd>& gram);

/// [light][1 + component]: 1, then the light weights of a view, as reflect_broad_lights takes them.
std::vector<float> light_functions(const BtfView& view, int components);

/// [components kept, from 0 to all]: RMS over views, texels and broad lights of what a BTF's other components reflect,
/// relative to the RMS of all.
std::vector<double> btf_errors_by_components(const Btf& btf);

}  // namespace maquette
