#pragma once

#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "render/frame/status.h"
#include "review/review.h"

namespace maquette {

struct SceneOptions;

/// The key of a bake for what is shown now, by its name; empty: it has none.
using BakeKeyNow = std::function<std::string(const std::string& bake)>;

/// What a review says of bakes, and what is known of the scene now.
struct ReviewedBakes {
  const Review& review;
  const std::vector<ReviewBake>& bakes;
  std::string shown = {};   ///< the look that `key_now` is of; empty: the state at hand
  BakeKeyNow key_now = {};  ///< null: of nothing
};

/// Where a bake was found that a review names.
enum class BakeFound { there, to_be_made, changed, changed_and_there };
/// Throws what `key_now` throws.
BakeFound find_bake(const ReviewedBakes& of, const ReviewBake& bake);

/// The looks that draw with a bake: the state at hand and looks "a", "b".
std::string owners_text(const ReviewBake& bake);

/// A line for each that is not there as the review says: the scene is another now, or it has to be made; which looks
/// draw with it, and what it will change.
std::vector<std::string> bake_lines(const ReviewedBakes& of);

/// The same as warnings on standard error, for commands: of `looks` of the review that the options name. `shown`: the
/// look that is about to be drawn, with what options change of it; where that is more than the camera, its name counts
/// as none of them.
void warn_of_bakes(const SceneOptions& options, const std::vector<std::string>& looks, const std::string& shown_name,
                   const Look& shown, const BakeKeyNow& key_now);

/// What a frame that was drawn lacks of the bakes that it wants, a line each.
std::vector<std::string> missing_bake_lines(const FrameStatus& status);
/// Warns of them, and of what modes' own bakes say of themselves, but for the lines that `told` has.
void warn_of_frame_bakes(const FrameStatus& status, std::set<std::string>* told = nullptr);

/// Keys of bakes by what decides them of a look, whatever its name.
class KnownBakes {
 public:
  void set(const Look& look, BakeKeys keys);
  const BakeKeys* find(const Look& look) const;  ///< null: not known
  void forget() { known_.clear(); }

 private:
  std::vector<std::pair<Look, BakeKeys>> known_;
};

}  // namespace maquette
