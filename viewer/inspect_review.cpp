#include "viewer/inspect_review.h"

#include <nlohmann/json.hpp>

#include "viewer/bake_lines.h"

namespace maquette {

namespace {

template <typename T>
std::vector<std::string> names_of(const std::vector<T>& things) {
  std::vector<std::string> names;
  for (const T& thing : things) names.push_back(thing.name);
  return names;
}

}  // namespace

nlohmann::ordered_json inspect_review(const std::string& file) {
  std::vector<ReviewBake> bakes;
  const Review review = load_review(file, &bakes);
  nlohmann::ordered_json json;
  json["kind"] = "review";
  json["scene"] = review.scene;
  json["environment"] = review.look.edits.environment;
  json["mode"] = review.look.mode;
  json["looks"] = names_of(review.looks);
  json["paths"] = names_of(review.paths);
  json["missing_files"] = missing_sources(review);
  json["changed_files"] = changed_sources(file);
  json["bakes"] = nlohmann::ordered_json::array();
  for (const ReviewBake& bake : bakes)
    json["bakes"].push_back({{"bake", bake.bake},
                             {"key", bake.key},
                             {"of", owners_text(bake)},
                             {"state", find_bake({review, bakes}, bake) == BakeFound::there ? "kept" : "to be made"}});
  return json;
}

}  // namespace maquette
