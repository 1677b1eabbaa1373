#pragma once

#include <cstdint>
#include <vector>

#include "render/prt/relight.h"

namespace maquette::test {

/// The light side as the thesis stores it: of each row the coefficients with the largest values alone, as pairs of
/// index and value. Source: seed 001, 10.2 (non-linear approximation of q). The program keeps all of q instead
/// (RelightTable), and reads the columns of the kept light.
class SparseTransfer {
 public:
  /// `kept`: of each row at most.
  SparseTransfer(const RelightTable& table, std::size_t kept);
  /// As RelightTable::sums.
  void sums(const KeptLight& light, std::vector<glm::vec4>* out) const;
  std::size_t bytes() const;
  /// RMS of what was left away, relative to the RMS of q.
  double error() const { return error_; }

 private:
  std::size_t coefficients_ = 0;
  std::vector<std::size_t> first_;    ///< [row], and the end
  std::vector<std::uint16_t> index_;  ///< coefficients, ascending in a row
  std::vector<std::uint16_t> value_;  ///< half floats
  double error_ = 0.0;
};

}  // namespace maquette::test
