#include "render/reflections/nearest_hits.h"

#include <algorithm>

#include "render/frame/camera.h"
#include "render/gl/bindings.h"
#include "scenes/error.h"

namespace maquette {

namespace {

const ShaderVariant kPlanar{"reflections/planar.comp", "", {}}, kLarge{"reflections/large.comp", "", {}},
    kResolve{"reflections/resolve.comp", "", {}}, kFinish{"reflections/finish.comp", "", {}},
    kVisible{"reflections/visible.comp", "", {}}, kFar{"reflections/far.comp", "", {}};
constexpr int kGroupsPerRow = 32768, kTile = 4, kFarTile = 8;  // tiles as in shaders/reflections/tiles.glsl
constexpr std::size_t kListBytes = 8, kCounterBytes = 16, kOfferBytes = 80, kFarTileBytes = 64;
/// Initial capacities, and the largest that fit a storage buffer of 128 MiB with a reserve.
constexpr unsigned kMinNodes = 1u << 18, kMaxNodes = 15u << 20, kMinOffers = 1u << 15, kMaxOffers = 3u << 19;

std::size_t tiles_of(const ReflectionTargets& t, int side) {
  return static_cast<std::size_t>((t.width + side - 1) / side) * static_cast<std::size_t>((t.height + side - 1) / side);
}

glm::mat4 mirror_in(const glm::vec4& plane) {
  const glm::vec3 n(plane);
  glm::mat4 m(1.0f);
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) m[c][r] -= 2.0f * n[r] * n[c];
  m[3] = glm::vec4(-2.0f * plane.w * n, 1.0f);
  return m;
}

/// Lower and upper corner of the visible part of the bounds, in clip space from -1 to 1; the whole screen when the
/// bounds surround the eye.
glm::vec4 window_of(const glm::mat4& clip_from_world, const Bounds& bounds) {
  glm::vec2 low(1.0f), high(-1.0f);
  for (int k = 0; k < 8; ++k) {
    const glm::vec4 clip =
        clip_from_world * glm::vec4(k & 1 ? bounds.max.x : bounds.min.x, k & 2 ? bounds.max.y : bounds.min.y,
                                    k & 4 ? bounds.max.z : bounds.min.z, 1.0f);
    if (clip.w <= 1e-6f) return {-1.0f, -1.0f, 1.0f, 1.0f};
    low = glm::min(low, glm::vec2(clip) / clip.w);
    high = glm::max(high, glm::vec2(clip) / clip.w);
  }
  return {glm::max(low, glm::vec2(-1.0f)), glm::min(high, glm::vec2(1.0f))};
}

/// A clip space whose borders are those of the window.
glm::mat4 through_window(const glm::mat4& clip_from_world, const glm::vec4& window) {
  const glm::vec2 low(window), high(window.z, window.w), scale = 2.0f / glm::max(high - low, glm::vec2(1e-6f));
  const glm::vec2 shift = -0.5f * scale * (low + high);
  glm::mat4 zoom(1.0f);
  zoom[0][0] = scale.x;
  zoom[1][1] = scale.y;
  glm::mat4 out = zoom * clip_from_world;
  for (int column = 0; column < 4; ++column) {
    out[column][0] += shift.x * clip_from_world[column][3];
    out[column][1] += shift.y * clip_from_world[column][3];
  }
  return out;
}

}  // namespace

void NearestHits::begin(const ReflectionTargets& t) {
  const std::size_t bytes =
      static_cast<std::size_t>(t.width) * static_cast<std::size_t>(t.height) * 2 * sizeof(unsigned);
  const auto tiles = static_cast<unsigned>(tiles_of(t, kTile));
  if (nearest_.bytes() != bytes || tiles_ != tiles) {
    nearest_ = Buffer("nearest triangles", bytes);
    tiles_ = tiles;
    list_capacity_ = offer_capacity_ = listed_ = offered_ = 0;
  }
  if (list_capacity_ == 0) grow();
  if (!counters_) counters_ = Buffer("uncertain pixels", sizeof(unsigned));
  nearest_.clear_to_zero();
}

/// Enlarges the buffers; false when they have their largest size already.
bool NearestHits::grow() {
  const unsigned nodes = std::clamp(listed_ + listed_ / 4, tiles_ + kMinNodes, tiles_ + kMaxNodes),
                 offers = std::clamp(offered_ + offered_ / 4, kMinOffers, kMaxOffers);
  const bool more = nodes > list_capacity_ || offers > offer_capacity_;
  if (nodes > list_capacity_) {
    list_capacity_ = nodes;
    lists_ = Buffer("triangles by tiles", kCounterBytes + nodes * kListBytes);
    list_view_ = Texture::make_buffer("triangles by tiles", GL_RG32UI, lists_);
  }
  if (offers > offer_capacity_) {
    offer_capacity_ = offers;
    offers_ = Buffer("offered triangles", offers * kOfferBytes);
    offer_view_ = Texture::make_buffer("offered triangles", GL_RGBA32UI, offers_);
    large_ = Buffer("large triangles", offers * sizeof(unsigned));
  }
  return more;
}

void NearestHits::clear_lists() {
  const unsigned counters[4] = {tiles_, 0, 0, 0}, none[2] = {0, 0};
  lists_.update(0, sizeof counters, counters);
  glClearNamedBufferSubData(lists_.get(), GL_RG32UI, static_cast<GLintptr>(kCounterBytes),
                            static_cast<GLsizeiptr>(tiles_ * kListBytes), GL_RG_INTEGER, GL_UNSIGNED_INT, none);
}

void NearestHits::prepare(const Program& program) const {
  glProgramUniform2ui(program.get(), program.location("u_capacity"), list_capacity_, offer_capacity_);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferOfferLists, lists_.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferOffers, offers_.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferLargeOffers, large_.get());
}

void NearestHits::find_nearest(const ReflectionFrame& frame, std::size_t count,
                               const std::function<void(std::size_t, std::size_t)>& offer,
                               const std::function<void()>& accept) {
  std::vector<std::pair<std::size_t, std::size_t>> parts{{0, count}};
  while (!parts.empty()) {
    const auto [begin, end] = parts.back();
    parts.pop_back();
    if (begin == end) continue;
    clear_lists();
    offer(begin, end);
    if (resolve(frame)) {
      accept();
      continue;
    }
    if (grow()) {
      parts.emplace_back(begin, end);
      continue;
    }
    if (end - begin == 1)
      throw Error("--reflections", "the reflections of one part of the scene do not fit in memory",
                  "use a coarser reflections.resolution, or --reflections octree");
    const std::size_t middle = begin + (end - begin) / 2;
    parts.emplace_back(middle, end);
    parts.emplace_back(begin, middle);
  }
}

/// Intersects the offered triangles with the rays; false when the lists were too small.
bool NearestHits::resolve(const ReflectionFrame& frame) {
  unsigned counters[3] = {0, 0, 0};
  lists_.read(0, sizeof counters, counters);
  offered_ = counters[1];
  if (offered_ <= offer_capacity_ && counters[2] > 0) {
    prepare(frame.programs->get(kLarge));
    run_groups(frame, kLarge, static_cast<int>(counters[2]));
    lists_.read(0, sizeof counters, counters);
  }
  listed_ = counters[0];
  if (offered_ > offer_capacity_ || listed_ > list_capacity_) return false;
  glBindTextureUnit(kUnitOfferLists, list_view_.get());
  glBindTextureUnit(kUnitOffers, offer_view_.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferNearest, nearest_.get());
  glUseProgram(frame.programs->get(kResolve).get());
  glDispatchCompute((tiles_ * kTile * kTile + 63) / 64, 1, 1);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  return true;
}

void NearestHits::set_groups(const std::vector<std::uint32_t>& group_of_triangle, std::size_t count) {
  groups_ = Buffer::from("groups of triangles", group_of_triangle);
  group_view_ = Texture::make_buffer("groups of triangles", GL_R32UI, groups_);
  seen_.assign(count, 0);
  seen_buffer_ = Buffer("groups seen", std::max<std::size_t>(count, 1) * sizeof(std::uint32_t));
}

void NearestHits::bind_far(const ReflectionFrame& frame, std::size_t reflector) {
  const std::size_t tiles = tiles_of(*frame.targets, kFarTile);
  if (far_.bytes() != tiles * kFarTileBytes) {
    far_ = Buffer("tiles of rays", tiles * kFarTileBytes);
    far_view_ = Texture::make_buffer("tiles of rays", GL_RGBA32F, far_);
  }
  glBindTextureUnit(kUnitFarTiles, far_view_.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferNearest, nearest_.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferFarTiles, far_.get());
  const Program& program = frame.programs->get(kFar);
  program.set("u_reflector", static_cast<int>(reflector));
  glUseProgram(program.get());
  glDispatchCompute(static_cast<GLuint>((tiles + 63) / 64), 1, 1);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

std::vector<std::uint32_t> NearestHits::find_visible(const ReflectionFrame& frame, std::size_t reflector,
                                                     const Buffer& boxes) {
  const int count = static_cast<int>(boxes.bytes() / kVisibleBoxBytes);
  std::vector<std::uint32_t> visible(static_cast<std::size_t>(count));
  if (count == 0) return visible;
  Buffer flags("visible boxes", visible.size() * sizeof(std::uint32_t));
  flags.clear_to_zero();
  const Texture box_view = Texture::make_buffer("boxes", GL_RGBA32F, boxes);
  bind_far(frame, reflector);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferVisibleBoxes, flags.get());
  glBindTextureUnit(kUnitBoxes, box_view.get());
  run_groups(frame, kVisible, count);
  flags.read(0, flags.bytes(), visible.data());
  return visible;
}

/// Runs one workgroup for each of `count` elements.
void NearestHits::run_groups(const ReflectionFrame& frame, const ShaderVariant& variant, int count) {
  const Program& program = frame.programs->get(variant);
  program.set("u_count", count);
  program.set("u_per_row", kGroupsPerRow);
  glUseProgram(program.get());
  glDispatchCompute(static_cast<GLuint>(std::min(count, kGroupsPerRow)),
                    static_cast<GLuint>((count + kGroupsPerRow - 1) / kGroupsPerRow), 1);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

void NearestHits::find_nearest_planar(const ReflectionFrame& frame, std::size_t reflector, const ClusterSet& clusters) {
  // The rays of a nearly flat mesh may deviate by twice the deviation of its normals
  // (render/reflections/reflectors.cpp).
  constexpr float kMeshDeviation_rad = 2e-3f;
  const Reflector& mirror = (*frame.reflectors)[reflector];
  glm::vec4 plane = *mirror.plane;
  if (glm::dot(plane, glm::vec4(glm::vec3(frame.constants->eye), 1.0f)) < 0.0f) plane = -plane;
  const glm::mat4 clip_from_world = frame.constants->clip_from_world * mirror_in(plane);
  const glm::vec4 window = window_of(frame.constants->clip_from_world, frame.buffers->bounds(mirror.item));
  const glm::mat4 window_from_world = through_window(clip_from_world, window);
  const GhostDeviation ghost = frame.ghost ? (*frame.ghost)[reflector] : GhostDeviation{};
  if (frame.ghost && ghost.offset_m == 0.0f) return;  // no pane, or outside the picture
  const auto widened = [&](Bounds box) {
    const float margin_m = ghost.at(glm::length(box.center() - glm::vec3(frame.constants->eye)) + box.radius());
    box.min -= margin_m;
    box.max += margin_m;
    return box;
  };
  triangles_.clear();
  for (std::size_t i = 0; i < clusters.of_item.size(); ++i) {
    if (!(*frame.occluding)[i] || i == mirror.item) continue;
    if (!may_be_seen(window_from_world, widened(frame.buffers->bounds(i)))) continue;
    for (std::size_t c = clusters.of_item[i].begin; c < clusters.of_item[i].end; ++c) {
      const Cluster& cluster = clusters.clusters[c];
      if (glm::dot(plane, glm::vec4(cluster.center, 1.0f)) < -cluster.radius) continue;
      const Bounds box{cluster.center - cluster.half_extent, cluster.center + cluster.half_extent};
      if (!may_be_seen(window_from_world, widened(box))) continue;
      for (std::uint32_t k = 0; k < cluster.triangle_count; ++k)
        triangles_.push_back(clusters.triangles[cluster.first_triangle + k].y);
    }
  }
  if (triangles_.empty()) return;
  triangle_list_ = Buffer::from("mirrored triangles", triangles_);
  const Program& program = frame.programs->get(kPlanar);
  const glm::vec2 size(frame.constants->size);
  const glm::vec2 low = (0.5f * glm::vec2(window.x, -window.w) + 0.5f) * size,
                  high = (0.5f * glm::vec2(window.z, -window.y) + 0.5f) * size;
  glProgramUniformMatrix4fv(program.get(), program.location("u_clip_from_world"), 1, GL_FALSE, &clip_from_world[0].x);
  glProgramUniform4fv(program.get(), program.location("u_plane"), 1, &plane.x);
  glProgramUniform4f(program.get(), program.location("u_window"), low.x, low.y, high.x, high.y);
  glProgramUniform2f(program.get(), program.location("u_ghost"), ghost.offset_m, ghost.turn);
  program.set("u_px_rad", frame.constants->forward.w);
  program.set("u_reflector", static_cast<int>(reflector));
  program.set("u_margin_px", 0.1f + (mirror.patch ? 0.0f : kMeshDeviation_rad / frame.constants->forward.w));
  const auto offer = [&](std::size_t begin, std::size_t end) {
    prepare(program);
    program.set("u_first", static_cast<int>(begin));
    program.set("u_count", static_cast<int>(end - begin));
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferPlanarTriangles, triangle_list_.get());
    glUseProgram(program.get());
    glDispatchCompute(static_cast<GLuint>((end - begin + 63) / 64), 1, 1);
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
  };
  bind_far(frame, reflector);
  find_nearest(frame, triangles_.size(), offer, [] {});
}

unsigned NearestHits::finish(const ReflectionFrame& frame, int channel, unsigned shortest) {
  const ReflectionTargets& t = *frame.targets;
  const Program& program = frame.programs->get(kFinish);
  Bounds box;
  for (std::size_t i = 0; i < frame.occluding->size(); ++i) {
    if (!(*frame.occluding)[i]) continue;
    box.min = glm::min(box.min, frame.buffers->bounds(i).min);
    box.max = glm::max(box.max, frame.buffers->bounds(i).max);
  }
  glProgramUniform3fv(program.get(), program.location("u_low"), 1, &box.min.x);
  glProgramUniform3fv(program.get(), program.location("u_high"), 1, &box.max.x);
  glProgramUniform1ui(program.get(), program.location("u_shortest"), shortest);
  program.set("u_channel", channel);
  program.set("u_group_count", static_cast<int>(seen_.size()));
  if (!seen_.empty()) {
    seen_buffer_.clear_to_zero();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferSeenGroups, seen_buffer_.get());
    glBindTextureUnit(kUnitTriangleGroups, group_view_.get());
  }
  glBindTextureUnit(kUnitFocus, t.focus.get());
  glBindImageTexture(kImageTriangle, t.triangle.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32UI);
  glBindImageTexture(kImageEffort, t.effort.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RG8UI);
  glBindImageTexture(kImageLowConfidence, t.low_confidence.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R8UI);
  counters_.clear_to_zero();
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferNearest, nearest_.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferHitCounters, counters_.get());
  glUseProgram(program.get());
  glDispatchCompute(static_cast<GLuint>((t.width + 7) / 8), static_cast<GLuint>((t.height + 7) / 8), 1);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
  unsigned uncertain = 0;
  counters_.read(0, sizeof uncertain, &uncertain);
  if (!seen_.empty()) seen_buffer_.read(0, seen_buffer_.bytes(), seen_.data());
  return uncertain;
}

std::vector<ShaderVariant> nearest_hits_shader_variants() {
  return {kPlanar, kLarge, kResolve, kFinish, kVisible, kFar};
}

}  // namespace maquette
