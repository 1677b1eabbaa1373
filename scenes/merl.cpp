
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include "scenes/brdf.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

// Source: Matusik et al. 2003, BRDFRead.cpp of the MERL database.
constexpr double kScale[3] = {1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0};
constexpr std::size_t kHeaderBytes = 3 * sizeof(std::int32_t);
constexpr std::size_t kEntries = kBrdfEntryCount;
constexpr std::size_t kFileBytes = kHeaderBytes + 3 * kEntries * sizeof(double);
constexpr std::size_t kSlice = std::size_t{kThetaDCount} * kPhiDCount;

struct SliceResult {
  std::size_t unmeasured = 0;
  bool infinite = false;
  bool empty_column[kPhiDCount] = {};
};

/// Decodes the theta_d x phi_d entries of one theta_h into `rgb`, and fills the gaps of every column (fixed phi_d) that
/// has a measured value.
SliceResult decode_slice(const std::byte* planes, std::size_t theta_h, glm::vec3* rgb) {
  SliceResult result;
  std::vector<double> values(3 * kSlice);
  for (std::size_t c = 0; c < 3; ++c) {
    std::memcpy(&values[c * kSlice], planes + (c * kEntries + theta_h * kSlice) * sizeof(double),
                kSlice * sizeof(double));
  }
  constexpr float kUnmeasured = -1.0f;
  for (std::size_t i = 0; i < kSlice; ++i) {
    const double v[3] = {values[i], values[kSlice + i], values[2 * kSlice + i]};
    if (v[0] >= 0.0 && v[1] >= 0.0 && v[2] >= 0.0) {
      rgb[i] = glm::vec3(static_cast<float>(v[0] * kScale[0]), static_cast<float>(v[1] * kScale[1]),
                         static_cast<float>(v[2] * kScale[2]));
      // A double beyond the range of float counts as infinite too.
      if (!std::isfinite(rgb[i].x + rgb[i].y + rgb[i].z)) result.infinite = true;
    } else {
      for (double x : v) {
        if (std::isinf(x)) result.infinite = true;
      }
      rgb[i] = glm::vec3(kUnmeasured);
      ++result.unmeasured;
    }
  }
  if (result.unmeasured == 0) return result;
  for (std::size_t phi = 0; phi < kPhiDCount; ++phi) {
    std::size_t first = 0;
    while (first < kThetaDCount && rgb[first * kPhiDCount + phi].x < 0.0f) ++first;
    if (first == kThetaDCount) {
      result.empty_column[phi] = true;
      continue;
    }
    glm::vec3 last = rgb[first * kPhiDCount + phi];
    for (std::size_t theta_d = 0; theta_d < kThetaDCount; ++theta_d) {
      glm::vec3& value = rgb[theta_d * kPhiDCount + phi];
      if (value.x < 0.0f) value = last;
      last = value;
    }
  }
  return result;
}

/// Columns without any measured value are copied from the nearest theta_h that has one (the smaller first).
void fill_empty_columns(const std::vector<SliceResult>& slices, std::vector<glm::vec3>& rgb) {
  parallel_for(0, kPhiDCount, [&](int phi) {
    for (int theta_h = 0; theta_h < kThetaHCount; ++theta_h) {
      if (!slices[static_cast<std::size_t>(theta_h)].empty_column[phi]) continue;
      const auto usable = [&](int t) {
        return t >= 0 && t < kThetaHCount && !slices[static_cast<std::size_t>(t)].empty_column[phi];
      };
      int source = -1;
      for (int step = 1; step < kThetaHCount && source < 0; ++step) {
        source = usable(theta_h - step) ? theta_h - step : usable(theta_h + step) ? theta_h + step : -1;
      }
      if (source < 0) continue;  // the whole phi_d plane is empty: filled from another one below
      for (std::size_t theta_d = 0; theta_d < kThetaDCount; ++theta_d) {
        const std::size_t offset = theta_d * kPhiDCount + static_cast<std::size_t>(phi);
        rgb[static_cast<std::size_t>(theta_h) * kSlice + offset] =
            rgb[static_cast<std::size_t>(source) * kSlice + offset];
      }
    }
  });
  // A phi_d without any measured value takes the nearest phi_d, periodically.
  const auto empty_plane = [&](int phi) { return rgb[static_cast<std::size_t>(phi)].x < 0.0f; };
  std::vector<int> source(kPhiDCount, -1);
  for (int phi = 0; phi < kPhiDCount; ++phi) {
    for (int step = 0; step <= kPhiDCount / 2 && source[static_cast<std::size_t>(phi)] < 0; ++step) {
      const int before = (phi - step + kPhiDCount) % kPhiDCount;
      const int after = (phi + step) % kPhiDCount;
      source[static_cast<std::size_t>(phi)] = !empty_plane(before) ? before : !empty_plane(after) ? after : -1;
    }
  }
  for (int phi = 0; phi < kPhiDCount; ++phi) {
    const int from = source[static_cast<std::size_t>(phi)];
    if (from == phi) continue;
    for (std::size_t i = 0; i < std::size_t{kThetaHCount} * kThetaDCount; ++i) {
      rgb[i * kPhiDCount + static_cast<std::size_t>(phi)] = rgb[i * kPhiDCount + static_cast<std::size_t>(from)];
    }
  }
}

void check_size_and_header(const std::string& path, std::span<const std::byte> bytes) {
  const std::string remedy = "name a MERL .binary table of 90 x 90 x 180 entries";
  if (bytes.size() < kHeaderBytes) {
    throw Error(path, "has " + std::to_string(bytes.size()) + " bytes, too short for the header of a MERL table",
                remedy);
  }
  std::int32_t dimensions[3];
  std::memcpy(dimensions, bytes.data(), kHeaderBytes);
  if (dimensions[0] != kThetaHCount || dimensions[1] != kThetaDCount || dimensions[2] != kPhiDCount) {
    throw Error(path,
                "starts with dimensions " + std::to_string(dimensions[0]) + " x " + std::to_string(dimensions[1]) +
                    " x " + std::to_string(dimensions[2]) + ", 90 x 90 x 180 expected",
                remedy);
  }
  if (bytes.size() != kFileBytes) {
    const bool truncated = bytes.size() < kFileBytes;
    throw Error(path,
                std::string(truncated ? "is truncated: " : "is too long: ") + std::to_string(bytes.size()) +
                    " bytes, " + std::to_string(kFileBytes) + " expected",
                truncated ? "copy the file again" : remedy);
  }
}

}  // namespace

BrdfTable load_merl(const std::string& path) {
  const std::vector<std::byte> bytes = read_file(path, std::size_t{1} << 30);
  check_size_and_header(path, bytes);
  BrdfTable table;
  table.name = std::filesystem::path(path).stem().string();
  table.rgb.resize(kEntries);
  std::vector<SliceResult> slices(kThetaHCount);
  parallel_for(0, kThetaHCount, [&](int theta_h) {
    const auto slice = static_cast<std::size_t>(theta_h);
    slices[slice] = decode_slice(bytes.data() + kHeaderBytes, slice, &table.rgb[slice * kSlice]);
  });
  bool empty_columns = false;
  for (const SliceResult& slice : slices) {
    if (slice.infinite) throw Error(path, "holds infinite values", "use a table with finite entries");
    table.unmeasured_count += slice.unmeasured;
    for (bool empty : slice.empty_column) empty_columns = empty_columns || empty;
  }
  if (table.unmeasured_count == kEntries) {
    throw Error(path, "holds no measured value: every entry is negative or not a number", "use another table");
  }
  if (empty_columns) fill_empty_columns(slices, table.rgb);
  table.hash = content_hash(std::as_bytes(std::span(table.rgb)));
  return table;
}

void save_merl(const std::string& path, const BrdfTable& table) {
  if (table.rgb.size() != kEntries) throw UsageError(path, "only full tables can be written");
  std::vector<std::byte> bytes(kFileBytes);
  const std::int32_t dimensions[3] = {kThetaHCount, kThetaDCount, kPhiDCount};
  std::memcpy(bytes.data(), dimensions, kHeaderBytes);
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> plane(kEntries);
    for (std::size_t i = 0; i < kEntries; ++i) {
      plane[i] = static_cast<double>(table.rgb[i][static_cast<int>(c)]) / kScale[c];
    }
    std::memcpy(bytes.data() + kHeaderBytes + c * kEntries * sizeof(double), plane.data(), kEntries * sizeof(double));
  }
  write_file_atomically(path, bytes);
}

}  // namespace maquette
