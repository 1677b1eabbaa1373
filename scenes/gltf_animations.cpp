// Animations of nodes. One that is damaged is left out with a warning: the scene is whole without it.
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>

#include "scenes/error.h"
#include "scenes/gltf_document.h"

namespace maquette::gltf {
namespace {

using Property = AnimatedNode::Property;
using Interpolation = AnimationTrack::Interpolation;

constexpr const char* kDamagedAnimation = "the animation is damaged; export it again";
/// Keys of all animations of a file: sparse accessors ask for any number of them with few bytes.
constexpr std::size_t kMostKeys = std::size_t{1} << 22;

std::string text_of(const Json& object, const char* key) {
  const auto found = object.is_object() ? object.find(key) : object.end();
  return object.is_object() && found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

/// Index into an array of the file. Throws Error.
std::size_t index_of(const Json& object, const char* key, std::size_t size, const std::string& where) {
  if (!object.is_object() || !object.contains(key) || !object[key].is_number_unsigned() ||
      object[key].get<std::size_t>() >= size)
    throw Error(where, std::string(key) + " is missing or no index of what the file has", kDamagedAnimation);
  return object[key].get<std::size_t>();
}

const Json& list_of(const Json& object, const char* key, const std::string& where) {
  if (!object.is_object() || !object.contains(key) || !object[key].is_array())
    throw Error(where, std::string("it has no ") + key, kDamagedAnimation);
  return object[key];
}

Interpolation interpolation_of(const Json& sampler, const std::string& where) {
  const std::string name = text_of(sampler, "interpolation");
  if (name.empty() || name == "LINEAR") return Interpolation::linear;
  if (name == "STEP") return Interpolation::step;
  if (name == "CUBICSPLINE") return Interpolation::cubic;
  throw Error(where, "interpolation " + name_text(name) + " is not one of STEP, LINEAR, CUBICSPLINE",
              kDamagedAnimation);
}

class AnimationReader {
 public:
  AnimationReader(Document* document, const std::vector<int>& scene_nodes, std::size_t index)
      : document_(*document),
        scene_nodes_(scene_nodes),
        json_(document->root["animations"][index]),
        element_(element("animations", index)),
        where_(at(document->path, element_)) {}

  /// Throws Error.
  Animation read() {
    Animation animation;
    animation.name = text_of(json_, "name");
    const Json& channels = list_of(json_, "channels", where_);
    for (std::size_t i = 0; i < channels.size(); ++i) read_channel(channels[i], i, &animation);
    for (const AnimatedNode& node : animation.nodes)
      for (const AnimationTrack& track : node.tracks)
        if (!track.times_s.empty())
          animation.duration_s = std::max(animation.duration_s, static_cast<double>(track.times_s.back()));
    return animation;
  }

 private:
  std::string named(std::size_t node) const {
    return "node " + name_text(document_.model.nodes[node].name) + " (" + std::to_string(node) + ")";
  }

  void read_channel(const Json& channel, std::size_t number, Animation* animation) {
    const std::string where = where_ + "." + element("channels", number);
    const Json empty = Json::object();
    const Json& target = channel.is_object() && channel.contains("target") ? channel["target"] : empty;
    const std::string path = text_of(target, "path");
    if (path == "pointer") {
      document_.warnings.add("KHR_animation_pointer is not played", element_);
      return;
    }
    if (!target.is_object() || !target.contains("node")) return;  // glTF leaves its target to an extension
    const std::size_t node = index_of(target, "node", document_.model.nodes.size(), where);
    if (path == "weights") {
      document_.warnings.add("morph targets of " + named(node) + " are not animated", element_);
      return;
    }
    static const std::vector<std::string> kPaths = {"translation", "rotation", "scale"};
    const auto property = std::ranges::find(kPaths, path);
    if (property == kPaths.end())
      throw Error(where, "its path " + name_text(path) + " is not known", kDamagedAnimation);
    if (scene_nodes_[node] < 0) return;  // of another scene of the file
    if (!document_.model.nodes[node].matrix.empty()) {
      document_.warnings.add(named(node) + " has a matrix, which cannot be animated", element_);
      return;
    }
    AnimationTrack track = read_track(channel, property == kPaths.begin() + 1, where);
    AnimatedNode& moved = node_of(animation, node);
    AnimationTrack& kept = moved.tracks[static_cast<std::size_t>(property - kPaths.begin())];
    if (!kept.times_s.empty()) throw Error(where, "it moves what another channel moves", kDamagedAnimation);
    kept = std::move(track);
  }

  AnimationTrack read_track(const Json& channel, bool rotation, const std::string& where) {
    const Json& samplers = list_of(json_, "samplers", where_);
    const Json& sampler = samplers[index_of(channel, "sampler", samplers.size(), where)];
    const std::size_t accessors = document_.model.accessors.size();
    AnimationTrack track;
    track.interpolation = interpolation_of(sampler, where);
    track.times_s = read_scalars(document_, index_of(sampler, "input", accessors, where));
    const std::size_t output = index_of(sampler, "output", accessors, where);
    if (rotation)
      track.values = read_vectors<4>(document_, output);
    else
      for (const glm::vec3& value : read_vectors<3>(document_, output)) track.values.emplace_back(value, 0.0f);
    check(track, where);
    return track;
  }

  void check(const AnimationTrack& track, const std::string& where) {
    const std::size_t stride = track.interpolation == Interpolation::cubic ? 3 : 1;
    if (track.times_s.empty() || track.values.size() != stride * track.times_s.size())
      throw Error(where,
                  "has " + std::to_string(track.values.size()) + " values for " + std::to_string(track.times_s.size()) +
                      " keys",
                  kDamagedAnimation);
    document_.animation_keys += track.times_s.size();
    if (document_.animation_keys > kMostKeys)
      throw Error(where, "brings the file to more than " + std::to_string(kMostKeys) + " keys", kDamagedAnimation);
    for (std::size_t i = 0; i < track.times_s.size(); ++i)
      if (!std::isfinite(track.times_s[i]) || track.times_s[i] < 0.0f ||
          (i > 0 && track.times_s[i] <= track.times_s[i - 1]))
        throw Error(where, "its times do not increase from 0 on", kDamagedAnimation);
    for (const glm::vec4& value : track.values)
      for (int c = 0; c < 4; ++c)
        if (!std::isfinite(value[c])) throw Error(where, "has a value that is not finite", kDamagedAnimation);
  }

  /// With the pose of the file.
  AnimatedNode& node_of(Animation* animation, std::size_t node) {
    const int index = scene_nodes_[node];
    const auto known = std::ranges::find(animation->nodes, index, &AnimatedNode::node);
    if (known != animation->nodes.end()) return *known;
    AnimatedNode added;
    added.node = index;
    const tinygltf::Node& source = document_.model.nodes[node];
    const auto fill = [](const std::vector<double>& from, glm::vec4* to) {
      for (std::size_t c = 0; c < std::min<std::size_t>(from.size(), 4); ++c)
        (*to)[static_cast<int>(c)] = static_cast<float>(from[c]);
    };
    fill(source.translation, &added.rest[Property::translation]);
    fill(source.rotation, &added.rest[Property::rotation]);
    fill(source.scale, &added.rest[Property::scale]);
    glm::vec4& q = added.rest[Property::rotation];
    q = glm::length(q) > 0.0f ? glm::normalize(q) : glm::vec4(0.0f, 0.0f, 0.0f, 1.0f);
    animation->nodes.push_back(added);
    return animation->nodes.back();
  }

  Document& document_;
  const std::vector<int>& scene_nodes_;
  const Json& json_;
  std::string element_, where_;
};

/// Skins whose joints, or nodes above them, are moved: their meshes keep the pose of the file.
void warn_of_skins(Document* document, const std::vector<int>& scene_nodes, const Animation& animation,
                   const std::string& where) {
  const auto skins = document->root.find("skins");
  if (skins == document->root.end()) return;
  std::set<int> moved;
  for (const AnimatedNode& node : animation.nodes) moved.insert(node.node);
  for (std::size_t s = 0; s < skins->size(); ++s)
    for (const Json& joint : (*skins)[s]["joints"])
      if (moved.contains(scene_nodes[joint.get<std::size_t>()])) {
        const std::string name = text_of((*skins)[s], "name");
        document->warnings.add("joints of skin " + (name.empty() ? std::to_string(s) : name_text(name)) +
                                   " move, and the meshes that are bound to it keep the pose of the file",
                               where);
        break;
      }
}

}  // namespace

void import_animations(Document* document, const std::vector<int>& scene_nodes, Scene* scene) {
  const auto found = document->root.find("animations");
  if (found == document->root.end() || !found->is_array()) return;
  for (std::size_t i = 0; i < found->size(); ++i) {
    const std::string where = element("animations", i);
    try {
      Animation animation = AnimationReader(document, scene_nodes, i).read();
      if (animation.nodes.empty()) {
        document->warnings.add("the animation moves no node of the scene and is left out", where);
        continue;
      }
      warn_of_skins(document, scene_nodes, animation, where);
      const std::string plain = animation.name.empty() ? "animation " + std::to_string(i + 1) : animation.name;
      animation.name = plain;
      for (int number = 2; animation_index(*scene, animation.name) >= 0; ++number)
        animation.name = plain + " " + std::to_string(number);
      scene->animations.push_back(std::move(animation));
    } catch (const Error& error) {
      std::string line = error.what();
      const std::string file = document->path + ": ";
      if (line.starts_with(file)) line = line.substr(file.size());
      document->warnings.add("the animation is left out: " + line, where);
    }
  }
}

}  // namespace maquette::gltf
