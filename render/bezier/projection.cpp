#include "render/bezier/projection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "render/bezier/patch_fit.h"
#include "render/bezier/patch_view.h"
#include "render/gl/bindings.h"
#include "render/reflections/clusters.h"
#include "render/reflections/nearest_hits.h"
#include "scenes/error.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr int kPieceCapacity = 1 << 18;  // 64 bytes each
/// Edges up to this length on screen are drawn straight, px.
constexpr float kShort_px = 3.0f;
constexpr std::size_t kNodeTexels = 5;

// Indices of the counters in shaders/bezier/*.comp.
enum Counter {
  small,
  pieces_a,
  pieces_b,
  newton_steps,
  vertices,
  lost,
  uncertain,
  dropped,
  large,
  uncertain_pixels,
  counter_count = 16
};

const ShaderVariant kVertices{"bezier/vertices.comp", "", {}}, kClassify{"bezier/classify.comp", "", {}},
    kPieces{"bezier/pieces.comp", "", {{"GHOST", "0"}}}, kGhostPieces{"bezier/pieces.comp", "", {{"GHOST", "1"}}},
    kBounds{"bezier/bounds.comp", "", {}}, kPoints{"bezier/points.comp", "", {}};

/// One side of one patch for the eye of this frame.
struct Part {
  int reflector = 0;
  int first_node = 0;
  ReflectorNodes nodes;
  glm::vec3 origin{0.0f};
  PatchView view;
  bezier_float::BezierSurface surface{};
  GhostDeviation ghost;  ///< bound of the difference between the rays that are traced and those of the patch
  /// How far outside a sphere the traced rays may be when the patch's own rays touch the sphere.
  float ghost_margin_m(const glm::vec3& center, float radius) const {
    return ghost.at(glm::length(center - origin) + radius + size_m);
  }
  bool fitted = false;  ///< the patch is fitted to a mesh
  int number = 0;       ///< index of its record in the shaders' block
  PatchRecord record;
  float size_m = 0.0f;  ///< from its origin to its farthest point
};

std::vector<glm::vec4> node_texels(const ReflectorNodes& nodes) {
  std::vector<glm::vec4> texels;
  for (const bezier_float::BezierNode& n : nodes.nodes) {
    texels.emplace_back(n.position, n.height);
    texels.emplace_back(n.normal, n.side);
    texels.emplace_back(n.dual_x, n.x.x);
    texels.emplace_back(n.dual_y, n.x.y);
    texels.emplace_back(n.direction, n.inverse_focus);
  }
  return texels;
}

/// Enlargement of a piece's bounding box on screen: its edges are straight within the tolerance, its interior within
/// twice the tolerance.
float margin_px(float tolerance_px) { return 2.0f * tolerance_px + 0.25f; }

/// Common start of the search for all vertices of a cluster; std430, as in shaders/bezier/vertices.comp.
struct ClusterStart {
  glm::vec2 x{0.0f};
  float certified = 0.0f, unused = 0.0f;
  glm::vec4 x_by_position{0.0f}, y_by_position{0.0f};
  glm::vec4 middle{0.0f}, half_extent{0.0f};  ///< world, m; the first has the radius, m, beside it
};

/// A cluster that may be visible in a part.
struct Candidate {
  std::uint32_t cluster = 0;
  ClusterStart start;
};

/// Nothing when the cluster is certainly invisible: its parameters, to first order plus a safety factor of 1.5, are
/// outside the window, or all of it is behind the surface.
std::optional<Candidate> find_candidate(const Part& part, const glm::vec3& eye_world, const ClusterSet& clusters,
                                        std::uint32_t number) {
  constexpr int kSteps = 10;
  constexpr float kSafety = 1.5f, kMargin = 0.02f;
  Cluster cluster = clusters.clusters[number];
  const float more_m = part.ghost_margin_m(cluster.center, cluster.radius);
  cluster.radius += more_m;
  cluster.half_extent += more_m;
  const glm::vec3 center = cluster.center - part.origin, eye = eye_world - part.origin;
  const bezier_float::BezierStart start = best_start(part.nodes, eye, center);
  bool certified = true;
  for (const bezier_float::BezierNode& node : part.nodes.nodes)
    certified = certified && bezier_float::is_before_focus(node, glm::length(center - node.position) + cluster.radius);
  Candidate out;
  out.cluster = number;
  out.start.certified = certified || part.nodes.unique ? 1.0f : 0.0f;
  out.start.x = start.x;
  out.start.middle = glm::vec4(cluster.center, cluster.radius);
  out.start.half_extent = glm::vec4(cluster.half_extent, 0.0f);
  const bezier_float::ReflectionPoint r =
      reflect_from(part.surface, eye, center, start.x, bezier_float::kParameterLimit, kSteps);
  if (!r.converged) return out;
  if (r.status == bezier_float::kReflectionBehind && r.height < -kSafety * cluster.radius) return std::nullopt;
  if (r.status > bezier_float::kReflectionOutside) return out;
  const bezier_float::ReflectionDerivative d = reflection_derivative(part.surface, eye, center, r.x);
  const glm::vec2 extent =
      kSafety * glm::vec2(dot(abs(d.x), cluster.half_extent), dot(abs(d.y), cluster.half_extent)) + glm::vec2(kMargin);
  const glm::vec4& window = part.view.window;
  if (r.height > kSafety * cluster.radius && (r.x.x - extent.x > window.z || r.x.x + extent.x < window.x ||
                                              r.x.y - extent.y > window.w || r.x.y + extent.y < window.y))
    return std::nullopt;
  out.start.x = r.x;
  out.start.x_by_position = glm::vec4(d.x, 0.0f);
  out.start.y_by_position = glm::vec4(d.y, 0.0f);
  return out;
}

class BezierReflections : public ReflectorTechnique {
 public:
  void trace(const ReflectionFrame& frame) override {
    prepare(frame);
    counts_.fill(0.0);
    unsigned patches = 0;
    for (std::size_t r = 0; r < frame.reflectors->size(); ++r) {
      if ((*frame.reflectors)[r].plane)
        hits_.find_nearest_planar(frame, r, *clusters_);
      else
        patches |= 1u << r;
    }
    for (const Part& part : find_parts(frame)) project(frame, part);
    counts_[uncertain_pixels] = hits_.finish(frame, 0, patches);
    frame.timer->end("projection");
  }
  bool marks_low_confidence() const override { return true; }
  void add_bytes(std::map<std::string, std::size_t>* bytes) const override {
    (*bytes)["projection"] = projected_.bytes() + pieces_[0].bytes() + pieces_[1].bytes() + nodes_.bytes() +
                             triangle_of_vertex_.bytes() + vertex_list_.bytes() + triangle_list_.bytes() +
                             start_list_.bytes() + hits_.bytes();
  }
  void add_counters(std::map<std::string, double>* counters) const override {
    (*counters)["newton_steps"] = counts_[newton_steps];
    (*counters)["projected_vertices"] = counts_[vertices];
    (*counters)["reflected_triangles"] = counts_[small] + counts_[large];
    (*counters)["halved_pieces"] = counts_[large];
    (*counters)["lost_vertices"] = counts_[lost];
    (*counters)["uncertain_vertices"] = counts_[uncertain];
    (*counters)["dropped_triangles"] = counts_[dropped];
    (*counters)["uncertain_pixels"] = counts_[uncertain_pixels];
  }

 private:
  void prepare(const ReflectionFrame& frame) {
    const std::size_t vertex_count = frame.buffers->geometry().positions.size();
    if (projected_.bytes() != std::max<std::size_t>(vertex_count * 2 * sizeof(glm::vec4), 32)) {
      projected_ = Buffer("projected vertices", std::max<std::size_t>(vertex_count * 2 * sizeof(glm::vec4), 32));
      projected_view_ = Texture::make_buffer("projected vertices", GL_RGBA32UI, projected_);
    }
    if (!clusters_ || epoch_ != frame.geometry_epoch) {
      clusters_ = make_clusters(frame.buffers->geometry());
      hits_.set_groups(cluster_of_triangle(*clusters_), clusters_->clusters.size());
      epoch_ = frame.geometry_epoch;
      listed_.assign(vertex_count, 0);
      triangle_of_vertex_ = Buffer();
      stamp_ = 0;
    }
    if (draws_points(frame) && !triangle_of_vertex_) {
      const std::vector<std::uint32_t>& indices = frame.buffers->geometry().indices;
      std::vector<std::uint32_t> triangles(std::max<std::size_t>(vertex_count, 1), 0u);
      for (std::size_t k = 0; k < indices.size(); ++k) triangles[indices[k]] = static_cast<std::uint32_t>(k / 3);
      triangle_of_vertex_ = Buffer::from("triangles of vertices", triangles);
    }
    if (!counters_) {
      for (Buffer& pieces : pieces_) pieces = Buffer("pieces", std::size_t{kPieceCapacity} * 64);
      counters_ = Buffer("projection counters", counter_count * sizeof(unsigned));
    }
    hits_.begin(*frame.targets);
  }

  std::vector<Part> find_parts(const ReflectionFrame& frame) {
    std::vector<Part> parts;
    for (std::size_t r = 0; r < frame.reflectors->size(); ++r) {
      const Reflector& reflector = (*frame.reflectors)[r];
      if (reflector.plane) continue;
      if (reflector.fit)
        add_fitted(frame, r, &parts);
      else
        add_patch(frame, r, &parts);
    }
    if (parts.size() > kMaxPatches)
      throw Error("--reflections bezier", "more than " + std::to_string(kMaxPatches) + " patches are in view",
                  "name fewer reflectors with --reflector, or use --reflections octree");
    std::vector<glm::vec4> texels;
    std::vector<PatchRecord> records(kMaxPatches);
    for (Part& part : parts) {
      part.number = static_cast<int>(&part - parts.data());
      records[static_cast<std::size_t>(part.number)] = part.record;
      part.first_node = static_cast<int>(texels.size() / kNodeTexels);
      const std::vector<glm::vec4> more = node_texels(part.nodes);
      texels.insert(texels.end(), more.begin(), more.end());
    }
    if (texels.empty()) return parts;
    nodes_ = Buffer::from("reflection nodes", texels);
    node_view_ = Texture::make_buffer("reflection nodes", GL_RGBA32F, nodes_);
    glBindTextureUnit(kUnitPatchNodes, node_view_.get());
    constexpr std::size_t kMirrorBytes = kMaxReflectors * sizeof(glm::ivec4);
    const std::size_t bytes = kMirrorBytes + records.size() * sizeof(PatchRecord);
    if (!patches_) patches_ = Buffer("patches in view", bytes);
    patches_.update(kMirrorBytes, bytes - kMirrorBytes, records.data());
    glBindBufferBase(GL_UNIFORM_BUFFER, kBlockReflectors, patches_.get());
    return parts;
  }

  void add_patch(const ReflectionFrame& frame, std::size_t number, std::vector<Part>* parts) {
    const Reflector& reflector = (*frame.reflectors)[number];
    const ReflectorPatch patch = make_reflector_patch(reflector.points);
    if (patch.degenerate)
      throw Error("--reflections bezier", "the patch '" + reflector.name + "' has no area",
                  "correct its control points");
    Part part;
    part.ghost = frame.ghost ? (*frame.ghost)[number] : GhostDeviation{};
    if (frame.ghost && part.ghost.offset_m == 0.0f) return;  // no pane, or outside the picture
    part.view = view_patch(patch, *frame.constants);
    // A second reflection is a few millimetres beside the first: far less than this margin.
    if (frame.ghost) part.view.window += 0.25f * glm::vec4(-1.0f, -1.0f, 1.0f, 1.0f);
    part.reflector = static_cast<int>(number);
    add_sides(frame, patch, reflector.points, part, parts);
  }

  /// A curved mesh: its patches only limit where triangles are searched; hits are found with the pixels' own rays.
  void add_fitted(const ReflectionFrame& frame, std::size_t number, std::vector<Part>* parts) {
    constexpr float kBetweenPixels = 0.02f;  // parameters
    const Reflector& reflector = (*frame.reflectors)[number];
    const std::vector<FittedPatch>& patches = reflector.fit->patches;
    const int side = std::max(4, static_cast<int>(16.0 / std::sqrt(static_cast<double>(patches.size()))));
    for (std::size_t k = 0; k < patches.size(); ++k) {
      const FitDeviation& seen = (*frame.fits)[static_cast<std::size_t>(reflector.first_patch) + k];
      if (seen.most == glm::vec2(0.0f)) continue;  // no pixel sees it
      // Only the visible part of the patch, so that the search is not disturbed by the rest.
      const glm::dvec4 window(4.0f - seen.least - kBetweenPixels, seen.most - 4.0f + kBetweenPixels);
      const std::array<glm::dvec3, 16> points = part_of_patch(patches[k].points, window);
      const ReflectorPatch patch = make_reflector_patch(points);
      if (patch.degenerate) continue;
      Part part;
      part.ghost = {1.05f * seen.reach.offset_m + 1e-6f, 1.05f * seen.reach.turn + 1e-6f};
      part.view = view_patch(patch, *frame.constants, side);
      part.view.window = glm::vec4(-1.0f, -1.0f, 1.0f, 1.0f);
      part.reflector = static_cast<int>(number);
      part.fitted = true;
      add_sides(frame, patch, points, part, parts);
    }
  }

  static void add_sides(const ReflectionFrame& frame, const ReflectorPatch& patch,
                        const std::array<glm::dvec3, 16>& points, const Part& part, std::vector<Part>* parts) {
    if (part.view.beams.empty()) return;
    for (ReflectorNodes& nodes : make_reflector_nodes(patch, glm::dvec3(frame.constants->eye) - patch.origin)) {
      Part side = part;
      // A reflection beside this part belongs to another part of the mesh, so the careful search is not needed.
      if (part.fitted) nodes.careful = false;
      side.nodes = std::move(nodes);
      side.origin = glm::vec3(patch.origin);
      side.surface = patch.single;
      side.record = make_patch_record(patch);
      for (const glm::dvec3& p : points)
        side.size_m = std::max(side.size_m, static_cast<float>(glm::length(p - patch.origin)));
      parts->push_back(std::move(side));
    }
  }

  void set_part(const Program& program, const Part& part) const {
    program.set("u_reflector", part.reflector);
    program.set("u_patch", part.number);
    program.set("u_first_node", part.first_node);
    program.set("u_node_count", static_cast<int>(part.nodes.nodes.size()));
    program.set("u_side", part.nodes.side);
    program.set("u_careful", part.nodes.careful ? 1 : 0);
    program.set("u_unique", part.nodes.unique ? 1 : 0);
    glProgramUniform4fv(program.get(), program.location("u_window"), 1, &part.view.window.x);
    glProgramUniform2f(program.get(), program.location("u_ghost"), part.ghost.offset_m, part.ghost.turn);
  }

  static void run(const Program& program, int count) {
    glUseProgram(program.get());
    glDispatchCompute(static_cast<GLuint>((count + 63) / 64), 1, 1);
  }

  std::array<unsigned, counter_count> read_counters() const {
    std::array<unsigned, counter_count> values{};
    counters_.read(0, sizeof values, values.data());
    return values;
  }

  /// The clusters that may be visible in the part.
  std::vector<Candidate> find_candidates(const ReflectionFrame& frame, const Part& part) const {
    const std::vector<Beam>& beams = part.view.beams;
    const auto may_be_reflected = [&](const glm::vec3& center, float radius) {
      const float bound = radius + part.ghost_margin_m(center, radius);
      return std::any_of(beams.begin(), beams.end(), [&](const Beam& b) { return may_meet(b, center, bound); });
    };
    std::vector<std::uint32_t> numbers;
    for (std::size_t i = 0; i < clusters_->of_item.size(); ++i) {
      if (i == (*frame.reflectors)[static_cast<std::size_t>(part.reflector)].item) continue;  // itself
      const Bounds& bounds = frame.buffers->bounds(i);
      if (!(*frame.occluding)[i] || !may_be_reflected(bounds.center(), bounds.radius())) continue;
      for (std::size_t c = clusters_->of_item[i].begin; c < clusters_->of_item[i].end; ++c)
        if (may_be_reflected(clusters_->clusters[c].center, clusters_->clusters[c].radius))
          numbers.push_back(static_cast<std::uint32_t>(c));
    }
    std::vector<std::optional<Candidate>> found(numbers.size());
    parallel_for(std::size_t{0}, numbers.size(), [&](std::size_t k) {
      found[k] = find_candidate(part, glm::vec3(frame.constants->eye), *clusters_, numbers[k]);
    });
    std::vector<Candidate> candidates;
    for (const std::optional<Candidate>& c : found)
      if (c) candidates.push_back(*c);
    return candidates;
  }

  /// Removes candidates whose projected box is outside the view or behind what has been found.
  void cull(const ReflectionFrame& frame, const Part& part, std::vector<Candidate>* candidates) {
    if (candidates->empty()) return;
    starts_.clear();
    for (const Candidate& c : *candidates) starts_.push_back(c.start);
    start_list_ = Buffer::from("starts", starts_);
    const Buffer boxes("boxes of clusters", starts_.size() * NearestHits::kVisibleBoxBytes);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferBoxes, boxes.get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferPatchStarts, start_list_.get());
    const Program& program = frame.programs->get(kBounds);
    set_part(program, part);
    program.set("u_count", static_cast<int>(starts_.size()));
    run(program, static_cast<int>(starts_.size()));
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
    const std::vector<std::uint32_t> in_view =
        hits_.find_visible(frame, static_cast<std::size_t>(part.reflector), boxes);
    std::size_t kept = 0;
    for (std::size_t k = 0; k < candidates->size(); ++k)
      if (in_view[k] != 0) (*candidates)[kept++] = (*candidates)[k];
    candidates->resize(kept);
  }

  /// First the clusters that the last picture shows, then those that may still be visible beside or in front of them.
  void project(const ReflectionFrame& frame, const Part& part) {
    std::vector<Candidate> candidates = find_candidates(frame, part);
    if (draws_points(frame)) {  // points occlude nothing
      project_clusters(frame, part, candidates);
      return;
    }
    const auto rest = std::stable_partition(candidates.begin(), candidates.end(),
                                            [&](const Candidate& c) { return hits_.seen_groups()[c.cluster] != 0; });
    if (rest != candidates.begin()) {
      hits_.bind_far(frame, static_cast<std::size_t>(part.reflector));
      project_clusters(frame, part, {candidates.begin(), rest});
      candidates.erase(candidates.begin(), rest);
    }
    cull(frame, part, &candidates);
    project_clusters(frame, part, candidates);
  }

  void project_clusters(const ReflectionFrame& frame, const Part& part, std::span<const Candidate> candidates) {
    hits_.find_nearest(
        frame, candidates.size(),
        [&](std::size_t begin, std::size_t end) {
          offer_clusters(frame, part, candidates.subspan(begin, end - begin));
        },
        [&] {
          const std::array<unsigned, counter_count> values = read_counters();
          for (std::size_t k = 0; k < counter_count; ++k) counts_[k] += values[k];
        });
  }

  void offer_clusters(const ReflectionFrame& frame, const Part& part, std::span<const Candidate> candidates) {
    counters_.clear_to_zero();
    ++stamp_;
    vertices_.clear();
    triangles_.clear();
    starts_.clear();
    for (const Candidate& c : candidates) {
      const Cluster& cluster = clusters_->clusters[c.cluster];
      for (std::uint32_t k = 0; k < cluster.vertex_count; ++k) {
        const std::uint32_t v = clusters_->vertices[cluster.first_vertex + k];
        if (listed_[v] != stamp_) vertices_.emplace_back(v, static_cast<unsigned>(starts_.size()));
        listed_[v] = stamp_;
      }
      for (std::uint32_t k = 0; k < cluster.triangle_count; ++k)
        triangles_.push_back(clusters_->triangles[cluster.first_triangle + k].y);
      starts_.push_back(c.start);
    }
    vertex_list_ = Buffer::from("mirrored vertices", vertices_);
    triangle_list_ = Buffer::from("mirrored triangles", triangles_);
    start_list_ = Buffer::from("starts", starts_);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferProjections, projected_.get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferBezierCounters, counters_.get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferPatchVertices, vertex_list_.get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferPatchStarts, start_list_.get());
    if (!vertices_.empty()) {
      const Program& vertices_program = frame.programs->get(kVertices);
      set_part(vertices_program, part);
      vertices_program.set("u_count", static_cast<int>(vertices_.size()));
      run(vertices_program, static_cast<int>(vertices_.size()));
      glMemoryBarrier(GL_ALL_BARRIER_BITS);
    }
    glBindTextureUnit(kUnitProjected, projected_view_.get());
    if (draws_points(frame))
      draw_points(frame, part);
    else
      subdivide(frame, part);
  }

  static bool draws_points(const ReflectionFrame& frame) {
    return frame.settings->get_string("bezier.draw") == "points";
  }

  /// Draws the vertices of `vertex_list_` as points.
  void draw_points(const ReflectionFrame& frame, const Part& part) {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferTriangleOfVertex, triangle_of_vertex_.get());
    hits_.bind_nearest();
    const Program& program = frame.programs->get(kPoints);
    program.set("u_reflector", part.reflector);
    program.set("u_count", static_cast<int>(vertices_.size()));
    program.set("u_point_px", frame.settings->get_int("bezier.point_size"));
    constexpr int kRounds = 3;
    for (int round = 0; round < kRounds; ++round) {
      program.set("u_round", round);
      run(program, static_cast<int>(vertices_.size()));
      glMemoryBarrier(GL_ALL_BARRIER_BITS);
    }
  }

  void subdivide(const ReflectionFrame& frame, const Part& part) {
    const int levels = frame.settings->get_int("bezier.levels");
    const auto tolerance_px = static_cast<float>(frame.settings->get_double("bezier.tolerance"));
    const auto run_over = [&](const ShaderVariant& variant, int count, int level) {
      const Program& program = frame.programs->get(variant);
      set_part(program, part);
      program.set("u_piece_capacity", kPieceCapacity);
      program.set("u_tolerance_px", tolerance_px);
      program.set("u_margin_px", margin_px(tolerance_px));
      program.set("u_count", count);
      hits_.prepare(program);
      if (level > 0) {
        program.set("u_short_px", kShort_px);
        program.set("u_last", level >= levels ? 1 : 0);
        program.set("u_next_counter", level % 2 == 0 ? static_cast<int>(pieces_a) : static_cast<int>(pieces_b));
      }
      glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferPieces, pieces_[(level + 1) % 2].get());
      glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferNextPieces, pieces_[level % 2].get());
      run(program, count);
      glMemoryBarrier(GL_ALL_BARRIER_BITS);
    };
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferBezierTriangles, triangle_list_.get());
    run_over(kClassify, static_cast<int>(triangles_.size()), 0);
    for (int level = 1; level <= std::max(levels, 1); ++level) {
      const std::size_t from = level % 2 == 1 ? pieces_a : pieces_b, to = level % 2 == 1 ? pieces_b : pieces_a;
      const int count = std::min(static_cast<int>(read_counters()[from]), kPieceCapacity);
      if (count == 0) break;
      const unsigned zero = 0;
      counters_.update(to * sizeof(unsigned), sizeof zero, &zero);
      run_over(part.ghost.offset_m > 0.0f ? kGhostPieces : kPieces, count, level);
    }
  }

  std::optional<ClusterSet> clusters_;
  std::uint32_t epoch_ = 0;
  std::vector<std::uint32_t> listed_;  ///< [vertex] stamp of the last list that contains it
  std::uint32_t stamp_ = 0;
  std::vector<glm::uvec2> vertices_;  ///< vertex, start
  std::vector<std::uint32_t> triangles_;
  std::vector<ClusterStart> starts_;
  NearestHits hits_;
  Buffer triangle_of_vertex_;  ///< only where points are drawn
  Buffer projected_, pieces_[2], counters_, nodes_, patches_, vertex_list_, triangle_list_, start_list_;
  Texture node_view_, projected_view_;
  std::array<double, counter_count> counts_{};
};

}  // namespace

std::vector<ShaderVariant> bezier_shader_variants() {
  return {kVertices, kClassify, kPieces, kGhostPieces, kBounds, kPoints};
}

std::unique_ptr<ReflectorTechnique> make_bezier_reflections() { return std::make_unique<BezierReflections>(); }

}  // namespace maquette
