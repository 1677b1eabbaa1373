#include "render/slf/light_field.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <set>

#include "render/bake/kept_bakes.h"
#include "render/parts/baked_parts.h"
#include "render/reference/path_scene.h"

namespace maquette {

namespace {

/// Bytes of outgoing light that are kept beside the compressed field.
constexpr std::size_t kMostKept = std::size_t{256} << 20;
/// Covers whose compressed terms are kept, some ten megabytes each.
constexpr std::size_t kMostTerms = 4;
/// Share of the progress that incident light takes.
constexpr double kIncidentShare = 0.9;

std::shared_ptr<const IncidentBake> find_incident(const LightFieldJob& job, LightFieldMemory* memory,
                                                  const std::atomic<bool>& cancel,
                                                  const std::function<void(double)>& progress) {
  const IncidentProvenance wanted = provenance_of(job.incident);
  if (memory->incident && memory->folder == job.incident.folder && memory->provenance == wanted)
    return memory->incident;
  memory->incident = nullptr;
  const auto baked = bake_incident(job.incident, {}, cancel, [&](double p) {
    if (progress) progress(kIncidentShare * p);
  });
  if (!baked) return nullptr;
  memory->incident = baked;
  memory->folder = job.incident.folder;
  memory->provenance = wanted;
  return baked;
}

/// Everything that outgoing light depends on besides the light that arrives.
std::vector<std::uint64_t> outgoing_key(const LightFieldJob& job, const OutgoingOptions& options) {
  std::vector<std::uint64_t> key{static_cast<std::uint64_t>(options.basis),
                                 std::bit_cast<std::uint64_t>(options.haar_error),
                                 std::bit_cast<std::uint32_t>(options.texel_m)};
  const std::vector<std::uint64_t> looks = looks_of(*job.scene);
  key.insert(key.end(), looks.begin(), looks.end());
  return key;
}

std::shared_ptr<const OutgoingField> find_outgoing(const LightFieldJob& job, const PathScene& materials,
                                                   const std::shared_ptr<const IncidentBake>& incident,
                                                   LightFieldMemory* memory, const std::atomic<bool>& cancel) {
  const OutgoingOptions options = outgoing_options(job, incident->atlas);
  std::vector<std::uint64_t> key = outgoing_key(job, options);
  if (memory->outgoing && memory->outgoing_of == incident && memory->outgoing_key == key) return memory->outgoing;
  memory->outgoing = nullptr;
  const auto outgoing = compute_outgoing(materials, incident->atlas, incident->field, options, cancel);
  if (!outgoing || static_cast<std::size_t>(outgoing->radiance.size()) * sizeof(float) > kMostKept) return outgoing;
  memory->outgoing = outgoing;
  memory->outgoing_of = incident;
  memory->outgoing_key = std::move(key);
  return outgoing;
}

std::shared_ptr<const InteractionTerms> find_terms(const LightFieldJob& job, const PathScene& materials,
                                                   const std::shared_ptr<const IncidentBake>& incident,
                                                   LightFieldMemory* memory, const std::atomic<bool>& cancel) {
  const OutgoingOptions options = outgoing_options(job, incident->atlas);
  LightFieldMemory::Terms wanted{incident, outgoing_key(job, options), nullptr};
  const auto known = std::ranges::find_if(
      memory->terms, [&](const LightFieldMemory::Terms& t) { return t.incident == incident && t.key == wanted.key; });
  if (known != memory->terms.end()) {
    wanted.terms = known->terms;
    memory->terms.erase(known);
  } else {
    wanted.terms =
        compress_interactions(materials, incident->atlas, incident->field, {.texel_m = options.texel_m}, cancel);
    if (!wanted.terms) return nullptr;
  }
  std::erase_if(memory->terms, [&](const LightFieldMemory::Terms& t) { return t.incident != incident; });
  memory->terms.push_front(wanted);
  if (memory->terms.size() > kMostTerms) memory->terms.pop_back();
  return wanted.terms;
}

/// Materials of `scene` whose looks are others than those of `before`.
std::string names_of_changed(const Scene& scene, const std::vector<std::uint64_t>& before) {
  const std::vector<std::uint64_t> looks = looks_of(scene);
  std::string names;
  for (std::size_t i = 0; i < std::min(looks.size(), before.size()); ++i)
    if (looks[i] != before[i]) names += (names.empty() ? "" : ", ") + scene.materials[i].name;
  return names;
}

/// Materials whose looks are others than in the bake, and parts that show other materials than there.
std::string exchanged_since(const LightFieldJob& job, const IncidentContents& baked) {
  std::string names = names_of_changed(*job.scene, baked.materials);
  for (const auto& [path, shown] : shown_in(*job.scene, *job.incident.geometry, job.incident.variant)) {
    const auto before = baked.shown.find(path);
    if (before != baked.shown.end() && before->second != shown)
      names += (names.empty() ? "" : ", ") + ("the material of " + path);
  }
  return names;
}

}  // namespace

std::shared_ptr<const PathScene> build_material_scene(const LightFieldJob& job, MeasuredLibrary* library) {
  auto dark = std::make_shared<Environment>();
  dark->width = 32;
  dark->height = 16;
  dark->rgb.assign(32 * 16, glm::vec3(0.0f));
  return build_path_scene({.scene = *job.scene,
                           .environment = dark,
                           .variant = job.incident.variant,
                           .geometry = job.incident.geometry.get(),
                           .library = library});
}

OutgoingOptions outgoing_options(const LightFieldJob& job, const LightFieldAtlas& atlas) {
  OutgoingOptions options = job.outgoing;
  options.texel_m = atlas.texels_per_m > 0.0 ? static_cast<float>(1.0 / atlas.texels_per_m) : 0.0f;
  return options;
}

void compress(const std::shared_ptr<const OutgoingField>& outgoing, const CompressionOptions& options,
              const std::atomic<bool>& cancel, LightField* field) {
  const Eigen::MatrixXf& radiance = outgoing->radiance;
  field->errors.assign(static_cast<std::size_t>(radiance.cols()), 0.0f);
  if (options.clusters == 0 || radiance.cols() == 0) {
    field->outgoing = outgoing;
    return;
  }
  const Eigen::VectorXf measure = outgoing_measure(Lumisphere(field->side));
  LocalPcaOptions pca;
  pca.clusters = options.clusters;
  pca.components = options.components;
  pca.rounds = 7;
  pca.stop = [&] { return cancel.load(); };
  field->fit = fit_local_pca(radiance, measure, pca);
  const double all = measure.cast<double>().sum();
  double sum = 0.0, squares = 0.0;
  for (Eigen::Index t = 0; t < radiance.cols(); ++t) sum += measure.cast<double>().dot(radiance.col(t).cast<double>());
  const double mean = sum / all / static_cast<double>(radiance.cols());
  if (!(mean > 0.0)) return;
  for (std::size_t t = 0; t < field->errors.size(); ++t) {
    squares += field->fit.errors[t];
    field->errors[t] = static_cast<float>(std::sqrt(field->fit.errors[t] / all) / mean);
  }
  field->error = std::sqrt(squares / all / static_cast<double>(radiance.cols())) / mean;
}

std::shared_ptr<const OutgoingField> outgoing_of_texels(const LightField& field, std::span<const std::size_t> texels,
                                                        const std::atomic<bool>& cancel) {
  LightFieldAtlas atlas = field.atlas;
  atlas.texels.clear();
  IncidentField incident;
  incident.side = field.side;
  incident.bins = field.incident->field.bins;
  incident.masked.assign(texels.size(), false);
  for (const std::size_t t : texels) {
    atlas.texels.push_back(field.atlas.texels[t]);
    const std::span<const float> light = field.incident->field.texel(t);
    incident.radiance.insert(incident.radiance.end(), light.begin(), light.end());
  }
  MeasuredLibrary library;
  const auto materials = build_material_scene(field.made_from, &library);
  return compute_outgoing(*materials, atlas, incident, outgoing_options(field.made_from, field.atlas), cancel);
}

Eigen::VectorXf decode_texel(const LightField& field, std::size_t texel) {
  if (!field.compressed()) return field.outgoing->radiance.col(static_cast<Eigen::Index>(texel));
  return field.fit.pca.decode({field.fit.owner[texel], field.fit.weights.col(static_cast<Eigen::Index>(texel))});
}

namespace {

std::vector<std::string> warn_of_triangles(const PathScene& scene, const std::set<std::uint32_t>& triangles, int side) {
  std::vector<std::string> warnings;
  std::set<const TracedMaterial*> seen;
  std::vector<std::uint32_t> traced_of(scene.geometry.indices.size() / 3, 0);
  for (std::uint32_t i = 0; i < scene.triangles.size(); ++i) traced_of[scene.triangles[i].source] = i;
  for (const std::uint32_t source : triangles) {
    const std::uint32_t triangle = traced_of[source];
    if (!seen.insert(&scene.material_of(triangle)).second) continue;
    const glm::vec3 n = scene.triangles[triangle].geometric;
    const glm::vec3 middle = (scene.triangles[triangle].positions[0] + scene.triangles[triangle].positions[1] +
                              scene.triangles[triangle].positions[2]) /
                             3.0f;
    const SurfacePoint p = resolve_surface(scene, {middle + n, -n}, {1.0f, triangle, glm::vec2(1.0f / 3.0f)}, {});
    const int wanted = lumisphere_side_for(peak_half_width(p));
    if (wanted <= side) continue;
    warnings.push_back("material " + p.material->values.name + " is too specular for lumispheres of " +
                       std::to_string(side) + " x " + std::to_string(side) + " directions; " +
                       (wanted <= Lumisphere::kLargestSide ? std::to_string(wanted) + " would do (slf.directions)"
                                                           : "another mode would do"));
  }
  return warnings;
}

}  // namespace

std::vector<std::string> warn_of_specular(const PathScene& scene, const LightFieldAtlas& atlas, int side) {
  std::set<std::uint32_t> triangles;
  for (const AtlasSide& s : atlas.sides) triangles.insert(s.triangle);
  return warn_of_triangles(scene, triangles, side);
}

std::vector<std::string> warn_of_specular(const PathScene& scene, const std::vector<AtlasPart>& parts, int side) {
  std::set<std::uint32_t> triangles;
  for (const AtlasPart& part : parts) {
    const DrawItem& item = scene.geometry.items[part.item];
    for (std::uint32_t i = 0; i + 2 < item.index_count; i += 3) triangles.insert((item.first_index + i) / 3);
  }
  return warn_of_triangles(scene, triangles, side);
}

std::vector<std::string> warn_of_second_uvs(const IncidentJob& job, const LightFieldAtlas& atlas) {
  std::vector<std::string> warnings;
  for (const auto& [item, fault] : atlas.own_charts) {
    if (fault == kNoSecondUvs) continue;
    const int node = job.geometry->items[item].node;
    warnings.push_back((node < 0 ? "a part" : job.scene->nodes[static_cast<std::size_t>(node)].name) +
                       ": charts are made here, as its second UV set cannot be used: " + fault);
  }
  return warnings;
}

std::vector<std::string> notes_of(const LightField& field) {
  std::vector<std::string> notes = field.warnings;
  if (!field.stale.empty()) notes.push_back("the light field is stale: " + field.stale);
  if (!field.exchanged.empty())
    notes.push_back("exchanged since the bake: " + field.exchanged +
                    "; light from them onto other parts is that of before");
  return notes;
}

std::vector<std::string> changes_since(const LightField& field, const LightFieldJob& now) {
  std::vector<std::string> changes;
  const IncidentProvenance wanted = provenance_of(now.incident), &baked = field.incident->provenance;
  if (wanted.geometry != baked.geometry) {
    const std::string which = name_difference(field.incident->contents, contents_of(now.incident));
    changes.push_back("stale: the light field was baked from other surfaces" +
                      (which.empty() ? "" : " (" + which + ")"));
  }
  if (wanted.light != baked.light) {
    const std::string which = light_difference(field.incident->contents, contents_of(now.incident));
    changes.push_back("stale: the light field was baked under other light" + (which.empty() ? "" : " (" + which + ")"));
  }
  const std::string names = names_of_changed(*now.scene, looks_of(*field.made_from.scene));
  if (!names.empty()) changes.push_back("the light field shows these materials as they were: " + names);
  return changes;
}

std::shared_ptr<const LightField> make_light_field(const LightFieldJob& job, LightFieldMemory* memory,
                                                   const std::atomic<bool>& cancel,
                                                   const std::function<void(double)>& progress) {
  // Before anything is traced: a material that cannot be shown is named at once.
  const std::shared_ptr<const PathScene> materials = build_material_scene(job, &memory->library);
  for (const AtlasPart& part : job.incident.parts) {
    const int index = material_of_item(*job.scene, job.incident.geometry->items[part.item], job.incident.variant);
    if (index < 0) continue;
    require_light_field_material(job.scene->materials[static_cast<std::size_t>(index)]);
  }
  std::vector<std::string> warnings = warn_of_specular(*materials, job.incident.parts, job.incident.options.side);
  warnings.insert(warnings.end(), job.left_out.begin(), job.left_out.end());
  if (memory->warn) memory->warn(warnings);
  const auto incident = find_incident(job, memory, cancel, progress);
  if (!incident) return nullptr;
  auto field = std::make_shared<LightField>();
  field->atlas = incident->atlas;
  field->side = incident->field.side;
  field->reused = incident->reused;
  field->stale = incident->stale;
  field->incident = incident;
  field->made_from = job;
  field->exchanged = exchanged_since(job, incident->contents);
  field->warnings = std::move(warnings);
  for (const std::string& line : warn_of_second_uvs(job.incident, incident->atlas)) field->warnings.push_back(line);
  if (job.interactions) {
    field->errors.assign(field->atlas.texels.size(), 0.0f);
    const auto terms = find_terms(job, *materials, incident, memory, cancel);
    field->interactions = terms ? compute_interactions(*terms, cancel) : nullptr;
    if (!field->interactions) return nullptr;
    if (progress) progress(1.0);
    return field;
  }
  const auto outgoing = find_outgoing(job, *materials, incident, memory, cancel);
  if (!outgoing) return nullptr;
  field->coefficients = outgoing->coefficients;
  compress(outgoing, job.compression, cancel, field.get());
  if (cancel) return nullptr;
  if (progress) progress(1.0);
  return field;
}

}  // namespace maquette
