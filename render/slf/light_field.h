#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "render/math/local_pca_fit.h"
#include "render/slf/incident_bake.h"
#include "render/slf/interactions.h"
#include "render/slf/outgoing.h"

namespace maquette {

struct CompressionOptions {
  int clusters = 128;  ///< 0: the fields are kept as they are
  int components = 8;
};
inline constexpr int kMostClusters = 256, kMostComponents = 16;

/// Everything a light field is made from, by value.
struct LightFieldJob {
  IncidentJob incident;
  std::shared_ptr<const Scene> scene;  ///< with the materials to show
  OutgoingOptions outgoing;
  CompressionOptions compression;
  bool interactions = false;          ///< slf.route=clusters
  std::vector<std::string> left_out;  ///< surfaces that get no texels although they were asked for, a line each
};

/// Outgoing radiance of an atlas, ready to be drawn.
struct LightField {
  LightFieldAtlas atlas;
  int side = Lumisphere::kDefaultSide;            ///< of the lumispheres
  LocalPcaFit fit;                                ///< of all texels; empty where nothing is compressed
  std::shared_ptr<const OutgoingField> outgoing;  ///< only where nothing is compressed
  std::shared_ptr<const IncidentBake> incident;   ///< what it was computed from
  LightFieldJob made_from;
  std::shared_ptr<const Interactions> interactions;  ///< instead of both: no outgoing light is stored
  std::vector<float> errors;                         ///< [texel] RMS of compression, relative to the mean of all texels
  double error = 0.0;                                ///< the same of all texels
  double coefficients = 0.0;                         ///< of incident light, used per texel and channel
  std::size_t reused = 0;                            ///< texels whose incident light an earlier run had made
  std::string stale;
  std::string exchanged;  ///< names of materials that look other than when they were baked
  /// Materials too specular for the lumispheres, surfaces without texels, and UV sets that are not used, a line each.
  std::vector<std::string> warnings;
  bool compressed() const { return fit.pca.cluster_count() > 0; }
};

/// Materials too specular, light that is another now, and materials whose reflection onto others is still that of the
/// material that was baked; a line each.
std::vector<std::string> notes_of(const LightField& field);

/// What is not as it was when the field was made, a line each: `now` is the job that would make it anew.
std::vector<std::string> changes_since(const LightField& field, const LightFieldJob& now);

/// What is kept between light fields of one incident bake, so that an exchange of materials traces nothing.
struct LightFieldMemory {
  std::string folder;
  IncidentProvenance provenance;
  std::shared_ptr<const IncidentBake> incident;
  MeasuredLibrary library;
  /// Takes LightField::warnings that are known before anything is traced; may be empty.
  std::function<void(const std::vector<std::string>&)> warn = {};
  /// Of the last field, unless it is large, with what it was computed from: another compression computes none.
  std::shared_ptr<const OutgoingField> outgoing;
  std::shared_ptr<const IncidentBake> outgoing_of;
  std::vector<std::uint64_t> outgoing_key;
  /// Of the covers that were shown last by slf.route=clusters, newest first: one that comes again costs its table.
  struct Terms {
    std::shared_ptr<const IncidentBake> incident;
    std::vector<std::uint64_t> key;
    std::shared_ptr<const InteractionTerms> terms;
  };
  std::deque<Terms> terms;
};

/// Geometry and materials to show; nothing is traced with it. `library`: is filled.
std::shared_ptr<const PathScene> build_material_scene(const LightFieldJob& job, MeasuredLibrary* library);
/// As the job says; textures filtered over a texel of the atlas.
OutgoingOptions outgoing_options(const LightFieldJob& job, const LightFieldAtlas& atlas);

/// Compresses outgoing radiance into `field`.
void compress(const std::shared_ptr<const OutgoingField>& outgoing, const CompressionOptions& options,
              const std::atomic<bool>& cancel, LightField* field);

/// Bakes or loads incident light, then makes and compresses outgoing light. Null once cancelled. Throws Error.
std::shared_ptr<const LightField> make_light_field(const LightFieldJob& job, LightFieldMemory* memory,
                                                   const std::atomic<bool>& cancel,
                                                   const std::function<void(double)>& progress);

/// A line for each material of the parts that is too specular for lumispheres of this side, with the side that would
/// do. `scene`: built from the materials to show.
std::vector<std::string> warn_of_specular(const PathScene& scene, const LightFieldAtlas& atlas, int side);
std::vector<std::string> warn_of_specular(const PathScene& scene, const std::vector<AtlasPart>& parts, int side);

/// A line for each part that has a second UV set which cannot be used.
std::vector<std::string> warn_of_second_uvs(const IncidentJob& job, const LightFieldAtlas& atlas);

/// Light that leaves some texels, computed anew from the light that arrives and the materials that are shown. Null once
/// cancelled. Throws Error.
std::shared_ptr<const OutgoingField> outgoing_of_texels(const LightField& field, std::span<const std::size_t> texels,
                                                        const std::atomic<bool>& cancel);

/// Outgoing radiance of a texel after compression, [3 bin + channel].
Eigen::VectorXf decode_texel(const LightField& field, std::size_t texel);

}  // namespace maquette
