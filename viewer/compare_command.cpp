#include <cstdio>

#include "scenes/error.h"
#include "scenes/image_io.h"
#include "viewer/command_line.h"
#include "viewer/commands.h"
#include "viewer/json_values.h"
#include "viewer/report_text.h"

namespace maquette {

namespace {

std::string size_text(const Image& image) { return std::to_string(image.width) + "x" + std::to_string(image.height); }

}  // namespace

int run_compare(const CommandLine& line) {
  const std::string& path = line.files[0];
  const std::string& reference_path = line.files[1];
  const Image image = load_hdr_image(path);
  const Image reference = load_hdr_image(reference_path);
  if (image.width != reference.width || image.height != reference.height)
    throw Error(path, "it has " + size_text(image) + " pixels, " + reference_path + " has " + size_text(reference),
                "compare pictures of one size");
  const nlohmann::ordered_json json = error_json(compare_images(image, reference));
  std::fputs(line.json ? (json.dump(2) + "\n").c_str() : report_text(json).c_str(), stdout);
  return 0;
}

}  // namespace maquette
