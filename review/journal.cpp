#include "review/journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <span>
#include <stdexcept>

#include "review/json_reader.h"
#include "review/json_text.h"
#include "scenes/error.h"
#include "scenes/files.h"

namespace maquette {

using Json = nlohmann::json;
namespace fs = std::filesystem;

namespace {

constexpr int kJournalFormat = 1;

[[noreturn]] void fail(const std::string& file) {
  throw Error(file, std::string("the journal cannot be written (") + std::strerror(errno) + ")",
              "make room, or save the review elsewhere");
}

/// A record behind the hash of its text, by which damage is known.
std::string line_of(const Json& record) {
  const std::string text = json_text(record);
  char digits[24];
  std::snprintf(digits, sizeof digits, "%016llx ",
                static_cast<unsigned long long>(content_hash(std::as_bytes(std::span(text.data(), text.size())))));
  return digits + text + "\n";
}

/// Throws std::exception for a line that is damaged or was written in part.
Json record_of(const std::string& line) {
  constexpr std::size_t kHash = 17;
  Json record = json_from_text(line.substr(std::min(kHash, line.size())));
  if (line_of(record) != line + "\n") throw std::runtime_error("damaged");
  return record;
}

void write_all(int descriptor, const std::string& text, const std::string& file) {
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t count = ::write(descriptor, text.data() + done, text.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail(file);
    done += static_cast<std::size_t>(count);
  }
}

}  // namespace

std::string state_folder() {
  const char* state = std::getenv("XDG_STATE_HOME");
  const char* home = std::getenv("HOME");
  fs::path folder = fs::temp_directory_path() / "maquette-state";
  if (state && *state == '/')
    folder = fs::path(state) / "maquette";
  else if (home && *home)
    folder = fs::path(home) / ".local" / "state" / "maquette";
  std::error_code code;
  fs::create_directories(folder, code);
  if (code) throw Error(folder.string(), "the folder cannot be made: " + code.message(), "set XDG_STATE_HOME");
  return folder.string();
}

std::string journal_file(const std::string& review_file) {
  const fs::path path = fs::absolute(review_file);
  if (access(path.parent_path().c_str(), W_OK) == 0) return path.string() + ".journal";
  const std::string text = path.string();
  char digits[20];
  std::snprintf(digits, sizeof digits, "%016llx",
                static_cast<unsigned long long>(content_hash(std::as_bytes(std::span(text.data(), text.size())))));
  return state_folder() + "/" + digits + ".journal";
}

std::optional<JournalContents> read_journal(const std::string& file) {
  std::error_code code;
  if (!fs::is_regular_file(file, code)) return std::nullopt;
  const std::string text = read_text_file(file);
  std::optional<JournalContents> contents;
  Json draft;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    const std::string line = text.substr(begin, end - begin);
    begin = end == std::string::npos ? text.size() : end + 1;
    try {
      if (end == std::string::npos) throw std::runtime_error("written in part");
      const Json record = record_of(line);
      if (!contents) {
        if (record.at("maquette_journal") != kJournalFormat) return std::nullopt;
        contents = JournalContents{History(record.at("document")), record.at("saved"), {}, 0, false};
        continue;
      }
      if (record.contains("draft")) {
        draft = record.at("draft");  // the last one counts
      } else if (record.contains("saving")) {
        contents->saving_hash = record.at("saving");
      } else if (record.contains("saved")) {
        contents->saved_hash = record.at("saved");
      } else {
        contents->history.follow(record);
        draft = Json();
      }
    } catch (const std::exception&) {
      if (!contents) return std::nullopt;
      // What follows a damaged line may build on it.
      for (contents->lost_lines = 1; begin < text.size(); ++contents->lost_lines)
        begin = std::min(text.find('\n', begin), text.size() - 1) + 1;
      break;
    }
  }
  if (!contents || draft.empty()) return contents;
  try {
    contents->history.record(contents->history.document().patch(draft));
    contents->ends_in_draft = true;
  } catch (const std::exception&) {
    ++contents->lost_lines;
  }
  return contents;
}

Journal::Journal(std::string file) : file_(std::move(file)) {
  descriptor_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (descriptor_ < 0) fail(file_);
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    ::close(descriptor_);
    descriptor_ = -1;
  }
}

Journal::~Journal() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void Journal::begin(const History& history, const std::string& saved_hash) {
  Json first;
  const std::vector<Json> records = history.records(&first);
  std::string text = line_of({{"maquette_journal", kJournalFormat}, {"saved", saved_hash}, {"document", first}});
  for (const Json& record : records) text += line_of(record);
  const std::string beside = file_ + ".new";
  const int next = ::open(beside.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0644);
  if (next < 0) fail(beside);
  try {
    // Locked before it has the name: nobody else gets hold of it in between.
    if (::flock(next, LOCK_EX | LOCK_NB) != 0) fail(beside);
    write_all(next, text, beside);
    if (::rename(beside.c_str(), file_.c_str()) != 0) fail(file_);
  } catch (...) {
    ::close(next);
    ::unlink(beside.c_str());
    throw;
  }
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = next;
  lines_ = 0;
}

void Journal::append(const Json& record) {
  write_all(descriptor_, line_of(record), file_);
  ++lines_;
}

void Journal::remove() { ::unlink(file_.c_str()); }

}  // namespace maquette
