// Damaged files of every kind that is read, each in a process of its own, by the program's own commands. 10^5 of them:
//
//   MAQUETTE_MUTATIONS=100000 [MAQUETTE_SEED=N] build/tests/test_fuzz --gtest_filter='Mutations.*'
//
// MAQUETTE_FIRST=N begins at one of them: the seed that a failure names, less the first seed.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <sstream>

#include "review/camera_path.h"
#include "review/review.h"
#include "scenes/btf/btf.h"
#include "scenes/btf/btf_file.h"
#include "scenes/btf/btf_reading.h"
#include "scenes/error.h"
#include "scenes/harmless.h"
#include "scenes/image_io.h"
#include "scenes/scene.h"
#include "tests/scenes/temporary_folder.h"
#include "tests/support/test_scenes.h"
#include "viewer/commands.h"
#include "viewer/print.h"

namespace maquette {
namespace {

namespace fs = std::filesystem;

constexpr int kMutationRounds = 300;  // where nothing else is asked for
constexpr int kLongest_s = 20;        // far above any of them
constexpr long kMostMemory_kB = 2'000'000;
constexpr int kMostLines = 3;

/// One file that is damaged, and what reads it: words of a command, before the file or what is `named` in its place, or
/// a function.
struct Target {
  std::string file;
  std::vector<std::string> words = {};
  std::string named = {};
  std::function<void(const std::string&)> read = {};
};

/// What a reading process came to.
struct Outcome {
  int status = 0;
  long memory_kb = 0;
  std::string out, error;
};

/// A few changes of the kinds that break readers.
std::string mutated(std::string bytes, std::mt19937* random) {
  static const char* const kWords[] = {
      "1e400", "-1",     "4294967295", "null", "\"\\u001b[2J\"", "\x1b[31m", "\xc2\x9b",
      "[[[[",  "1e20",   "{}",         "\xff", "\xe2\x80\xae",   "0",        "9999999999",
      "\n\n",  "-1e-30", "\"..\"",     "[]",   "true",           "\\",       "65536"};
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>((*random)() % std::max<std::size_t>(n, 1)); };
  if (below(200) == 0) {  // deep, and closed again
    const std::size_t depth = 1u << (4 + below(15));
    std::string open;
    for (std::size_t i = 0; i < depth; ++i) open += i % 2 == 0 ? "[" : "{\"a\":";
    for (std::size_t i = depth; i-- > 0;) bytes += i % 2 == 0 ? ']' : '}';
    return open + bytes;
  }
  const std::size_t changes = 1 + below(6);
  for (std::size_t i = 0; i < changes && !bytes.empty(); ++i) {
    // Headers decide most.
    const std::size_t at = below(below(2) == 0 ? std::min<std::size_t>(bytes.size(), 512) : bytes.size());
    switch (below(7)) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        break;
      case 1:
        bytes[at] = static_cast<char>((*random)());
        break;
      case 2:
        bytes.resize(at);
        break;
      case 3:
        bytes.erase(at, 1 + below(16));
        break;
      case 4:
        bytes.insert(at, bytes.substr(below(bytes.size()), below(64)));
        break;
      case 5: {
        const std::string word = kWords[below(std::size(kWords))];
        bytes.replace(at, below(2) == 0 ? 0 : word.size(), word);
        break;
      }
      default: {
        const std::uint32_t value = below(3) == 0   ? 0xffffffffu
                                    : below(2) == 0 ? 0x7fffffffu
                                                    : static_cast<std::uint32_t>((*random)());
        if (at + sizeof value <= bytes.size()) std::memcpy(bytes.data() + at, &value, sizeof value);
      }
    }
  }
  return bytes;
}

/// A triangle with a picture beside the file and its vertices in a data URI.
constexpr const char* kTextured = R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
"nodes": [{"mesh": 0, "name": "part", "translation": [0, 1, 0]}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
"materials": [{"name": "paint", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "roughnessFactor": 0.5}}],
"textures": [{"source": 0, "sampler": 0}], "samplers": [{"wrapS": 10497}], "images": [{"uri": "t.png"}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC2"}],
"bufferViews": [{"buffer": 0, "byteLength": 36}],
"buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}
)";

class Mutations : public test::TemporaryFolder {
 protected:
  void SetUp() override {
    TemporaryFolder::SetUp();
    ::setenv("MAQUETTE_CACHE", path("cache").c_str(), 1);
    fs::create_directories(path("btf"));
    fs::create_directories(path("work"));
    // A fork has no threads but the one that forked: this process makes none of its own.
    const Outcome made = in_process([this] { make_files(); });
    ASSERT_EQ(made.status, 0) << made.error;
    const auto inspected = [&](const std::string& file) { targets_.push_back({path(file), {"inspect"}}); };
    for (const char* file : {"a.glb", "s.gltf", "e.exr", "e.hdr", "r.maquette.json", "m.binary", "b.exr"})
      inspected(file);
    targets_.push_back({path("t.png"), {"inspect"}, path("s.gltf")});
    targets_.push_back(
        {path("p.path.json"), {}, {}, [](const std::string& file) { check_path(load_path(file), file); }});
    for (const auto& entry : fs::directory_iterator(path("btf"))) {
      targets_.push_back({entry.path().string(), {"inspect"}, path("btf")});
      break;
    }
    // Bakes are resumed from their folders: damaged parts are made again.
    std::map<std::string, int> kinds;
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(path("bakes")))
      if (entry.is_regular_file()) files.push_back(entry.path());
    std::ranges::sort(files);
    for (const fs::path& file : files) {
      const bool part = file.parent_path() != path("bakes");
      const std::string name = file.filename().string(), kind = !part ? "octree"
                                                                : file.parent_path().string().ends_with("-slf") ? "slf"
                                                                                                                : "prt";
      if (++kinds[kind + name.substr(0, name.find_first_of("0123456789"))] > 1) continue;  // blocks are alike
      targets_.push_back({file.string(), {"inspect"}, part ? file.parent_path().string() : file.string()});
      resumed_.push_back(
          {file.string(), {"bake", kind, "-o", path("bakes"), "--set", "octree.depth=3"}, path("a.glb")});
      if (kind != "octree") resumed_.back().words.resize(4);
    }
  }
  void TearDown() override {
    ::unsetenv("MAQUETTE_CACHE");
    TemporaryFolder::TearDown();
  }

  void make_files() {
    Scene scene;
    scene.materials = {test::matte(glm::vec3(0.5f))};
    test::add(&scene, test::make_grid({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 2, 0), "floor");
    test::add(&scene, test::make_grid({-1, 0, 0}, {1, 0, 0}, {0, 1, 0}, 2, 0), "wall");
    save_glb(path("a.glb"), scene);
    save_png(path("t.png"), Image(8, 8, 4, 0.5f));
    write("s.gltf", kTextured);
    save_exr(path("e.exr"), Image(16, 8, 3, 0.5f), {{"maquette.note", "a picture"}});
    write("e.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + std::string(128, '\x80'));
    CameraPath way;
    way.name = "way";
    way.keys.resize(2);
    way.keys[1].camera.eye.x += 1.0f;
    save_path(path("p.path.json"), way);
    Review review;
    review.scene = path("a.glb");
    review.looks.push_back(review.look);
    review.looks[0].name = "red";
    review.looks[0].edits.materials["paint"] = "builtin:paint-solid-red";
    review.paths = {way};
    save_review(path("r.maquette.json"), review);
    // The beginning of a MERL table: a whole one has 33 MB.
    const std::int32_t sizes[3] = {90, 90, 180};
    write("m.binary", std::string(reinterpret_cast<const char*>(sizes), sizeof sizes) + std::string(4096, '\x3f'));
    make_btf_images();
    save_btf(path("b.exr"), read_btf_folder(path("btf"), {.components = 2}));
    const std::vector<std::vector<std::string>> bakes = {
        {"octree", "--set", "octree.depth=3"},
        {"slf", "--set", "slf.texels=32", "--set", "slf.directions=4", "--set", "slf.paths=1"},
        {"prt", "--set", "prt.rays=1", "--set", "prt.faces=4", "--set", "prt.bounces=0", "--set", "prt.vertices=100"}};
    for (std::vector<std::string> words : bakes) {
      words.insert(words.begin(), "bake");
      words.insert(words.end(), {path("a.glb"), "-o", path("bakes")});
      if (run(words) != 0) std::exit(3);
    }
  }

  void make_btf_images() {
    for (const char* view : {"000 pv000", "030 pv000", "030 pv120", "030 pv240"})
      for (const char* light : {"000 pl000", "030 pl000", "030 pl120", "030 pl240"})
        save_png(path(std::string("btf/00001 tl") + light + " tv" + view + ".png"), Image(4, 4, 3, 0.4f));
  }

  static int run(std::vector<std::string> words) {
    words.insert(words.begin(), "maquette");
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    return run_program(static_cast<int>(words.size()), arguments.data());
  }

  /// What `body` does in a process of its own, with what it prints.
  Outcome in_process(const std::function<void()>& body) const {
    const std::string out = path("work/out"), error = path("work/error");
    const pid_t child = ::fork();
    if (child == 0) {
      if (!std::freopen(out.c_str(), "w", stdout) || !std::freopen(error.c_str(), "w", stderr)) ::_exit(4);
      ::alarm(kLongest_s);
      body();
      std::fflush(nullptr);
      ::_exit(0);
    }
    Outcome outcome;
    rusage usage{};
    ::wait4(child, &outcome.status, 0, &usage);
    outcome.memory_kb = usage.ru_maxrss;
    outcome.out = read(out);
    outcome.error = read(error);
    return outcome;
  }

  /// Lines without those of progress.
  static int message_lines(const std::string& text) {
    int count = 0;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) count += line.ends_with(" %") ? 0 : 1;
    return count;
  }

  /// What is wrong with how a damaged file was read; empty: nothing.
  static std::string fault_of(const Outcome& outcome) {
    if (WIFSIGNALED(outcome.status))
      return WTERMSIG(outcome.status) == SIGALRM ? "hangs"
                                                 : "crashes: signal " + std::to_string(WTERMSIG(outcome.status));
    if (WEXITSTATUS(outcome.status) > 2) return "exit code " + std::to_string(WEXITSTATUS(outcome.status));
    if (outcome.memory_kb > kMostMemory_kB) return "takes " + std::to_string(outcome.memory_kb) + " kB";
    if (message_lines(outcome.error) > kMostLines) return "more than three lines: " + outcome.error;
    for (const std::string& text : {outcome.out, outcome.error})
      if (harmless(text, true) != text) return "a control character: " + harmless(text);
    return {};
  }

  Outcome read_damaged(const Target& target, std::uint32_t seed) {
    std::mt19937 random(seed);
    const std::string whole = read(target.file);
    write_over(target.file, mutated(whole, &random));
    const Outcome outcome = in_process([&] {
      if (target.read) {
        try {
          target.read(target.file);
        } catch (const Error& error) {
          print_line(stderr, "maquette: %s", error.what());
        }
        return;
      }
      std::vector<std::string> words = target.words;
      words.push_back(target.named.empty() ? target.file : target.named);
      const int code = run(words);
      std::fflush(nullptr);
      ::_exit(code);
    });
    if (const std::string fault = fault_of(outcome); !fault.empty())
      ADD_FAILURE() << fs::path(target.file).filename().string() << ", seed " << seed << ": " << fault;
    write_over(target.file, whole);
    return outcome;
  }
  static void write_over(const std::string& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
  }

  std::vector<Target> targets_;
  std::vector<Target> resumed_;  ///< those that take long
};

TEST_F(Mutations, NoneCrashesHangsOrSteersTheTerminal) {
  const char* const asked = std::getenv("MAQUETTE_MUTATIONS");
  const char* const begin = std::getenv("MAQUETTE_SEED");
  const int rounds = asked ? std::atoi(asked) : kMutationRounds;
  const auto seed = static_cast<std::uint32_t>(begin ? std::atoi(begin) : 1);
  ASSERT_GT(targets_.size(), 12u);
  std::map<std::string, std::pair<int, int>> read;  // kinds: all, and those that were refused
  const char* const again = std::getenv("MAQUETTE_FIRST");
  for (int i = again ? std::atoi(again) : 0; i < rounds && !HasFailure(); ++i) {
    const std::vector<Target>& from = i % 100 == 99 ? resumed_ : targets_;
    const Target& target = from[static_cast<std::size_t>(i % 100 == 99 ? i / 100 : i) % from.size()];
    const Outcome outcome = read_damaged(target, seed + static_cast<std::uint32_t>(i));
    auto& [all, refused] = read[fs::path(target.file).filename().string()];
    ++all;
    refused += outcome.error.empty() ? 0 : 1;
    if (asked && i % 1000 == 999) std::printf("%d of %d\n", i + 1, rounds), std::fflush(stdout);
  }
  for (const auto& [name, count] : read)
    std::printf("%s: %d, %d of them with a message\n", name.c_str(), count.first, count.second);
}

}  // namespace
}  // namespace maquette
