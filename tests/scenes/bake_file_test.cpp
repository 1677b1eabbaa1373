#include "scenes/bake_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <numeric>

#include "scenes/error.h"
#include "scenes/exr_stream.h"
#include "tests/scenes/temporary_folder.h"

namespace maquette {
namespace {

BakeFile sample_file() {
  BakeFile file;
  file.attributes = {{"scene", "builtin:seat"}, {"depth", "7"}};
  BakeTable a{"nodes", {}, {}}, b{"sums", {}, {}};
  a.integers["mask"].resize(10000);
  std::iota(a.integers["mask"].begin(), a.integers["mask"].end(), 4294960000u);
  a.integers["plane"].assign(10000, 7u);
  b.floats["area"] = {0.5f, -1.0f, 3e30f};
  file.tables = {a, b};
  return file;
}

using BakeFileTest = test::TemporaryFolder;

TEST_F(BakeFileTest, RoundTrips) {
  const std::string file_path = path("bake.exr");
  const BakeFile file = sample_file();
  save_bake_file(file_path, file);
  const BakeFile loaded = load_bake_file(file_path);
  EXPECT_EQ(loaded.attributes, file.attributes);
  ASSERT_EQ(loaded.tables.size(), 2u);
  EXPECT_EQ(loaded.integers(file_path, "nodes", "mask"), file.tables[0].integers.at("mask"));
  EXPECT_EQ(loaded.floats(file_path, "sums", "area"), file.tables[1].floats.at("area"));
  EXPECT_THROW(loaded.floats(file_path, "sums", "mass"), Error);
  EXPECT_THROW(loaded.table(file_path, "weights"), Error);
}

/// A header asks for no more memory than the file can hold.
TEST_F(BakeFileTest, ATableIsNoLargerThanItsFile) {
  BakeFile bake;
  bake.tables.push_back({"rows", {{"a", std::vector<std::uint32_t>(100, 7u)}}, {}});
  save_bake_file(path("a.exr"), bake);
  EXPECT_FALSE(can_hold(path("a.exr"), std::uintmax_t{1} << 31));
  EXPECT_TRUE(can_hold(path("a.exr"), 16 * 4096));
  std::string bytes = read(path("a.exr"));
  std::size_t changed = 0;
  for (std::size_t at = 0; (at = bytes.find("Window\0box2i\0", at, 13)) != std::string::npos; ++at, ++changed) {
    const std::int32_t last_row = (1 << 17) - 1;
    std::memcpy(bytes.data() + at + 13 + 4 + 12, &last_row, sizeof last_row);
  }
  ASSERT_EQ(changed, 2u);
  write("b.exr", bytes);
  EXPECT_THROW(load_bake_file(path("b.exr")), Error);
}

TEST_F(BakeFileTest, NamesWhatIsDamaged) {
  const std::string file_path = path("bake.exr");
  save_bake_file(file_path, sample_file());
  const auto size = std::filesystem::file_size(file_path);
  std::filesystem::copy_file(file_path, path("whole.exr"));
  int refused = 0;
  for (std::uintmax_t at = 0; at < size; at += size / 37 + 1) {
    std::filesystem::copy_file(path("whole.exr"), file_path, std::filesystem::copy_options::overwrite_existing);
    std::fstream(file_path, std::ios::in | std::ios::out | std::ios::binary)
        .seekp(static_cast<std::streamoff>(at))
        .put('\x5a');
    try {
      const BakeFile file = load_bake_file(file_path);
      EXPECT_EQ(file.integers(file_path, "nodes", "plane"),
                std::vector<std::uint32_t>(10000, 7u));  // an arbitrary byte of the data
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("bake.exr"), std::string::npos);
      ++refused;
    }
    std::filesystem::copy_file(path("whole.exr"), file_path, std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(file_path, at);
    EXPECT_THROW(load_bake_file(file_path), Error) << at;
  }
  EXPECT_GT(refused, 20);
  EXPECT_THROW(load_bake_file(path("none.exr")), Error);
}

}  // namespace
}  // namespace maquette
