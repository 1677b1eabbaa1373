#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "scenes/btf/btf.h"

namespace maquette {

/// A BTF factorised for all views together: texels are divided among clusters, and a texel is a sum of its cluster's
/// functions of light and view, each times a colour: rho(x, l, v) = sum over c of g_c(x) h_k(x),c(l, v).
/// Source: Mueller, Meseth and Klein 2003, "Compression and Real-Time Rendering of Measured BTFs Using Local PCA";
/// seed 001, 10.2.6. Differs: colours lie on the texel axis, so that h is scalar, and the mean of a cluster is scaled
/// by each texel's colours: components are those about 0.
struct JointBtf {
  int width = 0, height = 0;
  int clusters = 0, terms = 0;  ///< functions of a cluster
  /// [view][light][cluster][term]: h, of mean square 1 over views and lights where it is not 0.
  std::vector<std::vector<float>> functions;
  /// Half floats, [level][y][x]: cluster, then [term][rgb]: g. Levels as in BtfView::factors.
  std::vector<std::uint16_t> texels;
  double error = 0.0;  ///< RMS of rho over finest texels, views and lights by cosine, relative to that of the BTF
  std::size_t texel_halves() const { return 1 + 3 * static_cast<std::size_t>(terms); }
  std::size_t function_count() const { return static_cast<std::size_t>(clusters * terms); }
};

struct JointBtfOptions {
  int clusters = 8;
  int components = 2;  ///< besides the first function
};

/// Fewer texels than clusters give fewer clusters; missing rank and black texels are no errors: what is not there is 0.
/// Deterministic, whatever the number of threads. Null once cancelled.
/// Source: clusters of subspaces, Kambhatla and Leen 1997, Sec. 3.2.
std::shared_ptr<const JointBtf> fit_joint_btf(const Btf& btf, const JointBtfOptions& options,
                                              const std::atomic<bool>& cancel);

/// rho at a sampled view of a texel of the finest level; as evaluate_btf, without interpolation between texels.
glm::vec3 evaluate_joint_btf(const JointBtf& joint, const Btf& btf, int texel, std::size_t view, const glm::vec3& wi);

}  // namespace maquette
