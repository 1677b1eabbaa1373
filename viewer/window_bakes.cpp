// Keys of bakes of the review that a window works on: what of it is to be made, and what its file is to say.
#include <algorithm>
#include <filesystem>

#include "scenes/error.h"
#include "viewer/session.h"
#include "viewer/window_session.h"

namespace maquette {

namespace {

/// Without those that were set back to the file's own.
std::map<std::string, std::string> replaced(std::map<std::string, std::string> materials) {
  std::erase_if(materials, [](const auto& entry) { return entry.second.empty(); });
  return materials;
}

}  // namespace

bool WindowSession::shows_state() const {
  const Edits& wanted = state.edits;
  return !loading() && !opening_ && applied_.environment == wanted.environment &&
         replaced(applied_.materials) == replaced(wanted.materials) && applied_.animation == wanted.animation &&
         applied_.turns == wanted.turns && applied_.dents == wanted.dents &&
         applied_.hidden_nodes == wanted.hidden_nodes;
}

std::optional<BakeKeys> WindowSession::bake_keys_now() {
  if (!shows_state()) return std::nullopt;
  try {
    return renderer_.bake_keys(make_request(*scene_, state, FrameSize()));
  } catch (const Error&) {  // the frame says it
    return BakeKeys();
  }
}

void WindowSession::tell_bakes() {
  const std::string look = *std::exchange(untold_bakes_, std::nullopt);
  const Review& review = review_->review();
  const Look* opened = look.empty() ? &review.look : &find_look(review, look);
  const bool comparable = missing_.empty() && same_bakes(*opened, state);
  BakeKeys now;
  const auto key_now = [&](const std::string& bake) {
    try {
      if (!now.contains(bake)) now[bake] = renderer_.bake_key(make_request(*scene_, state, FrameSize()), bake);
    } catch (const Error&) {
      now[bake].clear();  // the frame says it
    }
    return now[bake];
  };
  const ReviewedBakes of{review, review_->bakes(), look, comparable ? BakeKeyNow(key_now) : BakeKeyNow()};
  for (const std::string& line : bake_lines(of))
    add_message(MessageLevel::warning, std::filesystem::path(review_->file()).filename().string() + ": " + line);
  if (std::ranges::any_of(of.bakes, [&](const ReviewBake& bake) { return find_bake(of, bake) >= BakeFound::changed; }))
    known_bakes_.forget();  // what was known of the other looks does not hold either
}

void WindowSession::watch_bakes(bool busy) {
  if (untold_bakes_ && (!missing_.empty() || shows_state())) tell_bakes();
  if (busy || !shows_state() || known_bakes_.find(state)) return;
  if (std::ranges::none_of(state.looks, [&](const Look& look) { return same_bakes(look, state); })) return;
  if (const std::optional<BakeKeys> keys = bake_keys_now()) known_bakes_.set(state, *keys);
}

std::vector<ReviewBake> WindowSession::bakes_to_save() {
  if (const std::optional<BakeKeys> keys = bake_keys_now()) known_bakes_.set(state, *keys);
  std::map<std::string, BakeKeys> by_look;
  if (const BakeKeys* keys = known_bakes_.find(state)) by_look[""] = *keys;
  for (const Look& look : state.looks)
    if (const BakeKeys* keys = known_bakes_.find(look)) by_look[look.name] = *keys;
  return list_bakes(by_look);
}

}  // namespace maquette
