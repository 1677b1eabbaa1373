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
        hits_.offer_planar(frame, r, clusters_);
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
      offer_pairs(frame, {pairs_.begin(), rest});
      hits_.offer_large(frame);
      const std::vector<float> far_m = find_far(frame);
      const auto end = std::remove_if(rest, pairs_.end(), [&](const glm::uvec2& p) {
        const Cluster& c = clusters_.clusters[p.y];
        const Beam& beam = facets_[p.x].beam;
        return glm::length(c.center - beam.base) - c.radius - beam.base_radius > far_m[p.x];
      });
      offer_pairs(frame, {rest, end});
      pairs_.erase(end, pairs_.end());
    }
    hits_.offer_large(frame);
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

  /// Of each facet: how far away the farthest of what has been found in its box is, m.
  std::vector<float> find_far(const ReflectionFrame& frame) {
    const glm::vec2 size(frame.constants->size);
    const glm::ivec2 tiles = (glm::ivec2(frame.constants->size) + 7) / 8;
    std::vector<float> far_m(facets_.size(), 0.0f), of_tile;
    std::size_t reflector = frame.reflectors->size();
    for (std::size_t f = 0; f < facets_.size(); ++f) {
      if (facets_[f].reflector != reflector) {
        reflector = facets_[f].reflector;
        of_tile = hits_.read_far(frame, reflector);
      }
      const glm::vec4& box = facets_[f].box;
      const glm::vec2 low = (0.5f + 0.5f * glm::vec2(box.x, -box.w)) * size,
                      high = (0.5f + 0.5f * glm::vec2(box.z, -box.y)) * size;
      const glm::ivec2 from = glm::clamp(glm::ivec2(low) / 8, glm::ivec2(0), tiles - 1),
                       to = glm::clamp(glm::ivec2(high) / 8, glm::ivec2(0), tiles - 1);
      for (int y = from.y; y <= to.y; ++y)
        for (int x = from.x; x <= to.x; ++x)
          far_m[f] = std::max(far_m[f], of_tile[static_cast<std::size_t>(y * tiles.x + x)]);
    }
    return far_m;
  }

  void offer_pairs(const ReflectionFrame& frame, std::span<const glm::uvec2> pairs) {
    if (pairs.empty()) return;
    pair_buffer_ = Buffer("mirrored clusters", pairs.size_bytes(), pairs.data());
    if (!counters_) counters_ = Buffer("projection counters", sizeof(std::array<unsigned, counter_count>));
    const std::array<unsigned, counter_count> counts = assemble(frame, static_cast<int>(pairs.size()));
    for (std::size_t k = 0; k < counter_count; ++k) counts_[k] += counts[k];
  }

  std::array<unsigned, counter_count> assemble(const ReflectionFrame& frame, int count) {
    const Program& program = frame.programs->get(kAssemble);
    counters_.clear_to_zero();
    glBindTextureUnit(54, facet_view_.get());
    const Buffer* buffers[] = {&pair_buffer_, &cluster_buffer_, &vertex_buffer_, &triangle_buffer_, &counters_};
    for (GLuint k = 0; k < 5; ++k) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2 + k, buffers[k]->get());
    program.set("u_count", count);
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
