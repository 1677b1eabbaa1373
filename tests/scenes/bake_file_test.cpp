#include "scenes/bake_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numeric>

#include "scenes/error.h"
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
