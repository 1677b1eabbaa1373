#pragma once

#include <optional>
#include <string>

#include "review/open_review.h"
#include "viewer/look_stage.h"

namespace maquette {

/// Names, to the `maquette render` that the window starts for a picture, the command that a user repeats it with;
/// empty: there is none.
inline constexpr const char* kPictureCommand = "MAQUETTE_PICTURE_COMMAND";

/// A word as a shell takes it: in single quotes where it has other than plain characters.
std::string shell_word(const std::string& word);

/// The command that draws a look of a review as a settled frame; `look` empty: the one that was at hand when it was
/// saved.
std::string picture_command(const std::string& review, const std::string& look, const SettledFrame& settled,
                            const std::string& output);

/// The command that draws the look at hand again, bit for bit; none where the file of the review does not have it.
std::optional<std::string> repeating_command(const OpenReview& review, const SettledFrame& settled,
                                             const std::string& output);

}  // namespace maquette
