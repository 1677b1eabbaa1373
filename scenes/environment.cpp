#include "scenes/environment.h"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <span>

#include "scenes/environment_builtin.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/image_color.h"
#include "scenes/image_rows.h"
#include "scenes/parallel.h"

namespace maquette {
namespace {

constexpr int kMaxWidth = 8192;
constexpr int kMaxHeight = 4096;
/// Larger values are treated as invalid: the sun has 1.6e9 cd/m2, and squares must stay finite in float.
constexpr float kMaxRadiance = 1e15f;
/// Of Rec.709, as in luminance().
constexpr glm::vec3 kLuminanceWeights(0.2126f, 0.7152f, 0.0722f);

std::size_t texel_index(const Environment& environment, int x, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(environment.width) + static_cast<std::size_t>(x);
}

bool is_valid(const glm::vec3& rgb) {
  const auto fine = [](float v) { return v >= 0.0f && v <= kMaxRadiance; };  // false for NaN
  return fine(rgb.x) && fine(rgb.y) && fine(rgb.z);
}

std::string texels_text(std::size_t count) {
  return std::to_string(count) + (count == 1 ? " texel was" : " texels were");
}

/// Averages the rows of a file over area into a smaller map (or one of the same size) while they are read.
/// Invalid texels have no weight; a texel without any weight becomes NaN, for repair_texels.
class RowReducer {
 public:
  void begin(const HdrInfo& info) {
    info_ = info;
    const double factor =
        std::max({1.0, static_cast<double>(info.width) / kMaxWidth, static_cast<double>(info.height) / kMaxHeight});
    width_ = std::max(1, static_cast<int>(std::lround(info.width / factor)));
    height_ = std::max(1, static_cast<int>(std::lround(info.height / factor)));
    rgb_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
    if (reduces()) sums_.assign(static_cast<std::size_t>(width_), glm::dvec4(0.0));
  }

  void add(int first_row, int row_count, const float* values) {
    const auto row_floats = static_cast<std::size_t>(info_.width) * static_cast<std::size_t>(info_.channels);
    if (!reduces()) {
      parallel_for(0, row_count,
                   [&](int r) { copy_row(first_row + r, values + static_cast<std::size_t>(r) * row_floats); });
      return;
    }
    std::vector<glm::dvec4> narrow(static_cast<std::size_t>(row_count) * static_cast<std::size_t>(width_));
    parallel_for(0, row_count, [&](int r) {
      narrow_row(values + static_cast<std::size_t>(r) * row_floats,
                 &narrow[static_cast<std::size_t>(r) * static_cast<std::size_t>(width_)]);
    });
    for (int r = 0; r < row_count; ++r)
      add_narrow(first_row + r, &narrow[static_cast<std::size_t>(r) * static_cast<std::size_t>(width_)]);
  }

  Environment release() {
    Environment environment;
    environment.width = width_;
    environment.height = height_;
    environment.rgb = std::move(rgb_);
    environment.warnings = info_.warnings;
    if (desaturated_)
      environment.warnings.push_back(texels_text(desaturated_) + " outside the gamut of Rec.709 and became paler");
    if (reduces())
      environment.warnings.push_back("reduced from " + std::to_string(info_.width) + " x " +
                                     std::to_string(info_.height) + " to " + std::to_string(width_) + " x " +
                                     std::to_string(height_));
    return environment;
  }

 private:
  bool reduces() const { return width_ != info_.width || height_ != info_.height; }

  void copy_row(int y, const float* row) {
    glm::vec3* target = &rgb_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_)];
    std::size_t desaturated = 0;
    for (int x = 0; x < width_; ++x, row += info_.channels) target[x] = color_of(row, &desaturated);
    desaturated_ += desaturated;
  }

  /// Light has no negative components: colours outside Rec.709 keep their luminance instead.
  glm::vec3 color_of(const float* texel, std::size_t* desaturated) const {
    const glm::vec3 rgb(texel[0], texel[1], texel[2]);
    if (!info_.converted || !(std::min({rgb.x, rgb.y, rgb.z}) < 0.0f)) return rgb;
    const glm::vec3 paler = desaturate_into_gamut(rgb, kLuminanceWeights);
    // The matrix leaves rounding errors on the primaries and on grey.
    if (glm::distance(paler, rgb) > 1e-5f * std::max({rgb.x, rgb.y, rgb.z})) ++*desaturated;
    return paler;
  }

  /// Calls add(cell, share) for the one or two target cells that source cell `i` of `source_count` covers.
  template <class Add>
  static void distribute(int i, int source_count, int target_count, const Add& add) {
    const double scale = static_cast<double>(target_count) / source_count;
    const double begin = i * scale;
    const double end = (i + 1) * scale;
    const int cell = std::min(static_cast<int>(begin), target_count - 1);
    const double split = std::min(end, cell + 1.0);
    add(cell, split - begin);
    if (end - split > 1e-9 && cell + 1 < target_count) add(cell + 1, end - split);
  }

  void narrow_row(const float* row, glm::dvec4* target) {
    std::size_t desaturated = 0;
    for (int x = 0; x < info_.width; ++x, row += info_.channels) {
      const glm::vec3 rgb = color_of(row, &desaturated);
      if (!is_valid(rgb)) continue;
      distribute(x, info_.width, width_, [&](int cell, double share) { target[cell] += share * glm::dvec4(rgb, 1.0); });
    }
    desaturated_ += desaturated;
  }

  void add_narrow(int y, const glm::dvec4* row) {
    distribute(y, info_.height, height_, [&](int cell, double share) {
      if (cell != open_row_) finish_row(cell);
      for (int x = 0; x < width_; ++x) sums_[static_cast<std::size_t>(x)] += share * row[x];
    });
    if (y + 1 == info_.height) finish_row(-1);
  }

  void finish_row(int next_row) {
    for (int x = 0; x < width_; ++x) {
      glm::dvec4& sum = sums_[static_cast<std::size_t>(x)];
      rgb_[static_cast<std::size_t>(open_row_) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)] =
          sum.w > 0.0 ? glm::vec3(glm::dvec3(sum) / sum.w) : glm::vec3(std::numeric_limits<float>::quiet_NaN());
      sum = glm::dvec4(0.0);
    }
    open_row_ = next_row;
  }

  HdrInfo info_;
  int width_ = 0;
  int height_ = 0;
  int open_row_ = 0;
  std::vector<glm::vec3> rgb_;
  std::vector<glm::dvec4> sums_;
  std::atomic<std::size_t> desaturated_ = 0;
};

glm::vec3 mean_of_valid_neighbours(const Environment& environment, int x, int y) {
  glm::dvec3 sum(0.0);
  int count = 0;
  for (int ny = std::max(0, y - 1); ny <= std::min(environment.height - 1, y + 1); ++ny) {
    for (int dx = -1; dx <= 1; ++dx) {
      const int nx = (x + dx + environment.width) % environment.width;
      const glm::vec3& rgb = environment.rgb[texel_index(environment, nx, ny)];
      if (!is_valid(rgb)) continue;
      sum += rgb;
      ++count;
    }
  }
  return count ? glm::vec3(sum / static_cast<double>(count)) : glm::vec3(0.0f);
}

void repair_texels(Environment& environment) {
  std::vector<std::vector<std::pair<std::size_t, glm::vec3>>> repairs(static_cast<std::size_t>(environment.height));
  parallel_for(0, environment.height, [&](int y) {
    for (int x = 0; x < environment.width; ++x) {
      const std::size_t i = texel_index(environment, x, y);
      if (!is_valid(environment.rgb[i]))
        repairs[static_cast<std::size_t>(y)].emplace_back(i, mean_of_valid_neighbours(environment, x, y));
    }
  });
  std::size_t count = 0;
  for (const auto& row : repairs) {
    for (const auto& [i, rgb] : row) environment.rgb[i] = rgb;
    count += row.size();
  }
  if (count)
    environment.warnings.push_back(texels_text(count) +
                                   " not finite, negative or above 1e15 and became the mean of the neighbours");
}

void finish(Environment& environment) {
  repair_texels(environment);
  if (environment.width != 2 * environment.height && environment.width * environment.height > 1)
    environment.warnings.push_back("is not twice as wide as high (" + std::to_string(environment.width) + " x " +
                                   std::to_string(environment.height) + "); it is read as latitude-longitude");
  environment.hash = content_key(environment);
}

/// Of `builtin:clear-sky:DEG`.
double sun_elevation(const std::string& source, const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  if (!whole || !(value >= kLeastSunElevationDeg && value <= kMostSunElevationDeg))
    throw Error(source, "\"" + text + "\" is no elevation of the sun", "give degrees from 3 to 87");
  return value;
}

Environment make_builtin(const std::string& source, const std::string& name) {
  if (name == "clear-sky") return make_clear_sky();
  if (name.starts_with("clear-sky:")) return make_clear_sky(sun_elevation(source, name.substr(10)));
  if (name == "studio") return make_studio();
  std::string names;
  for (const std::string& known : builtin_environment_names())
    names += (names.empty() ? "builtin:" : ", builtin:") + known;
  throw UsageError(source, "no such built-in environment", "use one of " + names);
}

}  // namespace

std::vector<std::string> builtin_environment_names() { return {"clear-sky", "studio"}; }

std::uint64_t content_key(const Environment& environment) {
  if (environment.hash != 0) return environment.hash;
  const std::uint64_t size =
      (static_cast<std::uint64_t>(environment.width) << 32) | static_cast<std::uint64_t>(environment.height);
  return content_hash(std::as_bytes(std::span(environment.rgb)), size);
}

Environment load_environment(const std::string& source) {
  constexpr std::string_view kPrefix = "builtin:";
  Environment environment;
  if (source.starts_with(kPrefix)) {
    environment = make_builtin(source, source.substr(kPrefix.size()));
    environment.name = source;
  } else {
    RowReducer reducer;
    stream_hdr_image(
        source, HdrUse::environment, [&](const HdrInfo& info) { reducer.begin(info); },
        [&](int first_row, int row_count, const float* values) { reducer.add(first_row, row_count, values); });
    environment = reducer.release();
    environment.name = std::filesystem::path(source).filename().string();
  }
  finish(environment);
  return environment;
}

glm::dvec3 direction_from_latlong(double x, double y, int width, int height) {
  const double lon = std::numbers::pi - 2.0 * std::numbers::pi * x / width;
  const double lat = std::numbers::pi / 2.0 - std::numbers::pi * y / height;
  return {std::sin(lon) * std::cos(lat), std::sin(lat), std::cos(lon) * std::cos(lat)};
}

glm::dvec2 latlong_from_direction(const glm::dvec3& direction, int width, int height) {
  const double lon = std::atan2(direction.x, direction.z);
  const double lat = std::atan2(direction.y, std::hypot(direction.x, direction.z));
  return {(std::numbers::pi - lon) / (2.0 * std::numbers::pi) * width,
          (std::numbers::pi / 2.0 - lat) / std::numbers::pi * height};
}

glm::dvec3 evaluate_environment(const Environment& environment, const glm::dvec3& direction) {
  const glm::dvec2 point = latlong_from_direction(direction, environment.width, environment.height) - 0.5;
  const double x0 = std::floor(point.x);
  const double y0 = std::floor(point.y);
  const auto texel = [&](double x, double y) {
    const int column = (static_cast<int>(x) + environment.width) % environment.width;
    const int row = std::clamp(static_cast<int>(y), 0, environment.height - 1);
    return glm::dvec3(environment.rgb[texel_index(environment, column, row)]);
  };
  const glm::dvec3 top = glm::mix(texel(x0, y0), texel(x0 + 1, y0), point.x - x0);
  const glm::dvec3 bottom = glm::mix(texel(x0, y0 + 1), texel(x0 + 1, y0 + 1), point.x - x0);
  return glm::mix(top, bottom, point.y - y0);
}

}  // namespace maquette
