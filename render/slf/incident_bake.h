#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "render/bake/bake_ranks.h"
#include "render/slf/incident.h"
#include "render/slf/incident_contents.h"
#include "scenes/environment.h"

namespace maquette {

/// What a bake of incident light was made of: written into its files, and compared with what is asked for.
struct IncidentProvenance {
  std::string scene;            ///< its name, for messages
  std::uint64_t geometry = 0;   ///< hash of all surfaces that stop or pass light, and of the parts with texels
  std::uint64_t light = 0;      ///< hash of environment, its rotation and scale, lamps and emissive surfaces
  std::uint64_t materials = 0;  ///< hash of the materials that light was reflected by
  int atlas_side = 0, lumisphere_side = 0, paths = 0;
  bool operator==(const IncidentProvenance&) const = default;
};

/// All that incident light is baked from, by value.
struct IncidentJob {
  std::shared_ptr<const Scene> scene;  ///< with the materials to bake with; hidden nodes are not visible
  std::shared_ptr<const FlatGeometry> geometry;
  std::shared_ptr<const Environment> environment;
  int variant = -1;
  std::vector<AtlasPart> parts;
  AtlasOptions atlas;
  IncidentOptions options;
  std::string folder;       ///< of the bake's files; empty: it is kept in memory only
  bool must_work = false;   ///< the folder was named by the user: what is damaged or cannot be written is an error
  bool may_make = true;     ///< false: only what the folder holds is taken, and it must be whole
  bool show_stale = false;  ///< with `may_make` false: also a bake of other light
};

struct IncidentBake {
  LightFieldAtlas atlas;  ///< masked texels filled
  IncidentField field;
  IncidentProvenance provenance;
  IncidentContents contents;  ///< of what it was baked from
  std::size_t reused = 0;     ///< texels that an earlier run had made
  std::string stale;          ///< what it was made of that has changed; empty: nothing
};

IncidentProvenance provenance_of(const IncidentJob& job);
/// Of all that the bake of a job depends on, before its atlas is made: 16 hexadecimal digits.
std::string incident_key(const IncidentJob& job);
/// Where the bake of a scene is kept: below `folder`, or, where that is empty, in the cache by `key`. Empty without
/// either.
std::string incident_folder(const std::string& folder, const std::string& scene, const std::string& key);
std::string incident_folder(const std::string& folder, const IncidentJob& job);  ///< the same of a job

/// Texels are traced and written in blocks of so many: what a run that was stopped leaves whole.
inline constexpr std::size_t kIncidentBlock = 1024;

/// Loads the blocks that the folder holds, traces the others and writes each when it is done. Null once `cancel` is
/// set. Throws Error: a bake of another scene or geometry, of other light where that may not be shown, damaged files
/// or a full disk where `must_work`; what was written stays. The result is the same for any count of threads, ranks and
/// interruptions.
std::shared_ptr<const IncidentBake> bake_incident(const IncidentJob& job, const BakeRanks& ranks,
                                                  const std::atomic<bool>& cancel,
                                                  const std::function<void(double)>& progress);

/// What a folder holds, without the scene that it was made of.
struct IncidentSummary {
  IncidentProvenance provenance;
  IncidentContents contents;
  std::string scene_file;  ///< as it was named for the bake
  std::size_t texels = 0, blocks = 0, blocks_done = 0;
};
/// Whether the folder holds a bake of this kind, whole or not.
bool is_incident_folder(const std::string& folder);
IncidentSummary summarize_incident(const std::string& folder);  ///< Throws Error.
/// Whether it holds all of one.
bool is_whole_incident(const std::string& folder);
/// The light of a whole bake. Throws Error where a block is missing or damaged.
IncidentField load_incident(const std::string& folder, const IncidentSummary& summary);

}  // namespace maquette
