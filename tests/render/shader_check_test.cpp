// Every variant of every shader, checked against the language's specification by glslangValidator: without a driver, so
// that all sets of defines take seconds. What drivers make of them is seen by the pictures of tests/gpu.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <map>
#include <set>
#include <span>
#include <sstream>

#include "render/gbuffer/surfaces.h"
#include "render/gl/program_cache.h"
#include "render/renderer.h"
#include "scenes/parallel.h"
#include "test_paths.h"
#include "tests/scenes/temporary_folder.h"

namespace maquette {
namespace {

/// The stages of one program.
struct CheckedProgram {
  std::string name;
  std::vector<ShaderText> stages;
  std::vector<std::string> endings;  ///< by which glslangValidator knows the stages
};

CheckedProgram program_of(const ShaderVariant& variant, const ShaderDefines& common) {
  ShaderDefines defines = common;
  defines.insert(defines.end(), variant.defines.begin(), variant.defines.end());
  CheckedProgram program;
  program.name = variant.path;
  for (const auto& [name, value] : defines) program.name += " " + name + "=" + value;
  if (!variant.vertex_path.empty()) {
    program.stages.push_back(shader_text(variant.vertex_path, defines));
    program.endings.push_back(".vert");
  }
  program.stages.push_back(shader_text(variant.path, defines));
  program.endings.push_back(variant.vertex_path.empty() ? ".comp" : ".frag");
  return program;
}

/// All sets of details that a scene may have: none, or any with each combination of the three that change lobes.
std::vector<MaterialDetails> all_details() {
  std::vector<MaterialDetails> all{MaterialDetails{}};
  for (int k = 0; k < 8; ++k) all.push_back({true, (k & 1) != 0, (k & 2) != 0, (k & 4) != 0});
  return all;
}

const std::string kValidator =
    "glslangValidator '" + std::string(MAQUETTE_SOURCE_DIR) + "/tests/render/gl45_limits.conf'";

/// What a command prints, and whether it succeeds.
bool run(const std::string& command, std::string* said) {
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return false;
  char part[4096];
  for (std::size_t n = 0; (n = std::fread(part, 1, sizeof part, pipe)) > 0;) said->append(part, n);
  const int status = pclose(pipe);
  if (said->find("not found") != std::string::npos && WEXITSTATUS(status) == 127)
    *said = "install glslang-tools: " + *said;
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

class ShaderCheck : public test::TemporaryFolder {
 protected:
  std::vector<std::string> write_stages(const CheckedProgram& program, std::size_t number) const {
    std::vector<std::string> files;
    for (std::size_t s = 0; s < program.stages.size(); ++s)
      files.push_back(write(std::to_string(number) + program.endings[s], program.stages[s].source));
    return files;
  }
  /// What is said of a program whose stages are linked, with the names of files; empty: nothing.
  std::string link(const CheckedProgram& program, std::size_t number) const {
    std::string command = kValidator + " -l", said;
    for (const std::string& file : write_stages(program, number)) command += " '" + file + "'";
    if (run(command, &said)) return {};
    return program.name + ": " + program.stages.back().name_files(said, "ERROR: ");
  }
  /// The same of the stages of several, which are not linked: one process compiles them all in little more than the
  /// time in which it starts.
  std::string compile(std::span<const CheckedProgram> programs, std::size_t first) const {
    std::map<std::string, std::pair<std::size_t, std::size_t>> stages;  // program and stage of each file
    std::string command = kValidator, said, messages;
    for (std::size_t i = 0; i < programs.size(); ++i) {
      const std::vector<std::string> files = write_stages(programs[i], first + i);
      for (std::size_t s = 0; s < files.size(); ++s) {
        command += " '" + files[s] + "'";
        stages[files[s]] = {i, s};
      }
    }
    if (run(command, &said)) return {};
    const CheckedProgram* program = nullptr;
    std::size_t stage = 0;
    std::istringstream lines(said);
    for (std::string line; std::getline(lines, line);) {
      if (const auto found = stages.find(line); found != stages.end()) {
        program = &programs[found->second.first];
        stage = found->second.second;
      } else if (line.starts_with("ERROR: ") && program) {
        messages += program->name + ": " + program->stages[stage].name_files(line, "ERROR: ") + "\n";
      }
    }
    return messages.empty() ? said : messages;
  }
};

/// The first lines of what is said.
void expect_nothing_said(const std::string& messages) { EXPECT_EQ(messages.substr(0, 2000), ""); }

TEST_F(ShaderCheck, EveryVariantIsValidAndLinks) {
  std::vector<CheckedProgram> programs;
  std::set<std::string> seen;
  for (const MaterialDetails& details : all_details()) {
    const ShaderDefines common = shader_defines(details);
    std::set<ShaderVariant> listed;
    for (const ShaderVariant& variant : all_shader_variants()) {
      EXPECT_TRUE(listed.insert(variant).second) << variant.path << " is listed twice";
      CheckedProgram program = program_of(variant, common);
      // Defines that a shader does not read leave the same program.
      std::string key;
      for (const ShaderText& stage : program.stages) {
        for (const auto& [name, value] : common)
          if (stage.source.find(name, stage.source.find("#line 1 0")) != std::string::npos) key += name + value;
        key += stage.source.substr(stage.source.find("#line 1 0")) + '\0';
      }
      for (const auto& [name, value] : variant.defines) key += name + value;
      if (seen.insert(key).second) programs.push_back(std::move(program));
    }
  }
  std::size_t graphics = 0, compute = 0;
  for (const CheckedProgram& program : programs) ++(program.stages.size() == 2 ? graphics : compute);
  std::printf("%zu compute shaders, %zu graphics programs\n", compute, graphics);
  EXPECT_GT(programs.size(), 500u);

  constexpr std::size_t kTogether = 200;
  std::vector<std::string> said((programs.size() + kTogether - 1) / kTogether);
  parallel_for(std::size_t{0}, said.size(), [&](std::size_t k) {
    const std::size_t first = k * kTogether, count = std::min(kTogether, programs.size() - first);
    said[k] = compile(std::span(programs).subspan(first, count), first);
  });
  for (const std::string& messages : said) expect_nothing_said(messages);

  // Linked are all pairs of stages, without details and with all; a compute shader with itself, in its last variant:
  // that shows functions without a body.
  std::map<std::string, std::vector<std::size_t>> linked;
  for (std::size_t i = 0; i < programs.size(); ++i) {
    const std::string& name = programs[i].name;
    if (programs[i].stages.size() == 1)
      linked[name.substr(0, name.find(' '))] = {i};
    else if (name.find("DETAILS=0") != std::string::npos || name.find("ANALYTIC_FILM=1") != std::string::npos)
      linked["pairs"].push_back(i);
  }
  std::vector<std::size_t> all;
  for (const auto& [name, of_name] : linked) all.insert(all.end(), of_name.begin(), of_name.end());
  said.assign(all.size(), {});
  parallel_for(std::size_t{0}, all.size(), [&](std::size_t k) { said[k] = link(programs[all[k]], all[k]); });
  for (const std::string& messages : said) expect_nothing_said(messages);
}

TEST_F(ShaderCheck, FaultsAreFound) {
  const auto compute = [](const std::string& body) {
    CheckedProgram program;
    program.name = "made.comp";
    program.stages.push_back({"#version 450 core\n#line 1 0\n" + body, {"made.comp"}});
    program.endings.push_back(".comp");
    return program;
  };
  const std::string good = "layout(local_size_x = 64) in;\nvoid main() {}\n";
  EXPECT_EQ(link(compute(good), 0), "");
  const std::string undeclared = link(compute("layout(local_size_x = 64) in;\nvoid main() { missing = 1; }\n"), 1);
  EXPECT_NE(undeclared.find("made.comp:2: 'missing'"), std::string::npos) << undeclared;
  const std::string together = compile(
      std::vector<CheckedProgram>{compute(good), compute("layout(local_size_x = 64) in;\nvoid main() { lost(); }\n")},
      5);
  EXPECT_NE(together.find("made.comp:2: 'lost'"), std::string::npos) << together;
  EXPECT_NE(link(compute("layout(local_size_x = 2048) in;\nvoid main() {}\n"), 2), "") << "a work group too large";
  EXPECT_NE(link(compute(good + "layout(binding = 200) uniform sampler2D t;\n"), 3), "") << "a unit that is not there";
  EXPECT_NE(link(compute("layout(local_size_x = 64) in;\nvoid f();\nvoid main() { f(); }\n"), 4), "")
      << "a function without a body does not link";
}

}  // namespace
}  // namespace maquette
