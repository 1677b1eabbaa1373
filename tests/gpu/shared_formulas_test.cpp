#include "render/math/shared_formulas.h"

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <random>
#include <string>
#include <vector>

#include "render/gl/context.h"
#include "render/lights/light_list.h"
#include "scenes/files.h"
#include "test_paths.h"

namespace maquette {
namespace {

std::string read_shader(const std::string& path) {
  const auto bytes = read_file(std::string(MAQUETTE_SOURCE_DIR) + "/shaders/" + path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// One invocation a case: reads `Case in_cases[]`, writes `vec4 out_values[]`; `body` sets `result`.
std::vector<glm::vec4> run_on_gpu(const std::vector<std::string>& files, const std::string& case_members,
                                  const std::string& body, const void* cases, std::size_t case_bytes,
                                  std::size_t count) {
  std::string source = "#version 450 core\nlayout(local_size_x = 64) in;\n";
  for (const std::string& file : files) source += read_shader(file) + "\n";
  source += "struct Case {" + case_members + "};\n";
  source += "layout(std430, binding = 0) readonly buffer In { Case in_cases[]; };\n";
  source += "layout(std430, binding = 1) writeonly buffer Out { vec4 out_values[]; };\n";
  source += "void main() {\n  uint i = gl_GlobalInvocationID.x;\n  if (i >= uint(in_cases.length())) return;\n";
  source += "  Case c = in_cases[i];\n  vec4 result;\n" + body + "\n  out_values[i] = result;\n}\n";
  const GLuint shader = glCreateShader(GL_COMPUTE_SHADER);
  const char* text = source.c_str();
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint good = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
  char log[4096] = {};
  glGetShaderInfoLog(shader, sizeof log, nullptr, log);
  EXPECT_TRUE(good) << log;
  const GLuint program = glCreateProgram();
  glAttachShader(program, shader);
  glLinkProgram(program);
  GLuint buffers[2];
  glCreateBuffers(2, buffers);
  glNamedBufferStorage(buffers[0], static_cast<GLsizeiptr>(case_bytes * count), cases, 0);
  glNamedBufferStorage(buffers[1], static_cast<GLsizeiptr>(16 * count), nullptr, 0);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffers[0]);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, buffers[1]);
  std::vector<glm::vec4> values(count, glm::vec4(-7.0f));
  if (good) {
    glUseProgram(program);
    glDispatchCompute(static_cast<GLuint>((count + 63) / 64), 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(buffers[1], 0, static_cast<GLsizeiptr>(16 * count), values.data());
  }
  glDeleteBuffers(2, buffers);
  glDeleteProgram(program);
  glDeleteShader(shader);
  EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
  return values;
}

class SharedFormulas : public ::testing::Test {
 protected:
  GlContext context_ = GlContext::create_headless();
  std::mt19937 random_{42};
  glm::vec3 vector() {
    std::uniform_real_distribution<float> uniform(-1.0f, 1.0f);
    return {uniform(random_), uniform(random_), uniform(random_)};
  }
  float unit() { return std::uniform_real_distribution<float>(0.0f, 1.0f)(random_); }
};

TEST_F(SharedFormulas, VisibilityReadsTheSameBits) {
  struct Case {
    glm::vec4 direction{};
    glm::uvec4 words[5]{};  // 18 of them
  };
  std::vector<Case> cases(4000);
  for (Case& c : cases) {
    c.direction = glm::vec4(glm::normalize(vector()), 0.0f);
    for (glm::uvec4& w : c.words) w = glm::uvec4(random_(), random_(), random_(), random_());
  }
  const auto got =
      run_on_gpu({"shared/octahedral.glsl", "shared/visibility.glsl"}, "vec4 direction; uvec4 words[5];",
                 "VisibilityCorner corner = visibility_corner(c.direction.xyz);\n"
                 "VisibilityBitPosition place = visibility_bit_position(corner.lower);\n"
                 "uint word = c.words[place.word >> 2][place.word & 3];\n"
                 "result = vec4(dot(visibility_shares(corner.fraction), visibility_bits(word, place.shift)), "
                 "float(visibility_bit(c.direction.xyz)), float(place.word), 0.0);",
                 cases.data(), sizeof(Case), cases.size());
  int different = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const Case& c = cases[i];
    const shared::VisibilityCorner corner = shared::visibility_corner(glm::vec3(c.direction));
    const shared::VisibilityBitPosition place = shared::visibility_bit_position(corner.lower);
    ASSERT_TRUE(place.word >= 0 && place.word < shared::kVisibilityWords);
    const std::uint32_t word = c.words[place.word >> 2][place.word & 3];
    const float value =
        glm::dot(shared::visibility_shares(corner.fraction), shared::visibility_bits(word, place.shift));
    different += std::abs(got[i].x - value) > 1e-4f ? 1 : 0;
    different += got[i].y != static_cast<float>(shared::visibility_bit(glm::vec3(c.direction))) ? 1 : 0;
    different += got[i].z != static_cast<float>(place.word) ? 1 : 0;
  }
  EXPECT_LE(different, 12);  // a direction on the border of two cells may be rounded to either
}

TEST_F(SharedFormulas, LightsSampleTheSame) {
  struct Case {
    LightRecord light{};
    glm::vec4 point{}, u{};
  };
  static_assert(sizeof(Case) == 96);
  std::vector<Case> cases(4000);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    Case& c = cases[i];
    c.light.kind = static_cast<std::uint32_t>(i % 4);
    c.light.position = vector();
    c.light.direction = c.light.kind == shared::kLightTriangle ? vector() : glm::normalize(vector());
    c.light.range_m = i % 8 < 4 ? 0.0f : 2.5f;
    c.light.color = glm::vec3(unit(), unit(), unit());
    c.light.edge2 = c.light.kind == shared::kLightSpot ? glm::vec3(0.9f, 0.4f, 0.0f) : vector();
    c.light.selection_pdf = 0.5f;
    c.light.cdf = 1.0f;
    c.point = glm::vec4(2.0f * vector(), 0.0f);
    c.u = glm::vec4(unit(), unit(), 0.0f, 0.0f);
  }
  const auto got = run_on_gpu({"shared/lights.glsl"}, "LightRecord light; vec4 point; vec4 u;",
                              "LightSample s = light_sample(c.light, c.point.xyz, c.u.xy);\n"
                              "result = vec4(s.radiance.x, s.wi.y, s.pdf, "
                              "light_bandwidth(c.light, s.wi, s.distance_m, 3.0));",
                              cases.data(), sizeof(Case), cases.size());
  int lit = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const Case& c = cases[i];
    const auto s = shared::light_sample(c.light, glm::vec3(c.point), glm::vec2(c.u));
    EXPECT_NEAR(got[i].x, s.radiance.x, 1e-4f * (1.0f + s.radiance.x)) << i;
    if (s.radiance.x < 1e-4f) continue;
    ++lit;
    EXPECT_NEAR(got[i].y, s.wi.y, 1e-4f) << i;
    EXPECT_NEAR(got[i].z, s.pdf, 1e-3f * s.pdf) << i;
    const float nu = shared::light_bandwidth(c.light, s.wi, s.distance_m, 3.0f);
    EXPECT_NEAR(got[i].w, nu, 1e-3f * nu) << i;
  }
  EXPECT_GT(lit, 1500);
}

}  // namespace
}  // namespace maquette
