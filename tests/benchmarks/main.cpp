// maquette_bench: prints every figure that the project promises, with its target and whether it is met.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <span>
#include <string>
#include <thread>

#include "render/raytraced/large_pages.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "tests/benchmarks/prt_curves.h"
#include "tests/benchmarks/stage.h"

namespace maquette::bench {
namespace {

struct Part {
  const char* name;
  const char* help;
  Figures (*measure)(Stage&);
};
constexpr Part kParts[] = {
    {"correct", "uniform against direct quadrature", measure_correct},
    {"research", "time to 2 % under Grace Cathedral, four measured tables", measure_research},
    {"samples", "deviation and time of one shading sample", measure_samples},
    {"converged", "noise of the converged pictures, and whether `uniform` converges to them", measure_converged},
    {"equal-quality", "time of bandwidth and uniform to the same error", measure_equal_quality},
    {"progressive", "error while nothing moves, bandwidth against uniform", measure_progressive},
    {"validate", "predicted against measured bandwidth and variance", measure_validation},
    {"multisampling", "cost of 4 samples a pixel", measure_multisampling},
    {"moving", "frames of the default picture while the camera flies or the light turns", measure_moving},
    {"pictures", "what the default mode shows over time, against all light paths", measure_pictures},
    {"interactive", "rotating light, first frame, swaps", measure_interactive},
    {"looks", "the window: first picture of another look, frames while a path plays", measure_looks},
    {"reflections", "reflection points on patches and triangles, a million each", measure_reflections},
    {"reflection-frames", "reflector techniques: time, growth with the scene, outlines", measure_reflection_frames},
    {"skipped-rays", "mirrored rays that need not be traced: share, time, FLIP", measure_skipping},
    {"octree", "octrees: build time, traversal against Embree, visibility", measure_octree},
    {"reference", "the path tracer: rays a second, against closed forms and uniform, the car's cabin",
     measure_path_tracer},
    {"meter", "time until the window has the error of a view at rest", measure_meter},
    {"slf", "surface light fields of the seat against mode reference: bases, compression, bake", measure_slf},
    {"prt", "radiance transfer of the seat: errors, light that turns, bake", measure_prt},
    {"prt-curves", "radiance transfer of a coarse cloth: compression, light, components, covers", measure_prt_curves},
    {"scaling", "cost against pixels and against samples", measure_scaling},
};

const char* verdict_text(Figure::Verdict verdict) {
  switch (verdict) {
    case Figure::Verdict::met:
      return "met";
    case Figure::Verdict::missed:
      return "missed";
    case Figure::Verdict::absent:
      return "not measured";
    default:
      return "";
  }
}

std::string first_line(const char* path, const std::string& key) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);)
    if (line.starts_with(key)) return line.substr(line.find(':') + 1);
  return {};
}

std::string load_average() {
  std::ifstream file("/proc/loadavg");
  std::string one;
  file >> one;
  return one;
}

std::string machine(const DeviceInfo& device) {
  return std::to_string(std::thread::hardware_concurrency()) + " cores of" + first_line("/proc/cpuinfo", "model name") +
         "; " + device.renderer + ", OpenGL " + device.version;
}

std::string markdown(const Figures& figures, const std::string& where) {
  std::string text = where + "\n\n| figure | target | measured | |\n| --- | --- | --- | --- |\n";
  for (const Figure& f : figures)
    text += "| " + f.name + " | " + f.target + " | " + f.measured + " | " + verdict_text(f.verdict) + " |\n";
  return text;
}

void print(const Figures& figures) {
  for (const Figure& f : figures)
    std::printf("%-58s %-22s %-40s %s\n", f.name.c_str(), f.target.c_str(), f.measured.c_str(),
                verdict_text(f.verdict));
  std::fflush(stdout);
}

Figures run_part(const Part& part, Stage& stage) {
  std::fprintf(stderr, "== %s (load %s)\n", part.name, load_average().c_str());
  try {
    return part.measure(stage);
  } catch (const std::exception& error) {
    return {absent(part.name, "", error.what())};
  }
}

int run(int argc, char** argv) {
  CLI::App app{"Measures what Maquette promises, and prints it beside the targets."};
  Options options;
  std::string markdown_path;
  std::vector<std::string> settings;
  options.scratch = (std::filesystem::temp_directory_path() / "maquette-bench").string();
  options.program = (std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path() / "maquette").string();
  app.add_option("--data", options.data, "folder with real scenes, environments and tables");
  app.add_option("--program", options.program, "the maquette program");
  app.add_option("--scratch", options.scratch, "references and tables are kept here between runs");
  app.add_option("--charts", options.charts, "folder for charts, of `reflection-frames` by the size of the scene");
  app.add_option("--case", options.only, "only cases whose name holds this (repeatable)");
  app.add_option("--set", settings, "setting=value for every frame (repeatable)");
  app.add_option("--repeats", options.repeats, "runs whose median counts");
  app.add_option("--reference-seconds", options.reference_seconds, "time for one reference picture");
  app.add_option("--sweep-seconds", options.sweep_seconds, "longest frame of a sweep");
  app.add_flag("--fresh", options.fresh, "make the references again");
  app.add_option("--markdown", markdown_path, "write the table to this file as well");
  app.require_subcommand(1, 0);
  app.fallthrough();
  app.add_subcommand("all", "every figure");
  for (const Part& part : kParts) app.add_subcommand(part.name, part.help);
  CLI11_PARSE(app, argc, argv);
  for (const std::string& s : settings) {
    const std::size_t equals = s.find('=');
    if (equals == std::string::npos) throw UsageError("--set", "'" + s + "' is not setting=value");
    options.settings.emplace_back(s.substr(0, equals), s.substr(equals + 1));
  }
  if (!options.data.empty() && !std::filesystem::is_directory(options.data))
    throw Error(options.data, "is not a folder");
  Stage stage(options);
  const std::string where = machine(stage.device());
  std::printf("%s; load at the start %s\n", where.c_str(), load_average().c_str());
  Figures all;
  for (const Part& part : kParts) {
    if (!app.got_subcommand("all") && !app.got_subcommand(part.name)) continue;
    const Figures figures = run_part(part, stage);
    print(figures);
    all.insert(all.end(), figures.begin(), figures.end());
  }
  if (!markdown_path.empty()) {
    const std::string text = markdown(all, where);
    write_file_atomically(markdown_path, std::as_bytes(std::span(text)));
  }
  return 0;
}

}  // namespace
}  // namespace maquette::bench

int main(int argc, char** argv) {
  maquette::restart_in_large_pages(argv);
  try {
    return maquette::bench::run(argc, argv);
  } catch (const maquette::UsageError& error) {
    std::fprintf(stderr, "maquette_bench: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "maquette_bench: %s\n", error.what());
    return 1;
  }
}
