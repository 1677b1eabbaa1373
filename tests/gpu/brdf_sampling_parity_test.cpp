#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "render/gl/context.h"
#include "render/gl/objects.h"
#include "render/materials/brdf_sampler.h"
#include "render/materials/brdf_tables.h"

namespace {

using namespace maquette;

/// In: wo.xy and two random numbers. Out: direction, density, coordinates, density computed again, index of the cell.
std::string parity_shader() {
  return "#version 450 core\n"
         "layout(local_size_x = 64) in;\n"
         "layout(std430, binding = 0) readonly buffer ThetaCells { vec2 theta_cells[]; };\n"
         "layout(std430, binding = 1) readonly buffer PhiCells { vec2 phi_cells[]; };\n"
         "layout(std430, binding = 2) readonly buffer Inputs { vec4 inputs[]; };\n"
         "layout(std430, binding = 3) writeonly buffer Outputs { vec4 outputs[]; };\n"
         "vec2 fetch_theta_cell(int e, int k) { return theta_cells[e * 96 + k]; }\n"
         "vec2 fetch_phi_cell(int e, int k, int p) { return phi_cells[(e * 96 + k) * 16 + p]; }\n" +
         load_shader_text("shared/merl.glsl") + "\n" + load_shader_text("shared/brdf_sampling.glsl") +
         "\nvoid main() {\n"
         "  uint i = gl_GlobalInvocationID.x;\n"
         "  vec4 v = inputs[i];\n"
         "  vec3 wo = vec3(v.x, v.y, sqrt(max(0.0, 1.0 - v.x * v.x - v.y * v.y)));\n"
         "  BrdfSample s = sample_brdf(wo, v.zw);\n"
         "  vec3 c = merl_coordinates(s.wi, wo);\n"
         "  MerlCell cell = merl_cell(c);\n"
         "  outputs[3 * i] = vec4(s.wi, s.pdf);\n"
         "  outputs[3 * i + 1] = vec4(c, brdf_sample_pdf(wo, s.wi));\n"
         "  outputs[3 * i + 2] = vec4(cell.fraction, float(merl_index(cell.lower.x, cell.lower.y, cell.lower.z)));\n"
         "}\n";
}

GLuint build_program(const std::string& source) {
  const GLuint shader = glCreateShader(GL_COMPUTE_SHADER);
  const char* text = source.c_str();
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  char log[4096] = "";
  glGetShaderInfoLog(shader, sizeof log, nullptr, log);
  GLint compiled = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  EXPECT_TRUE(compiled) << log;
  const GLuint program = glCreateProgram();
  glAttachShader(program, shader);
  glLinkProgram(program);
  glDeleteShader(shader);
  return program;
}

/// Both sides compile the same source of sampler and coordinates; this tests that the driver's arithmetic agrees.
TEST(BrdfSamplingParity, ShaderAndHostAgree) {
  const GlContext context = GlContext::create_headless();
  const GLuint program = build_program(parity_shader());
  for (const char* name : {"paint-silver-metallic", "metal-chrome", "matte-white"}) {
    const BrdfTables tables = compute_brdf_tables(make_builtin_brdf(name));
    constexpr std::size_t kCount = 16384;
    std::vector<glm::vec4> inputs(kCount), outputs(3 * kCount);
    std::mt19937 random(1);
    std::uniform_real_distribution<float> unit(0.0f, 1.0f);
    for (glm::vec4& v : inputs) {
      const float theta = 1.57f * unit(random), phi = 6.28f * unit(random);
      v = glm::vec4(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), unit(random), unit(random));
    }
    const Buffer buffers[] = {Buffer::from("theta", tables.theta_cells), Buffer::from("phi", tables.phi_cells),
                              Buffer::from("inputs", inputs), Buffer::from("outputs", outputs)};
    for (GLuint b = 0; b < 4; ++b) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, b, buffers[b].get());
    glUseProgram(program);
    glDispatchCompute(kCount / 64, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    buffers[3].read(0, outputs.size() * sizeof(glm::vec4), outputs.data());
    shared::BrdfSampler sampler(tables);
    int other_direction = 0, other_density = 0, other_coordinates = 0, other_asked = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
      const glm::vec4 v = inputs[i];
      const glm::vec3 wo(v.x, v.y, std::sqrt(std::max(0.0f, 1.0f - v.x * v.x - v.y * v.y)));
      const auto expected = sampler.sample_brdf(wo, glm::vec2(v.z, v.w));
      const glm::vec3 wi(outputs[3 * i]);
      const auto differs = [](float a, float b) { return std::abs(a - b) > 5e-3f * std::abs(b); };
      if (glm::length(wi - expected.wi) > 1e-4f) ++other_direction;
      if (differs(outputs[3 * i].w, expected.pdf)) ++other_density;
      if (differs(outputs[3 * i + 1].w, sampler.brdf_sample_pdf(wo, wi))) ++other_asked;
      // theta_h of a mirror direction is limited by the float directions: 1e-7 rad, 0.03 bins near zero.
      const glm::vec3 coordinates = shared::merl_coordinates(wi, wo);
      const glm::vec3 difference = glm::abs(coordinates - glm::vec3(outputs[3 * i + 1]));
      if (difference.x > 0.03f || difference.y > 2e-3f) ++other_coordinates;
    }
    // A number on the border of a cell may be in either cell.
    EXPECT_LT(other_direction, 8) << name;
    EXPECT_LT(other_density, 8) << name;
    EXPECT_LT(other_asked, 80) << name;
    EXPECT_LT(other_coordinates, 8) << name;
  }
  glDeleteProgram(program);
  EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
}

}  // namespace
