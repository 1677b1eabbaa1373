// What a frame shows on screen: the tone mapped picture, or an intermediate of it as false colours.
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "render/bandwidth_shared.h"
#include "render/false_color.h"
#include "render/renderer_impl.h"
#include "render/tonemap.h"
#include "scenes/error.h"
#include "scenes/suggest.h"

namespace maquette {

namespace {

template <typename T>
std::vector<T> read_texture(const Texture& texture, GLenum format, GLenum type, int channels) {
  std::vector<T> data(static_cast<std::size_t>(texture.width()) * static_cast<std::size_t>(texture.height()) *
                      static_cast<std::size_t>(channels));
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glGetTextureImage(texture.get(), 0, format, type, static_cast<GLsizei>(data.size() * sizeof(T)), data.data());
  return data;
}

glm::vec3 decode_normal(std::uint32_t packed) {
  const auto part = [](std::uint32_t v) {
    return std::clamp(static_cast<float>(static_cast<std::int16_t>(v & 0xffff)) / 32767.0f, -1.0f, 1.0f);
  };
  const float u = part(packed), v = part(packed >> 16);
  glm::vec3 n(u, 1.0f - std::abs(u) - std::abs(v), v);
  if (n.y < 0.0f) {
    n.x = (1.0f - std::abs(v)) * (u >= 0.0f ? 1.0f : -1.0f);
    n.z = (1.0f - std::abs(u)) * (v >= 0.0f ? 1.0f : -1.0f);
  }
  return glm::normalize(n);
}

struct ViewSource {
  const char* name;
  enum {
    marks,
    borrowed,
    quads,
    bend,
    axes,
    footprint,
    depth,
    surface,
    reflection,
    effort,
    doubt,
    distance,
    skipped,
    glossy
  } from;
  int channel;
};
constexpr ViewSource kViews[] = {
    {"shaded", ViewSource::marks, 0},
    {"level", ViewSource::marks, 1},
    {"samples", ViewSource::marks, 2},
    {"borrowed", ViewSource::borrowed, 0},
    {"bandwidth", ViewSource::quads, 0},
    {"variance", ViewSource::quads, 2},
    {"curvature", ViewSource::bend, 0},
    {"angular_bandwidth", ViewSource::axes, 3},
    {"footprint_stretch", ViewSource::footprint, 0},
    {"footprint_angle", ViewSource::footprint, 1},
    {"depth", ViewSource::depth, 0},
    {"normal", ViewSource::surface, 0},
    {"base_color", ViewSource::surface, 1},
    {"material", ViewSource::surface, 2},
    {"reflection", ViewSource::reflection, 0},
    {"ghost", ViewSource::reflection, 1},
    {"reflection_distance", ViewSource::distance, 0},
    {"reflection_steps", ViewSource::effort, 0},
    {"reflection_root", ViewSource::effort, 1},
    {"reflection_doubt", ViewSource::doubt, 0},
    {"rays_skipped", ViewSource::skipped, 0},
    {"glossy", ViewSource::glossy, 0},
};

/// How far the footprint of a shaded point is longer than wide, and along which direction: degrees from 0 to 180 from
/// the screen's right towards its top; 0 where it is round. Arguments: of screen_bandwidth.
glm::vec2 footprint(float nu_x, float nu_y, float correlation) {
  const double x = nu_x, y = nu_y, cross = static_cast<double>(correlation) * x * y;
  const double middle = 0.5 * (x * x + y * y), spread = std::hypot(0.5 * (x * x - y * y), cross);
  if (middle <= 0.0) return {1.0f, 0.0f};
  constexpr double kLeast = 2.5e-4;  // of the wider axis, squared: the correlation is a half float
  const double stretch = std::sqrt((middle + spread) / std::max(middle - spread, kLeast * (middle + spread)));
  if (spread <= kLeast * middle) return {static_cast<float>(stretch), 0.0f};
  // Of the smaller eigenvalue; rows run downwards.
  const double angle = glm::degrees(0.5 * std::atan2(2.0 * cross, y * y - x * x));
  return {static_cast<float>(stretch), static_cast<float>(angle < 0.0 ? angle + 180.0 : angle)};
}

/// What a view shows at a grid point.
using PointValue = std::function<glm::vec3(int x, int y)>;

template <typename T>
PointValue value_of_points(const FrameTargets& t, std::vector<T> values) {
  return [w = t.grid_width(), values = std::move(values)](int x, int y) {
    return glm::vec3(static_cast<float>(values[static_cast<std::size_t>(y * w + x)]));
  };
}

/// Of images of four channels: `value` gets those of the point, or of its quad.
template <typename T, typename Value>
PointValue value_of_texels(const Texture& source, GLenum format, GLenum type, int points_a_side, Value value) {
  return [w = source.width(), texels = read_texture<T>(source, format, type, 4), points_a_side, value](int x, int y) {
    return value(&texels[4 * static_cast<std::size_t>(y / points_a_side * w + x / points_a_side)]);
  };
}

glm::vec3 surface_value(const std::uint32_t* g, int channel) {
  if (channel == 0) return decode_normal(g[0]);
  if (channel == 2) return glm::vec3(static_cast<float>(g[2] >> 16));
  const auto part = [&](int shift) {
    const float v = static_cast<float>(g[1] >> shift & 255u) / 255.0f;
    return v * v;
  };
  return {part(0), part(8), part(16)};
}

/// Of the views of a frame's own images.
PointValue value_of(const FrameTargets& t, const ViewSource& view) {
  const int channel = view.channel;
  switch (view.from) {
    case ViewSource::depth:
      return value_of_points(t, read_texture<float>(t.depth, GL_RED, GL_FLOAT, 1));
    case ViewSource::marks:
      return value_of_texels<std::uint8_t>(t.marks, GL_RGBA_INTEGER, GL_UNSIGNED_BYTE, 1,
                                           [channel](const std::uint8_t* mark) {
                                             const float v = mark[channel];
                                             return glm::vec3(channel == 2 && v > 0.0f ? std::exp2(v) : v);
                                           });
    case ViewSource::surface:
      return value_of_texels<std::uint32_t>(t.surface, GL_RGBA_INTEGER, GL_UNSIGNED_INT, 1,
                                            [channel](const std::uint32_t* g) { return surface_value(g, channel); });
    case ViewSource::bend:
      return value_of_texels<std::uint32_t>(t.bend, GL_RGBA_INTEGER, GL_UNSIGNED_INT, 2, [](const std::uint32_t* q) {
        const shared::ScreenBend bend = shared::unpack_bend({q[0], q[1], q[2], q[3]});
        return glm::vec3(std::max(bend.turn.x / bend.step_m.x, bend.turn.y / bend.step_m.y));
      });
    case ViewSource::footprint:
      return value_of_texels<float>(t.axes, GL_RGBA, GL_FLOAT, 2, [channel](const float* q) {
        return glm::vec3(footprint(q[0], q[1], q[2])[channel]);
      });
    case ViewSource::quads:
      return value_of_texels<float>(t.pyramid, GL_RGBA, GL_FLOAT, 2, [channel](const float* q) {
        return glm::vec3(channel == 2 ? q[2] * q[2] : q[channel]);
      });
    default:
      return value_of_texels<float>(t.axes, GL_RGBA, GL_FLOAT, 2,
                                    [channel](const float* q) { return glm::vec3(q[channel]); });
  }
}

/// Scaled so that what is seen (alpha 1) has the mean 0.2.
Image at_mean_grey(Image values) {
  double sum = 0.0, count = 1e-30;
  for (std::size_t i = 0; i < values.data.size(); i += 4) {
    if (values.data[i + 3] <= 0.0f) continue;
    sum += static_cast<double>(values.data[i + 1]);
    count += 1.0;
  }
  const auto scale = static_cast<float>(0.2 * count / std::max(sum, 1e-30));
  for (std::size_t i = 0; i < values.data.size(); ++i)
    if (i % 4 != 3) values.data[i] *= scale;
  return values;
}

}  // namespace

const std::vector<std::string>& Renderer::debug_view_names() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> names;
    for (const ViewSource& view : kViews) names.emplace_back(view.name);
    return names;
  }();
  return kNames;
}

Image Renderer::Impl::read_reflection(int channel) const {
  if (last_plan.reflections.empty())
    throw Error("--view", "reflections are seen with a reflector in view and a technique",
                "add --reflections raytraced");
  const ReflectionTargets& r = *reflection;
  const auto radiance = read_texture<float>(r.radiance, GL_RGBA, GL_FLOAT, 4);
  const auto direction = read_texture<float>(r.ray_direction, GL_RGBA, GL_FLOAT, 4);
  const auto effort = read_texture<std::uint8_t>(r.effort, GL_RG_INTEGER, GL_UNSIGNED_BYTE, 2);
  const auto doubt = read_texture<std::uint8_t>(r.doubt, GL_RED_INTEGER, GL_UNSIGNED_BYTE, 1);
  Image image(r.width, r.height, 4);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    if (direction[i / 4 * 4 + 3] == 0.0f) continue;  // where no reflector is seen nothing is written
    const float value = channel < 0   ? radiance[i]
                        : channel > 1 ? static_cast<float>(doubt[i / 4])
                                      : static_cast<float>(effort[i / 4 * 2 + static_cast<std::size_t>(channel)]);
    image.data[i] = i % 4 == 3 ? 1.0f : value;
  }
  return image;
}

Image Renderer::Impl::read_reflected_distances() const {
  Image image = read_reflection(-1);
  const auto origin = read_texture<float>(reflection->ray_origin, GL_RGBA, GL_FLOAT, 4);
  const auto along_m = read_texture<float>(reflection->depth, GL_RED, GL_FLOAT, 1);
  const glm::vec3 eye(constants.eye);
  for (std::size_t i = 0; i < along_m.size(); ++i) {
    const glm::vec3 to = glm::vec3(origin[4 * i], origin[4 * i + 1], origin[4 * i + 2]) - eye;
    const bool hits = image.data[4 * i + 3] > 0.0f && along_m[i] > 0.0f;
    for (std::size_t c = 0; c < 3; ++c) image.data[4 * i + c] = hits ? glm::length(to) + along_m[i] : 0.0f;
  }
  return image;
}

Image Renderer::Impl::read_ghost() {
  if (last_plan.reflections.empty() || !ghost)
    throw Error("--view", "there is no second image", "add --set reflections.ghost=true");
  std::swap(ghost, reflection);
  Image image = read_reflection(-1);
  std::swap(ghost, reflection);
  return image;
}

Image Renderer::Impl::read_glossy() const {
  if (!last_plan.glossy)
    throw Error("--view", "no opaque surface mirrors the scene here; the plan says why",
                "add --reflections octree, and see left_out of --stats");
  const auto met = read_texture<float>(glossy->mean, GL_RGBA, GL_FLOAT, 4);
  const auto direction = read_texture<float>(glossy->ray_direction, GL_RGBA, GL_FLOAT, 4);
  Image image(glossy->width, glossy->height, 4);
  for (std::size_t i = 0; i < met.size(); ++i)
    image.data[i] = i % 4 == 3 ? (direction[i] > 0.0f ? 1.0f : 0.0f) : met[i];
  return image;
}

Image Renderer::Impl::read_skipped() const {
  Image image = read_reflection(-1);
  const auto direction = read_texture<float>(reflection->ray_direction, GL_RGBA, GL_FLOAT, 4);
  for (std::size_t i = 0; i < image.data.size(); ++i)
    if (i % 4 != 3) image.data[i] = direction[i / 4 * 4 + 3] < 0.0f ? 1.0f : 0.0f;
  return image;
}

Image Renderer::read_debug_view(const std::string& name) const {
  if (impl_->shows_reference())
    throw Error("--view", "'" + name + "' is a view of the modes that rasterise", "choose another --mode");
  const FrameTargets& t = *impl_->targets;
  const auto* view =
      std::find_if(std::begin(kViews), std::end(kViews), [&](const ViewSource& v) { return name == v.name; });
  if (view == std::end(kViews))
    throw UsageError("--view", "unknown view '" + name + "'", did_you_mean(name, debug_view_names()));
  const bool of_bandwidth = view->from == ViewSource::quads || view->from == ViewSource::bend ||
                            view->from == ViewSource::axes || view->from == ViewSource::footprint;
  if (of_bandwidth && !t.bandwidth)
    throw Error("--view", "'" + name + "' exists in mode bandwidth only", "add --mode bandwidth");
  if (view->from == ViewSource::marks && find_lookup_mode(impl_->last_plan.mode))
    throw Error("--view", "'" + name + "' is a view of samples, of which mode " + impl_->last_plan.mode + " takes none",
                "choose --mode bandwidth or uniform");
  if (view->from == ViewSource::reflection && view->channel == 1) return impl_->read_ghost();
  if (view->from == ViewSource::reflection) return impl_->read_reflection(-1);
  if (view->from == ViewSource::doubt) return impl_->read_reflection(2);
  if (view->from == ViewSource::effort) return impl_->read_reflection(view->channel);
  if (view->from == ViewSource::distance) return impl_->read_reflected_distances();
  if (view->from == ViewSource::skipped) return impl_->read_skipped();
  if (view->from == ViewSource::glossy) return impl_->read_glossy();
  const PointValue value =
      view->from == ViewSource::borrowed ? value_of_points<float>(t, impl_->borrowed_shares()) : value_of(t, *view);
  const std::vector<float> depth = read_texture<float>(t.depth, GL_RED, GL_FLOAT, 1);
  Image image(t.grid_width(), t.grid_height(), 4);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      if (depth[static_cast<std::size_t>(y * image.width + x)] <= 0.0f) continue;
      const glm::vec3 v = value(x, y);
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = v[c];
      image.at(x, y, 3) = 1.0f;
    }
  return image;
}

Image debug_view_picture(const Image& values, const std::string& name) {
  if (name == "reflection" || name == "ghost" || name == "glossy")
    return tone_map(at_mean_grey(values), 0.0f, "pbr-neutral");
  if (name != "normal" && name != "base_color") return false_color_image(values);
  Image picture = values;
  for (std::size_t i = 0; i < picture.data.size(); ++i) {
    if (i % 4 == 3) continue;
    float& v = picture.data[i];
    v = name == "normal" ? (picture.data[i - i % 4 + 3] > 0.0f ? 0.5f * v + 0.5f : 0.0f)
                         : std::pow(std::max(v, 0.0f), 1.0f / 2.2f);
  }
  return picture;
}

ShaderVariant present_variant(int side) {
  return {"present/present.frag", "present/present.vert", {{"SIDE", std::to_string(side)}}};
}

Image Renderer::read_display(float exposure_ev, const std::string& tonemap) const {
  const Impl& s = *impl_;
  if (!s.points_are_picture()) return tone_map(read_radiance(), exposure_ev, tonemap);
  Image points(s.targets->grid_width(), s.targets->grid_height(), 4);
  points.data = read_texture<float>(s.targets->radiance, GL_RGBA, GL_FLOAT, 4);
  return tone_map(points, exposure_ev, tonemap, s.targets->side);
}

void Renderer::present(int x, int y, int width, int height, float exposure_ev, const std::string& tonemap,
                       const std::string& debug_view) {
  Impl& s = *impl_;
  Texture view;
  const bool by_points =
      debug_view.empty() && s.points_are_picture() && width == s.targets->width && height == s.targets->height;
  GLuint texture = by_points ? s.targets->radiance.get() : s.picture().get();
  int curve = tonemap_index(tonemap);
  if (!debug_view.empty()) {
    const Image picture = debug_view_picture(read_debug_view(debug_view), debug_view);
    view = Texture::make_2d("debug view", GL_RGBA32F, picture.width, picture.height);
    view.upload(0, picture.width, picture.height, GL_RGBA, GL_FLOAT, picture.data.data());
    texture = view.get();
    curve = -1;
  }
  const Program& program = s.programs.get(present_variant(by_points ? s.targets->side : 1));
  program.set("u_exposure", std::exp2(exposure_ev));
  program.set("u_curve", curve);
  // Window coordinates put row 0 at the bottom, whatever the clip origin of the G-buffer pass.
  glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
  program.set("u_flip", 1);
  glViewport(x, y, width, height);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glBindTextureUnit(24, texture);
  GLuint empty = 0;
  glCreateVertexArrays(1, &empty);
  const GlName<VertexArrayTraits> vertex_array(empty);
  glBindVertexArray(empty);
  glUseProgram(program.get());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindVertexArray(0);
}

}  // namespace maquette
