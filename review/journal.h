#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "review/history.h"

namespace maquette {

/// Where untitled reviews, and those in folders that cannot be written, keep their journals:
/// `$XDG_STATE_HOME/maquette`, or `~/.local/state/maquette`; made if need be. Throws Error when it cannot be.
std::string state_folder();
/// Of a review: beside it, where its folder can be written, else in the state folder.
std::string journal_file(const std::string& review_file);

/// What a journal holds: the history up to the last record that was written whole.
struct JournalContents {
  History history;
  std::string saved_hash;      ///< of the review file that was last saved or opened; empty: none
  std::string saving_hash;     ///< of one that was about to be written
  std::size_t lost_lines = 0;  ///< at the end, written in part or damaged
  bool ends_in_draft = false;  ///< the last change was still going on: it is a step now
};
/// Nothing when there is no such file or not even its first line.
std::optional<JournalContents> read_journal(const std::string& file);

/// A journal that this program alone writes: in each line a JSON record behind the hash of its text. It is locked as
/// long as it lives.
class Journal {
 public:
  /// Throws Error when it cannot be written. Not valid when another program has locked it.
  explicit Journal(std::string file);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  bool locked() const { return descriptor_ >= 0; }
  const std::string& file() const { return file_; }
  /// Begins the file anew with this history; written beside and renamed. Throws Error.
  void begin(const History& history, const std::string& saved_hash);
  /// Adds one line. Throws Error when it cannot be written.
  void append(const nlohmann::json& record);
  /// Lines since `begin`.
  std::size_t lines() const { return lines_; }
  /// Takes the file away: nothing in it is worth keeping.
  void remove();

 private:
  std::string file_;
  int descriptor_ = -1;
  std::size_t lines_ = 0;
};

}  // namespace maquette
