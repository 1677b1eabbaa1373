#include "viewer/bake_lines.h"

#include <algorithm>
#include <cstdio>

#include "scenes/suggest.h"
#include "ui/bake_state.h"
#include "viewer/options.h"
#include "viewer/print.h"

namespace maquette {

namespace {

const Look& look_of(const Review& review, const std::string& name) {
  return name.empty() ? review.look : find_look(review, name);
}

/// The folder that settings name for a bake, where it has a setting for that; else empty.
std::string named_folder(const Settings& settings, const std::string& bake) {
  const std::string setting = bake + ".bake";
  return find_setting(setting) ? settings.get_string(setting) : "";
}

}  // namespace

std::vector<std::string> missing_bake_lines(const FrameStatus& status) {
  std::vector<std::string> lines;
  if (!status.has_geometry) return lines;
  for (const auto& [name, bake] : status.bakes()) {
    if (bake.ready) continue;
    const bool own = status.own_bakes.contains(name);
    lines.push_back(own ? name + ": nothing is baked; a preview is drawn (" + name + ".run is hold)"
                        : "the bake of " + name + " is not there: the picture lacks it");
  }
  return lines;
}

void warn_of_frame_bakes(const FrameStatus& status, std::set<std::string>* told) {
  std::vector<std::string> lines = missing_bake_lines(status);
  for (const auto& [name, bake] : status.own_bakes)
    for (const std::string& note : bake.notes) lines.push_back(name + ": " + note);
  for (const std::string& line : lines)
    if (!told || told->insert(line).second) print_line(stderr, "warning: %s", line.c_str());
}

std::string owners_text(const ReviewBake& bake) {
  constexpr std::size_t kNamed = 4;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::min(bake.looks.size(), kNamed); ++i) names.push_back("\"" + bake.looks[i] + "\"");
  if (bake.looks.size() > kNamed) names.push_back("and " + std::to_string(bake.looks.size() - kNamed) + " more");
  const std::string looks = (names.size() == 1 ? "look " : "looks ") + join(names);
  if (names.empty()) return "the state at hand";
  return bake.at_hand ? "the state at hand and " + looks : looks;
}

BakeFound find_bake(const ReviewedBakes& of, const ReviewBake& bake) {
  const std::string first = bake.at_hand ? std::string() : bake.looks.front();
  const auto is_kept = [&](const std::string& look, const std::string& key) {
    return is_bake_kept(builtin_registry(), bake.bake, key, of.review.scene, look_of(of.review, look).settings);
  };
  const bool is_shown = of.shown.empty() ? bake.at_hand : std::ranges::find(bake.looks, of.shown) != bake.looks.end();
  const std::string now = of.key_now && is_shown ? of.key_now(bake.bake) : "";
  if (!now.empty() && now != bake.key)
    return is_kept(of.shown, now) ? BakeFound::changed_and_there : BakeFound::changed;
  return is_kept(now.empty() ? first : of.shown, bake.key) ? BakeFound::there : BakeFound::to_be_made;
}

std::vector<std::string> bake_lines(const ReviewedBakes& of) {
  std::vector<std::string> lines;
  for (const ReviewBake& bake : of.bakes) {
    const BakeFound found = find_bake(of, bake);
    if (found == BakeFound::there) continue;
    const std::string effect = panels::bake_effect(builtin_registry(), bake.bake);
    const std::string name = "bake " + bake.bake + " of " + owners_text(bake);
    const std::string change = effect.empty() ? "" : "; it changes " + effect;
    const std::string first = bake.at_hand ? std::string() : bake.looks.front();
    const std::string folder = named_folder(look_of(of.review, first).settings, bake.bake);
    if (found == BakeFound::to_be_made && !folder.empty())
      lines.push_back(name + " is not whole in " + folder + ": maquette bake " + bake.bake + " makes it" + change);
    else if (found == BakeFound::to_be_made)
      lines.push_back(name + " is not in the cache: to be made" + change);
    else
      lines.push_back(name + ": the scene is not as it was when the review was saved; " +
                      (found == BakeFound::changed ? "it is made anew" + change : "what it needs now is there"));
  }
  return lines;
}

void warn_of_bakes(const SceneOptions& options, const std::vector<std::string>& looks, const std::string& shown_name,
                   const Look& shown, const BakeKeyNow& key_now) {
  if (options.review.empty()) return;
  std::vector<ReviewBake> bakes;
  const Review review = load_review(options.review, &bakes);
  std::vector<std::string> told = looks;
  const bool as_saved = same_bakes(look_of(review, shown_name), shown);
  if (!as_saved) std::erase(told, shown_name);
  bakes = bakes_of_looks(bakes, told);
  for (const std::string& line : bake_lines({review, bakes, shown_name, as_saved ? key_now : BakeKeyNow()}))
    print_line(stderr, "warning: %s: %s\n", options.review.c_str(), line.c_str());
}

void KnownBakes::set(const Look& look, BakeKeys keys) {
  for (auto& [known, of_known] : known_)
    if (same_bakes(known, look)) {
      of_known = std::move(keys);
      return;
    }
  known_.emplace_back(look, std::move(keys));
}

const BakeKeys* KnownBakes::find(const Look& look) const {
  for (const auto& [known, keys] : known_)
    if (same_bakes(known, look)) return &keys;
  return nullptr;
}

}  // namespace maquette
