#include "tests/pictures/compare.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <set>

#include "scenes/image_io.h"

namespace maquette::pictures {

namespace {

namespace fs = std::filesystem;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double mean_magnitude(const Image& image) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    const auto value = static_cast<double>(image.data[i]);
    if ((image.channels == 4 && i % 4 == 3) || !std::isfinite(value)) continue;
    sum += std::abs(value);
    count += 1.0;
  }
  return sum / std::max(count, 1.0);
}

double relative_difference(float base, float other, double mean) {
  if (base == other || (std::isnan(base) && std::isnan(other))) return 0.0;
  if (!std::isfinite(base) || !std::isfinite(other)) return kInfinity;
  const double b = base, scale = std::max(std::abs(b), mean);
  return scale > 0.0 ? std::abs(static_cast<double>(other) - b) / scale : kInfinity;
}

/// First line of a file; empty without one.
std::string first_line(const fs::path& path) {
  std::string line;
  std::ifstream stream(path);
  std::getline(stream, line);
  return line;
}

/// Paths below the folder.
std::set<std::string> pictures_of(const fs::path& folder, const std::string& case_name) {
  std::set<std::string> files;
  if (fs::exists(folder / (case_name + ".exr"))) files.insert(case_name + ".exr");
  if (fs::is_directory(folder / case_name))
    for (const fs::directory_entry& entry : fs::directory_iterator(folder / case_name))
      if (entry.path().extension() == ".exr") files.insert(case_name + "/" + entry.path().filename().string());
  return files;
}

struct Verdict {
  PictureDifference worst;
  bool same = true;
  std::string text = "same";
};

void fail(Verdict* verdict, const std::string& text) {
  if (verdict->same) verdict->text = text;
  verdict->same = false;
}

Verdict judge(const fs::path& base, const fs::path& pictures, const PictureCase& c, const Tolerance& tolerance) {
  Verdict verdict;
  for (const auto& [folder, whose] : {std::pair{base, "base: "}, std::pair{pictures, "here: "}}) {
    const std::string error = first_line(folder / (c.name + ".error"));
    if (!error.empty()) fail(&verdict, whose + error);
  }
  const std::set<std::string> of_base = pictures_of(base, c.name), here = pictures_of(pictures, c.name);
  if (of_base != here) fail(&verdict, "not the same pictures were drawn");
  if (of_base.empty()) fail(&verdict, "nothing was drawn");
  for (const std::string& file : of_base) {
    if (!here.contains(file)) continue;
    const PictureDifference difference = compare_pictures(
        load_hdr_image((base / file).string()), load_hdr_image((pictures / file).string()), tolerance.relative);
    verdict.worst.largest = std::max(verdict.worst.largest, difference.largest);
    verdict.worst.failing_share = std::max(verdict.worst.failing_share, difference.failing_share);
    if (difference.failing_share > (c.adaptive ? tolerance.adaptive_share : 0.0)) fail(&verdict, "DIFFERS in " + file);
  }
  if (verdict.same && verdict.worst.failing_share > 0.0) verdict.text = "same, but for adaptive counts";
  return verdict;
}

}  // namespace

PictureDifference compare_pictures(const Image& base, const Image& picture, double tolerance) {
  if (base.width != picture.width || base.height != picture.height || base.channels != picture.channels)
    return {kInfinity, 1.0};
  const double mean = mean_magnitude(base);
  const auto channels = static_cast<std::size_t>(base.channels);
  PictureDifference difference;
  std::size_t failing = 0;
  for (std::size_t pixel = 0; pixel < base.data.size(); pixel += channels) {
    double largest = 0.0;
    for (std::size_t i = pixel; i < pixel + channels; ++i)
      largest = std::max(largest, relative_difference(base.data[i], picture.data[i], mean));
    difference.largest = std::max(difference.largest, largest);
    if (largest > tolerance) ++failing;
  }
  difference.failing_share = static_cast<double>(failing * channels) / static_cast<double>(base.data.size());
  return difference;
}

bool compare_folders(const fs::path& base, const fs::path& pictures, const std::vector<PictureCase>& cases,
                     const Tolerance& tolerance) {
  std::size_t same = 0;
  std::printf("%-48s %11s %10s  %s\n", "case", "largest", "failing", "verdict");
  for (const PictureCase& c : cases) {
    const Verdict verdict = judge(base, pictures, c, tolerance);
    if (verdict.same) ++same;
    std::printf("%-48s %11.2g %8.3f %%  %s\n", c.name.c_str(), verdict.worst.largest,
                100.0 * verdict.worst.failing_share, verdict.text.c_str());
  }
  std::printf("%zu of %zu the same\n", same, cases.size());
  return same == cases.size() && !cases.empty();
}

}  // namespace maquette::pictures
