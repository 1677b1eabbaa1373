#include "review/review_bakes.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "review/json_reader.h"
#include "review/review.h"
#include "scenes/error.h"
#include "scenes/suggest.h"

namespace maquette {

using Json = nlohmann::json;

namespace {

/// Null where there is none of that name; the state at hand for an empty one.
const Look* look_named(const Review& review, const std::string& name) {
  if (name.empty()) return &review.look;
  const auto found = std::ranges::find(review.looks, name, &Look::name);
  return found == review.looks.end() ? nullptr : &*found;
}

/// Those of looks for which `holds` is true.
template <typename Holds>
std::vector<ReviewBake> filtered(const std::vector<ReviewBake>& bakes, const Holds& holds) {
  std::vector<ReviewBake> left;
  for (ReviewBake bake : bakes) {
    bake.at_hand = bake.at_hand && holds(std::string());
    std::erase_if(bake.looks, [&](const std::string& look) { return !holds(look); });
    if (bake.at_hand || !bake.looks.empty()) left.push_back(std::move(bake));
  }
  return left;
}

ReviewBake bake_from_json(const Json& json, const std::vector<std::string>& looks, const std::string& where) {
  JsonReader reader(json, where);
  ReviewBake bake;
  bake.bake = reader.choice("bake", keyed_bakes(builtin_registry()));
  bake.key = reader.text("key");
  if (!is_bake_key(bake.key))
    throw Error(reader.where("key"), "\"" + bake.key + "\" is no key of a bake", "it has 16 digits, 0 to 9 and a to f");
  bake.at_hand = reader.flag("at_hand");
  bake.looks = reader.texts("looks");
  for (const std::string& look : bake.looks)
    if (std::ranges::find(looks, look) == looks.end())
      throw Error(reader.where("looks"), "the review has no look \"" + look + "\"",
                  looks.empty() ? "it has none at all" : did_you_mean(look, looks));
  reader.finish();
  if (!bake.at_hand && bake.looks.empty())
    throw Error(where, "it belongs to no look and not to the state at hand", "name looks of the review, or remove it");
  return bake;
}

}  // namespace

bool same_bakes(const Look& a, const Look& b) {
  return a.mode == b.mode && a.reflections == b.reflections && a.edits == b.edits && a.settings == b.settings;
}

std::vector<ReviewBake> list_bakes(const std::map<std::string, BakeKeys>& by_look) {
  std::map<std::pair<std::string, std::string>, ReviewBake> listed;
  for (const auto& [look, keys] : by_look)
    for (const auto& [name, key] : keys) {
      ReviewBake& bake = listed[{name, key}];
      bake.bake = name;
      bake.key = key;
      if (look.empty())
        bake.at_hand = true;
      else
        bake.looks.push_back(look);
    }
  std::vector<ReviewBake> bakes;
  for (auto& [of, bake] : listed) bakes.push_back(std::move(bake));
  return bakes;
}

BakeKeys keys_of_look(const std::vector<ReviewBake>& bakes, const std::string& look) {
  BakeKeys keys;
  for (const ReviewBake& bake : bakes_of_looks(bakes, {look})) keys[bake.bake] = bake.key;
  return keys;
}

std::vector<ReviewBake> bakes_of_looks(const std::vector<ReviewBake>& bakes, const std::vector<std::string>& looks) {
  return filtered(bakes, [&](const std::string& look) { return std::ranges::find(looks, look) != looks.end(); });
}

std::vector<ReviewBake> bakes_that_hold(const std::vector<ReviewBake>& bakes, const Review& then, const Review& now) {
  if (then.scene != now.scene || then.scene_of_file != now.scene_of_file) return {};
  return filtered(bakes, [&](const std::string& name) {
    const Look *before = look_named(then, name), *after = look_named(now, name);
    return before && after && same_bakes(*before, *after);
  });
}

Json bakes_json(const std::vector<ReviewBake>& bakes, const Review& review) {
  Json list = Json::array();
  const auto known = [&](const std::string& name) { return look_named(review, name) != nullptr; };
  for (const ReviewBake& bake : filtered(bakes, known))
    list.push_back({{"bake", bake.bake}, {"key", bake.key}, {"at_hand", bake.at_hand}, {"looks", bake.looks}});
  return list;
}

std::vector<ReviewBake> bakes_from_json(const Json& list, const Review& review, const std::string& where) {
  std::vector<std::string> looks;
  for (const Look& look : review.looks) looks.push_back(look.name);
  std::vector<ReviewBake> bakes;
  std::set<std::pair<std::string, std::string>> seen;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string at = where + "[" + std::to_string(i) + "]";
    ReviewBake bake = bake_from_json(list[i], looks, at);
    std::vector<std::string> of = bake.looks;
    if (bake.at_hand) of.emplace_back();
    for (const std::string& look : of)
      if (!seen.insert({bake.bake, look}).second)
        throw Error(at,
                    (look.empty() ? "the state at hand" : "look \"" + look + "\"") + " has two keys of " + bake.bake,
                    "remove one");
    bakes.push_back(std::move(bake));
  }
  return bakes;
}

}  // namespace maquette
