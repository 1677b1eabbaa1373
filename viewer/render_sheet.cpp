#include "viewer/render_sheet.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include "render/gl/context.h"
#include "scenes/error.h"
#include "scenes/image_io.h"
#include "viewer/command_line.h"
#include "viewer/look_stage.h"
#include "viewer/outputs.h"
#include "viewer/print.h"
#include "viewer/review_options.h"

namespace maquette {

namespace {

constexpr int kGap_px = 4;
constexpr int kLargestSide_px = 32768;

struct Sheet {
  std::string part;                  ///< the material whose sources are the columns; empty: one column
  std::vector<std::string> sources;  ///< of it, in their order
  std::vector<std::string> environments;
};

Sheet sheet_of(const CommandLine& line) {
  const SceneOptions& options = line.options;
  Sheet sheet;
  std::map<std::string, std::size_t> counts;
  for (const auto& [name, source] : options.materials) ++counts[name];
  for (const auto& [name, source] : options.materials) {
    if (counts[name] < 2) continue;
    if (!sheet.part.empty() && name != sheet.part)
      throw UsageError("--material " + name, "the sheet varies " + sheet.part + " already",
                       "give several sources to one material only");
    sheet.part = name;
    sheet.sources.push_back(source);
  }
  sheet.environments = line.environments;
  if (sheet.environments.empty()) sheet.environments.push_back(options.environment);
  if (sheet.sources.size() < 2 && sheet.environments.size() < 2)
    throw UsageError("--sheet", "there is nothing to vary", "give --material NAME=FILE or --env FILE several times");
  return sheet;
}

void check_size(const SceneOptions& options, std::size_t columns, std::size_t rows) {
  const auto side = [](int cell, std::size_t count) { return static_cast<std::size_t>(cell + kGap_px) * count; };
  if (side(options.width, columns) > kLargestSide_px || side(options.height, rows) > kLargestSide_px)
    throw UsageError("--size", "the sheet would be wider or higher than 32768 pixels", "ask for smaller cells");
}

}  // namespace

Image join_pictures(const std::vector<Image>& pictures, int columns, int gap_px) {
  if (pictures.empty()) return {};
  const Image& first = pictures.front();
  const int rows = (static_cast<int>(pictures.size()) + columns - 1) / columns;
  Image joined(columns * (first.width + gap_px) - gap_px, rows * (first.height + gap_px) - gap_px, first.channels);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const int x0 = static_cast<int>(i) % columns * (first.width + gap_px),
              y0 = static_cast<int>(i) / columns * (first.height + gap_px);
    for (int y = 0; y < first.height; ++y) {
      const auto from = pictures[i].data.begin() + static_cast<std::ptrdiff_t>(pictures[i].index(0, y));
      std::copy_n(from, static_cast<std::size_t>(first.width) * static_cast<std::size_t>(first.channels),
                  joined.data.begin() + static_cast<std::ptrdiff_t>(joined.index(x0, y0 + y)));
    }
  }
  return joined;
}

int render_sheet(const CommandLine& line) {
  const SceneOptions& options = line.options;
  const Sheet sheet = sheet_of(line);
  if (options.output.empty()) throw UsageError("--sheet", "it is one picture", "add --output FILE.png or FILE.exr");
  std::vector<std::string> others = input_files(options);
  others.insert(others.end(), sheet.environments.begin(), sheet.environments.end());
  check_replaces_none("--output", options.output, others);
  const bool png = picture_format(options.output) == PictureFormat::png;
  check_writable("--output", options.output);
  const std::size_t columns = std::max<std::size_t>(sheet.sources.size(), 1), rows = sheet.environments.size();
  check_size(options, columns, rows);

  const std::optional<Review> review = review_of(options);
  const std::shared_ptr<const Scene> scene =
      review ? std::make_shared<const Scene>(load_scene(review->scene, review->scene_of_file))
             : load_session_scene(without_edits(options));
  Look look = review ? look_of_review(*review, *scene, options) : absolute_sources(look_of_options(*scene, options));
  const GlContext context = GlContext::create_headless();
  LookStage stage(scene);
  SettledFrame settled;
  settled.size = {options.width, options.height, options.msaa, options.samples, options.seed};
  settled.frames = options.average;
  std::vector<Image> pictures;
  for (const std::string& environment : sheet.environments) {
    look.edits.environment = environment;
    float exposure_ev = 0.0f;
    for (std::size_t column = 0; column < columns; ++column) {
      if (!sheet.part.empty())
        for (const Material& material : scene->materials)
          if (sheet.part == "*" || material.name == sheet.part)
            look.edits.materials[material.name] = sheet.sources[column];
      if (png && column == 0) exposure_ev = stage.exposure_ev(look);  // one row can be compared by eye
      stage.render(look, settled);
      pictures.push_back(png ? stage.renderer().read_display(exposure_ev, look.tonemap)
                             : stage.renderer().read_radiance());
      print_line(stdout, "row %zu, column %zu: %s%s%s\n", (pictures.size() - 1) / columns + 1, column + 1,
                 environment.c_str(), sheet.part.empty() ? "" : ", ",
                 sheet.part.empty() ? "" : sheet.sources[column].c_str());
      std::fflush(stdout);
    }
  }
  const Image joined = join_pictures(pictures, static_cast<int>(columns), kGap_px);
  if (png)
    save_png(options.output, joined);
  else
    save_exr(options.output, joined, {{"maquette.sheet", sheet.part}});
  print_line(stdout, "%s: %dx%d, %zu rows, %zu columns\n", options.output.c_str(), joined.width, joined.height, rows,
             columns);
  return 0;
}

}  // namespace maquette
