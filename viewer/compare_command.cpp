#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "scenes/error.h"
#include "scenes/image_io.h"
#include "viewer/command_line.h"
#include "viewer/commands.h"
#include "viewer/json_values.h"
#include "viewer/outputs.h"
#include "viewer/report_text.h"

namespace maquette {

namespace {

std::string size_text(const Image& image) { return std::to_string(image.width) + "x" + std::to_string(image.height); }

/// .png: FLIP in false colours; .exr: the absolute difference of R, G and B, alpha of the reference.
void write_difference(const std::string& path, const ErrorReport& report, const Image& image, const Image& reference) {
  if (picture_format(path) == PictureFormat::png) return save_png(path, difference_picture(report, image, reference));
  Image difference(reference.width, reference.height, 4, 1.0f);
  for (int y = 0; y < reference.height; ++y) {
    for (int x = 0; x < reference.width; ++x) {
      for (int c = 0; c < 3; ++c) difference.at(x, y, c) = std::abs(image.at(x, y, c) - reference.at(x, y, c));
      if (reference.channels > 3) difference.at(x, y, 3) = reference.at(x, y, 3);
    }
  }
  save_exr(path, difference, {{"maquette.difference", "absolute"}});
}

}  // namespace

int run_compare(const CommandLine& line) {
  const std::string& path = line.files[0];
  const std::string& reference_path = line.files[1];
  const std::string& output = line.options.output;
  if (!output.empty()) {
    picture_format(output);
    check_replaces_none("--output", output, line.files);
    check_writable("--output", output);
  }
  const Image image = load_picture(path);
  const Image reference = load_picture(reference_path);
  if (image.width != reference.width || image.height != reference.height)
    throw Error(path, "it has " + size_text(image) + " pixels, " + reference_path + " has " + size_text(reference),
                "compare pictures of one size");
  const ErrorReport report = measure_error(image, reference);
  if (!output.empty()) write_difference(output, report, image, reference);
  const nlohmann::ordered_json json = error_json(report.figures);
  print_report(line.json, json);
  return 0;
}

}  // namespace maquette
