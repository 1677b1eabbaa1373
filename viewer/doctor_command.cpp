#include <GLFW/glfw3.h>
#include <OpenEXR/OpenEXRConfig.h>
#include <draco/core/draco_version.h>
#include <embree3/rtcore_config.h>
#include <imgui.h>
#include <opensubdiv/version.h>
#include <tbb/version.h>
#include <unistd.h>
#include <xxhash.h>

#include <CLI/Version.hpp>
#include <Eigen/Core>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "render/gl/context.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "viewer/command_line.h"
#include "viewer/commands.h"
#include "viewer/outputs.h"
#include "viewer/report_text.h"

namespace maquette {

namespace {

using Json = nlohmann::ordered_json;

std::string version_text(int major, int minor, int patch) {
  return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch);
}

Json libraries_json() {
  int major = 0, minor = 0, patch = 0;
  glfwGetVersion(&major, &minor, &patch);
  return {
      {"GLFW", version_text(major, minor, patch)},
      {"Dear ImGui", IMGUI_VERSION},
      {"GLM", version_text(GLM_VERSION_MAJOR, GLM_VERSION_MINOR, GLM_VERSION_PATCH)},
      {"OpenEXR", OPENEXR_VERSION_STRING},
      {"OpenSubdiv", version_text(OPENSUBDIV_VERSION_MAJOR, OPENSUBDIV_VERSION_MINOR, OPENSUBDIV_VERSION_PATCH)},
      {"Draco", draco::kDracoVersion},
      {"Embree", RTC_VERSION_STRING},
      {"TBB", version_text(TBB_VERSION_MAJOR, TBB_VERSION_MINOR, TBB_VERSION_PATCH)},
      {"Eigen", version_text(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
      {"nlohmann json",
       version_text(NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR, NLOHMANN_JSON_VERSION_PATCH)},
      {"CLI11", CLI11_VERSION},
      {"xxHash", version_text(XXH_VERSION_MAJOR, XXH_VERSION_MINOR, XXH_VERSION_RELEASE)},
  };
}

struct Limit {
  const char* name;
  int found;
  int needed;
};

/// Adds the limits, and what fails for those that are too low.
void append_limits(const DeviceInfo& device, Json* report, Json* problems) {
  const Limit limits[] = {
      {"storage_block_bytes", device.max_storage_block_bytes, 1 << 27},
      {"uniform_block_bytes", device.max_uniform_block_bytes, 1 << 16},
      {"texture_buffer_texels", device.max_texture_buffer_texels, 1 << 26},
      {"texture_size", device.max_texture_size, 8192},
      {"texture_layers", device.max_layers, 2048},
      {"compute_shared_bytes", device.max_compute_shared_bytes, 32768},
  };
  for (const Limit& limit : limits) {
    (*report)["limits"][limit.name] = std::to_string(limit.found) + " (needed: " + std::to_string(limit.needed) + ")";
    if (limit.found < limit.needed)
      problems->push_back(std::string(limit.name) + " is " + std::to_string(limit.found) + ", " +
                          std::to_string(limit.needed) + " is needed: large scenes, tables or pictures may fail");
  }
  (*report)["limits"]["samples"] = std::to_string(device.max_samples);
}

/// Whether a context could be made.
bool append_graphics(Json* report, Json* problems) {
  try {
    const GlContext context = GlContext::create_headless();
    const DeviceInfo device = query_device();
    (*report)["graphics"] = {{"vendor", device.vendor},
                             {"renderer", device.renderer},
                             {"OpenGL", device.version},
                             {"GLSL", device.shading_language}};
    append_limits(device, report, problems);
    if (device.software)
      problems->push_back("graphics: a software renderer (" + device.renderer + "): everything works, slowly");
    return true;
  } catch (const Error& error) {
    const std::string message = error.what(), key = "graphics: ";
    (*report)["graphics"] = message.starts_with(key) ? message.substr(key.size()) : message;
    problems->push_back(std::string("nothing can be drawn: ") + error.what());
    return false;
  }
}

std::optional<std::string> find_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  const std::string folders = path ? path : "";
  std::size_t begin = 0;
  while (begin <= folders.size()) {
    const std::size_t end = std::min(folders.find(':', begin), folders.size());
    const std::string file = folders.substr(begin, end - begin) + "/" + name;
    if (access(file.c_str(), X_OK) == 0) return file;
    begin = end + 1;
  }
  return std::nullopt;
}

void append_programs(Json* report, Json* problems) {
  for (const auto& [name, use] : {std::pair{"ffmpeg", "video"}, std::pair{"gnuplot", "charts"}}) {
    const std::optional<std::string> found = find_program(name);
    (*report)["programs"][name] = found.value_or("not found");
    if (!found) problems->push_back(std::string(name) + " is not installed: no " + use + " in versions that make it");
  }
}

void append_display(Json* report, Json* problems) {
  for (const char* name : {"WAYLAND_DISPLAY", "DISPLAY"}) {
    const char* value = std::getenv(name);
    if (value == nullptr || *value == 0) continue;
    (*report)["display"] = std::string(name) + "=" + value;
    return;
  }
  (*report)["display"] = "none";
  problems->push_back("there is no display: `view` will not work, `render` will");
}

void append_cache(Json* report, Json* problems) {
  const std::optional<std::filesystem::path> folder = cache_folder();
  if (!folder) {
    (*report)["cache"] = "off";
    problems->push_back(
        "the cache is off (MAQUETTE_CACHE is empty or there is no HOME): tables are computed at every start");
    return;
  }
  std::error_code error;
  std::filesystem::create_directories(*folder, error);
  std::uintmax_t bytes = 0;
  for (std::filesystem::recursive_directory_iterator entry(*folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code ignored;
    const std::uintmax_t size = entry->is_regular_file(ignored) ? entry->file_size(ignored) : 0;
    if (!ignored) bytes += size;
  }
  (*report)["cache"] = folder->string() + ", " + std::to_string(bytes >> 20) + " MiB";
  try {
    check_writable("", (*folder / "probe").string());
  } catch (const Error& problem) {
    problems->push_back(std::string("the cache cannot be written: tables are computed at every start (") +
                        problem.what() + ")");
  }
}

}  // namespace

int run_doctor(const CommandLine& line) {
  Json report, problems = Json::array();
  report["maquette"] = MAQUETTE_VERSION;
  const bool can_draw = append_graphics(&report, &problems);
  append_display(&report, &problems);
  append_cache(&report, &problems);
  report["libraries"] = libraries_json();
  append_programs(&report, &problems);
  report["what_will_not_work_here"] = problems;
  print_report(line.json, report);
  return can_draw ? 0 : 1;
}

}  // namespace maquette
