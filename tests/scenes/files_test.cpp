#include "scenes/files.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "scenes/cache_entry.h"
#include "scenes/error.h"

namespace {

namespace fs = std::filesystem;
using namespace maquette;

std::vector<std::byte> bytes_of(const std::string& text) {
  std::vector<std::byte> bytes(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) bytes[i] = static_cast<std::byte>(text[i]);
  return bytes;
}

class FilesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("maquette_files_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    setenv("MAQUETTE_CACHE", (folder_ / "cache").c_str(), 1);
  }
  void TearDown() override {
    unsetenv("MAQUETTE_CACHE");
    fs::remove_all(folder_);
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::size_t entry_count() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  fs::path folder_;
};

TEST_F(FilesTest, WritesAndReadsBack) {
  const auto bytes = bytes_of(std::string("a\0b", 3));
  write_file_atomically(path("f.bin"), bytes);
  EXPECT_EQ(read_file(path("f.bin")), bytes);
  write_file_atomically(path("f.bin"), bytes_of("second"));
  EXPECT_EQ(read_file(path("f.bin")), bytes_of("second"));
  EXPECT_EQ(entry_count(), 1u);
}

TEST_F(FilesTest, ReadFaultsNameTheFile) {
  const auto message = [&](const std::string& name, std::size_t max_bytes) {
    try {
      read_file(name, max_bytes);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(message(path("absent"), 10).find("absent: does not exist"), std::string::npos);
  EXPECT_NE(message(folder_.string(), 10).find("is a folder"), std::string::npos);
  write_file_atomically(path("long"), bytes_of("0123456789"));
  EXPECT_NE(message(path("long"), 9).find("has 10 bytes"), std::string::npos);
  EXPECT_EQ(message(path("long"), 10), "");
}

TEST_F(FilesTest, FailedWriteLeavesNothing) {
  EXPECT_THROW(write_file_atomically(path("no_such_folder/f"), bytes_of("x")), Error);
  EXPECT_THROW(write_file_atomically(folder_.string(), bytes_of("x")), Error);
  EXPECT_THROW(write_file_atomically("", bytes_of("x")), Error);
  write_file_atomically(path("kept"), bytes_of("old"));
  EXPECT_THROW(write_atomically(path("kept"),
                                [](const std::string& temporary) {
                                  std::ofstream(temporary) << "half";
                                  throw Error(temporary, "stopped");
                                }),
               Error);
  EXPECT_EQ(read_file(path("kept")), bytes_of("old"));
  EXPECT_EQ(entry_count(), 1u);
}

TEST_F(FilesTest, TemporaryKeepsTheExtension) {
  write_atomically(path("picture.exr"), [](const std::string& temporary) {
    EXPECT_EQ(fs::path(temporary).extension(), ".exr");
    std::ofstream(temporary) << "x";
  });
}

TEST_F(FilesTest, LinksStayAndTheirTargetIsReplaced) {
  for (const char* target : {"real", "not yet there"}) {
    if (target == std::string("real")) write_file_atomically(path("real"), bytes_of("old"));
    fs::remove(path("link"));
    fs::create_symlink(target, path("link"));
    write_file_atomically(path("link"), bytes_of("new"));
    EXPECT_TRUE(fs::is_symlink(path("link")));
    EXPECT_EQ(read_file(path(target)), bytes_of("new"));
  }
  EXPECT_EQ(entry_count(), 3u);
}

TEST_F(FilesTest, PipesAndDevicesAreWrittenIntoAndStay) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  const int reader = ::open(path("pipe").c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  write_file_atomically(path("pipe"), bytes_of("through"));
  char got[16] = {};
  EXPECT_EQ(::read(reader, got, sizeof got), 7);
  ::close(reader);
  EXPECT_STREQ(got, "through");
  EXPECT_TRUE(fs::is_fifo(path("pipe")));
  write_file_atomically("/dev/null", bytes_of("x"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_THROW(write_file_atomically("/dev/full", bytes_of("x")), Error);
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
  EXPECT_EQ(entry_count(), 1u);
}

TEST_F(FilesTest, HashDependsOnContentAndSeed) {
  EXPECT_EQ(content_hash(bytes_of("abc")), content_hash(bytes_of("abc")));
  EXPECT_NE(content_hash(bytes_of("abc")), content_hash(bytes_of("abd")));
  EXPECT_NE(content_hash(bytes_of("abc")), content_hash(bytes_of("abc"), 1));
}

TEST_F(FilesTest, CacheKeepsKindsVersionsAndKeysApart) {
  cache_store("table", 1, 7, bytes_of("seven"));
  EXPECT_EQ(cache_load("table", 1, 7), bytes_of("seven"));
  EXPECT_FALSE(cache_load("table", 2, 7));
  EXPECT_FALSE(cache_load("table", 1, 8));
  EXPECT_FALSE(cache_load("other", 1, 7));
  EXPECT_TRUE(cache_holds("table", 1, 7));
  EXPECT_FALSE(cache_holds("table", 2, 7));
  EXPECT_FALSE(cache_holds("table", 1, 8));
  EXPECT_FALSE(cache_holds("other", 1, 7));
}

TEST_F(FilesTest, DamagedCacheEntryCountsAsAbsent) {
  cache_store("table", 1, 7, bytes_of("a longer payload"));
  const fs::path entry = fs::directory_iterator(folder_ / "cache")->path();
  const auto whole = read_file(entry.string());
  auto flipped = whole;
  flipped.back() ^= std::byte{1};
  write_file_atomically(entry.string(), flipped);
  EXPECT_FALSE(cache_load("table", 1, 7));
  for (std::size_t length : {std::size_t{0}, std::size_t{5}, whole.size() - 1}) {
    write_file_atomically(entry.string(), std::span(whole).first(length));
    EXPECT_FALSE(cache_load("table", 1, 7)) << length;
    EXPECT_FALSE(cache_holds("table", 1, 7)) << length;
  }
  write_file_atomically(entry.string(), whole);
  EXPECT_TRUE(cache_load("table", 1, 7));
}

TEST_F(FilesTest, ARelativeCacheFolderIsIgnored) {
  const char* before = std::getenv("XDG_CACHE_HOME");
  const std::string kept = before ? before : "", home = std::getenv("HOME") ? std::getenv("HOME") : "";
  unsetenv("MAQUETTE_CACHE");
  setenv("XDG_CACHE_HOME", "a/relative/path", 1);
  setenv("HOME", path("").c_str(), 1);
  EXPECT_EQ(cache_folder(), fs::path(path("")) / ".cache" / "maquette");
  setenv("XDG_CACHE_HOME", path("cache").c_str(), 1);
  EXPECT_EQ(cache_folder(), fs::path(path("cache")) / "maquette");
  setenv("HOME", home.c_str(), 1);
  if (before)
    setenv("XDG_CACHE_HOME", kept.c_str(), 1);
  else
    unsetenv("XDG_CACHE_HOME");
}

TEST_F(FilesTest, CacheCanBeSwitchedOffAndMayFail) {
  setenv("MAQUETTE_CACHE", "", 1);
  cache_store("table", 1, 7, bytes_of("x"));
  EXPECT_FALSE(cache_load("table", 1, 7));
  write_file_atomically(path("file"), bytes_of("x"));
  setenv("MAQUETTE_CACHE", path("file").c_str(), 1);  // a file where the folder should be
  EXPECT_NO_THROW(cache_store("table", 1, 7, bytes_of("x")));
  EXPECT_FALSE(cache_load("table", 1, 7));
}

}  // namespace
