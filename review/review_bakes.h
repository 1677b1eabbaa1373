#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "render/bake/bake_keys.h"
#include "review/look.h"

namespace maquette {

struct Review;

/// A bake that looks of a review draw with, by the key that it had when the review was saved. It is no part of what is
/// edited: undo and journal do not know it.
struct ReviewBake {
  std::string bake;                ///< its name, one of keyed_bakes
  std::string key;                 ///< BakeKeys
  bool at_hand = false;            ///< the state at hand draws with it
  std::vector<std::string> looks;  ///< the kept looks that do
  bool operator==(const ReviewBake&) const = default;
};

/// Whether two looks draw with the same bakes: all but names, camera, and how the picture is shown.
bool same_bakes(const Look& a, const Look& b);

/// Keys by the name of the look, which is empty for the state at hand, as a list, and back.
std::vector<ReviewBake> list_bakes(const std::map<std::string, BakeKeys>& by_look);
BakeKeys keys_of_look(const std::vector<ReviewBake>& bakes, const std::string& look);
/// Those of some looks alone.
std::vector<ReviewBake> bakes_of_looks(const std::vector<ReviewBake>& bakes, const std::vector<std::string>& looks);
/// Those of looks that are in `now` as they are in `then`.
std::vector<ReviewBake> bakes_that_hold(const std::vector<ReviewBake>& bakes, const Review& then, const Review& now);

nlohmann::json bakes_json(const std::vector<ReviewBake>& bakes, const Review& review);
/// Throws Error that names the member under `where`: an unknown bake or look (with the nearest name), a key that is
/// none, a look that has two keys of one bake.
std::vector<ReviewBake> bakes_from_json(const nlohmann::json& list, const Review& review, const std::string& where);

}  // namespace maquette
