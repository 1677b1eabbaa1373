#include "viewer/picture_command.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "review/look_json.h"
#include "scenes/error.h"

namespace maquette {

std::string shell_word(const std::string& word) {
  constexpr const char* kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./,:@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string picture_command(const std::string& review, const std::string& look, const SettledFrame& settled,
                            const std::string& output) {
  const FrameSize& size = settled.size;
  std::string command = "maquette render " + shell_word(review);
  if (!look.empty()) command += " --look " + shell_word(look);
  command += " -o " + shell_word(output) + " --size " + std::to_string(size.width) + "x" + std::to_string(size.height);
  if (size.msaa > 1) command += " --msaa " + std::to_string(size.msaa);
  if (size.samples > 0) command += " --samples " + std::to_string(size.samples);
  if (size.seed > 0) command += " --seed " + std::to_string(size.seed);
  if (settled.frames > 1) command += " --average " + std::to_string(settled.frames);
  return command;
}

std::optional<std::string> repeating_command(const OpenReview& review, const SettledFrame& settled,
                                             const std::string& output) {
  if (review.file().empty()) return std::nullopt;
  const Look& at_hand = review.review().look;
  const auto as_it_is = [](const std::string& source) { return source; };
  // As files have them: a metered exposure, for one, is not in a look.
  const nlohmann::json wanted = look_json(at_hand, as_it_is);
  const auto same = [&](const Look& look) { return look_json(look, as_it_is) == wanted; };
  try {
    const Review saved = load_review(review.file());
    if (!at_hand.name.empty() && std::any_of(saved.looks.begin(), saved.looks.end(), same))
      return picture_command(review.file(), at_hand.name, settled, output);
    if (same(saved.look)) return picture_command(review.file(), "", settled, output);
  } catch (const Error&) {
    // The file has gone or is damaged: it repeats nothing.
  }
  return std::nullopt;
}

}  // namespace maquette
