#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "scenes/bake_file.h"
#include "scenes/scene.h"

namespace maquette {

struct FlatGeometry;
struct IncidentJob;

/// What a bake of incident light was made of, piece by piece, so that what differs can be named.
struct IncidentContents {
  std::map<std::string, std::uint64_t> surfaces;  ///< by path of the node: hash of where its surfaces lie
  std::vector<std::string> parts;                 ///< paths of the nodes with texels
  std::vector<std::uint64_t> materials;           ///< [material] looks_of
  std::map<std::string, std::uint64_t> shown;     ///< by path of the node: hash of which materials its surfaces show
  std::map<std::string, std::string> light;       ///< environment, rotation, scale, lamps
};

IncidentContents contents_of(const IncidentJob& job);
/// IncidentContents::shown of a scene.
std::map<std::string, std::uint64_t> shown_in(const Scene& scene, const FlatGeometry& geometry, int variant);
/// [material] hash of all that it looks like, texels of its textures among it.
std::vector<std::uint64_t> looks_of(const Scene& scene);

void write_contents(const IncidentContents& contents, std::map<std::string, std::string>* attributes);
/// Empty where the attributes have none.
IncidentContents read_contents(const std::map<std::string, std::string>& attributes);

/// What of the light is another, by name, as it is in the bake and now; empty: nothing that has one.
std::string light_difference(const IncidentContents& baked, const IncidentContents& now);

/// What of the surfaces or the parts with texels is another, by name; empty: nothing that has one.
std::string name_difference(const IncidentContents& baked, const IncidentContents& now);

}  // namespace maquette
