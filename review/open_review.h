#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "review/journal.h"
#include "review/review.h"

namespace maquette {

/// A review that is being worked on: its file, its history, and the journal, which has every change within a second.
class OpenReview {
 public:
  /// Untitled, of this state. `keeps_journal`: in the state folder.
  explicit OpenReview(const Review& review, bool keeps_journal = true);
  /// From a file, or from its journal where that has later changes or the file is damaged. Throws Error.
  explicit OpenReview(const std::string& file);
  /// Continues an untitled review by its journal. Throws Error.
  static std::unique_ptr<OpenReview> continued(const std::string& journal_file);

  ~OpenReview();
  OpenReview(OpenReview&&) = delete;
  OpenReview& operator=(OpenReview&&) = delete;

  const Review& review() const { return review_; }
  const std::string& file() const { return file_; }  ///< empty: untitled
  bool read_only() const { return read_only_; }      ///< another window has it
  bool changed() const { return changed_; }          ///< since it was saved
  /// What the file says of the bakes of looks that are still as they were when it was saved, or what it is to say.
  const std::vector<ReviewBake>& bakes() const { return bakes_; }
  /// For the next time that it is saved: no change of the review.
  void set_bakes(std::vector<ReviewBake> bakes) { bakes_ = std::move(bakes); }
  /// What a user should know of how it was opened.
  std::vector<std::string> take_notes() { return std::exchange(notes_, {}); }

  /// The review as it is now, in every iteration of the window's loop. `busy`: a control or the mouse is held, the
  /// change goes on and becomes one step when it is over; the journal has each state of it as a draft meanwhile, before
  /// the frame is drawn that shows it.
  /// `apart`: the camera was put somewhere, and moves that follow are another step.
  void observe(const Review& now, bool busy, bool apart = false);
  /// What the program changed of its own accord: no step of its own.
  void amend(const Review& now);
  bool can_undo() const { return history_.can_undo(); }
  bool can_redo() const { return history_.can_redo(); }
  /// The review before the last step, after the next; nothing when there is none.
  std::optional<Review> undo();
  std::optional<Review> redo();

  /// To its file, or to another. Throws Error: read-only, a folder that cannot be written.
  void save(const std::string& file);

  /// Journals of untitled reviews that were not saved and belong to no open window, latest first. Another untitled
  /// review keeps the latest twenty and removes the others.
  static std::vector<std::string> left_behind();

 private:
  OpenReview(History history, Review review) : history_(std::move(history)), review_(std::move(review)) {}
  static void discard_old();
  void keep_journal(const std::string& file);
  void write(const nlohmann::json& record);
  void compact();
  nlohmann::json patch_to(const Review& now) const;
  Review parsed() const;

  History history_;
  Review review_;
  std::vector<ReviewBake> bakes_;
  std::string file_, saved_hash_;
  nlohmann::json saved_;  ///< document in the file
  std::unique_ptr<Journal> journal_;
  bool read_only_ = false, changed_ = false;
  std::vector<std::string> notes_;
  std::optional<Review> draft_;
};

}  // namespace maquette
