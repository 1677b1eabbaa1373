#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

namespace maquette {

/// Samples of each of `clusters`, by the owner of each sample. An empty cluster gets the sample with the largest error,
/// whose error becomes 0.
template <typename Owner>
std::vector<std::vector<Eigen::Index>> members_of_clusters(const std::vector<Owner>& owner, std::size_t clusters,
                                                           std::vector<float>* errors) {
  std::vector<std::vector<Eigen::Index>> members(clusters);
  for (std::size_t i = 0; i < owner.size(); ++i)
    members[static_cast<std::size_t>(owner[i])].push_back(static_cast<Eigen::Index>(i));
  for (auto& m : members) {
    if (!m.empty()) continue;
    const auto worst = std::max_element(errors->begin(), errors->end()) - errors->begin();
    (*errors)[static_cast<std::size_t>(worst)] = 0.0f;
    m.push_back(worst);
  }
  return members;
}

}  // namespace maquette
