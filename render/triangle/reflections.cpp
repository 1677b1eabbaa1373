#include "render/triangle/reflections.h"

#include <algorithm>
#include <array>
#include <span>
#include <string>

#include "render/gl/bindings.h"
#include "render/reflections/nearest_hits.h"
#include "render/triangle/facets.h"
#include "scenes/error.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr std::size_t kFacetTexels = 22;
/// Largest number of pairs of mirror triangle and cluster in one batch.
constexpr std::size_t kMaxPairs = 32000;
constexpr std::size_t kKeptBytes = 8;
/// More pairs than this would take minutes and block the window (a cockpit's windshield has 20,000, which take a
/// quarter of a second on two cores).
constexpr std::size_t kMaxPairsPerFrame = 400000;

// The same order as in shaders/triangle/*.comp.
enum Counter { kept, boxes, roots, footprints, counter_count };

const ShaderVariant kCull{"triangle/cull.comp", "", {}}, kAssemble{"triangle/assemble.comp", "", {}};

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
    texels.insert(texels.end(), {f.sides[0], f.sides[1], f.sides[2], glm::vec4(f.widening, f.longest_px)});
  }
  return texels;
}

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
        hits_.find_nearest_planar(frame, r, clusters_);
        continue;
      }
      const GhostDeviation ghost = frame.ghost ? (*frame.ghost)[r] : GhostDeviation{};
      if (frame.ghost && ghost.offset_m == 0.0f) continue;  // no pane, or outside the picture
      const std::vector<Facet> more =
          make_facets(reflector, r, frame.buffers->geometry(), *frame.constants, side, ghost);
      facets_.insert(facets_.end(), more.begin(), more.end());
    }
    find_pairs(frame);
    if (pairs_.size() > kMaxPairsPerFrame)
      throw Error("--reflections triangle",
                  std::to_string(facets_.size()) + " triangles of reflectors would be tested against " +
                      std::to_string(pairs_.size()) + " parts of the scene, which would take minutes",
                  "use raytraced or octree, or name a smaller reflector with --reflector");
    if (!pairs_.empty()) {
      facet_buffer_ = Buffer::from("mirror triangles", facet_texels(facets_));
      facet_view_ = Texture::make_buffer("mirror triangles", GL_RGBA32F, facet_buffer_);
      const auto rest = std::stable_partition(pairs_.begin(), pairs_.end(),
                                              [&](const glm::uvec2& p) { return hits_.seen_groups()[p.y] != 0; });
      project_pairs(frame, {pairs_.begin(), rest});
      pairs_.erase(keep_visible(frame, rest), pairs_.end());
      project_pairs(frame, {rest, pairs_.end()});
    }
    hits_.finish(frame, 1, 0);
    frame.timer->end("projection");
  }
  void add_bytes(std::map<std::string, std::size_t>* bytes) const override {
    (*bytes)["projection"] = facet_buffer_.bytes() + pair_buffer_.bytes() + kept_buffer_.bytes() +
                             cluster_buffer_.bytes() + triangle_buffer_.bytes() + hits_.bytes();
  }
  void add_counters(std::map<std::string, double>* counters) const override {
    (*counters)["mirror_triangles"] = static_cast<double>(facets_.size());
    (*counters)["mirrored_clusters"] = static_cast<double>(pairs_.size());
    (*counters)["projected_vertices"] = 3.0 * counts_[kept];
    (*counters)["cubic_roots"] = counts_[roots];
    (*counters)["reflected_triangles"] = counts_[boxes];
    (*counters)["unplaced_triangles"] = counts_[footprints];
  }

 private:
  void update_clusters(const ReflectionFrame& frame) {
    if (cluster_buffer_ && epoch_ == frame.geometry_epoch) return;
    epoch_ = frame.geometry_epoch;
    clusters_ = make_clusters(frame.buffers->geometry());
    std::vector<glm::uvec2> records;  // first triangle, count
    std::vector<std::uint32_t> triangles;
    for (const Cluster& c : clusters_.clusters) records.emplace_back(c.first_triangle, c.triangle_count);
    for (const glm::uvec2& t : clusters_.triangles) triangles.push_back(t.y);
    if (records.empty()) return;
    hits_.set_groups(cluster_of_triangle(clusters_), records.size());
    cluster_buffer_ = Buffer::from("clusters", records);
    cluster_view_ = Texture::make_buffer("clusters", GL_RG32UI, cluster_buffer_);
    triangle_buffer_ = Buffer::from("cluster triangles", triangles);
    triangle_view_ = Texture::make_buffer("cluster triangles", GL_R32UI, triangle_buffer_);
  }

  /// Finds the clusters that may be visible in each facet.
  void find_pairs(const ReflectionFrame& frame) {
    std::vector<std::vector<glm::uvec2>> found(facets_.size());
    parallel_for(std::size_t{0}, facets_.size(), [&](std::size_t f) {
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
  /// End of the pairs of the first pair's reflector; the pairs are sorted by facet.
  template <typename Iterator>
  Iterator end_of_reflector(Iterator first, Iterator end) const {
    const std::size_t reflector = facets_[first->x].reflector;
    return std::find_if(first, end, [&](const glm::uvec2& p) { return facets_[p.x].reflector != reflector; });
  }

  /// Keeps, from `first` on, the pairs whose cluster a ray of their facet may hit before the nearest hit so far;
  /// returns the new end.
  Pairs::iterator keep_visible(const ReflectionFrame& frame, Pairs::iterator first) {
    const glm::vec2 size(frame.constants->size);
    Pairs::iterator kept = first;
    while (first != pairs_.end()) {
      const std::size_t reflector = facets_[first->x].reflector;
      const auto end = end_of_reflector(first, pairs_.end());
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

  void project_pairs(const ReflectionFrame& frame, std::span<const glm::uvec2> pairs) {
    if (!counters_) counters_ = Buffer("projection counters", sizeof(std::array<unsigned, counter_count>));
    while (!pairs.empty()) {
      const auto of_one = static_cast<std::size_t>(end_of_reflector(pairs.begin(), pairs.end()) - pairs.begin());
      const std::span<const glm::uvec2> some = pairs.first(std::min(of_one, kMaxPairs));
      hits_.bind_far(frame, facets_[some.front().x].reflector);
      hits_.find_nearest(
          frame, some.size(),
          [&](std::size_t begin, std::size_t end) { offer(frame, some.subspan(begin, end - begin)); },
          [&] {
            const std::array<unsigned, counter_count> counts = read_counters();
            for (std::size_t k = 0; k < counter_count; ++k) counts_[k] += counts[k];
          });
      pairs = pairs.subspan(some.size());
    }
  }

  std::array<unsigned, counter_count> read_counters() const {
    std::array<unsigned, counter_count> counts{};
    counters_.read(0, sizeof counts, counts.data());
    return counts;
  }

  void offer(const ReflectionFrame& frame, std::span<const glm::uvec2> pairs) {
    pair_buffer_ = Buffer("mirrored clusters", pairs.size_bytes(), pairs.data());
    const Texture pair_view = Texture::make_buffer("mirrored clusters", GL_RG32UI, pair_buffer_);
    std::size_t most = 0;
    for (const glm::uvec2& p : pairs) most += clusters_.clusters[p.y].triangle_count;
    if (kept_buffer_.bytes() < most * kKeptBytes) {
      kept_buffer_ = Buffer("mirrored triangles", most * kKeptBytes);
      kept_view_ = Texture::make_buffer("mirrored triangles", GL_RG32UI, kept_buffer_);
    }
    counters_.clear_to_zero();
    glBindTextureUnit(kUnitFacets, facet_view_.get());
    glBindTextureUnit(kUnitClusterPairs, pair_view.get());
    glBindTextureUnit(kUnitTriangleClusters, cluster_view_.get());
    glBindTextureUnit(kUnitClusterTriangles, triangle_view_.get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferKeptPairs, kept_buffer_.get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferPairCounters, counters_.get());
    const GhostDeviation& ghost = facets_[pairs.front().x].ghost;
    run(frame.programs->get(kCull), pairs.size(), Cluster::kMaxTriangles);
    const Program& assemble = frame.programs->get(kAssemble);
    glBindTextureUnit(kUnitKeptPairs, kept_view_.get());
    hits_.prepare(assemble);
    glProgramUniform2f(assemble.get(), assemble.location("u_ghost"), ghost.offset_m, ghost.turn);
    run(assemble, read_counters()[kept], 1);
  }

  /// Runs `each` invocations for each of `count` elements.
  static void run(const Program& program, std::size_t count, std::size_t each) {
    program.set("u_count", static_cast<int>(count));
    glUseProgram(program.get());
    glDispatchCompute(static_cast<GLuint>((count * each + 63) / 64), 1, 1);
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
  }

  ClusterSet clusters_;
  std::uint32_t epoch_ = 0;
  std::vector<Facet> facets_;
  std::vector<glm::uvec2> pairs_;  ///< facet, cluster
  NearestHits hits_;
  Buffer facet_buffer_, pair_buffer_, kept_buffer_, cluster_buffer_, triangle_buffer_, counters_;
  Texture facet_view_, kept_view_, cluster_view_, triangle_view_;
  std::array<double, counter_count> counts_{};
};

}  // namespace

std::vector<ShaderVariant> triangle_shader_variants() { return {kCull, kAssemble}; }

std::unique_ptr<ReflectorTechnique> make_triangle_reflections() { return std::make_unique<TriangleReflections>(); }

}  // namespace maquette
