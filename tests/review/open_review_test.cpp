// Reviews that are being worked on: journal, kill and reopen, saving, two windows.
#include "review/open_review.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <thread>

#include "scenes/error.h"
#include "tests/scenes/temporary_folder.h"
#include "tests/support/random_reviews.h"
#include "tests/support/text.h"

namespace maquette {
namespace {

using test::contains;

class OpenReviews : public test::TemporaryFolder {
 protected:
  void SetUp() override {
    TemporaryFolder::SetUp();
    setenv("XDG_STATE_HOME", path("state").c_str(), 1);
    file_ = path("a.maquette.json");
  }
  /// Saves a review of this exposure.
  void save(float exposure_ev) {
    Review review;
    review.look.auto_exposure = false;
    review.look.exposure_ev = exposure_ev;
    save_review(file_, review);
  }
  static std::string notes_of(OpenReview* open) {
    std::string all;
    for (const std::string& note : open->take_notes()) all += note + "\n";
    return all;
  }
  static void expose(OpenReview* open, float exposure_ev) {
    Review now = open->review();
    now.look.exposure_ev = exposure_ev;
    open->observe(now, false);
  }
  std::string file_;
};

TEST_F(OpenReviews, KeepsUnsavedChangesAndTheHistory) {
  save(1.0f);
  {
    OpenReview open(file_);
    EXPECT_EQ(notes_of(&open), "");
    expose(&open, 2.0f);
    expose(&open, 3.0f);
    open.undo();
  }
  OpenReview again(file_);
  EXPECT_TRUE(contains(notes_of(&again), "changes that were not saved are there again"));
  EXPECT_EQ(again.review().look.exposure_ev, 2.0f);
  EXPECT_TRUE(again.changed());
  EXPECT_EQ(again.redo()->look.exposure_ev, 3.0f);
  EXPECT_EQ(again.undo()->look.exposure_ev, 2.0f);
  EXPECT_EQ(again.undo()->look.exposure_ev, 1.0f);
  EXPECT_FALSE(again.undo());
}

TEST_F(OpenReviews, DeepNestingIsRefused) {
  for (const std::string& open : {std::string("["), std::string("{\"a\":")}) {
    std::string text;
    for (int i = 0; i < 300000; ++i) text += open;
    text += "1" + std::string(300000, open == "[" ? ']' : '}');
    write("a.maquette.json", text);
    const std::string said = test::message_of<Error>([&] { load_review(file_); });
    EXPECT_TRUE(contains(said, "nested deeper")) << said;
    EXPECT_FALSE(contains(said, "json.exception")) << said;
  }
}

TEST_F(OpenReviews, NamesNoDevicesAndPipes) {
  std::filesystem::create_symlink("/dev/zero", path("zero.hdr"));
  ASSERT_EQ(::mkfifo(path("pipe.exr").c_str(), 0600), 0);
  for (const std::string& named : {path("zero.hdr"), path("pipe.exr"), std::string("/dev/zero")}) {
    save(1.0f);
    std::string text = read(file_);
    const std::string before = "\"source\": \"";
    std::size_t at = text.find(before, text.find("\"environment\""));
    ASSERT_NE(at, std::string::npos);
    at += before.size();
    text.replace(at, text.find('"', at) - at, named);
    write("a.maquette.json", text);
    const std::string said = test::message_of<Error>([&] { load_review(file_); });
    EXPECT_TRUE(contains(said, "neither a file nor a folder")) << said;
  }
}

TEST_F(OpenReviews, TheHistorySurvivesSaving) {
  save(1.0f);
  {
    OpenReview open(file_);
    expose(&open, 2.0f);
    open.save(file_);
    EXPECT_FALSE(open.changed());
  }
  EXPECT_EQ(load_review(file_).look.exposure_ev, 2.0f);
  OpenReview again(file_);
  EXPECT_EQ(notes_of(&again), "");
  EXPECT_FALSE(again.changed());
  EXPECT_EQ(again.undo()->look.exposure_ev, 1.0f);
}

TEST_F(OpenReviews, ASecondWindowOnlyReads) {
  save(1.0f);
  OpenReview first(file_);
  OpenReview second(file_);
  EXPECT_TRUE(second.read_only());
  EXPECT_TRUE(contains(notes_of(&second), "is open in another window"));
  expose(&second, 5.0f);
  EXPECT_TRUE(contains(test::message_of<Error>([&] { second.save(file_); }), "another window has it open"));
  expose(&first, 2.0f);
  first.save(file_);
  EXPECT_EQ(load_review(file_).look.exposure_ev, 2.0f);
  second.save(path("b.maquette.json"));
  EXPECT_EQ(load_review(path("b.maquette.json")).look.exposure_ev, 5.0f);
  EXPECT_FALSE(second.read_only());
}

TEST_F(OpenReviews, ADamagedFileComesBackFromItsJournal) {
  save(1.0f);
  {
    OpenReview open(file_);
    expose(&open, 2.0f);
    open.save(file_);
  }
  const std::string text = read(file_);
  write("a.maquette.json", text.substr(0, text.size() / 2));
  EXPECT_THROW(load_review(file_), Error);
  OpenReview open(file_);
  EXPECT_TRUE(contains(notes_of(&open), "restored from its journal"));
  EXPECT_EQ(open.review().look.exposure_ev, 2.0f);
  open.save(file_);
  EXPECT_EQ(load_review(file_).look.exposure_ev, 2.0f);
  std::filesystem::remove(journal_file(file_));
  write("c.maquette.json", "{");
  EXPECT_THROW(OpenReview(path("c.maquette.json")), Error);
}

TEST_F(OpenReviews, AFileThatSomebodyElseChangedWins) {
  save(1.0f);
  {
    OpenReview open(file_);
    expose(&open, 2.0f);
  }
  save(7.0f);
  OpenReview open(file_);
  EXPECT_TRUE(contains(notes_of(&open), "was changed by another program"));
  EXPECT_EQ(open.review().look.exposure_ev, 7.0f);
  EXPECT_FALSE(open.can_undo());
  EXPECT_TRUE(std::filesystem::exists(file_ + ".journal.old"));
}

TEST_F(OpenReviews, ADragIsOneStepAndADraftMeanwhile) {
  save(0.0f);
  {
    OpenReview open(file_);
    Review now = open.review();
    for (int i = 1; i <= 30; ++i) {
      now.look.auto_exposure = false;
      now.look.exposure_ev = 0.25f * static_cast<float>(i);
      open.observe(now, true);
      const auto journal = read_journal(journal_file(file_));
      ASSERT_TRUE(journal);
      EXPECT_TRUE(journal->ends_in_draft);
      EXPECT_EQ(review_from_document(journal->history.document(), "").look.exposure_ev, now.look.exposure_ev);
    }
    EXPECT_FALSE(open.can_undo());
    open.observe(now, false);
    EXPECT_TRUE(open.can_undo());
    EXPECT_FALSE(read_journal(journal_file(file_))->ends_in_draft);
    EXPECT_EQ(open.undo()->look.exposure_ev, 0.0f);
  }
}

TEST_F(OpenReviews, ADragThatWasTakenBackLeavesNothing) {
  save(0.0f);
  OpenReview open(file_);
  Review now = open.review();
  for (const float ev : {1.0f, 2.0f, 0.0f}) {
    now.look.exposure_ev = ev;
    open.observe(now, true);
  }
  EXPECT_EQ(review_from_document(read_journal(journal_file(file_))->history.document(), "").look.exposure_ev, 0.0f);
  open.observe(now, false);
  const auto journal = read_journal(journal_file(file_));
  EXPECT_FALSE(journal->ends_in_draft);
  EXPECT_FALSE(journal->history.can_undo());
  EXPECT_FALSE(open.can_undo());
}

TEST_F(OpenReviews, ADragOfSomethingElseThanTheLookIsADraftToo) {
  save(0.0f);
  OpenReview open(file_);
  Review now = open.review();
  now.regions.push_back({0.1f, 0.2f, 0.3f, 0.4f});
  now.look.exposure_ev = 3.0f;
  open.observe(now, true);
  EXPECT_EQ(review_from_document(read_journal(journal_file(file_))->history.document(), ""), now);
}

/// An eye that was put somewhere is one step, the orbit behind it another: from the journal, too.
TEST_F(OpenReviews, ACameraThatIsPutSomewhereIsAStepOfItsOwn) {
  save(0.0f);
  {
    OpenReview open(file_);
    Review now = open.review();
    const auto move = [&](float x, bool apart) {
      now.look.camera.eye.x = x;
      open.observe(now, false, apart);
    };
    move(1.0f, false);
    move(2.0f, false);
    move(7.0f, true);
    move(8.0f, false);
    move(9.0f, false);
  }
  OpenReview again(file_);
  Review now = again.review();
  EXPECT_EQ(now.look.camera.eye.x, 9.0f);
  EXPECT_EQ(again.undo()->look.camera.eye.x, 7.0f) << "the orbit";
  EXPECT_EQ(again.undo()->look.camera.eye.x, 2.0f) << "the eye";
  EXPECT_EQ(again.redo()->look.camera.eye.x, 7.0f);
  now.look.camera.eye.x = 5.0f;
  again.observe(now, false);
  EXPECT_EQ(again.undo()->look.camera.eye.x, 7.0f) << "a move behind it does not join it";
}

/// Windows that crash again and again: the latest reviews stay, and each new one is kept.
TEST_F(OpenReviews, ManyUntitledOnesAreNotTheEndOfKeeping) {
  std::string newest;
  for (int i = 0; i < 130; ++i) {
    const pid_t child = fork();
    if (child == 0) {
      OpenReview open(Review{});
      Review now = open.review();
      now.look.auto_exposure = false;
      now.look.exposure_ev = 0.25f * static_cast<float>(i);
      open.observe(now, false);
      _exit(open.take_notes().empty() ? 0 : 1);
    }
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "window " << i << " keeps nothing";
  }
  const std::vector<std::string> left = OpenReview::left_behind();
  EXPECT_LE(left.size(), 21u);
  EXPECT_GE(left.size(), 20u);
  const auto kept = OpenReview::continued(left.front());
  EXPECT_EQ(kept->review().look.exposure_ev, 32.25f) << "the latest is there";
}

TEST_F(OpenReviews, UntitledOnesAreFoundAgain) {
  { OpenReview nothing_happened{Review()}; }
  EXPECT_TRUE(OpenReview::left_behind().empty());
  Review review;
  review.look.auto_exposure = false;
  {
    OpenReview open(review);
    expose(&open, 4.0f);
    EXPECT_TRUE(OpenReview::left_behind().empty()) << "its window is open";
  }
  const std::vector<std::string> left = OpenReview::left_behind();
  ASSERT_EQ(left.size(), 1u);
  OpenReview other(review);  // takes another journal
  const auto open = OpenReview::continued(left[0]);
  EXPECT_EQ(open->review().look.exposure_ev, 4.0f);
  open->save(file_);
  EXPECT_EQ(open->undo()->look.exposure_ev, 0.0f);
  EXPECT_TRUE(OpenReview::left_behind().empty()) << "it has a file now";
}

TEST_F(OpenReviews, AFolderThatCannotBeWritten) {
  save(1.0f);
  using Perms = std::filesystem::perms;
  std::filesystem::create_directories(path("state"));
  std::filesystem::permissions(path("state"), Perms::all);
  std::filesystem::permissions(path(""),
                               Perms::owner_read | Perms::owner_exec | Perms::others_read | Perms::others_exec);
  const pid_t child = fork();
  if (child == 0) {
    constexpr uid_t kNobody = 65534;
    if (geteuid() == 0 && (setgid(kNobody) != 0 || setuid(kNobody) != 0)) _exit(9);  // who is root writes everywhere
    try {
      OpenReview open(file_);
      const bool said =
          contains(notes_of(&open), "cannot be written: save the review under another name") || geteuid() != kNobody;
      expose(&open, 2.0f);
      try {
        open.save(file_);
      } catch (const Error& error) {
        const bool kept = OpenReview(file_).read_only() && open.review().look.exposure_ev == 2.0f;
        _exit(said && kept && !contains(error.what(), "\n") ? 0 : 2);
      }
      _exit(3);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s\n", error.what());
      _exit(4);
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  std::filesystem::permissions(path(""), Perms::owner_all);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0) << "2: not said, or lost; 3: written; 4: it does not open";
}

TEST_F(OpenReviews, SavingElsewhereNeedsAFolder) {
  OpenReview open{Review()};
  EXPECT_TRUE(
      contains(test::message_of<Error>([&] { open.save(path("none/a.maquette.json")); }), "its folder does not exist"));
  EXPECT_EQ(open.file(), "");
}

/// A journal that was cut off or damaged anywhere opens, with all that was whole before.
TEST_F(OpenReviews, AnyBeginningOfAJournalOpens) {
  save(0.0f);
  {
    OpenReview open(file_);
    for (int i = 1; i <= 20; ++i) expose(&open, static_cast<float>(i));
  }
  const std::string whole = read(journal_file(file_));
  const std::size_t header = whole.find('\n') + 1;
  test::RandomReviews random(6);
  for (int i = 0; i < 60; ++i) {
    std::string text = whole;
    const std::size_t at = static_cast<std::size_t>(random.pick(static_cast<int>(whole.size())));
    if (i % 2 == 0)
      text.resize(at);
    else
      text[at] = static_cast<char>(random.pick(256));
    write("a.maquette.json.journal", text);
    OpenReview open(file_);
    const auto lines = std::count(whole.begin() + static_cast<std::ptrdiff_t>(header),
                                  whole.begin() + static_cast<std::ptrdiff_t>(std::max(at, header)), '\n');
    if (at >= header) {
      EXPECT_GE(open.review().look.exposure_ev, static_cast<float>(lines)) << at;
    }
  }
}

/// Killed at random moments: what was observed before the kill is there, and the review opens.
TEST_F(OpenReviews, NothingIsLostWhenKilled) {
  save(0.0f);
  const char* const wanted = std::getenv("MAQUETTE_KILLS");
  const int kills = wanted ? std::atoi(wanted) : 8;
  test::RandomReviews random(7);
  float before = 0.0f;
  for (int kill_number = 0; kill_number < kills; ++kill_number) {
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    const pid_t child = fork();
    if (child == 0) {
      OpenReview open(file_);
      Review now = open.review();
      for (int i = 0;; ++i) {
        now.look.exposure_ev = before + 0.001f * static_cast<float>(i + 1);
        open.observe(now, i % 7 < 3);  // some of them while the mouse is held
        if (i % 50 == 49) open.save(file_);
        const ssize_t ignored = ::write(ends[1], &now.look.exposure_ev, sizeof(float));
        if (ignored < 0) _exit(1);
      }
    }
    close(ends[1]);
    std::jthread killer([&, delay_us = 2000 + random.pick(60000)] {
      std::this_thread::sleep_for(std::chrono::microseconds(delay_us));
      kill(child, SIGKILL);
    });
    float last = before, value = 0.0f;
    while (::read(ends[0], &value, sizeof value) == static_cast<ssize_t>(sizeof value)) last = value;
    close(ends[0]);
    waitpid(child, nullptr, 0);
    OpenReview open(file_);
    EXPECT_GE(open.review().look.exposure_ev, last) << "kill " << kill_number;
    before = open.review().look.exposure_ev;
  }
}

}  // namespace
}  // namespace maquette
