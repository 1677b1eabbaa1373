#include "render/bezier/projection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "render/bezier/reflector_patch.h"
#include "render/reflections/clusters.h"
#include "render/reflections/raster.h"
#include "scenes/error.h"

namespace maquette {

namespace {

constexpr int kDrawnCapacity = 1 << 19;  // triangles, 64 bytes each
constexpr int kPieceCapacity = 1 << 18;
constexpr std::size_t kNodeTexels = 5;

// Slots of the counters in shaders/bezier/*.comp.
enum Counter { drawn, pieces_a, pieces_b, newton_steps, vertices, lost, uncertain, dropped, counter_count = 16 };

ShaderVariant triangles_variant(bool scene) { return {"bezier/triangles.comp", "", {{"SCENE", scene ? "1" : "0"}}}; }

/// One side of one patch, as the eye of this frame sees it.
struct Part {
  int reflector = 0;
  int first_node = 0;
  ReflectorNodes nodes;
  glm::vec3 origin{0.0f};
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

/// The rays of each quad of nodes. Between nodes they leave the corners' cone by what its own turn differs from a
/// straight one's; kSlack of the turn is more than car glass bends in a quarter of a pane.
std::vector<Beam> make_beams(const Part& part) {
  constexpr float kSlack = 0.25f;
  const auto& nodes = part.nodes.nodes;
  const auto side = static_cast<std::size_t>(kNodesPerSide);
  std::vector<Beam> beams;
  for (std::size_t j = 0; j + 1 < side; ++j)
    for (std::size_t i = 0; i + 1 < side; ++i) {
      std::vector<glm::vec3> origins, directions;
      for (const std::size_t k : {j * side + i, j * side + i + 1, (j + 1) * side + i, (j + 1) * side + i + 1}) {
        origins.push_back(part.origin + nodes[k].position);
        directions.push_back(nodes[k].direction);
      }
      Beam beam = make_beam(origins, directions);
      const float angle = std::acos(std::clamp(beam.cosine, 0.0f, 1.0f)) * (1.0f + kSlack) + 1e-3f;
      beam.cosine = angle < 1.5f ? std::cos(angle) : 0.0f;
      beam.sine = std::sqrt(1.0f - beam.cosine * beam.cosine);
      beam.base_radius *= 1.0f + kSlack;
      beams.push_back(beam);
    }
  return beams;
}

/// Where the search begins for all of a cluster; std430 twin of the one in shaders/bezier/vertices.comp.
struct ClusterStart {
  glm::vec2 x{0.0f}, shortest{0.0f};
  glm::vec4 certified{0.0f};
};

ClusterStart find_cluster_start(const Part& part, const glm::vec3& eye, const Cluster& cluster) {
  const glm::vec3 center = cluster.center - part.origin;
  const bezier_float::BezierStart start = choose_start(part.nodes, eye - part.origin, center);
  bool certified = true;
  for (const bezier_float::BezierNode& node : part.nodes.nodes)
    certified = certified && bezier_float::is_before_focus(node, glm::length(center - node.position) + cluster.radius);
  return {start.x, start.shortest, glm::vec4(certified || part.nodes.unique ? 1.0f : 0.0f)};
}

class BezierReflections : public ReflectorTechnique {
 public:
  void trace(const ReflectionFrame& frame) override {
    prepare(frame);
    counts_.fill(0.0);
    for (std::size_t r = 0; r < frame.reflectors->size(); ++r)
      if ((*frame.reflectors)[r].plane) raster_.draw_planar(frame, r);
    for (const Part& part : find_parts(frame)) project(frame, part);
    frame.timer->end("projection");
  }
  void add_bytes(std::map<std::string, std::size_t>* bytes) const override {
    (*bytes)["projection"] = projected_.bytes() + drawn_.bytes() + pieces_[0].bytes() + pieces_[1].bytes() +
                             nodes_.bytes() + vertex_list_.bytes() + triangle_list_.bytes() + start_list_.bytes() +
                             raster_.bytes();
  }
  void add_counters(std::map<std::string, double>* counters) const override {
    (*counters)["newton_steps"] = counts_[newton_steps];
    (*counters)["projected_vertices"] = counts_[vertices];
    (*counters)["reflected_triangles"] = counts_[drawn];
    (*counters)["lost_vertices"] = counts_[lost];
    (*counters)["uncertain_vertices"] = counts_[uncertain];
    (*counters)["dropped_triangles"] = counts_[dropped];
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
    if (!drawn_) {
      drawn_ = Buffer("reflected triangles", std::size_t{kDrawnCapacity} * 64);
      drawn_view_ = Texture::make_buffer("reflected triangles", GL_RGBA32F, drawn_);
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
      for (ReflectorNodes& nodes : make_reflector_nodes(patch, glm::dvec3(frame.constants->eye) - patch.origin)) {
        Part part{static_cast<int>(r), static_cast<int>(texels.size() / kNodeTexels), std::move(nodes),
                  glm::vec3(patch.origin)};
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
    const std::vector<Beam> beams = make_beams(part);
    const auto may_be_reflected = [&](const glm::vec3& center, float radius) {
      return std::any_of(beams.begin(), beams.end(), [&](const Beam& b) { return may_meet(b, center, radius); });
    };
    vertices_.clear();
    triangles_.clear();
    starts_.clear();
    ++stamp_;
    for (std::size_t i = 0; i < clusters_->of_item.size(); ++i) {
      if (i == (*frame.reflectors)[static_cast<std::size_t>(part.reflector)].item) continue;  // a mirror in itself
      const Bounds& bounds = frame.buffers->bounds(i);
      if (!(*frame.occluding)[i] || !may_be_reflected(bounds.center(), bounds.radius())) continue;
      for (std::size_t c = clusters_->of_item[i].begin; c < clusters_->of_item[i].end; ++c) {
        const Cluster& cluster = clusters_->clusters[c];
        if (!may_be_reflected(cluster.center, cluster.radius)) continue;
        for (std::uint32_t k = 0; k < cluster.vertex_count; ++k) {
          const std::uint32_t v = clusters_->vertices[cluster.first_vertex + k];
          if (listed_[v] != stamp_) vertices_.emplace_back(v, static_cast<unsigned>(starts_.size()));
          listed_[v] = stamp_;
        }
        for (std::uint32_t k = 0; k < cluster.triangle_count; ++k)
          triangles_.push_back(clusters_->triangles[cluster.first_triangle + k].y);
        starts_.push_back(find_cluster_start(part, glm::vec3(frame.constants->eye), cluster));
      }
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
    const Program& vertices_program = frame.programs->get({"bezier/vertices.comp", "", {}});
    set_part(vertices_program, part);
    vertices_program.set("u_count", static_cast<int>(vertices_.size()));
    run(vertices_program, static_cast<int>(vertices_.size()));
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
    subdivide(frame, part);
    draw(frame, part);
  }

  void subdivide(const ReflectionFrame& frame, const Part& part) {
    const int levels = frame.settings->get_int("bezier.levels");
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, drawn_.get());
    const auto set_up = [&](const Program& program, int level) {
      set_part(program, part);
      program.set("u_drawn_capacity", kDrawnCapacity);
      program.set("u_piece_capacity", kPieceCapacity);
      program.set("u_tolerance_px", static_cast<float>(frame.settings->get_double("bezier.tolerance")));
      program.set("u_last", level >= levels ? 1 : 0);
      program.set("u_next_counter", level % 2 == 0 ? static_cast<int>(pieces_a) : static_cast<int>(pieces_b));
      glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 5, pieces_[(level + 1) % 2].get());
      glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, pieces_[level % 2].get());
    };
    const Program& first = frame.programs->get(triangles_variant(true));
    set_up(first, 0);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 7, triangle_list_.get());
    first.set("u_count", static_cast<int>(triangles_.size()));
    run(first, static_cast<int>(triangles_.size()));
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
    const Program& further = frame.programs->get(triangles_variant(false));
    for (int level = 1; level <= levels; ++level) {
      const std::size_t from = level % 2 == 1 ? pieces_a : pieces_b, to = level % 2 == 1 ? pieces_b : pieces_a;
      const int count = std::min(static_cast<int>(read_counters()[from]), kPieceCapacity);
      if (count == 0) break;
      const unsigned zero = 0;
      counters_.update(to * sizeof(unsigned), sizeof zero, &zero);
      set_up(further, level);
      further.set("u_count", count);
      run(further, count);
      glMemoryBarrier(GL_ALL_BARRIER_BITS);
    }
  }

  void draw(const ReflectionFrame& frame, const Part& part) {
    const std::array<unsigned, counter_count> values = read_counters();
    for (std::size_t k = 0; k < counter_count; ++k) counts_[k] += values[k];
    const int count = std::min(static_cast<int>(values[drawn]), kDrawnCapacity);
    if (count == 0) return;
    const Program& program = frame.programs->get({"reflections/projected.frag", "reflections/projected.vert", {}});
    program.set("u_reflector", part.reflector);
    raster_.draw(*frame.targets, [&] {
      glUseProgram(program.get());
      glBindVertexArray(raster_.vertex_array());
      glBindTextureUnit(55, drawn_view_.get());
      glDrawArrays(GL_TRIANGLES, 0, 3 * count);
    });
  }

  std::optional<ClusterSet> clusters_;
  std::uint32_t epoch_ = 0;
  std::vector<std::uint32_t> listed_;  ///< of each vertex: the stamp of the last list that it is on
  std::uint32_t stamp_ = 0;
  std::vector<glm::uvec2> vertices_;  ///< vertex, start
  std::vector<std::uint32_t> triangles_;
  std::vector<ClusterStart> starts_;
  ReflectionRaster raster_;
  Buffer projected_, drawn_, pieces_[2], counters_, nodes_, vertex_list_, triangle_list_, start_list_;
  Texture drawn_view_, node_view_;
  std::array<double, counter_count> counts_{};
};

}  // namespace

std::vector<ShaderVariant> bezier_shader_variants() {
  return {{"bezier/vertices.comp", "", {}},
          triangles_variant(true),
          triangles_variant(false),
          {"reflections/projected.frag", "reflections/projected.vert", {}}};
}

std::unique_ptr<ReflectorTechnique> make_bezier_reflections() { return std::make_unique<BezierReflections>(); }

}  // namespace maquette
