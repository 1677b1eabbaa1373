#include "render/bezier/projection.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "render/bezier/patch_view.h"
#include "render/reflections/clusters.h"
#include "render/reflections/raster.h"
#include "scenes/error.h"

namespace maquette {

namespace {

constexpr int kDrawnCapacity[2] = {1 << 19, 1 << 18};  // triangles and pieces, 64 bytes each
constexpr int kPieceCapacity = 1 << 18;
constexpr std::size_t kNodeTexels = 5;

// Slots of the counters in shaders/bezier/*.comp.
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
  doubtful,
  counter_count = 16
};

const ShaderVariant kVertices{"bezier/vertices.comp", "", {}}, kClassify{"bezier/classify.comp", "", {}},
    kPieces{"bezier/pieces.comp", "", {}}, kMend{"bezier/mend.comp", "", {}},
    kDrawSmall{"reflections/projected.frag", "reflections/projected.vert", {}},
    kDrawLarge{"bezier/hit.frag", "bezier/hit.vert", {}};

/// One side of one patch, as the eye of this frame sees it.
struct Part {
  int reflector = 0;
  int first_node = 0;
  ReflectorNodes nodes;
  glm::vec3 origin{0.0f};
  PatchView view;
  bezier_float::BezierSurface surface;
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

/// What a piece is drawn larger by: its edges are within the tolerance of straight ones, what lies between them within
/// twice as much.
float margin_px(float tolerance_px) { return 2.0f * tolerance_px + 0.25f; }

/// Where the search begins for all of a cluster; std430 twin of the one in shaders/bezier/vertices.comp.
struct ClusterStart {
  glm::vec2 x{0.0f};
  float certified = 0.0f, unused = 0.0f;
  glm::vec4 x_by_place{0.0f}, y_by_place{0.0f};
  glm::vec4 middle{0.0f};  ///< world, m
};

/// Nothing when the window shows nothing of the cluster: its parameters, to the first order with half as much again,
/// lie beside it, or all of it lies behind the surface.
std::optional<ClusterStart> find_cluster_start(const Part& part, const glm::vec3& eye_world, const Cluster& cluster) {
  constexpr int kSteps = 10;
  constexpr float kReach = 1.5f, kMargin = 0.02f;
  const glm::vec3 center = cluster.center - part.origin, eye = eye_world - part.origin;
  const bezier_float::BezierStart start = choose_start(part.nodes, eye, center);
  bool certified = true;
  for (const bezier_float::BezierNode& node : part.nodes.nodes)
    certified = certified && bezier_float::is_before_focus(node, glm::length(center - node.position) + cluster.radius);
  ClusterStart out;
  out.certified = certified || part.nodes.unique ? 1.0f : 0.0f;
  out.x = start.x;
  out.middle = glm::vec4(cluster.center, 0.0f);
  const bezier_float::ReflectionPoint r =
      reflect_from(part.surface, eye, center, start.x, bezier_float::kParameterLimit, kSteps);
  if (!r.converged) return out;
  if (r.status == bezier_float::kReflectionBehind && r.height < -kReach * cluster.radius) return std::nullopt;
  if (r.status > bezier_float::kReflectionOutside) return out;
  const bezier_float::ReflectionDerivative d = reflection_derivative(part.surface, eye, center, r.x);
  const glm::vec2 reach =
      kReach * glm::vec2(dot(abs(d.x), cluster.half_extent), dot(abs(d.y), cluster.half_extent)) + glm::vec2(kMargin);
  const glm::vec4& window = part.view.window;
  if (r.height > kReach * cluster.radius && (r.x.x - reach.x > window.z || r.x.x + reach.x < window.x ||
                                             r.x.y - reach.y > window.w || r.x.y + reach.y < window.y))
    return std::nullopt;
  out.x = r.x;
  out.x_by_place = glm::vec4(d.x, 0.0f);
  out.y_by_place = glm::vec4(d.y, 0.0f);
  return out;
}

class BezierReflections : public ReflectorTechnique {
 public:
  void trace(const ReflectionFrame& frame) override {
    prepare(frame);
    counts_.fill(0.0);
    for (std::size_t r = 0; r < frame.reflectors->size(); ++r)
      if ((*frame.reflectors)[r].plane) raster_.draw_planar(frame, r);
    const std::vector<Part> parts = find_parts(frame);
    for (const Part& part : parts) project(frame, part);
    if (!parts.empty()) mend(frame);
    frame.timer->end("projection");
  }
  void add_bytes(std::map<std::string, std::size_t>* bytes) const override {
    (*bytes)["projection"] = projected_.bytes() + drawn_[0].bytes() + drawn_[1].bytes() + pieces_[0].bytes() +
                             pieces_[1].bytes() + nodes_.bytes() + vertex_list_.bytes() + triangle_list_.bytes() +
                             start_list_.bytes() + mended_.bytes() + raster_.bytes();
  }
  void add_counters(std::map<std::string, double>* counters) const override {
    (*counters)["newton_steps"] = counts_[newton_steps];
    (*counters)["projected_vertices"] = counts_[vertices];
    (*counters)["reflected_triangles"] = counts_[small] + counts_[large];
    (*counters)["halved_pieces"] = counts_[large];
    (*counters)["lost_vertices"] = counts_[lost];
    (*counters)["uncertain_vertices"] = counts_[uncertain];
    (*counters)["dropped_triangles"] = counts_[dropped];
    (*counters)["uncertain_pixels"] = counts_[doubtful];
  }

 private:
  void prepare(const ReflectionFrame& frame) {
    const std::size_t vertex_count = frame.buffers->geometry().positions.size();
    if (projected_.bytes() != std::max<std::size_t>(vertex_count * 2 * sizeof(glm::vec4), 32))
      projected_ = Buffer("projected vertices", std::max<std::size_t>(vertex_count * 2 * sizeof(glm::vec4), 32));
    if (!clusters_ || epoch_ != frame.geometry_epoch) {
      clusters_ = make_clusters(frame.buffers->geometry());
      epoch_ = frame.geometry_epoch;
      listed_.assign(vertex_count, 0);
      stamp_ = 0;
    }
    if (!counters_) {
      for (std::size_t k = 0; k < 2; ++k) {
        drawn_[k] = Buffer("reflected triangles", static_cast<std::size_t>(kDrawnCapacity[k]) * 64);
        drawn_view_[k] = Texture::make_buffer("reflected triangles", GL_RGBA32F, drawn_[k]);
      }
      for (Buffer& pieces : pieces_) pieces = Buffer("pieces", std::size_t{kPieceCapacity} * 64);
      counters_ = Buffer("projection counters", counter_count * sizeof(unsigned));
    }
    raster_.begin(*frame.targets);
  }

  std::vector<Part> find_parts(const ReflectionFrame& frame) {
    std::vector<Part> parts;
    std::vector<glm::vec4> texels;
    for (std::size_t r = 0; r < frame.reflectors->size(); ++r) {
      const Reflector& reflector = (*frame.reflectors)[r];
      if (reflector.plane) continue;
      if (!reflector.patch)
        throw Error("--reflections bezier", "'" + reflector.name + "' is a curved mesh, not a Bezier patch",
                    "use --reflections triangle or octree for it, or name the patches with --reflector");
      const ReflectorPatch patch = make_reflector_patch(reflector.points);
      if (patch.degenerate)
        throw Error("--reflections bezier", "the patch '" + reflector.name + "' has no area",
                    "correct its control points");
      const PatchView view = view_patch(patch, *frame.constants);
      if (view.beams.empty()) continue;
      for (ReflectorNodes& nodes : make_reflector_nodes(patch, glm::dvec3(frame.constants->eye) - patch.origin)) {
        Part part{static_cast<int>(r),
                  static_cast<int>(texels.size() / kNodeTexels),
                  std::move(nodes),
                  glm::vec3(patch.origin),
                  view,
                  patch.single};
        const std::vector<glm::vec4> more = node_texels(part.nodes);
        texels.insert(texels.end(), more.begin(), more.end());
        parts.push_back(std::move(part));
      }
    }
    if (texels.empty()) return parts;
    nodes_ = Buffer::from("reflection nodes", texels);
    node_view_ = Texture::make_buffer("reflection nodes", GL_RGBA32F, nodes_);
    glBindTextureUnit(54, node_view_.get());
    return parts;
  }

  void set_part(const Program& program, const Part& part) const {
    program.set("u_reflector", part.reflector);
    program.set("u_first_node", part.first_node);
    program.set("u_node_count", static_cast<int>(part.nodes.nodes.size()));
    program.set("u_side", part.nodes.side);
    program.set("u_careful", part.nodes.careful ? 1 : 0);
    program.set("u_unique", part.nodes.unique ? 1 : 0);
    glProgramUniform4fv(program.get(), program.location("u_window"), 1, &part.view.window.x);
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

  /// What may be seen in the part: its vertices with the start of their cluster, and its triangles.
  void list_clusters(const ReflectionFrame& frame, const Part& part) {
    const std::vector<Beam>& beams = part.view.beams;
    const auto may_be_reflected = [&](const glm::vec3& center, float radius) {
      return std::any_of(beams.begin(), beams.end(), [&](const Beam& b) { return may_meet(b, center, radius); });
    };
    std::vector<std::uint32_t> candidates;
    for (std::size_t i = 0; i < clusters_->of_item.size(); ++i) {
      if (i == (*frame.reflectors)[static_cast<std::size_t>(part.reflector)].item) continue;  // a mirror in itself
      const Bounds& bounds = frame.buffers->bounds(i);
      if (!(*frame.occluding)[i] || !may_be_reflected(bounds.center(), bounds.radius())) continue;
      for (std::size_t c = clusters_->of_item[i].begin; c < clusters_->of_item[i].end; ++c)
        if (may_be_reflected(clusters_->clusters[c].center, clusters_->clusters[c].radius))
          candidates.push_back(static_cast<std::uint32_t>(c));
    }
    std::vector<std::optional<ClusterStart>> starts(candidates.size());
    const glm::vec3 eye(frame.constants->eye);
    tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t k) {
      starts[k] = find_cluster_start(part, eye, clusters_->clusters[candidates[k]]);
    });
    vertices_.clear();
    triangles_.clear();
    starts_.clear();
    ++stamp_;
    for (std::size_t n = 0; n < candidates.size(); ++n) {
      if (!starts[n]) continue;
      const Cluster& cluster = clusters_->clusters[candidates[n]];
      for (std::uint32_t k = 0; k < cluster.vertex_count; ++k) {
        const std::uint32_t v = clusters_->vertices[cluster.first_vertex + k];
        if (listed_[v] != stamp_) vertices_.emplace_back(v, static_cast<unsigned>(starts_.size()));
        listed_[v] = stamp_;
      }
      for (std::uint32_t k = 0; k < cluster.triangle_count; ++k)
        triangles_.push_back(clusters_->triangles[cluster.first_triangle + k].y);
      starts_.push_back(*starts[n]);
    }
  }

  void project(const ReflectionFrame& frame, const Part& part) {
    list_clusters(frame, part);
    if (triangles_.empty()) return;
    vertex_list_ = Buffer::from("mirrored vertices", vertices_);
    triangle_list_ = Buffer::from("mirrored triangles", triangles_);
    start_list_ = Buffer::from("starts", starts_);
    counters_.clear_to_zero();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, projected_.get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, counters_.get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, vertex_list_.get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 5, start_list_.get());
    const Program& vertices_program = frame.programs->get(kVertices);
    set_part(vertices_program, part);
    vertices_program.set("u_count", static_cast<int>(vertices_.size()));
    run(vertices_program, static_cast<int>(vertices_.size()));
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
    subdivide(frame, part);
    draw(frame, part);
  }

  void subdivide(const ReflectionFrame& frame, const Part& part) {
    const int levels = frame.settings->get_int("bezier.levels");
    const auto tolerance_px = static_cast<float>(frame.settings->get_double("bezier.tolerance"));
    const auto run_over = [&](const ShaderVariant& variant, int count, int level) {
      const Program& program = frame.programs->get(variant);
      set_part(program, part);
      program.set("u_drawn_capacity", kDrawnCapacity[level == 0 ? 0 : 1]);
      program.set("u_piece_capacity", kPieceCapacity);
      program.set("u_tolerance_px", tolerance_px);
      program.set("u_margin_px", margin_px(tolerance_px));
      program.set("u_count", count);
      if (level > 0) {
        program.set("u_small_capacity", kDrawnCapacity[0]);
        program.set("u_last", level >= levels ? 1 : 0);
        program.set("u_next_counter", level % 2 == 0 ? static_cast<int>(pieces_a) : static_cast<int>(pieces_b));
      }
      glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, drawn_[level == 0 ? 0 : 1].get());
      glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 5, pieces_[(level + 1) % 2].get());
      glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, pieces_[level % 2].get());
      run(program, count);
      glMemoryBarrier(GL_ALL_BARRIER_BITS);
    };
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 7, triangle_list_.get());
    run_over(kClassify, static_cast<int>(triangles_.size()), 0);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 7, drawn_[0].get());
    for (int level = 1; level <= std::max(levels, 1); ++level) {
      const std::size_t from = level % 2 == 1 ? pieces_a : pieces_b, to = level % 2 == 1 ? pieces_b : pieces_a;
      const int count = std::min(static_cast<int>(read_counters()[from]), kPieceCapacity);
      if (count == 0) break;
      const unsigned zero = 0;
      counters_.update(to * sizeof(unsigned), sizeof zero, &zero);
      run_over(kPieces, count, level);
    }
  }

  void draw(const ReflectionFrame& frame, const Part& part) {
    const std::array<unsigned, counter_count> values = read_counters();
    for (std::size_t k = 0; k < counter_count; ++k) counts_[k] += values[k];
    const int count[2] = {std::min(static_cast<int>(values[small]), kDrawnCapacity[0]),
                          std::min(static_cast<int>(values[large]), kDrawnCapacity[1])};
    raster_.draw(*frame.targets, [&] {
      glBindVertexArray(raster_.vertex_array());
      for (int k = 0; k < 2; ++k) {
        if (count[k] == 0) continue;
        const Program& program = frame.programs->get(k == 0 ? kDrawSmall : kDrawLarge);
        program.set("u_reflector", part.reflector);
        if (k == 1)
          program.set("u_margin_px", margin_px(static_cast<float>(frame.settings->get_double("bezier.tolerance"))));
        glUseProgram(program.get());
        glBindTextureUnit(55, drawn_view_[k].get());
        glDrawArrays(GL_TRIANGLES, 0, (k == 0 ? 3 : 6) * count[k]);
      }
    });
  }

  void mend(const ReflectionFrame& frame) {
    const ReflectionTargets& t = *frame.targets;
    if (mended_.width() != t.width || mended_.height() != t.height)
      mended_ = Texture::make_2d("mended triangles", GL_R32UI, t.width, t.height);
    unsigned patches = 0;
    for (std::size_t r = 0; r < frame.reflectors->size(); ++r)
      if (!(*frame.reflectors)[r].plane) patches |= 1u << r;
    const Program& program = frame.programs->get(kMend);
    Bounds box;
    for (std::size_t i = 0; i < frame.occluding->size(); ++i) {
      if (!(*frame.occluding)[i]) continue;
      box.min = glm::min(box.min, frame.buffers->bounds(i).min);
      box.max = glm::max(box.max, frame.buffers->bounds(i).max);
    }
    glProgramUniform3fv(program.get(), program.location("u_low"), 1, &box.min.x);
    glProgramUniform3fv(program.get(), program.location("u_high"), 1, &box.max.x);
    glProgramUniform1ui(program.get(), program.location("u_patches"), patches);
    glBindTextureUnit(0, t.triangle.get());
    glBindImageTexture(0, mended_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32UI);
    glBindImageTexture(1, t.doubt.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R8UI);
    glBindTextureUnit(54, t.focus.get());
    counters_.clear_to_zero();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, counters_.get());
    glUseProgram(program.get());
    glDispatchCompute(static_cast<GLuint>((t.width + 7) / 8), static_cast<GLuint>((t.height + 7) / 8), 1);
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
    glCopyImageSubData(mended_.get(), GL_TEXTURE_2D, 0, 0, 0, 0, t.triangle.get(), GL_TEXTURE_2D, 0, 0, 0, 0, t.width,
                       t.height, 1);
    counts_[doubtful] = read_counters()[doubtful];
  }

  std::optional<ClusterSet> clusters_;
  std::uint32_t epoch_ = 0;
  std::vector<std::uint32_t> listed_;  ///< of each vertex: the stamp of the last list that it is on
  std::uint32_t stamp_ = 0;
  std::vector<glm::uvec2> vertices_;  ///< vertex, start
  std::vector<std::uint32_t> triangles_;
  std::vector<ClusterStart> starts_;
  ReflectionRaster raster_;
  Buffer projected_, drawn_[2], pieces_[2], counters_, nodes_, vertex_list_, triangle_list_, start_list_;
  Texture drawn_view_[2], node_view_, mended_;
  std::array<double, counter_count> counts_{};
};

}  // namespace

std::vector<ShaderVariant> bezier_shader_variants() {
  return {kVertices, kClassify, kPieces, kDrawSmall, kDrawLarge, kMend};
}

std::unique_ptr<ReflectorTechnique> make_bezier_reflections() { return std::make_unique<BezierReflections>(); }

}  // namespace maquette
