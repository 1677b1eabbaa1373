#pragma once

#include <algorithm>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "review/camera_path.h"
#include "review/inspection_setup.h"
#include "review/look.h"
#include "review/review_bakes.h"

namespace maquette {

/// A rectangle of the picture that the inspection measures, 0 to 1 from the top left.
struct InspectedRegion {
  float x = 0.0f, y = 0.0f, width = 0.0f, height = 0.0f;
  bool operator==(const InspectedRegion&) const = default;
};

/// All that a user makes of a scene: the state at hand, what was kept of looks, paths and
/// regions, and how panes are inspected. Sources are built-in
/// names and absolute paths.
struct Review {
  std::string scene = "builtin:cockpit";
  std::string scene_of_file;  ///< name or index of a glTF scene; empty: the file's default
  Look look;                  ///< the state at hand
  std::vector<Look> looks;
  std::vector<CameraPath> paths;
  std::vector<InspectedRegion> regions;
  InspectionSetup inspection;
  bool operator==(const Review&) const = default;
};

bool is_review_file(const std::string& path);  ///< by `.maquette.json`

/// The review as undo and journal keep it: without the exposure that was only metered, sources as they are.
nlohmann::json review_document(const Review& review);
/// `where`: for messages. Throws Error: what look_from_json and path_from_json throw, and names that are there twice.
Review review_from_document(const nlohmann::json& document, const std::string& where);

/// Text of a `.maquette.json` (docs/formats.md): sources relative to its folder, with hashes of their contents. Bakes
/// of looks that the review does not have are left out.
std::string review_text(const Review& review, const std::string& file, const std::vector<ReviewBake>& bakes = {});
/// Throws Error: no such file, JSON that is damaged, a newer version, unknown members (the nearest names).
/// `bakes`: what the file says of them; may be null.
Review load_review(const std::string& file, std::vector<ReviewBake>* bakes = nullptr);
/// Of the text itself; `file` gives the folder, and the name for messages.
Review parse_review(const std::string& text, const std::string& file, std::vector<ReviewBake>* bakes = nullptr);
/// Writes beside and renames. Throws Error.
void save_review(const std::string& file, const Review& review, const std::vector<ReviewBake>& bakes = {});

/// Files that the review names, each once: the scene first.
std::vector<std::string> review_sources(const Review& review);
/// Of them those that are not there.
std::vector<std::string> missing_sources(const Review& review);
/// Those that are there with another content than the file says, by the hashes in its text.
std::vector<std::string> changed_sources(const std::string& file);

/// Of a file its bytes, of a folder (a BTF's images) the names and sizes in it; 16 hexadecimal digits.
std::string source_hash(const std::string& source);

/// By name. Throws UsageError with the nearest names.
const Look& find_look(const Review& review, const std::string& name);
const CameraPath& find_path(const Review& review, const std::string& name);
/// `name`, or with a number behind it where one of these has it already.
template <typename T>
std::string free_name(const std::vector<T>& things, const std::string& name) {
  const auto taken = [&](const std::string& wanted) {
    return std::any_of(things.begin(), things.end(), [&](const T& thing) { return thing.name == wanted; });
  };
  if (!taken(name)) return name;
  int number = 2;
  while (taken(name + " " + std::to_string(number))) ++number;
  return name + " " + std::to_string(number);
}

/// A source as it stands in a file of this folder, and back.
std::string relative_source(const std::string& source, const std::string& folder);
std::string absolute_source(const std::string& source, const std::string& folder);

}  // namespace maquette
