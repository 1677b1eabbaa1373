
#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <span>

#include "scenes/btf/btf_reading.h"
#include "scenes/btf/btf_values.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/image_io.h"
#include "scenes/parallel.h"
#include "scenes/texture_formats.h"

namespace maquette {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostNamed = 5;  // of the missing images

/// A direction as its angles in thousandths of a degree: names repeat them exactly. The pole has one azimuth.
struct AngleKey {
  long theta = 0, phi = 0;
  auto operator<=>(const AngleKey&) const = default;
  glm::dvec3 direction() const {
    return direction_of_angles(static_cast<double>(theta) / 1e3, static_cast<double>(phi) / 1e3);
  }
};
AngleKey key_of(double theta_deg, double phi_deg) {
  const long theta = std::lround(theta_deg * 1e3), turn = 360000;
  const long phi = theta == 0 ? 0 : (std::lround(phi_deg * 1e3) % turn + turn) % turn;
  return {theta, phi};
}

using ViewImages = std::map<AngleKey, std::string>;   // by light
using FolderImages = std::map<AngleKey, ViewImages>;  // by view

bool is_image(const std::string& path) {
  const std::string extension = lower_extension(path);
  return extension == ".jpg" || extension == ".jpeg" || extension == ".png" || extension == ".exr" ||
         extension == ".hdr";
}

std::vector<std::string> image_paths(const std::string& folder) {
  std::vector<std::string> paths;
  try {
    for (const fs::directory_entry& entry :
         fs::recursive_directory_iterator(folder, fs::directory_options::follow_directory_symlink))
      if (is_image(entry.path().string()) && entry.is_regular_file()) paths.push_back(entry.path().string());
  } catch (const fs::filesystem_error& error) {
    throw Error(folder, "cannot be read (" + error.code().message() + ")", "check the path and its permissions");
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

void check_angles(const std::string& path, const BtfAngles& angles, bool cosine) {
  for (const double theta : {angles.theta_l, angles.theta_v})
    if (!(theta >= 0.0 && theta <= 90.0))
      throw Error(path, "has an angle of " + btf_number(theta) + " degrees to the normal, expected 0 to 90",
                  "correct its name");
  if (cosine && angles.theta_l > 89.0)
    throw Error(path, "has its light along the surface, where values with the cosine say nothing",
                "remove it, or set btf.cosine=false");
}

FolderImages list_images(const std::string& folder, bool cosine) {
  FolderImages images;
  for (const std::string& path : image_paths(folder)) {
    BtfAngles angles;
    if (!parse_btf_angles(fs::path(path).filename().string(), &angles)) continue;
    check_angles(path, angles, cosine);
    std::string& place = images[key_of(angles.theta_v, angles.phi_v)][key_of(angles.theta_l, angles.phi_l)];
    if (!place.empty())
      throw Error(path, "has the angles of " + fs::path(place).filename().string(), "remove one of them");
    place = path;
  }
  if (images.empty())
    throw Error(folder, "is a folder without images that are named by their angles",
                "expected names like \"tl015 pl000 tv030 pv060.jpg\" (.jpg, .png, .exr, .hdr)");
  return images;
}

/// The count of lights that most views have; the larger of equally frequent ones.
std::size_t usual_count(const FolderImages& images) {
  std::map<std::size_t, std::size_t> counts;
  for (const auto& [view, lights] : images) ++counts[lights.size()];
  return std::max_element(counts.begin(), counts.end(),
                          [](const auto& a, const auto& b) {
                            return a.second != b.second ? a.second < b.second : a.first < b.first;
                          })
      ->first;
}

/// A light may have been moved in single views, so lists of lights differ; their count does not.
void check_complete(const std::string& folder, const FolderImages& images) {
  const std::size_t usual = usual_count(images);
  std::map<AngleKey, std::size_t> seen;
  for (const auto& [view, lights] : images)
    for (const auto& [light, path] : lights) ++seen[light];
  std::size_t missing = 0;
  std::string names;
  for (const auto& [view, lights] : images) {
    if (lights.size() >= usual) continue;
    std::size_t open = usual - lights.size();
    for (const auto& [light, count] : seen) {
      if (open == 0) break;
      if (lights.contains(light) || 2 * count < images.size()) continue;
      --open;
      if (++missing > kMostNamed) continue;
      names += (names.empty() ? "" : ", ") + btf_angles_text(light.direction(), 'l') + " " +
               btf_angles_text(view.direction(), 'v');
    }
    missing += open;
    if (names.empty()) names = "some of " + btf_angles_text(view.direction(), 'v');
  }
  if (missing == 0) return;
  throw Error(folder,
              std::to_string(missing) + " of " + std::to_string(images.size() * usual) +
                  " images are missing: " + names + (missing > kMostNamed ? ", ..." : ""),
              "copy the folder again");
}

struct PlainImage {
  int width = 0, height = 0;
  std::vector<float> rgb;  ///< linear
};

PlainImage decode_low_range(const std::string& path, double gamma) {
  TextureImage image;
  std::vector<std::string> notes;
  try {
    decode_texture(read_file(path), &image, &notes);
  } catch (const Error& error) {
    throw Error(path, error.what());
  }
  PlainImage out{image.width, image.height, {}};
  const std::size_t texels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  out.rgb.resize(3 * texels);
  std::array<float, 256> table;
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = linear_of_encoded(static_cast<float>(i) / 255.0f, gamma);
  for (std::size_t t = 0; t < texels; ++t)
    for (std::size_t c = 0; c < 3; ++c)
      out.rgb[3 * t + c] = image.rgba16.empty()
                               ? table[image.rgba[4 * t + c]]
                               : linear_of_encoded(static_cast<float>(image.rgba16[4 * t + c]) / 65535.0f, gamma);
  return out;
}

PlainImage decode_high_range(const std::string& path, double gamma) {
  const Image image = load_hdr_image(path);
  PlainImage out{image.width, image.height, {}};
  const auto channels = static_cast<std::size_t>(image.channels);
  for (std::size_t i = 0; i < image.data.size(); i += channels)
    for (std::size_t c = 0; c < 3; ++c) {
      const float value = image.data[i + c];
      out.rgb.push_back(gamma > 0.0 && gamma != 1.0 ? linear_of_encoded(value, gamma) : value);
    }
  check_finite(path, "the image", out.rgb.data(), out.rgb.size());
  return out;
}

PlainImage load_plain(const std::string& path, double gamma) {
  const std::string extension = lower_extension(path);
  return extension == ".exr" || extension == ".hdr" ? decode_high_range(path, gamma) : decode_low_range(path, gamma);
}

/// Reads the images of one view, as rho.
class ViewReader {
 public:
  ViewReader(const std::string& folder, const BtfReading& reading) : folder_(folder), reading_(reading) {}

  /// From the first image that is read.
  int width() const { return width_; }
  int height() const { return height_; }

  std::vector<float> read(const ViewImages& images) {
    std::vector<std::pair<AngleKey, std::string>> list(images.begin(), images.end());
    if (width_ == 0) {
      const PlainImage first = load_plain(list[0].second, reading_.gamma);
      if (first.width > kMostBtfSide || first.height > kMostBtfSide)
        throw Error(list[0].second, "has more than 8,192 texels a side", "make the images smaller");
      width_ = first.width;
      height_ = first.height;
      first_ = list[0].second;
    }
    const std::size_t texels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    if (list.size() * texels * 3 * sizeof(float) > kMostViewBytes)
      throw Error(folder_, "the images of one view are more than 4 GiB", "make them smaller");
    std::vector<float> values(list.size() * texels * 3);
    parallel_for(std::size_t{0}, list.size(), [&](std::size_t l) {
      const PlainImage image = load_plain(list[l].second, reading_.gamma);
      if (image.width != width_ || image.height != height_)
        throw Error(list[l].second,
                    "has " + std::to_string(image.width) + " x " + std::to_string(image.height) + " texels, " +
                        fs::path(first_).filename().string() + " has " + std::to_string(width_) + " x " +
                        std::to_string(height_),
                    "give all images one size");
      const float scale = rho_of_value(reading_.cosine, list[l].first.direction());
      std::transform(image.rgb.begin(), image.rgb.end(), values.begin() + static_cast<std::ptrdiff_t>(l * texels * 3),
                     [&](float v) { return v * scale; });
    });
    return values;
  }

 private:
  const std::string& folder_;
  const BtfReading& reading_;
  int width_ = 0, height_ = 0;
  std::string first_;
};

/// The number that begins at `at`, or nothing.
std::optional<double> number_at(const std::string& text, std::size_t at) {
  std::size_t end = at;
  if (end < text.size() && (text[end] == '-' || text[end] == '+')) ++end;
  const std::size_t digits = end;
  while (end < text.size() && std::isdigit(static_cast<unsigned char>(text[end]))) ++end;
  if (end == digits) return std::nullopt;
  if (end + 1 < text.size() && text[end] == '.' && std::isdigit(static_cast<unsigned char>(text[end + 1]))) {
    ++end;
    while (end < text.size() && std::isdigit(static_cast<unsigned char>(text[end]))) ++end;
  }
  return std::stod(text.substr(at, end - at));
}

}  // namespace

bool parse_btf_angles(const std::string& name, BtfAngles* angles) {
  std::string text = name;
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto find = [&](const char* tag, double* value) {
    for (std::size_t at = text.rfind(tag); at != std::string::npos;
         at = at == 0 ? std::string::npos : text.rfind(tag, at - 1))
      if (const std::optional<double> number = number_at(text, at + 2)) {
        *value = *number;
        return true;
      }
    return false;
  };
  return find("tl", &angles->theta_l) && find("pl", &angles->phi_l) && find("tv", &angles->theta_v) &&
         find("pv", &angles->phi_v);
}

Btf read_btf_folder(const std::string& folder, const BtfReading& reading, const BtfTask& task) {
  const FolderImages images = list_images(folder, reading.cosine);
  check_complete(folder, images);
  Btf btf;
  btf.name = fs::path(folder).lexically_normal().filename().string();
  if (btf.name.empty()) btf.name = fs::path(folder).parent_path().filename().string();
  btf.components = reading.components;
  btf.texel_m = reading.texel_m > 0.0 ? reading.texel_m : kUnknownTexel_m;
  btf.provenance = {{"source", folder},
                    {"btf.cosine", reading.cosine ? "true" : "false"},
                    {"btf.gamma", btf_number(reading.gamma)},
                    {"texel", reading.texel_m > 0.0 ? "btf.texel_mm" : "assumed: images do not say it"}};
  ViewReader reader(folder, reading);
  BtfLightSets sets;
  for (const auto& [view, lights] : images) {
    task.check(folder);
    task.report("reading " + btf.name, static_cast<double>(btf.views.size()) / static_cast<double>(images.size()));
    std::vector<float> values = reader.read(lights);
    std::vector<glm::dvec3> directions;
    for (const auto& [light, path] : lights) directions.push_back(light.direction());
    btf.views.push_back(factorise_btf_view(view.direction(), sets.find(directions), btf.components, &values));
  }
  btf.width = reader.width();
  btf.height = reader.height();
  complete_btf(&btf);
  task.report("reading " + btf.name, 1.0);
  return btf;
}

std::uint64_t btf_content_key(const std::string& source) {
  std::vector<std::string> paths = {source};
  std::error_code code;
  if (fs::is_directory(source, code)) {
    paths.clear();
    BtfAngles ignored;
    for (const std::string& path : image_paths(source))
      if (parse_btf_angles(fs::path(path).filename().string(), &ignored)) paths.push_back(path);
  }
  std::vector<std::uint64_t> hashes(paths.size());
  parallel_for(std::size_t{0}, paths.size(), [&](std::size_t i) {
    const std::string name = fs::path(paths[i]).filename().string();
    const std::vector<std::byte> bytes = read_file(paths[i], std::size_t{64} << 30);
    hashes[i] = content_hash(bytes, content_hash(std::as_bytes(std::span(name))));
  });
  return content_hash(std::as_bytes(std::span(hashes)));
}

}  // namespace maquette
