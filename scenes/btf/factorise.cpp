#include "scenes/btf/factorise.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "scenes/btf/half_floats.h"
#include "scenes/linear_algebra.h"
#include "scenes/luminance.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

using RowMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Images = Eigen::Map<RowMatrix>;  // [light][texel rgb]

/// Columns a block: sums of products stay exact enough in float within one, and blocks are summed in double, in order.
constexpr Eigen::Index kBlock = 3072;

void describe(const Images& images, const std::vector<double>& shares, BtfViewFigures* figures) {
  const Eigen::Index texels = images.cols() / 3;
  std::vector<double> variance(shares.size()), mean(shares.size()), dark(shares.size());
  parallel_for(std::size_t{0}, shares.size(), [&](std::size_t l) {
    const float* row = images.data() + static_cast<Eigen::Index>(l) * images.cols();
    const auto y = [&](Eigen::Index t) { return luminance(glm::dvec3(row[3 * t], row[3 * t + 1], row[3 * t + 2])); };
    double sum = 0.0, squares = 0.0;
    for (Eigen::Index t = 0; t < texels; ++t) sum += y(t);
    mean[l] = sum / static_cast<double>(texels);
    std::size_t count = 0;
    for (Eigen::Index t = 0; t < texels; ++t) {
      const double value = y(t);
      squares += (value - mean[l]) * (value - mean[l]);
      count += value < 0.25 * mean[l] ? 1 : 0;
    }
    variance[l] = squares / static_cast<double>(texels);
    dark[l] = static_cast<double>(count) / static_cast<double>(texels);
  });
  double all_mean = 0.0, all_variance = 0.0;
  for (std::size_t l = 0; l < shares.size(); ++l) {
    all_mean += shares[l] * mean[l];
    all_variance += shares[l] * variance[l];
    figures->shadowed += shares[l] * dark[l];
  }
  figures->contrast = all_mean > 0.0 ? std::sqrt(all_variance) / all_mean : 0.0;
}

/// images * images^T / texels.
Eigen::MatrixXd gram_matrix(const Images& images) {
  const Eigen::Index blocks = (images.cols() + kBlock - 1) / kBlock;
  constexpr Eigen::Index kRound = 16;  // blocks that run at once: their results are in memory
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(images.rows(), images.rows());
  std::vector<Eigen::MatrixXf> parts(kRound);
  for (Eigen::Index first = 0; first < blocks; first += kRound) {
    const Eigen::Index count = std::min(kRound, blocks - first);
    parallel_for(Eigen::Index{0}, count, [&](Eigen::Index i) {
      const Eigen::Index begin = (first + i) * kBlock, width = std::min(kBlock, images.cols() - begin);
      const auto block = images.middleCols(begin, width);
      parts[static_cast<std::size_t>(i)] = block * block.transpose();
    });
    for (Eigen::Index i = 0; i < count; ++i) gram += parts[static_cast<std::size_t>(i)].cast<double>();
  }
  return gram * (3.0 / static_cast<double>(images.cols()));
}

/// Writes mean and components, [texel][1 + component][rgb].
void write_factors(const Eigen::RowVectorXf& mean, const RowMatrix& components, std::vector<std::uint16_t>* factors) {
  const Eigen::Index texels = mean.cols() / 3, count = components.rows();
  factors->resize(static_cast<std::size_t>(texels * 3 * (1 + count)));
  parallel_for(Eigen::Index{0}, texels, [&](Eigen::Index t) {
    std::uint16_t* out = factors->data() + t * 3 * (1 + count);
    for (Eigen::Index k = 0; k < 3; ++k) *out++ = half_of_float(mean[3 * t + k]);
    for (Eigen::Index c = 0; c < count; ++c)
      for (Eigen::Index k = 0; k < 3; ++k) *out++ = half_of_float(components(c, 3 * t + k));
  });
}

}  // namespace

BtfLights make_btf_lights(std::vector<glm::dvec3> directions) {
  BtfLights lights;
  lights.mesh = std::make_shared<const DirectionMesh>(std::move(directions));
  lights.shares = lights.mesh->quadrature().solid_angle;
  // A light between others that are very near has next to no share: its images still count.
  const double least = 1e-4 / static_cast<double>(lights.shares.size());
  double sum = 0.0;
  for (double& share : lights.shares) sum += share = std::max(share, least);
  for (double& share : lights.shares) share /= sum;
  return lights;
}

BtfView factorise_btf_view(const glm::dvec3& direction, const BtfLights& lights, int components,
                           std::vector<float>* images) {
  const auto light_count = static_cast<Eigen::Index>(lights.shares.size());
  assert(light_count > 0 && images->size() % lights.shares.size() == 0 && components <= kMostBtfComponents);
  Images x(images->data(), light_count, static_cast<Eigen::Index>(images->size()) / light_count);
  BtfView view;
  view.direction = direction;
  view.lights = lights.mesh;
  describe(x, lights.shares, &view.figures);
  const Eigen::VectorXd shares = Eigen::Map<const Eigen::VectorXd>(lights.shares.data(), light_count);
  const Eigen::VectorXd roots = shares.cwiseSqrt();

  const Eigen::RowVectorXf mean = shares.cast<float>().transpose() * x;
  x.rowwise() -= mean;
  const Eigen::MatrixXd scaled = roots.asDiagonal() * gram_matrix(x) * roots.asDiagonal();
  const SymmetricEigen solver(scaled);

  RowMatrix basis = RowMatrix::Zero(components, light_count);  // roots times weights
  view.light_weights.assign(static_cast<std::size_t>(light_count * components), 0.0f);
  for (Eigen::Index c = 0; c < std::min<Eigen::Index>(components, light_count); ++c) {
    Eigen::VectorXd u = solver.eigenvectors().col(light_count - 1 - c);
    Eigen::Index largest = 0;
    u.cwiseAbs().maxCoeff(&largest);
    if (u[largest] < 0.0) u = -u;
    basis.row(c) = u.cwiseProduct(roots).cast<float>();
    for (Eigen::Index l = 0; l < light_count; ++l)
      view.light_weights[static_cast<std::size_t>(l * components + c)] = static_cast<float>(u[l] / roots[l]);
  }
  view.figures.energy = std::max(0.0, solver.eigenvalues().sum());
  view.figures.mean_energy = static_cast<double>(mean.squaredNorm()) * 3.0 / static_cast<double>(x.cols());
  for (Eigen::Index c = 0; c < std::min<Eigen::Index>(static_cast<Eigen::Index>(kBtfSpectrum), light_count); ++c)
    view.figures.spectrum.push_back(static_cast<float>(std::max(0.0, solver.eigenvalues()[light_count - 1 - c])));
  write_factors(mean, basis * x, &view.factors);
  return view;
}

}  // namespace maquette
