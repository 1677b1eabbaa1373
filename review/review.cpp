#include "review/review.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>

#include "render/btf/btf_source.h"
#include "review/json_reader.h"
#include "review/json_text.h"
#include "review/look_json.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/gltf_file.h"
#include "scenes/json_fault.h"
#include "scenes/suggest.h"

namespace maquette {

using Json = nlohmann::json;
namespace fs = std::filesystem;

namespace {

constexpr int kReviewFormat = 1;
constexpr const char* kExtension = ".maquette.json";

std::string same(const std::string& source) { return source; }

bool is_file(const std::string& source) { return !source.empty() && !source.starts_with("builtin:"); }

/// The file or folder that a source names: a BTF's may say how it is read behind it.
std::string place_of(const std::string& source) {
  return is_btf_source(source) ? parse_btf_source(source).place : source;
}

Json document_json(const Review& review, const SourceMap& to_file) {
  Json looks = Json::array(), paths = Json::array(), regions = Json::array();
  for (const Look& look : review.looks) looks.push_back(look_json(look, to_file));
  for (const CameraPath& path : review.paths) paths.push_back(path_json(path));
  for (const InspectedRegion& r : review.regions)
    regions.push_back(
        {{"x", shortest(r.x)}, {"y", shortest(r.y)}, {"width", shortest(r.width)}, {"height", shortest(r.height)}});
  return {{"scene", {{"source", to_file(review.scene)}, {"name", review.scene_of_file}}},
          {"look", look_json(review.look, to_file)},
          {"looks", looks},
          {"paths", paths},
          {"regions", regions},
          {"inspection", inspection_json(review.inspection)}};
}

template <typename T>
void check_names(const std::vector<T>& things, const std::string& where, const std::string& what) {
  std::set<std::string> names;
  for (const T& thing : things) {
    if (thing.name.empty()) throw Error(where, "a " + what + " has no name", "give it one");
    if (!names.insert(thing.name).second)
      throw Error(where, "two of them are named \"" + thing.name + "\"", "rename one");
  }
}

/// Throws Error for one that is outside the picture.
InspectedRegion region_from_json(const Json& json, const std::string& where) {
  JsonReader reader(json, where);
  InspectedRegion region;
  region.x = reader.real("x", 0.0f, 1.0f);
  region.y = reader.real("y", 0.0f, 1.0f);
  region.width = reader.real("width", 0.0f, 1.0f);
  region.height = reader.real("height", 0.0f, 1.0f);
  reader.finish();
  constexpr float kRounding = 1e-5f;
  if (region.x + region.width > 1.0f + kRounding || region.y + region.height > 1.0f + kRounding)
    throw Error(where, "it reaches outside the picture", "x + width and y + height are at most 1");
  return region;
}

/// The members of a document; others may stand beside them.
Review read_document(JsonReader* reader, const SourceMap& from_file) {
  Review review;
  JsonReader scene(reader->member("scene"), reader->where("scene"));
  review.scene = from_file(scene.text("source"));
  review.scene_of_file = scene.text("name");
  scene.finish();
  review.look = look_from_json(reader->member("look"), reader->where("look"), from_file);
  const auto at = [&](const std::string& key, std::size_t i) {
    return reader->where(key + "[" + std::to_string(i) + "]");
  };
  const Json& looks = reader->list("looks");
  for (std::size_t i = 0; i < looks.size(); ++i)
    review.looks.push_back(look_from_json(looks[i], at("looks", i), from_file));
  const Json& paths = reader->list("paths");
  for (std::size_t i = 0; i < paths.size(); ++i) review.paths.push_back(path_from_json(paths[i], at("paths", i)));
  if (reader->has("regions")) {  // the first reviews had none, and nothing of the inspection
    const Json& regions = reader->list("regions");
    for (std::size_t i = 0; i < regions.size(); ++i)
      review.regions.push_back(region_from_json(regions[i], at("regions", i)));
  }
  if (reader->has("inspection"))
    review.inspection = inspection_from_json(reader->member("inspection"), reader->where("inspection"));
  check_names(review.looks, reader->where("looks"), "look");
  check_names(review.paths, reader->where("paths"), "path");
  return review;
}

Json parse_json(const std::string& text, const std::string& file) {
  try {
    return json_from_text(text);
  } catch (const Json::exception& problem) {
    throw Error(file, "it is damaged: " + json_fault(problem.what()),
                "a window restores it from its journal: maquette view " + file);
  }
}

std::string folder_of(const std::string& file) { return fs::absolute(file).parent_path().string(); }

void add_sources(const Look& look, std::vector<std::string>* sources) {
  const auto add = [&](const std::string& source) {
    if (is_file(source) && std::find(sources->begin(), sources->end(), source) == sources->end())
      sources->push_back(source);
  };
  add(look.edits.environment);
  for (const auto& [name, source] : look.edits.materials) add(source);
}

template <typename T>
const T& find_named(const std::vector<T>& things, const std::string& name, const std::string& option) {
  std::vector<std::string> names;
  for (const T& thing : things) {
    if (thing.name == name) return thing;
    names.push_back(thing.name);
  }
  throw UsageError(option + " " + name, "the review has none of that name",
                   names.empty() ? "it has none at all" : did_you_mean(name, names));
}

}  // namespace

bool is_review_file(const std::string& path) { return path.ends_with(kExtension); }

std::string relative_source(const std::string& source, const std::string& folder) {
  if (!is_file(source)) return source;
  const fs::path relative = fs::path(source).lexically_relative(folder);
  return relative.empty() ? source : relative.generic_string();
}

std::string absolute_source(const std::string& source, const std::string& folder) {
  if (!is_file(source)) return source;
  return (fs::path(folder) / source).lexically_normal().string();
}

Json review_document(const Review& review) {
  Review kept = review;
  kept.look = canonical(kept.look);
  return document_json(kept, same);
}

namespace {

/// What a review names is a file or a folder, after all links: no device and no pipe, which end late or never.
void require_files(const Review& review, const std::string& where) {
  for (const std::string& source : review_sources(review)) {
    std::error_code ignored;
    const fs::file_status status = fs::status(place_of(source), ignored);
    if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status))
      throw Error(where, "it names " + place_of(source) + ", which is neither a file nor a folder", "name another one");
  }
}

}  // namespace

Review review_from_document(const Json& document, const std::string& where) {
  JsonReader reader(document, where + ": ");
  Review review = read_document(&reader, same);
  reader.finish();
  require_files(review, where);
  return review;
}

std::string review_text(const Review& review, const std::string& file, const std::vector<ReviewBake>& bakes) {
  const std::string folder = folder_of(file);
  Json json = document_json(review, [&](const std::string& source) { return relative_source(source, folder); });
  json["maquette_review"] = kReviewFormat;
  json["program"] = MAQUETTE_VERSION;
  json["files"] = Json::object();
  for (const std::string& source : review_sources(review))
    if (fs::exists(place_of(source))) json["files"][relative_source(source, folder)] = source_hash(source);
  json["bakes"] = bakes_json(bakes, review);
  return json_text(json, 1) + "\n";
}

Review parse_review(const std::string& text, const std::string& file, std::vector<ReviewBake>* bakes) {
  const Json json = parse_json(text, file);
  JsonReader reader(json, file + ": ");
  if (reader.count("maquette_review", 1, 1000000) > kReviewFormat)
    throw Error(file, "it is of a newer version of the program", "update the program");
  reader.text("program");
  reader.object("files");
  const std::string folder = folder_of(file);
  Review review = read_document(&reader, [&](const std::string& source) {
    const std::string absolute = absolute_source(source, folder);
    if (std::error_code ignored; gltf::has_scheme(source) && is_file(source) && !fs::exists(absolute, ignored))
      throw Error(file, gltf::name_text(source) + " is not read: only files are", "name a file beside the review");
    return absolute;
  });
  std::vector<ReviewBake> named;
  if (reader.has("bakes"))  // reviews had none at first
    named = bakes_from_json(reader.list("bakes"), review, reader.where("bakes"));
  reader.finish();
  require_files(review, file);
  if (bakes) *bakes = std::move(named);
  return review;
}

Review load_review(const std::string& file, std::vector<ReviewBake>* bakes) {
  return parse_review(read_text_file(file), file, bakes);
}

void save_review(const std::string& file, const Review& review, const std::vector<ReviewBake>& bakes) {
  const std::string text = review_text(review, file, bakes);
  write_file_atomically(file, std::as_bytes(std::span(text.data(), text.size())));
}

std::vector<std::string> review_sources(const Review& review) {
  std::vector<std::string> sources;
  if (is_file(review.scene)) sources.push_back(review.scene);
  add_sources(review.look, &sources);
  for (const Look& look : review.looks) add_sources(look, &sources);
  return sources;
}

std::vector<std::string> missing_sources(const Review& review) {
  std::vector<std::string> missing = review_sources(review);
  std::erase_if(missing, [](const std::string& source) {
    std::error_code ignored;
    return fs::exists(place_of(source), ignored);
  });
  return missing;
}

std::vector<std::string> changed_sources(const std::string& file) {
  const Json json = parse_json(read_text_file(file), file);
  std::vector<std::string> changed;
  const auto files = json.find("files");
  if (files == json.end()) return changed;
  for (const auto& [source, hash] : files->items()) {
    const std::string absolute = absolute_source(source, folder_of(file));
    std::error_code ignored;
    if (fs::exists(place_of(absolute), ignored) && hash != source_hash(absolute)) changed.push_back(source);
  }
  return changed;
}

std::string source_hash(const std::string& source) {
  const std::string place = place_of(source);
  std::uint64_t hash = 0;
  const auto mix = [&](const std::string& text) {
    hash = content_hash(std::as_bytes(std::span(text.data(), text.size())), hash);
  };
  if (fs::is_directory(place)) {
    std::set<std::string> entries;
    for (const fs::directory_entry& entry : fs::directory_iterator(place))
      entries.insert(entry.path().filename().string() +
                     (entry.is_regular_file() ? " " + std::to_string(entry.file_size()) : ""));
    for (const std::string& entry : entries) mix(entry);
  } else {
    hash = content_hash(read_file(place));
  }
  char digits[20];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(hash));
  return digits;
}

const Look& find_look(const Review& review, const std::string& name) {
  return find_named(review.looks, name, "--look");
}

const CameraPath& find_path(const Review& review, const std::string& name) {
  return find_named(review.paths, name, "--path");
}

}  // namespace maquette
