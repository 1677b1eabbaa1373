#include "tests/benchmarks/reference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "render/environment_buffers.h"
#include "render/gl/objects.h"
#include "render/rgb9e5_shared.h"
#include "scenes/error.h"
#include "scenes/files.h"

namespace maquette::bench {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kBrightOverMean = 50.0;
constexpr std::size_t kMaxBrightTexels = 256;
constexpr int kMaxDirections = 1600;

double luminance(const glm::dvec3& c) { return 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b; }

double mean_luminance(const Environment& e) {
  double sum = 0.0, weights = 0.0;
  for (int y = 0; y < e.height; ++y) {
    const double weight = std::sin(kPi * (y + 0.5) / e.height);
    for (int x = 0; x < e.width; ++x) {
      sum += weight * luminance(e.rgb[static_cast<std::size_t>(y * e.width + x)]);
      weights += weight;
    }
  }
  return sum / weights;
}

std::vector<std::size_t> bright_texels(const Environment& e) {
  const double threshold = kBrightOverMean * mean_luminance(e);
  std::vector<std::size_t> bright;
  for (std::size_t i = 0; i < e.rgb.size(); ++i)
    if (luminance(e.rgb[i]) > threshold) bright.push_back(i);
  std::sort(bright.begin(), bright.end(),
            [&](std::size_t a, std::size_t b) { return luminance(e.rgb[a]) > luminance(e.rgb[b]); });
  if (bright.size() > kMaxBrightTexels) bright.resize(kMaxBrightTexels);
  std::sort(bright.begin(), bright.end());
  return bright;
}

/// Residual light between texel centres, bilinear, zero where no bright texel is a corner.
class Residual {
 public:
  Residual(const Environment& all, const Environment& rest) : all_(all), rest_(rest) {}
  glm::dvec3 texel(int x, int y) const {
    const int column = (x + all_.width) % all_.width, row = std::clamp(y, 0, all_.height - 1);
    const auto i = static_cast<std::size_t>(row * all_.width + column);
    return glm::dvec3(all_.rgb[i]) - glm::dvec3(rest_.rgb[i]);
  }
  /// The square between four centres, its lower corner given, cut into side^2 pieces.
  void append_cell(int x, int y, int side, std::vector<BrightDirection>* directions) const {
    for (int k = 0; k < side * side; ++k) {
      const double a = (k % side + 0.5) / side, b = (k / side + 0.5) / side;
      const glm::dvec3 light =
          glm::mix(glm::mix(texel(x, y), texel(x + 1, y), a), glm::mix(texel(x, y + 1), texel(x + 1, y + 1), a), b);
      if (luminance(light) <= 0.0) continue;
      const double map_x = x + 0.5 + a, map_y = y + 0.5 + b;
      const double solid_angle = 2.0 * kPi * kPi / (static_cast<double>(all_.width) * all_.height * side * side) *
                                 std::sin(kPi * map_y / all_.height);
      directions->push_back({glm::vec4(direction_from_latlong(map_x, map_y, all_.width, all_.height), 0.0),
                             glm::vec4(light * solid_angle, 0.0)});
    }
  }

 private:
  const Environment& all_;
  const Environment& rest_;
};

/// `source` between the shader's own headers: everything that load_point and the BRDFs need.
std::string kernel_source(bool measured) {
  std::string text =
      "#version 450 core\n#define MEASURED " + std::string(measured ? "1" : "0") + "\nlayout(local_size_x = 64) in;\n";
  for (const char* path :
       {"shared/frame.glsl", "shared/constants.glsl", "shared/latlong.glsl", "shared/octahedral.glsl",
        "shared/rgb9e5.glsl", "shared/gbuffer.glsl", "shared/material_table.glsl", "shared/analytic.glsl",
        "shared/merl.glsl", "shading/point.glsl"})
    text += load_shader_text(path);
  return text + R"(
layout(binding = 31) uniform samplerBuffer t_directions;
layout(std430, binding = 2) readonly buffer Pixels { uint b_pixels[]; };
layout(std430, binding = 3) writeonly buffer Light { vec4 b_light[]; };
uniform int u_pixel_count;
uniform int u_direction_count;

#if MEASURED
/// What measured_brdf gives on the average over xi.
vec3 brdf(Point p, vec3 wi) {
  vec3 c = merl_coordinates(wi, p.wo);
  vec2 whole = floor(c.yz), part = c.yz - whole;
  vec3 sum = vec3(0.0);
  for (int k = 0; k < 4; ++k) {
    vec2 corner = vec2(k & 1, k >> 1);
    // xi below 1 - part stays at the lower neighbour: the middle of each interval stands for it.
    vec2 xi = mix(0.5 * (vec2(1.0) - part), vec2(1.0) - 0.5 * part, corner);
    vec2 weight = mix(vec2(1.0) - part, part, corner);
    sum += weight.x * weight.y * measured_brdf(p.slot, wi, p.wo, xi);
  }
  return sum * p.tint;
}
#else
vec3 brdf(Point p, vec3 wi) { return evaluate_analytic(p.analytic, wi, p.wo).total; }
#endif

void main() {
  int id = int(gl_GlobalInvocationID.x);
  if (id >= u_pixel_count) return;
  uint packed_pixel = b_pixels[id];
  Point p = load_point(ivec2(packed_pixel & 65535u, packed_pixel >> 16u));
  vec3 sum = vec3(0.0);
  for (int i = 0; i < u_direction_count; ++i) {
    vec3 wi = to_local(p, texelFetch(t_directions, 2 * i).xyz);
    if (wi.z <= 0.0) continue;
    sum += brdf(p, wi) * wi.z * texelFetch(t_directions, 2 * i + 1).rgb;
  }
  b_light[id] = vec4(sum * u_frame.environment.z, 1.0);
}
)";
}

GlName<ProgramTraits> compile_kernel(bool measured) {
  const std::string source = kernel_source(measured);
  const char* text = source.c_str();
  GlName<ProgramTraits> program(glCreateShaderProgramv(GL_COMPUTE_SHADER, 1, &text));
  GLint linked = 0;
  glGetProgramiv(program.get(), GL_LINK_STATUS, &linked);
  if (linked) return program;
  std::string log(4096, '\0');
  glGetProgramInfoLog(program.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  throw Error("benchmark", "its quadrature kernel does not compile: " + log);
}

bool is_pane(const Scene& scene, int material) {
  if (material < 0 || material >= static_cast<int>(scene.materials.size())) return false;
  const Material& m = scene.materials[static_cast<std::size_t>(material)];
  return m.glass || m.alpha_mode == AlphaMode::blend;
}

}  // namespace

SplitEnvironment split_environment(const Environment& environment) {
  const int bias = EnvironmentBuffers::packing_bias(environment);
  Environment all = environment;
  for (glm::vec3& c : all.rgb) c = shared::unpack_rgb9e5(shared::pack_rgb9e5(c, bias), bias);
  auto rest = std::make_shared<Environment>(all);
  SplitEnvironment split;
  const std::vector<std::size_t> bright = bright_texels(all);
  std::vector<bool> is_bright(all.rgb.size(), false);
  for (const std::size_t i : bright) is_bright[i] = true;
  const auto width = static_cast<std::size_t>(all.width);
  for (const std::size_t i : bright) {
    // The nearest ordinary texel of the row takes its place.
    const std::size_t row = i / width * width, column = i % width;
    for (std::size_t step = 1; step < width; ++step) {
      const std::size_t left = row + (column + width - step) % width, right = row + (column + step) % width;
      const std::size_t other = !is_bright[left] ? left : right;
      rest->rgb[i] = is_bright[other] ? glm::vec3(0.0f) : glm::min(all.rgb[other], all.rgb[i]);
      if (!is_bright[other]) break;
    }
  }
  rest->name += " without its brightest texels";
  rest->hash = content_hash(std::as_bytes(std::span(rest->rgb)), 1);
  std::vector<std::size_t> cells;  // lower corners of the squares that a bright texel is a corner of
  for (const std::size_t i : bright)
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t column = (i % width + width - (k & 1)) % width;
      const std::size_t row = i / width;
      if (row < (k >> 1)) continue;  // above the first row: its clamped half is left out with the pole's sine
      cells.push_back((row - (k >> 1)) * width + column);
    }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  const Residual residual(all, *rest);
  const double per_cell = kMaxDirections / std::max(1.0, static_cast<double>(cells.size()));
  const int finer = std::clamp(static_cast<int>(std::sqrt(per_cell)), 2, 16);
  for (int h = 0; h < 2; ++h)
    for (const std::size_t cell : cells)
      residual.append_cell(static_cast<int>(cell % width), static_cast<int>(cell / width),
                           h == 0 ? std::max(1, finer * 3 / 4) : finer, &split.bright[h]);
  split.rest = std::move(rest);
  return split;
}

Image shade_directions(Renderer& renderer, const std::vector<BrightDirection>& directions, bool all_measured) {
  const Image material = renderer.read_debug_view("material");
  Image light(material.width, material.height, 4);
  const Buffer table = Buffer::from("bright directions", directions);
  const Texture table_view = Texture::make_buffer("bright directions", GL_RGBA32F, table);
  const Scene& scene = renderer.scene();
  for (const bool measured : {false, true}) {
    std::vector<std::uint32_t> pixels;
    for (int y = 0; y < material.height; ++y)
      for (int x = 0; x < material.width; ++x) {
        if (material.at(x, y, 3) < 1.0f) continue;
        const auto m = static_cast<std::size_t>(material.at(x, y, 0));
        const bool known = m < scene.materials.size();
        if (known && scene.materials[m].unlit) continue;
        const bool is_measured = all_measured || (known && !scene.materials[m].measured.empty());
        if (is_measured == measured)
          pixels.push_back(static_cast<std::uint32_t>(x) | static_cast<std::uint32_t>(y) << 16);
      }
    if (pixels.empty()) continue;
    const Buffer list = Buffer::from("pixels", pixels);
    const Buffer out("light of bright directions", pixels.size() * sizeof(glm::vec4));
    const GlName<ProgramTraits> program = compile_kernel(measured);
    glProgramUniform1i(program.get(), glGetUniformLocation(program.get(), "u_pixel_count"),
                       static_cast<GLint>(pixels.size()));
    glProgramUniform1i(program.get(), glGetUniformLocation(program.get(), "u_direction_count"),
                       static_cast<GLint>(directions.size()));
    glUseProgram(program.get());
    glBindTextureUnit(31, table_view.get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, list.get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, out.get());
    glDispatchCompute(static_cast<GLuint>((pixels.size() + 63) / 64), 1, 1);
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
    std::vector<glm::vec4> values(pixels.size());
    out.read(0, out.bytes(), values.data());
    for (std::size_t i = 0; i < pixels.size(); ++i)
      for (int c = 0; c < 4; ++c)
        light.at(static_cast<int>(pixels[i] & 65535u), static_cast<int>(pixels[i] >> 16), c) = values[i][c];
  }
  return light;
}

std::shared_ptr<const Scene> without_panes(const Scene& scene) {
  auto opaque = std::make_shared<Scene>(scene);
  for (Mesh& mesh : opaque->meshes) {
    if (!mesh.primitives.empty() && is_pane(scene, mesh.primitives[0].material)) mesh.cage.reset();
    std::erase_if(mesh.primitives, [&](const Primitive& p) { return is_pane(scene, p.material); });
  }
  for (Node& node : opaque->nodes) {
    if (node.mesh >= 0 && opaque->meshes[static_cast<std::size_t>(node.mesh)].primitives.empty()) node.mesh = -1;
    if (node.patch >= 0 && is_pane(scene, scene.patches[static_cast<std::size_t>(node.patch)].material))
      node.patch = -1;
  }
  return opaque;
}

}  // namespace maquette::bench
