// A disk that is full at any byte: what was there stays whole, and what is said to be written is.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <functional>

#include "scenes/bake_file.h"
#include "scenes/error.h"
#include "scenes/exr_stream.h"
#include "scenes/files.h"
#include "scenes/image_io.h"
#include "tests/scenes/temporary_folder.h"

namespace maquette {
namespace {

namespace fs = std::filesystem;

/// While it lives, no file grows beyond so many bytes: writing fails there, as on a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    handler_ = signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
  sighandler_t handler_ = SIG_DFL;
};

class FullDisks : public test::TemporaryFolder {
 protected:
  /// `save` writes a file over one that is there, with room for each number of bytes.
  void expect_whole(const std::string& name, const std::function<void(const std::string&)>& save) {
    const std::string file = path(name), old = "what was there before";
    save(file);
    const std::string whole = read(file);
    ASSERT_GT(whole.size(), 100u);
    for (std::size_t room = 0; room <= whole.size(); room += std::max<std::size_t>(whole.size() / 97, 1)) {
      write(name, old);
      bool said = true;
      try {
        const FullDisk disk(room);
        save(file);
      } catch (const Error& error) {
        said = false;
        EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
      }
      EXPECT_EQ(read(file) == (said ? whole : old), true)
          << name << " with room for " << room << " of " << whole.size();
      for (const auto& entry : fs::directory_iterator(path("")))
        EXPECT_EQ(entry.path().filename().string(), name) << "is left behind";
    }
    fs::remove(file);
  }
};

TEST_F(FullDisks, LeaveExrFilesWhole) {
  Image image(40, 30, 4);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<float>(i % 97);
  expect_whole("a.exr", [&](const std::string& file) { save_exr(file, image); });
}

TEST_F(FullDisks, LeaveBakesWhole) {
  BakeFile bake;
  bake.tables.resize(2);
  for (BakeTable& table : bake.tables) {
    table.name = &table == bake.tables.data() ? "first" : "second";
    for (std::uint32_t i = 0; i < 900; ++i) table.integers["number"].push_back(i * 2654435761u);
  }
  expect_whole("b.exr", [&](const std::string& file) { save_bake_file(file, bake); });
}

TEST_F(FullDisks, LeavePngAndOtherFilesWhole) {
  const Image image(40, 30, 3, 0.5f);
  expect_whole("a.png", [&](const std::string& file) { save_png(file, image); });
  const std::string text(5000, 'x');
  expect_whole("a.txt", [&](const std::string& file) { write_file_atomically(file, std::as_bytes(std::span(text))); });
}

TEST(ExrStream, TellsWhatADestructorSwallows) {
  ExrStream stream("/dev/full");
  const char bytes[] = "some bytes";
  stream.write(bytes, sizeof bytes);  // kept in memory so far
  EXPECT_THROW(stream.close(), std::runtime_error);
}

/// What a killed run leaves is removed by the next one that writes there; what a living one writes stays.
TEST_F(FullDisks, WhatAKilledRunLeftIsRemoved) {
  const pid_t child = fork();
  if (child == 0) {
    for (int i = 0; i < 3; ++i) write(fs::path(temporary_path(path("a.exr"))).filename().string(), "a part");
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  const std::string own = temporary_path(path("c.exr"));  // this process has not looked here before
  write(fs::path(own).filename().string(), "in work");
  const std::string other = write(".partial-notes", "of somebody else");
  std::vector<std::string> left;
  for (const auto& entry : fs::directory_iterator(path(""))) left.push_back(entry.path().filename().string());
  std::ranges::sort(left);
  EXPECT_EQ(left, (std::vector<std::string>{fs::path(own).filename().string(), ".partial-notes"})) << left.size();
  EXPECT_TRUE(fs::exists(other));
}

}  // namespace
}  // namespace maquette
