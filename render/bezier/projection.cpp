#include "render/bezier/projection.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/bezier/reflector_patch.h"
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

/// Whether rays from the patch may meet a sphere: around each node they fill a cone that holds its neighbours' rays.
bool may_be_reflected(const Part& part, const glm::vec3& center, float radius) {
  const auto& nodes = part.nodes.nodes;
  float spacing = 0.0f, spread = 0.0f;
  const auto side = static_cast<std::size_t>(kNodesPerSide);
  for (std::size_t j = 0; j < side; ++j)
    for (std::size_t i = 0; i < side; ++i)
      for (const std::size_t other :
           {i + 1 < side ? j * side + i + 1 : j * side + i, j + 1 < side ? (j + 1) * side + i : j * side + i}) {
        const auto &a = nodes[j * side + i], &b = nodes[other];
        spacing = std::max(spacing, glm::length(a.position - b.position));
        spread = std::max(spread, std::acos(std::clamp(glm::dot(a.direction, b.direction), -1.0f, 1.0f)));
      }
  for (const auto& node : nodes) {
    const glm::vec3 to = center - part.origin - node.position;
    const float distance = glm::length(to), reach = radius + spacing;
    if (distance <= reach) return true;
    const float angle = std::acos(std::clamp(glm::dot(to, node.direction) / distance, -1.0f, 1.0f));
    if (angle <= spread + std::asin(reach / distance)) return true;
  }
  return false;
}

class BezierReflections : public ReflectorTechnique {
 public:
  void trace(const ReflectionFrame& frame) override {
    prepare(frame);
    clear(*frame.targets);
    counts_.fill(0.0);
    for (const Part& part : find_parts(frame)) project(frame, part);
    frame.timer->end("projection");
  }
  void add_bytes(std::map<std::string, std::size_t>* bytes) const override {
    (*bytes)["projection"] =
        projected_.bytes() + drawn_.bytes() + pieces_[0].bytes() + pieces_[1].bytes() + nodes_.bytes() + depth_.bytes();
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
    const std::size_t vertex_bytes = frame.buffers->geometry().positions.size() * 2 * sizeof(glm::vec4);
    if (projected_.bytes() != vertex_bytes)
      projected_ = Buffer("projected vertices", std::max<std::size_t>(vertex_bytes, 32));
    if (!drawn_) {
      drawn_ = Buffer("reflected triangles", std::size_t{kDrawnCapacity} * 64);
      drawn_view_ = Texture::make_buffer("reflected triangles", GL_RGBA32F, drawn_);
      for (Buffer& pieces : pieces_) pieces = Buffer("pieces", std::size_t{kPieceCapacity} * 64);
      counters_ = Buffer("projection counters", counter_count * sizeof(unsigned));
      GLuint name = 0;
      glCreateVertexArrays(1, &name);
      vertex_array_ = GlName<VertexArrayTraits>(name);
    }
    const ReflectionTargets& t = *frame.targets;
    if (depth_.width() == t.width && depth_.height() == t.height && attached_ == t.triangle.get()) return;
    depth_ = Texture::make_2d("reflected depth buffer", GL_DEPTH_COMPONENT32F, t.width, t.height);
    GLuint framebuffer = 0;
    glCreateFramebuffers(1, &framebuffer);
    framebuffer_ = GlName<FramebufferTraits>(framebuffer);
    attached_ = t.triangle.get();
    glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, attached_, 0);
    glNamedFramebufferTexture(framebuffer, GL_DEPTH_ATTACHMENT, depth_.get(), 0);
  }

  void clear(const ReflectionTargets& t) {
    const GLuint none[4] = {0, 0, 0, 0};
    const float far_depth = 0.0f;
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
    glViewport(0, 0, t.width, t.height);
    glClearNamedFramebufferuiv(framebuffer_.get(), GL_COLOR, 0, none);
    glClearNamedFramebufferfv(framebuffer_.get(), GL_DEPTH, 0, &far_depth);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
  }

  std::vector<Part> find_parts(const ReflectionFrame& frame) {
    std::vector<Part> parts;
    std::vector<glm::vec4> texels;
    for (std::size_t r = 0; r < frame.reflectors->size(); ++r) {
      const Reflector& reflector = (*frame.reflectors)[r];
      if (!reflector.patch)
        throw Error("--reflections bezier", "'" + reflector.name + "' is a mesh, not a Bezier patch",
                    "use another technique for it, or name the patches with --reflector");
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

  void project(const ReflectionFrame& frame, const Part& part) {
    const FlatGeometry& geometry = frame.buffers->geometry();
    counters_.clear_to_zero();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, projected_.get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, counters_.get());
    std::vector<std::size_t> items;
    for (std::size_t i = 0; i < geometry.items.size(); ++i) {
      const Bounds& bounds = frame.buffers->bounds(i);
      if (i == (*frame.reflectors)[static_cast<std::size_t>(part.reflector)].item) continue;  // a mirror in itself
      if ((*frame.occluding)[i] && may_be_reflected(part, bounds.center(), bounds.radius())) items.push_back(i);
    }
    const Program& vertices_program = frame.programs->get({"bezier/vertices.comp", "", {}});
    set_part(vertices_program, part);
    for (const std::size_t i : items) {
      vertices_program.set("u_first_vertex", static_cast<int>(geometry.items[i].first_vertex));
      vertices_program.set("u_vertex_count", static_cast<int>(geometry.items[i].vertex_count));
      run(vertices_program, static_cast<int>(geometry.items[i].vertex_count));
    }
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
    subdivide(frame, part, items);
    draw(frame, part);
  }

  void subdivide(const ReflectionFrame& frame, const Part& part, const std::vector<std::size_t>& items) {
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
    for (const std::size_t i : items) {
      const DrawItem& item = frame.buffers->geometry().items[i];
      first.set("u_first", static_cast<int>(item.first_index / 3));
      first.set("u_count", static_cast<int>(item.index_count / 3));
      run(first, static_cast<int>(item.index_count / 3));
    }
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
    const Program& further = frame.programs->get(triangles_variant(false));
    for (int level = 1; level <= levels; ++level) {
      const std::size_t from = level % 2 == 1 ? pieces_a : pieces_b, to = level % 2 == 1 ? pieces_b : pieces_a;
      const int count = std::min(static_cast<int>(read_counters()[from]), kPieceCapacity);
      if (count == 0) break;
      const unsigned zero = 0;
      counters_.update(to * sizeof(unsigned), sizeof zero, &zero);
      set_up(further, level);
      further.set("u_first", 0);
      further.set("u_count", count);
      run(further, count);
      glMemoryBarrier(GL_ALL_BARRIER_BITS);
    }
  }

  void draw(const ReflectionFrame& frame, const Part& part) {
    const std::array<unsigned, counter_count> values = read_counters();
    for (std::size_t k = 0; k < counter_count; ++k) counts_[k] += values[k];
    const int count = std::min(static_cast<int>(values[drawn]), kDrawnCapacity);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
    glViewport(0, 0, frame.targets->width, frame.targets->height);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glEnable(GL_CLIP_DISTANCE0);
    glBindVertexArray(vertex_array_.get());
    glBindTextureUnit(55, drawn_view_.get());
    const Program& program = frame.programs->get({"reflections/projected.frag", "reflections/projected.vert", {}});
    program.set("u_reflector", part.reflector);
    glUseProgram(program.get());
    if (count > 0) glDrawArrays(GL_TRIANGLES, 0, 3 * count);
    glBindVertexArray(0);
    glDisable(GL_CLIP_DISTANCE0);
    glDisable(GL_DEPTH_TEST);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
  }

  Buffer projected_, drawn_, pieces_[2], counters_, nodes_;
  Texture drawn_view_, node_view_, depth_;
  GlName<FramebufferTraits> framebuffer_;
  GlName<VertexArrayTraits> vertex_array_;
  GLuint attached_ = 0;
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
