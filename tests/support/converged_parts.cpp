#include "tests/support/converged_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "render/gl/objects.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/luminance.h"

namespace maquette::test {
namespace {

constexpr double kBrightOverMean = 50.0;
constexpr std::size_t kMaxBrightTexels = 256;
constexpr int kMaxPoints = 1600;
/// Most pieces along a side of a cell that contains the mirror direction.
constexpr int kMaxPointsASide = 24;

double mean_sky_luminance(const Environment& e) {
  double sum = 0.0, weights = 0.0;
  for (int y = 0; y < e.height; ++y) {
    const double weight = std::sin(std::numbers::pi * (y + 0.5) / e.height);
    for (int x = 0; x < e.width; ++x) {
      sum += weight * luminance(glm::dvec3(e.rgb[static_cast<std::size_t>(y * e.width + x)]));
      weights += weight;
    }
  }
  return sum / weights;
}

std::vector<std::size_t> bright_texels(const Environment& e) {
  const double threshold = kBrightOverMean * mean_sky_luminance(e);
  std::vector<std::size_t> bright;
  for (std::size_t i = 0; i < e.rgb.size(); ++i)
    if (luminance(glm::dvec3(e.rgb[i])) > threshold) bright.push_back(i);
  std::sort(bright.begin(), bright.end(), [&](std::size_t a, std::size_t b) {
    return luminance(glm::dvec3(e.rgb[a])) > luminance(glm::dvec3(e.rgb[b]));
  });
  if (bright.size() > kMaxBrightTexels) bright.resize(kMaxBrightTexels);
  std::sort(bright.begin(), bright.end());
  return bright;
}

/// The square whose upper left texel is (x, y), with the difference of all and rest at its corners.
BrightCell cell_between(const Environment& all, const Environment& rest, int x, int y) {
  BrightCell cell{glm::vec4(x, y, 0.0f, 0.0f), {}};
  for (int k = 0; k < 4; ++k) {
    const int column = (x + (k & 1)) % all.width, row = std::min(y + (k >> 1), all.height - 1);
    const auto i = static_cast<std::size_t>(row * all.width + column);
    cell.light[k] = glm::vec4(all.rgb[i] - rest.rgb[i], 0.0f);
  }
  return cell;
}

/// The code that load_point, the BRDFs and the estimator need, from the shader's own files.
std::string shared_source(bool measured) {
  std::string text = "#version 450 core\n#define MEASURED " + std::string(measured ? "1" : "0") +
                     "\n#define ANALYTIC_ANISOTROPY 0\n#define ANALYTIC_COAT_NORMAL 0\n#define ANALYTIC_FILM "
                     "0\nlayout(local_size_x = 64) in;\n";
  for (const char* path :
       {"shared/frame.glsl", "shared/constants.glsl", "shared/latlong.glsl", "shared/octahedral.glsl",
        "shared/rgb9e5.glsl", "shared/gbuffer.glsl", "shared/material_table.glsl", "shared/luminance.glsl",
        "shared/analytic.glsl", "shared/merl.glsl", "shading/point.glsl"})
    text += load_shader_text(path);
  return text + R"(
layout(std430, binding = 2) readonly buffer Pixels { uint b_pixels[]; };
layout(std430, binding = 3) writeonly buffer Light { vec4 b_light[]; };
uniform int u_pixel_count;
)";
}

std::string quadrature_source(bool measured) {
  return shared_source(measured) + "const int kMaxPointsASide = " + std::to_string(kMaxPointsASide) + R"(;
layout(binding = 31) uniform samplerBuffer t_cells;
uniform int u_cell_count;
uniform int u_points_a_side;
uniform float u_spacing;
/// Least width of a lobe (rad, of directions). At grazing angles, lobes are narrower across the plane of view and
/// normal.
const float kPartsLobeCore_rad = 0.001, kLeastCosine = 0.1;

#if MEASURED
/// Mean of measured_brdf over xi.
vec3 brdf(Point p, vec3 wi) {
  vec3 c = merl_coordinates(wi, p.wo);
  vec2 whole = floor(c.yz), part = c.yz - whole;
  vec3 sum = vec3(0.0);
  for (int k = 0; k < 4; ++k) {
    vec2 corner = vec2(k & 1, k >> 1);
    // For xi below 1 - part the lower neighbour is used: the middle of each interval stands for it.
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
  vec2 texel = 1.0 / vec2(u_frame.environment_size.xy);
  float row_rad = 3.14159265 * texel.y;
  vec3 mirror = from_local(p, vec3(-p.wo.xy, p.wo.z));
  float narrowest = u_spacing * max(p.wo.z, kLeastCosine);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < u_cell_count; ++i) {
    vec2 corner = texelFetch(t_cells, 5 * i).xy + 0.5;
    float away = distance(direction_from_latlong_uv((corner + 0.5) * texel), mirror) - 0.71 * row_rad;
    int side = clamp(int(row_rad / (narrowest * (max(away, 0.0) + kPartsLobeCore_rad))) + 1, u_points_a_side, kMaxPointsASide);
    float step = 1.0 / float(side);
    vec3 l00 = texelFetch(t_cells, 5 * i + 1).rgb, l10 = texelFetch(t_cells, 5 * i + 2).rgb;
    vec3 l01 = texelFetch(t_cells, 5 * i + 3).rgb, l11 = texelFetch(t_cells, 5 * i + 4).rgb;
    vec3 cell = vec3(0.0);
    for (int k = 0; k < side * side; ++k) {
      vec2 part = (vec2(k % side, k / side) + 0.5) * step;
      vec2 uv = (corner + part) * texel;
      vec3 wi = to_local(p, direction_from_latlong_uv(uv));
      vec3 light = mix(mix(l00, l10, part.x), mix(l01, l11, part.x), part.y);
      cell += wi.z > 0.0 ? brdf(p, wi) * (wi.z * sin(3.14159265 * uv.y)) * light : vec3(0.0);
    }
    sum += cell * (step * step);
  }
  b_light[id] = vec4(sum * (2.0 * row_rad * 3.14159265 * texel.x * u_frame.environment.z), 1.0);
}
)";
}

std::string sampling_source() {
  return shared_source(true) + R"(
struct Result { vec3 sum; };
#define ON_SAMPLE(f, radiance, weight, wi, world, pdf, is_brdf) result.sum += f * radiance * weight
#define SAMPLE_GROUP 4
)" + load_shader_text("shading/integrate.glsl") +
         R"(
uniform int u_samples;

void main() {
  int id = int(gl_GlobalInvocationID.x);
  if (id >= u_pixel_count) return;
  ivec2 pixel = ivec2(b_pixels[id] & 65535u, b_pixels[id] >> 16u);
  Point p = load_point(pixel);
  Result result;
  result.sum = vec3(0.0);
  integrate(p, pixel, 0u, u_samples, result);
  b_light[id] = vec4(result.sum * u_frame.environment.z, 1.0);
}
)";
}

GlName<ProgramTraits> compile_kernel(const std::string& source) {
  const char* text = source.c_str();
  GlName<ProgramTraits> program(glCreateShaderProgramv(GL_COMPUTE_SHADER, 1, &text));
  GLint link_status = 0;
  glGetProgramiv(program.get(), GL_LINK_STATUS, &link_status);
  if (link_status) return program;
  std::string log(4096, '\0');
  glGetProgramInfoLog(program.get(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  throw Error("converged picture", "its kernel does not compile: " + log);
}

void set_int(const GlName<ProgramTraits>& program, const char* name, int value) {
  glProgramUniform1i(program.get(), glGetUniformLocation(program.get(), name), value);
}

/// Runs one invocation a pixel and returns their results.
std::vector<glm::vec4> run_kernel(const GlName<ProgramTraits>& program, const std::vector<std::uint32_t>& pixels) {
  const Buffer list = Buffer::from("pixels", pixels);
  const Buffer out("light of pixels", pixels.size() * sizeof(glm::vec4));
  set_int(program, "u_pixel_count", static_cast<int>(pixels.size()));
  glUseProgram(program.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, list.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, out.get());
  glDispatchCompute(static_cast<GLuint>((pixels.size() + 63) / 64), 1, 1);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  std::vector<glm::vec4> values(pixels.size());
  out.read(0, out.bytes(), values.data());
  return values;
}

bool is_pane(const Scene& scene, int material) {
  if (material < 0 || material >= static_cast<int>(scene.materials.size())) return false;
  const Material& m = scene.materials[static_cast<std::size_t>(material)];
  return m.glass || m.alpha_mode == AlphaMode::blend;
}

}  // namespace

SplitEnvironment split_environment(const Environment& environment) {
  const Environment& all = environment;
  auto rest = std::make_shared<Environment>(all);
  SplitEnvironment split;
  const std::vector<std::size_t> bright = bright_texels(all);
  std::vector<bool> is_bright(all.rgb.size(), false);
  for (const std::size_t i : bright) is_bright[i] = true;
  const auto width = static_cast<std::size_t>(all.width);
  for (const std::size_t i : bright) {
    // Replaced by the nearest ordinary texel of the row.
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
  std::vector<std::size_t> cells;  // lower corners of the squares that have a bright texel as corner
  for (const std::size_t i : bright)
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t column = (i % width + width - (k & 1)) % width;
      const std::size_t row = i / width;
      if (row < (k >> 1)) continue;  // above the first row: its clamped half is left out with the pole's sine
      cells.push_back((row - (k >> 1)) * width + column);
    }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  for (const std::size_t cell : cells)
    split.bright.push_back(cell_between(all, *rest, static_cast<int>(cell % width), static_cast<int>(cell / width)));
  split.rest = std::move(rest);
  return split;
}

CellGrid fine_grid(const SplitEnvironment& split) {
  const double per_cell = kMaxPoints / std::max(1.0, static_cast<double>(split.bright.size()));
  return {std::clamp(static_cast<int>(std::sqrt(per_cell)), 2, 16), 0.04f};
}

CellGrid coarse_grid(const SplitEnvironment& split) {
  return {std::max(1, fine_grid(split).points_a_side * 3 / 4), 0.06f};
}

Image shade_cells(Renderer& renderer, const std::vector<BrightCell>& cells, const CellGrid& grid, bool all_measured) {
  const Image material = renderer.read_debug_view("material");
  Image light(material.width, material.height, 4);
  const Buffer table = Buffer::from("bright cells", cells);
  const Texture table_view = Texture::make_buffer("bright cells", GL_RGBA32F, table);
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
    const GlName<ProgramTraits> program = compile_kernel(quadrature_source(measured));
    set_int(program, "u_cell_count", static_cast<int>(cells.size()));
    set_int(program, "u_points_a_side", grid.points_a_side);
    glProgramUniform1f(program.get(), glGetUniformLocation(program.get(), "u_spacing"), grid.spacing);
    glBindTextureUnit(31, table_view.get());
    const std::vector<glm::vec4> values = run_kernel(program, pixels);
    for (std::size_t i = 0; i < pixels.size(); ++i)
      for (int c = 0; c < 4; ++c)
        light.at(static_cast<int>(pixels[i] & 65535u), static_cast<int>(pixels[i] >> 16), c) = values[i][c];
  }
  return light;
}

PixelSampler::PixelSampler() : program_(compile_kernel(sampling_source())) {}

std::vector<glm::vec3> PixelSampler::draw(const std::vector<std::uint32_t>& pixels, int samples) const {
  set_int(program_, "u_samples", samples);
  const std::vector<glm::vec4> values = run_kernel(program_, pixels);
  return {values.begin(), values.end()};
}

double SampledHalf::add(std::size_t pixel, const glm::vec3& value) {
  // Source: Welford 1962, "Note on a method for calculating corrected sums of squares and products".
  double spread = 0.0;
  runs_[pixel] += 1.0;
  for (std::size_t c = 0; c < 3; ++c) {
    float& mean = mean_.data[4 * pixel + c];
    const double before = static_cast<double>(value[static_cast<int>(c)]) - mean;
    mean += static_cast<float>(before / runs_[pixel]);
    spread += before * (static_cast<double>(value[static_cast<int>(c)]) - mean);
  }
  return spread;
}

void SampledHalf::add(const Image& run) {
  whole_runs_ += 1.0;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    spread_[i] += add(i, {run.data[4 * i], run.data[4 * i + 1], run.data[4 * i + 2]});
    mean_.data[4 * i + 3] = run.data[4 * i + 3];
  }
}

void SampledHalf::add(const std::vector<std::uint32_t>& pixels, const std::vector<glm::vec3>& run) {
  for (std::size_t k = 0; k < pixels.size(); ++k)
    add((pixels[k] >> 16) * static_cast<std::size_t>(mean_.width) + (pixels[k] & 65535u), run[k]);
}

double SampledHalf::variance(int x, int y) const {
  double squares = 0.0, degrees = 0.0;
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, mean_.height - 1); ++v)
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, mean_.width - 1); ++u) {
      const auto i = static_cast<std::size_t>(v * mean_.width + u);
      const double weight = u == x && v == y ? 1.0 : 0.25;
      squares += weight * spread_[i];
      degrees += weight * (whole_runs_ - 1.0);
    }
  return squares / std::max(degrees, 1e-9);
}

std::vector<std::uint32_t> SampledHalf::neediest(const SampledHalf& other, std::size_t count) const {
  std::vector<std::pair<double, std::uint32_t>> gains;
  for (int y = 0; y < mean_.height; ++y)
    for (int x = 0; x < mean_.width; ++x) {
      const auto i = static_cast<std::size_t>(y * mean_.width + x);
      if (mean_.data[4 * i + 3] < 1.0f) continue;
      gains.emplace_back(other.variance(x, y) / (runs_[i] * (runs_[i] + 1.0)),
                         static_cast<std::uint32_t>(x) | static_cast<std::uint32_t>(y) << 16);
    }
  count = std::min(count, gains.size());
  std::nth_element(gains.begin(), gains.begin() + static_cast<std::ptrdiff_t>(count), gains.end(), std::greater<>());
  std::vector<std::uint32_t> pixels;
  for (std::size_t k = 0; k < count; ++k) pixels.push_back(gains[k].second);
  return pixels;
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

}  // namespace maquette::test
