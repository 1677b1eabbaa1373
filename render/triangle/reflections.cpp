#include "render/triangle/reflections.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

#include "render/reflections/raster.h"
#include "render/triangle/facets.h"
#include "scenes/error.h"

namespace maquette {

namespace {

constexpr std::size_t kFacetTexels = 22;
constexpr std::size_t kBoxBytes = 32;
constexpr std::size_t kMostBoxes = (std::size_t{128} << 20) / kBoxBytes;  // a storage buffer that every driver has
constexpr int kGroupsPerRow = 32768;

enum Counter { boxes, roots, vertices, footprints, counter_count };

const ShaderVariant kAssemble{"triangle/assemble.comp", "", {}}, kDraw{"triangle/hit.frag", "triangle/hit.vert", {}};

std::vector<glm::vec4> facet_texels(const std::vector<Facet>& facets) {
  std::vector<glm::vec4> texels;
  texels.reserve(facets.size() * kFacetTexels);
  for (const Facet& f : facets) {
    const mirror::TriangleMirror& m = f.mirror;
    for (const glm::vec3& v :
         {m.t1, m.e1, m.e2, m.d1, m.f1, m.f2, m.n0, m.n1, m.n2, m.n0_rest, m.n1_rest, m.n2_rest, m.g, m.g_rest})
      texels.emplace_back(v, 0.0f);
    texels.emplace_back(f.beam.base, f.beam.base_radius);
    texels.emplace_back(f.beam.axis, f.beam.sine);
    texels.push_back(f.box);
    texels.emplace_back(f.margin_px, f.margin, static_cast<float>(f.reflector), f.beam.cosine);
    texels.insert(texels.end(), {f.sides[0], f.sides[1], f.sides[2], glm::vec4(f.widening, 0.0f)});
  }
  return texels;
}

/// std430 twin of ClusterRecord in shaders/triangle/assemble.comp.
struct ClusterRecord {
  std::uint32_t first_vertex, vertex_count, first_triangle, triangle_count;
};

class TriangleReflections : public ReflectorTechnique {
 public:
  void trace(const ReflectionFrame& frame) override {
    update_clusters(frame);
    raster_.begin(*frame.targets);
    counts_.fill(0);
    facets_.clear();
    const int side = frame.settings->get_int("triangle.side");
    for (std::size_t r = 0; r < frame.reflectors->size(); ++r) {
      const Reflector& reflector = (*frame.reflectors)[r];
      if (reflector.plane) {
        raster_.draw_planar(frame, r);
        continue;
      }
      const std::vector<Facet> more = make_facets(reflector, r, frame.buffers->geometry(), *frame.constants, side);
      facets_.insert(facets_.end(), more.begin(), more.end());
    }
    find_pairs(frame);
    if (!pairs_.empty()) draw_pairs(frame);
    frame.timer->end("projection");
  }
  void add_bytes(std::map<std::string, std::size_t>* bytes) const override {
    (*bytes)["projection"] = facet_buffer_.bytes() + pair_buffer_.bytes() + cluster_buffer_.bytes() +
                             vertex_buffer_.bytes() + triangle_buffer_.bytes() + box_buffer_.bytes() + raster_.bytes();
  }
  void add_counters(std::map<std::string, double>* counters) const override {
    (*counters)["mirror_triangles"] = static_cast<double>(facets_.size());
    (*counters)["mirrored_clusters"] = static_cast<double>(pairs_.size());
    (*counters)["projected_vertices"] = counts_[vertices];
    (*counters)["cubic_roots"] = counts_[roots];
    (*counters)["reflected_triangles"] = counts_[boxes];
    (*counters)["unplaced_triangles"] = counts_[footprints];
  }

 private:
  void update_clusters(const ReflectionFrame& frame) {
    if (cluster_buffer_ && epoch_ == frame.geometry_epoch) return;
    epoch_ = frame.geometry_epoch;
    clusters_ = make_clusters(frame.buffers->geometry());
    std::vector<ClusterRecord> records;
    for (const Cluster& c : clusters_.clusters)
      records.push_back({c.first_vertex, c.vertex_count, c.first_triangle, c.triangle_count});
    if (records.empty()) return;
    cluster_buffer_ = Buffer::from("clusters", records);
    vertex_buffer_ = Buffer::from("cluster vertices", clusters_.vertices);
    triangle_buffer_ = Buffer::from("cluster triangles", clusters_.triangles);
  }

  /// Which clusters may be seen in which facets.
  void find_pairs(const ReflectionFrame& frame) {
    std::vector<std::vector<glm::uvec2>> found(facets_.size());
    tbb::parallel_for(std::size_t{0}, facets_.size(), [&](std::size_t f) {
      const Facet& facet = facets_[f];
      for (std::size_t i = 0; i < clusters_.of_item.size(); ++i) {
        if (!(*frame.occluding)[i] || i == (*frame.reflectors)[facet.reflector].item) continue;
        const Bounds& bounds = frame.buffers->bounds(i);
        if (!may_meet(facet, bounds.center(), bounds.radius())) continue;
        for (std::size_t c = clusters_.of_item[i].begin; c < clusters_.of_item[i].end; ++c)
          if (may_meet(facet, clusters_.clusters[c].center, clusters_.clusters[c].radius))
            found[f].emplace_back(static_cast<unsigned>(f), static_cast<unsigned>(c));
      }
    });
    pairs_.clear();
    for (const auto& some : found) pairs_.insert(pairs_.end(), some.begin(), some.end());
  }

  void draw_pairs(const ReflectionFrame& frame) {
    facet_buffer_ = Buffer::from("mirror triangles", facet_texels(facets_));
    facet_view_ = Texture::make_buffer("mirror triangles", GL_RGBA32F, facet_buffer_);
    pair_buffer_ = Buffer::from("mirrored clusters", pairs_);
    if (!counters_) counters_ = Buffer("projection counters", sizeof(std::array<unsigned, counter_count>));
    if (!box_buffer_) make_boxes(std::size_t{1} << 17);
    std::array<unsigned, counter_count> counts = assemble(frame);
    if (counts[boxes] > box_capacity_) {
      if (counts[boxes] > kMostBoxes)
        throw Error("--reflections triangle",
                    std::to_string(counts[boxes]) +
                        " triangles in the reflectors are more than a storage buffer holds (" +
                        std::to_string(kMostBoxes) + ")",
                    "use --reflections octree");
      std::size_t capacity = box_capacity_;
      while (capacity < counts[boxes]) capacity *= 2;
      make_boxes(capacity);
      counts = assemble(frame);
    }
    for (std::size_t k = 0; k < counter_count; ++k) counts_[k] = counts[k];
    const Program& program = frame.programs->get(kDraw);
    raster_.draw(*frame.targets, [&] {
      glUseProgram(program.get());
      glBindVertexArray(raster_.vertex_array());
      glBindTextureUnit(55, box_view_.get());
      if (counts[boxes] > 0) glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(6 * counts[boxes]));
    });
  }

  void make_boxes(std::size_t capacity) {
    box_capacity_ = capacity;
    box_buffer_ = Buffer("reflected boxes", capacity * kBoxBytes);
    box_view_ = Texture::make_buffer("reflected boxes", GL_RGBA32F, box_buffer_);
  }

  std::array<unsigned, counter_count> assemble(const ReflectionFrame& frame) {
    const Program& program = frame.programs->get(kAssemble);
    counters_.clear_to_zero();
    glBindTextureUnit(54, facet_view_.get());
    const Buffer* buffers[] = {&pair_buffer_,     &cluster_buffer_, &vertex_buffer_,
                               &triangle_buffer_, &box_buffer_,     &counters_};
    for (GLuint k = 0; k < 6; ++k) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2 + k, buffers[k]->get());
    const int count = static_cast<int>(pairs_.size());
    program.set("u_count", count);
    program.set("u_box_capacity", static_cast<int>(box_capacity_));
    glUseProgram(program.get());
    glDispatchCompute(static_cast<GLuint>(std::min(count, kGroupsPerRow)),
                      static_cast<GLuint>((count + kGroupsPerRow - 1) / kGroupsPerRow), 1);
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
    std::array<unsigned, counter_count> counts{};
    counters_.read(0, sizeof counts, counts.data());
    return counts;
  }

  ClusterSet clusters_;
  std::uint32_t epoch_ = 0;
  std::vector<Facet> facets_;
  std::vector<glm::uvec2> pairs_;  ///< facet, cluster
  ReflectionRaster raster_;
  Buffer facet_buffer_, pair_buffer_, cluster_buffer_, vertex_buffer_, triangle_buffer_, box_buffer_, counters_;
  Texture facet_view_, box_view_;
  std::size_t box_capacity_ = 0;
  std::array<double, counter_count> counts_{};
};

}  // namespace

std::vector<ShaderVariant> triangle_shader_variants() { return {kAssemble, kDraw}; }

std::unique_ptr<ReflectorTechnique> make_triangle_reflections() { return std::make_unique<TriangleReflections>(); }

}  // namespace maquette
