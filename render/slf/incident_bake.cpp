#include "render/slf/incident_bake.h"

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <thread>

#include "render/bake/bake_attributes.h"
#include "render/bake/kept_bakes.h"
#include "render/lights/light_numbers.h"
#include "render/parts/baked_parts.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

namespace fs = std::filesystem;

constexpr const char *kManifestKind = "slf", *kBlockKind = "slf-incident";
constexpr const char* kVersion = "3";

/// What shines besides the environment's texels.
std::vector<float> numbers_of_light(const IncidentJob& job) {
  const Scene& scene = *job.scene;
  std::vector<float> numbers{std::remainder(job.options.env_rotation_rad, 2.0f * std::numbers::pi_v<float>),
                             job.options.env_scale};
  const std::vector<float> lamps = light_numbers(scene);
  numbers.insert(numbers.end(), lamps.begin(), lamps.end());
  for (const Material& m : scene.materials)
    numbers.insert(numbers.end(),
                   {m.emissive.x, m.emissive.y, m.emissive.z, static_cast<float>(m.emissive_texture.image)});
  return numbers;
}

std::map<std::string, std::string> attributes_of(const IncidentProvenance& p) {
  return {{"version", kVersion},
          {"scene", p.scene},
          {"geometry", hex(p.geometry)},
          {"light", hex(p.light)},
          {"materials", hex(p.materials)},
          {"atlas_side", std::to_string(p.atlas_side)},
          {"lumisphere_side", std::to_string(p.lumisphere_side)},
          {"paths", std::to_string(p.paths)}};
}

IncidentProvenance read_provenance(const std::string& path, const BakeFile& file) {
  const auto number = [&](const char* name) {
    return static_cast<int>(std::strtol(attribute(path, file, name).c_str(), nullptr, 10));
  };
  const auto hash = [&](const char* name) {
    return static_cast<std::uint64_t>(std::strtoull(attribute(path, file, name).c_str(), nullptr, 16));
  };
  if (attribute(path, file, "version") != kVersion) throw Error(path, "the bake has another version", "bake it again");
  return {attribute(path, file, "scene"), hash("geometry"),          hash("light"),  hash("materials"),
          number("atlas_side"),           number("lumisphere_side"), number("paths")};
}

std::string manifest_path(const std::string& folder) { return (fs::path(folder) / "bake.exr").string(); }
std::string block_path(const std::string& folder, std::size_t block) {
  char name[40];
  std::snprintf(name, sizeof name, "incident-%05zu.exr", block);
  return (fs::path(folder) / name).string();
}

std::size_t block_count(std::size_t texels) { return (texels + kIncidentBlock - 1) / kIncidentBlock; }

/// Text of what differs besides surfaces, or empty. Light and materials apart.
std::string difference(const IncidentProvenance& found, const IncidentProvenance& wanted) {
  if (found.scene != wanted.scene) return "scene " + found.scene + " instead of " + wanted.scene;
  if (found.atlas_side != wanted.atlas_side)
    return "an atlas of " + std::to_string(found.atlas_side) + " texels a side instead of " +
           std::to_string(wanted.atlas_side);
  if (found.lumisphere_side != wanted.lumisphere_side)
    return "lumispheres of " + std::to_string(found.lumisphere_side) + " bins a side instead of " +
           std::to_string(wanted.lumisphere_side);
  return {};
}

std::string key_of(const IncidentProvenance& provenance) { return key_of_attributes(attributes_of(provenance)); }

std::string read_kind(const BakeFile& file) {
  const auto found = file.attributes.find("kind");
  return found != file.attributes.end() ? found->second : "";
}

/// Reads the texels of a block, `masked.size()` of them: radiance [texel][bin][RGB]. Throws Error.
void read_block(const std::string& path, const std::string& key, std::size_t block, std::span<float> radiance,
                std::span<std::uint32_t> masked) {
  const BakeFile file = load_bake_file(path);
  if (read_kind(file) != kBlockKind) throw Error(path, "the file holds no incident light");
  if (attribute(path, file, "key") != key) throw Error(path, "the block is of another bake", "bake it again");
  if (attribute(path, file, "block") != std::to_string(block))
    throw Error(path, "the block is another one of the bake", "bake it again");
  const auto& stored = file.integers(path, "texels", "masked");
  if (stored.size() < masked.size()) throw Error(path, "the block is too short", "bake it again");
  static constexpr const char* kNames[] = {"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto& channel = file.floats(path, "radiance", kNames[c]);
    if (channel.size() < radiance.size() / 3) throw Error(path, "the block is too short", "bake it again");
    for (std::size_t i = 0; i < radiance.size() / 3; ++i) radiance[3 * i + c] = channel[i];
  }
  std::copy_n(stored.begin(), masked.size(), masked.begin());
}

/// One bake under way.
class Run {
 public:
  Run(const IncidentJob& job, const BakeRanks& ranks, const std::atomic<bool>& cancel,
      const std::function<void(double)>& progress)
      : job_(job),
        ranks_(ranks),
        cancel_(cancel),
        progress_(progress),
        bake_(std::make_shared<IncidentBake>()),
        patience_(ranks) {}

  std::shared_ptr<const IncidentBake> make() {
    bake_->atlas = make_atlas(*job_.geometry, job_.parts, job_.atlas);
    bake_->provenance = provenance_of(job_);
    bake_->provenance.atlas_side = bake_->atlas.side;
    bake_->contents = contents_of(job_);
    const Lumisphere lumisphere(job_.options.side);
    IncidentField& field = bake_->field;
    field.side = lumisphere.side();
    field.bins = lumisphere.count();
    field.masked.assign(bake_->atlas.texels.size(), false);
    field.radiance.assign(field.masked.size() * stride(), 0.0f);
    masked_.assign(field.masked.size(), 0);
    check_manifest();
    load_blocks();
    if (!job_.may_make && done_ < blocks()) fail_incomplete();
    if (!trace_blocks() || !await_others()) return nullptr;
    for (std::size_t t = 0; t < masked_.size(); ++t) field.masked[t] = masked_[t] != 0;
    fill_masked_texels(field.masked, &bake_->atlas);
    if (progress_) progress_(1.0);
    return bake_;
  }

 private:
  std::size_t stride() const { return static_cast<std::size_t>(3 * bake_->field.bins); }
  std::size_t texels() const { return bake_->atlas.texels.size(); }
  std::size_t blocks() const { return block_count(texels()); }
  std::size_t first(std::size_t block) const { return block * kIncidentBlock; }
  std::size_t end(std::size_t block) const { return std::min(first(block) + kIncidentBlock, texels()); }

  void check_manifest() {
    if (job_.folder.empty()) return;
    const std::string path = manifest_path(job_.folder);
    std::error_code ignored;
    if (!fs::exists(path, ignored)) {
      if (!job_.may_make) throw Error(job_.folder, "there is no surface light field", "make it: maquette bake slf");
      if (ranks_.rank == 0 || ranks_.count == 1) write_manifest(path);
      return;
    }
    IncidentContents contents;
    try {
      const BakeFile file = load_bake_file(path);
      found_ = read_provenance(path, file);
      contents = read_contents(file.attributes);
    } catch (const Error&) {
      if (!job_.may_make) throw;
      return write_manifest(path);
    }
    IncidentProvenance& wanted = bake_->provenance;
    if (const std::string other = difference(found_, wanted); !other.empty())
      throw Error(job_.folder, "the light field was baked from " + other,
                  "name another folder, or remove it and bake again");
    if (found_.geometry != wanted.geometry) {
      const std::string which = name_difference(contents, bake_->contents);
      throw Error(job_.folder,
                  contents.surfaces == bake_->contents.surfaces && !which.empty()
                      ? "the light field was baked for other parts of scene " + found_.scene + " (" + which + ")"
                      : "the light field was baked from another geometry of scene " + found_.scene +
                            (which.empty() ? " (normals, texture coordinates or order)" : " (" + which + ")"),
                  "name another folder, or remove it and bake again");
    }
    if (found_.light != wanted.light) {
      const std::string which = light_difference(contents, bake_->contents);
      bake_->stale = "it was baked under other light" + (which.empty() ? "" : " (" + which + ")");
      if (job_.may_make || !job_.show_stale)
        throw Error(job_.folder, "the light field is stale: " + bake_->stale,
                    job_.may_make ? "name another folder, or remove it and bake again"
                                  : "bake it under this light (maquette bake slf takes --env, --env-rotation and "
                                    "--env-scale), or show it: --set slf.stale=show");
    }
    if (job_.may_make && (found_.materials != wanted.materials || found_.paths != wanted.paths))
      throw Error(job_.folder,
                  found_.paths != wanted.paths
                      ? "the light field was begun with " + std::to_string(found_.paths) + " paths a bin"
                      : "the light field was begun with other materials",
                  "name another folder, or remove it and bake again");
    if (job_.may_make) return;
    wanted = found_;
    bake_->contents = std::move(contents);
  }

  void write_manifest(const std::string& path) {
    try {
      std::error_code ignored;
      fs::create_directories(job_.folder, ignored);
      BakeFile file;
      file.attributes = attributes_of(bake_->provenance);
      file.attributes["kind"] = kManifestKind;
      file.attributes["texels"] = std::to_string(texels());
      file.attributes["scene_file"] = job_.scene->name;
      write_contents(bake_->contents, &file.attributes);
      BakeTable table{"texels", {}, {}};
      auto &x = table.integers["x"], &y = table.integers["y"], &triangle = table.integers["triangle_number"];
      for (const AtlasTexel& t : bake_->atlas.texels) {
        x.push_back(t.x);
        y.push_back(t.y);
        triangle.push_back(bake_->atlas.sides[t.side].triangle);
      }
      file.tables.push_back(std::move(table));
      save_bake_file(path, file);
    } catch (const Error&) {
      if (job_.must_work) throw;
    }
  }

  void load_blocks() {
    have_.assign(blocks(), false);
    if (job_.folder.empty()) return;
    for (std::size_t b = 0; b < blocks() && !cancel_; ++b)
      if (load_block(b)) bake_->reused += end(b) - first(b);
  }

  /// False where there is none. One that is damaged counts as none where it can be made again.
  bool load_block(std::size_t block) {
    const std::string path = block_path(job_.folder, block);
    std::error_code ignored;
    if (!fs::exists(path, ignored)) return false;
    try {
      read_block(
          path, key_of(bake_->provenance), block,
          std::span(bake_->field.radiance).subspan(first(block) * stride(), (end(block) - first(block)) * stride()),
          std::span(masked_).subspan(first(block), end(block) - first(block)));
    } catch (const Error&) {
      if (!job_.may_make) throw;
      return false;
    }
    have_[block] = true;
    ++done_;
    report();
    return true;
  }

  void save_block(std::size_t block) {
    if (job_.folder.empty()) return;
    BakeFile file;
    file.attributes = {{"kind", kBlockKind}, {"key", key_of(bake_->provenance)}, {"block", std::to_string(block)}};
    BakeTable radiance{"radiance", {}, {}}, state{"texels", {}, {}};
    static constexpr const char* kNames[] = {"R", "G", "B"};
    for (std::size_t c = 0; c < 3; ++c) {
      auto& channel = radiance.floats[kNames[c]];
      for (std::size_t i = first(block) * stride() + c; i < end(block) * stride(); i += 3)
        channel.push_back(bake_->field.radiance[i]);
    }
    auto& masked = state.integers["masked"];
    masked.assign(masked_.begin() + static_cast<std::ptrdiff_t>(first(block)),
                  masked_.begin() + static_cast<std::ptrdiff_t>(end(block)));
    file.tables = {std::move(state), std::move(radiance)};
    try {
      std::error_code ignored;
      fs::create_directories(job_.folder, ignored);
      save_bake_file(block_path(job_.folder, block), file);
    } catch (const Error&) {
      if (job_.must_work) throw;
    }
  }

  bool trace_blocks() {
    for (std::size_t b = 0; b < blocks(); ++b)
      if (!have_[b] && ranks_.has(b) && !trace_block(b)) return false;
    return true;
  }

  bool trace_block(std::size_t b) {
    if (cancel_) return false;
    const auto begin = RankPatience::Clock::now();
    if (!tracer_) tracer_ = make_tracer();
    parallel_for(first(b), end(b), [&](std::size_t t) {
      if (cancel_) return;
      masked_[t] = tracer_->trace(t, std::span(bake_->field.radiance).subspan(t * stride(), stride())) ? 1u : 0u;
    });
    if (cancel_) return false;
    save_block(b);
    have_[b] = true;
    ++done_;
    patience_.made_block(begin);
    report();
    return true;
  }

  bool await_others() {
    patience_.begin(blocks() - done_);
    while (done_ < blocks()) {
      if (cancel_) return false;
      bool any = false;
      std::size_t missing = blocks();  // the last one: a process that is only slow goes through them from the first
      for (std::size_t b = 0; b < blocks(); ++b) {
        if (have_[b]) continue;
        const bool came = load_block(b);
        any |= came;
        if (!came) missing = b;
      }
      if (any) patience_.block_came();
      if (missing == blocks() || any) continue;
      if (!patience_.is_over())
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
      else if (!trace_block(missing))
        return false;
    }
    return true;
  }

  std::unique_ptr<IncidentTracer> make_tracer() const {
    const auto scene = build_path_scene({.scene = *job_.scene,
                                         .environment = job_.environment,
                                         .variant = job_.variant,
                                         .geometry = job_.geometry.get()});
    return std::make_unique<IncidentTracer>(scene, std::make_shared<const LightFieldAtlas>(bake_->atlas), job_.options);
  }

  [[noreturn]] void fail_incomplete() const {
    throw Error(
        job_.folder,
        "the light field is not complete: " + std::to_string(done_) + " of " + std::to_string(blocks()) + " blocks",
        "finish it: maquette bake slf");
  }
  void report() const {
    if (progress_) progress_(static_cast<double>(done_) / static_cast<double>(blocks()));
  }

  const IncidentJob& job_;
  const BakeRanks ranks_;
  const std::atomic<bool>& cancel_;
  const std::function<void(double)>& progress_;
  std::shared_ptr<IncidentBake> bake_;
  IncidentProvenance found_;
  std::vector<std::uint32_t> masked_;  ///< words: threads write neighbours
  std::vector<bool> have_;
  std::size_t done_ = 0;
  std::unique_ptr<IncidentTracer> tracer_;
  RankPatience patience_;
};

}  // namespace

IncidentProvenance provenance_of(const IncidentJob& job) {
  const FlatGeometry& g = *job.geometry;
  IncidentProvenance p;
  p.scene = bake_name_of_scene(job.scene->name);
  std::vector<std::uint64_t> parts;
  for (const AtlasPart& part : job.parts) parts.push_back(2 * part.item + (part.both_sides ? 1 : 0));
  p.geometry = chain_hash(parts, 0);
  p.geometry = chain_hash(g.positions, p.geometry);
  p.geometry = chain_hash(g.normals, p.geometry);
  p.geometry = chain_hash(g.indices, p.geometry);
  p.geometry = chain_hash(g.uv0, p.geometry);
  p.geometry = chain_hash(g.uv1, p.geometry);
  p.geometry = chain_hash(g.colors, p.geometry);
  p.light = chain_hash(numbers_of_light(job), job.environment ? job.environment->hash : 0);
  if (job.environment && job.environment->hash == 0) p.light = chain_hash(job.environment->rgb, p.light);
  // What each part shows: two parts that exchange their materials are other surfaces, although no material has changed.
  const std::vector<std::uint64_t> looks = looks_of(*job.scene);
  std::vector<std::uint64_t> shown;
  for (const DrawItem& item : g.items) {
    const int material = material_of_item(*job.scene, item, job.variant);
    shown.push_back(material < 0 ? 0 : looks[static_cast<std::size_t>(material)]);
  }
  p.materials = chain_hash(shown, chain_hash(looks, static_cast<std::uint64_t>(job.variant + 1)));
  p.atlas_side = job.atlas.side;
  p.lumisphere_side = job.options.side;
  p.paths = job.options.paths;
  return p;
}

std::string incident_key(const IncidentJob& job) {
  std::string text;
  for (const auto& [name, value] : attributes_of(provenance_of(job))) text += name + "=" + value + ";";
  text += std::to_string(job.atlas.texels_per_m);
  return hex(content_hash(std::as_bytes(std::span(text))));
}

std::string incident_folder(const std::string& folder, const std::string& scene, const std::string& key) {
  if (!folder.empty()) {
    std::error_code ignored;
    if (fs::exists(manifest_path(folder), ignored)) return folder;
    return (fs::path(folder) / (bake_name_of_scene(scene) + "-slf")).string();
  }
  const auto cache = cache_folder();
  return cache ? (*cache / ("slf-" + key)).string() : std::string();
}

std::string incident_folder(const std::string& folder, const IncidentJob& job) {
  return incident_folder(folder, job.scene->name, folder.empty() ? incident_key(job) : std::string());
}

std::shared_ptr<const IncidentBake> bake_incident(const IncidentJob& job, const BakeRanks& ranks,
                                                  const std::atomic<bool>& cancel,
                                                  const std::function<void(double)>& progress) {
  return Run(job, ranks, cancel, progress).make();
}

bool is_incident_folder(const std::string& folder) {
  const std::string path = manifest_path(folder);
  std::error_code ignored;
  return fs::exists(path, ignored) && read_kind(load_bake_file(path)) == kManifestKind;
}

IncidentSummary summarize_incident(const std::string& folder) {
  const std::string path = manifest_path(folder);
  const BakeFile file = load_bake_file(path);
  if (read_kind(file) != kManifestKind) throw Error(path, "the bake is no surface light field");
  IncidentSummary summary;
  summary.provenance = read_provenance(path, file);
  summary.texels = std::strtoull(attribute(path, file, "texels").c_str(), nullptr, 10);
  summary.blocks = block_count(summary.texels);
  const auto scene = file.attributes.find("scene_file");
  if (scene != file.attributes.end()) summary.scene_file = scene->second;
  summary.contents = read_contents(file.attributes);
  std::error_code ignored;
  for (std::size_t b = 0; b < summary.blocks; ++b)
    summary.blocks_done += fs::exists(block_path(folder, b), ignored) ? 1 : 0;
  return summary;
}

bool is_whole_incident(const std::string& folder) {
  try {
    if (!is_incident_folder(folder)) return false;
    const IncidentSummary summary = summarize_incident(folder);
    return summary.blocks_done == summary.blocks;
  } catch (const Error&) {
    return false;
  }
}

IncidentField load_incident(const std::string& folder, const IncidentSummary& summary) {
  const IncidentProvenance& p = summary.provenance;
  if (p.lumisphere_side < 1 || p.lumisphere_side > Lumisphere::kLargestSide ||
      summary.texels > static_cast<std::size_t>(kLargestAtlas) * static_cast<std::size_t>(kLargestAtlas))
    throw Error(folder, "the sizes of the light field are out of range", "bake it again");
  IncidentField field;
  field.side = p.lumisphere_side;
  field.bins = Lumisphere(field.side).count();
  const std::size_t stride = static_cast<std::size_t>(3 * field.bins);
  const std::string key = key_of(p);
  for (std::size_t b = 0; b < summary.blocks; ++b) {
    const std::size_t first = b * kIncidentBlock, count = std::min(kIncidentBlock, summary.texels - first);
    std::vector<std::uint32_t> masked(count);
    std::vector<float> radiance(count * stride);
    read_block(block_path(folder, b), key, b, radiance, masked);
    field.radiance.insert(field.radiance.end(), radiance.begin(), radiance.end());
    for (const std::uint32_t m : masked) field.masked.push_back(m != 0);
  }
  return field;
}

}  // namespace maquette
