#include "render/triangle/reflections.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <span>

#include "render/reflections/nearest_hits.h"
#include "render/triangle/facets.h"

namespace maquette {

namespace {

constexpr std::size_t kFacetTexels = 22;
constexpr int kGroupsPerRow = 32768;

enum Counter { boxes, roots, vertices, footprints, counter_count };

const ShaderVariant kAssemble{"triangle/assemble.comp", "", {}};

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
    hits_.begin(*frame.targets);
    counts_.fill(0);
    facets_.clear();
    const int side = frame.settings->get_int("triangle.side");
    for (std::size_t r = 0; r < frame.reflectors->size(); ++r) {
      const Reflector& reflector = (*frame.reflectors)[r];
      if (reflector.plane) {
        hits_.take_planar(frame, r, clusters_);
        continue;
      }
      const std::vector<Facet> more = make_facets(reflector, r, frame.buffers->geometry(), *frame.constants, side);
      facets_.insert(facets_.end(), more.begin(), more.end());
    }
    find_pairs(frame);
    if (!pairs_.empty()) {
      facet_buffer_ = Buffer::from("mirror triangles", facet_texels(facets_));
      facet_view_ = Texture::make_buffer("mirror triangles", GL_RGBA32F, facet_buffer_);
      const auto rest = std::stable_partition(pairs_.begin(), pairs_.end(),
                                              [&](const glm::uvec2& p) { return hits_.seen_groups()[p.y] != 0; });
      take_pairs(frame, {pairs_.begin(), rest});
      pairs_.erase(keep_visible(frame, rest), pairs_.end());
      take_pairs(frame, {rest, pairs_.end()});
    }
    hits_.finish(frame, 1, 0);
    frame.timer->end("projection");
  }
  void add_bytes(std::map<std::string, std::size_t>* bytes) const override {
    (*bytes)["projection"] = facet_buffer_.bytes() + pair_buffer_.bytes() + cluster_buffer_.bytes() +
                             vertex_buffer_.bytes() + triangle_buffer_.bytes() + hits_.bytes();
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
    hits_.set_groups(cluster_of_triangle(clusters_), records.size());
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

  using Pairs = std::vector<glm::uvec2>;
  /// Of the pairs from `first` on those whose cluster some ray of their facet may meet before what has been found; the
  /// end of what is left.
  Pairs::iterator keep_visible(const ReflectionFrame& frame, Pairs::iterator first) {
    const glm::vec2 size(frame.constants->size);
    Pairs::iterator kept = first;
    while (first != pairs_.end()) {
      const std::size_t reflector = facets_[first->x].reflector;
      const auto end =
          std::find_if(first, pairs_.end(), [&](const glm::uvec2& p) { return facets_[p.x].reflector != reflector; });
      std::vector<glm::vec4> boxes;
      for (auto pair = first; pair != end; ++pair) {
        const Cluster& c = clusters_.clusters[pair->y];
        const glm::vec4& box = facets_[pair->x].box;
        boxes.emplace_back(c.center - c.half_extent, 0.0f);
        boxes.emplace_back(c.center + c.half_extent, 0.0f);
        boxes.emplace_back((0.5f + 0.5f * glm::vec2(box.x, -box.w)) * size,
                           (0.5f + 0.5f * glm::vec2(box.z, -box.y)) * size);
      }
      const std::vector<std::uint32_t> visible =
          hits_.find_visible(frame, reflector, Buffer::from("boxes of clusters", boxes));
      for (std::size_t k = 0; first != end; ++k, ++first)
        if (visible[k] != 0) *kept++ = *first;
    }
    return kept;
  }

  void take_pairs(const ReflectionFrame& frame, std::span<const glm::uvec2> pairs) {
    if (pairs.empty()) return;
    if (!counters_) counters_ = Buffer("projection counters", sizeof(std::array<unsigned, counter_count>));
    std::array<unsigned, counter_count> counts{};
    hits_.take(
        frame, pairs.size(),
        [&](std::size_t begin, std::size_t end) {
          const std::span<const glm::uvec2> some = pairs.subspan(begin, end - begin);
          pair_buffer_ = Buffer("mirrored clusters", some.size_bytes(), some.data());
          counts = assemble(frame, static_cast<int>(some.size()));
        },
        [&] {
          for (std::size_t k = 0; k < counter_count; ++k) counts_[k] += counts[k];
        });
  }

  std::array<unsigned, counter_count> assemble(const ReflectionFrame& frame, int count) {
    const Program& program = frame.programs->get(kAssemble);
    counters_.clear_to_zero();
    glBindTextureUnit(54, facet_view_.get());
    const Buffer* buffers[] = {&pair_buffer_, &cluster_buffer_, &vertex_buffer_, &triangle_buffer_, &counters_};
    for (GLuint k = 0; k < 5; ++k) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2 + k, buffers[k]->get());
    program.set("u_count", count);
    hits_.prepare(program, false);
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
  NearestHits hits_;
  Buffer facet_buffer_, pair_buffer_, cluster_buffer_, vertex_buffer_, triangle_buffer_, counters_;
  Texture facet_view_;
  std::array<double, counter_count> counts_{};
};

}  // namespace

std::vector<ShaderVariant> triangle_shader_variants() { return {kAssemble}; }

std::unique_ptr<ReflectorTechnique> make_triangle_reflections() { return std::make_unique<TriangleReflections>(); }

}  // namespace maquette
