#include "tests/support/sparse_transfer.h"

#include <algorithm>
#include <cmath>

#include "scenes/btf/half_floats.h"
#include "scenes/parallel.h"

namespace maquette::test {

SparseTransfer::SparseTransfer(const RelightTable& table, std::size_t kept) : coefficients_(table.coefficients()) {
  const std::size_t rows = table.rows(), count = std::min(kept, coefficients_);
  std::vector<std::uint16_t> q(rows * coefficients_);  // [row][coefficient]
  std::vector<glm::vec4> column;
  for (std::uint32_t j = 0; j < coefficients_; ++j) {
    table.sums({{j}, {glm::vec3(1.0f)}}, &column);
    for (std::size_t r = 0; r < rows; ++r) q[r * coefficients_ + j] = half_of_float(column[r].x);
  }
  double left_away = 0.0, all = 0.0;
  std::vector<std::uint16_t> order(coefficients_);
  std::vector<float> of(coefficients_);
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t j = 0; j < coefficients_; ++j) {
      order[j] = static_cast<std::uint16_t>(j);
      of[j] = float_of_half(q[r * coefficients_ + j]);
    }
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                     [&](std::uint16_t a, std::uint16_t b) {
                       return std::abs(of[a]) != std::abs(of[b]) ? std::abs(of[a]) > std::abs(of[b]) : a < b;
                     });
    for (std::size_t k = 0; k < coefficients_; ++k) {
      const double square = static_cast<double>(of[order[k]]) * static_cast<double>(of[order[k]]);
      all += square;
      if (k >= count) left_away += square;
    }
    std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count));
    first_.push_back(index_.size());
    for (std::size_t k = 0; k < count; ++k) {
      if (of[order[k]] == 0.0f) continue;
      index_.push_back(order[k]);
      value_.push_back(half_of_float(of[order[k]]));
    }
  }
  first_.push_back(index_.size());
  error_ = all > 0.0 ? std::sqrt(left_away / all) : 0.0;
}

void SparseTransfer::sums(const KeptLight& light, std::vector<glm::vec4>* out) const {
  std::vector<glm::vec3> dense(coefficients_, glm::vec3(0.0f));
  for (std::size_t k = 0; k < light.coefficients.size(); ++k) dense[light.coefficients[k]] = light.values[k];
  out->resize(first_.size() - 1);
  parallel_for(std::size_t{0}, out->size(), [&](std::size_t r) {
    glm::vec3 sum(0.0f);
    for (std::size_t e = first_[r]; e < first_[r + 1]; ++e) sum += float_of_half(value_[e]) * dense[index_[e]];
    (*out)[r] = glm::vec4(sum, 0.0f);
  });
}

std::size_t SparseTransfer::bytes() const {
  return first_.size() * sizeof(std::uint32_t) + (index_.size() + value_.size()) * sizeof(std::uint16_t);
}

}  // namespace maquette::test
