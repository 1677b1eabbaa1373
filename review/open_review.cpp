#include "review/open_review.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <span>
#include <utility>

#include "review/json_reader.h"
#include "review/look_json.h"
#include "scenes/error.h"
#include "scenes/files.h"

namespace maquette {

using Json = nlohmann::json;
namespace fs = std::filesystem;

namespace {

constexpr int kMostUntitled = 100;
/// So many journals that were left behind stay, the latest.
constexpr std::size_t kMostLeftBehind = 20;
constexpr std::size_t kMostLines = 3 * History::kDepth;

std::string hash_of(const std::string& text) {
  char digits[20];
  std::snprintf(digits, sizeof digits, "%016llx",
                static_cast<unsigned long long>(content_hash(std::as_bytes(std::span(text.data(), text.size())))));
  return digits;
}

std::string untitled_journal(int number) { return state_folder() + "/untitled-" + std::to_string(number) + ".journal"; }

std::string count_of(std::size_t count, const std::string& thing) {
  return std::to_string(count) + " " + thing + (count == 1 ? "" : "s");
}

}  // namespace

void OpenReview::discard_old() {
  const std::vector<std::string> left = left_behind();
  for (std::size_t i = kMostLeftBehind; i < left.size(); ++i)
    if (Journal old(left[i]); old.locked()) old.remove();
}

OpenReview::OpenReview(const Review& review, bool keeps_journal)
    : history_(review_document(review)), review_(review), saved_(history_.document()) {
  if (!keeps_journal) return;
  try {
    discard_old();
    for (int number = 1; number <= kMostUntitled && !journal_; ++number) {
      const std::string name = untitled_journal(number);
      const auto contents = read_journal(name);
      if (contents && contents->history.can_undo()) continue;  // somebody may want it back
      keep_journal(name);
    }
    if (!journal_) throw Error(state_folder(), "it has " + std::to_string(kMostUntitled) + " journals of open windows");
    journal_->begin(history_, "");
  } catch (const Error& error) {
    journal_.reset();
    notes_.push_back(std::string(error.what()) + ". Changes are kept once the review is saved");
  }
}

OpenReview::~OpenReview() {
  if (journal_ && file_.empty() && !history_.can_undo()) journal_->remove();  // nothing happened
}

/// Takes the journal if no other window has it.
void OpenReview::keep_journal(const std::string& name) {
  journal_ = std::make_unique<Journal>(name);
  if (!journal_->locked()) journal_.reset();
  history_.set_sink([this](const Json& record) { write(record); });
}

OpenReview::OpenReview(const std::string& file) : history_(Json()), file_(fs::absolute(file).string()) {
  const std::string text = read_text_file(file_);
  saved_hash_ = hash_of(text);
  std::optional<JournalContents> kept;
  try {
    keep_journal(journal_file(file_));
    read_only_ = !journal_;
    if (read_only_) notes_.push_back(file_ + " is open in another window: this one cannot change it");
    kept = read_journal(journal_file(file_));
  } catch (const Error& error) {
    notes_.push_back(std::string(error.what()) + ". Changes are kept once the review is saved elsewhere");
  }
  std::string damage;
  Review saved;
  try {
    review_ = saved = parse_review(text, file_, &bakes_);
    saved_ = review_document(review_);
    history_ = History(saved_);
  } catch (const Error& error) {
    damage = error.what();
    if (!kept) throw;
  }
  if (kept && !read_only_ && (kept->saved_hash == saved_hash_ || kept->saving_hash == saved_hash_ || !damage.empty())) {
    try {
      review_ = review_from_document(kept->history.document(), journal_file(file_));
      history_ = std::move(kept->history);
      if (!damage.empty())
        notes_.push_back(damage + ". It was restored from its journal; save it");
      else if (history_.document() != saved_)
        notes_.push_back(file_ + ": changes that were not saved are there again; undo takes them back");
      if (kept->lost_lines > 0) notes_.push_back("the last line of the journal was not written whole");
    } catch (const Error& error) {
      if (!damage.empty()) throw;
      notes_.push_back(std::string(error.what()) + ". The journal was left aside");
    }
  } else if (kept && !read_only_ && kept->history.can_undo()) {
    std::error_code ignored;
    fs::copy_file(journal_file(file_), journal_file(file_) + ".old", fs::copy_options::overwrite_existing, ignored);
    notes_.push_back(file_ + " was changed by another program: the history of " +
                     count_of(kept->history.undo_count(), "step") + " was set aside as .journal.old");
  }
  if (journal_) {
    history_.set_sink([this](const Json& record) { write(record); });
    compact();
  }
  if (!read_only_ && access(file_.c_str(), W_OK) != 0)
    notes_.push_back(file_ + " cannot be written: save the review under another name");
  changed_ = history_.document() != saved_;
  bakes_ = bakes_that_hold(bakes_, saved, review_);
}

std::unique_ptr<OpenReview> OpenReview::continued(const std::string& name) {
  std::optional<JournalContents> kept = read_journal(name);
  if (!kept) throw Error(name, "it is no journal", "remove it");
  Review review = review_from_document(kept->history.document(), name);
  std::unique_ptr<OpenReview> open(new OpenReview(std::move(kept->history), std::move(review)));
  open->keep_journal(name);
  if (!open->journal_) throw Error(name, "another window has it open");
  open->compact();
  open->changed_ = true;
  return open;
}

std::vector<std::string> OpenReview::left_behind() {
  std::vector<std::pair<fs::file_time_type, std::string>> found;
  for (int number = 1; number <= kMostUntitled; ++number) {
    const std::string name = untitled_journal(number);
    std::error_code code;
    if (!fs::exists(name, code)) continue;
    const auto contents = read_journal(name);
    if (!contents || !contents->history.can_undo()) continue;
    if (Journal(name).locked()) found.emplace_back(fs::last_write_time(name, code), name);
  }
  std::sort(found.rbegin(), found.rend());
  std::vector<std::string> names;
  for (const auto& [time, name] : found) names.push_back(name);
  return names;
}

void OpenReview::write(const Json& record) {
  const bool draft = record.contains("draft");
  if (!draft) changed_ = history_.document() != saved_;
  if (!journal_) return;
  try {
    journal_->append(record);
  } catch (const Error& error) {
    notes_.push_back(error.what());
    journal_.reset();
    return;
  }
  if (journal_->lines() > kMostLines && !draft) compact();
}

void OpenReview::compact() {
  if (!journal_) return;
  try {
    journal_->begin(history_, saved_hash_);
  } catch (const Error& error) {
    notes_.push_back(error.what());
    journal_.reset();
  }
}

/// Of the look alone where nothing else differs: a hundred looks beside it would take their time in every frame.
Json OpenReview::patch_to(const Review& now) const {
  Review rest = now;
  rest.look = review_.look;
  if (rest != review_) return Json::diff(history_.document(), review_document(now));
  const auto same = [](const std::string& source) { return source; };
  return Json::diff(Json{{"look", history_.document().at("look")}}, Json{{"look", look_json(now.look, same)}});
}

void OpenReview::observe(const Review& now, bool busy, bool apart) {
  Review kept = now;
  kept.look = canonical(kept.look);
  if (busy) {
    if (kept == (draft_ ? *draft_ : review_)) return;
    draft_ = kept;
    write({{"draft", patch_to(kept)}});
    return;
  }
  const bool begun = std::exchange(draft_, std::nullopt).has_value();
  if (kept == review_) {
    if (begun) write({{"draft", Json::array()}});  // it was taken back
    return;
  }
  review_ = kept;
  history_.record(review_document(kept), apart);
}

void OpenReview::amend(const Review& now) {
  review_ = now;
  review_.look = canonical(review_.look);
  history_.amend(review_document(review_));
}

Review OpenReview::parsed() const { return review_from_document(history_.document(), "undo"); }

std::optional<Review> OpenReview::undo() {
  if (!history_.undo()) return std::nullopt;
  return review_ = parsed();
}

std::optional<Review> OpenReview::redo() {
  if (!history_.redo()) return std::nullopt;
  return review_ = parsed();
}

void OpenReview::save(const std::string& name) {
  const std::string target = fs::absolute(name).string();
  const bool other = target != file_;
  if (!other && read_only_) throw Error(file_, "another window has it open", "save it under another name");
  std::unique_ptr<Journal> next;
  if (other) {
    if (!fs::is_directory(fs::path(target).parent_path()))
      throw Error(target, "its folder does not exist", "create the folder first");
    next = std::make_unique<Journal>(journal_file(target));
    if (!next->locked()) throw Error(target, "another window has it open", "choose another name");
  }
  const std::string text = review_text(review_, target, bakes_);
  if (!other) write({{"saving", hash_of(text)}});
  write_file_atomically(target, std::as_bytes(std::span(text.data(), text.size())));
  saved_ = history_.document();
  saved_hash_ = hash_of(text);
  changed_ = false;
  if (!other) return write({{"saved", saved_hash_}});
  if (journal_ && file_.empty()) journal_->remove();  // the untitled one
  journal_ = std::move(next);
  file_ = target;
  read_only_ = false;
  history_.set_sink([this](const Json& record) { write(record); });
  compact();
}

}  // namespace maquette
