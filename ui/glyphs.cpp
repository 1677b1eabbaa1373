#include "ui/glyphs.h"

#include "scenes/harmless.h"

namespace maquette {

namespace {

/// The panels have their own Latin, Greek, Cyrillic, Vietnamese and punctuation; controls are not drawn, private ones
/// stand for bytes that are no character.
bool is_further(std::uint32_t c) {
  return c >= 0x530u && c < 0x10000u && !(c >= 0x1e00u && c < 0x1f00u) && !(c >= 0x2000u && c < 0x2070u) &&
         !(c >= 0xe000u && c < 0xf900u) && c != 0xfeffu;
}

}  // namespace

void Glyphs::note(const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    if (static_cast<unsigned char>(text[at]) < 0x80u) {
      ++at;
      continue;
    }
    const Utf8Character c = utf8_character(text, at);
    if (c.bytes > 0 && is_further(c.code)) all_.insert(static_cast<char16_t>(c.code));
    at += c.bytes == 0 ? 1 : c.bytes;
  }
}

void Glyphs::note(const EditorState& state, const EditorFacts& facts) {
  if (const Scene* scene = facts.scene) {
    note(scene->name);
    for (const Node& node : scene->nodes) note(node.name);
    for (const Material& material : scene->materials) note(material.name);
    for (const Camera& camera : scene->cameras) note(camera.name);
    for (const std::string& variant : scene->variants) note(variant);
    for (const Animation& animation : scene->animations) note(animation.name);
  }
  for (const Look& look : state.looks) {
    note(look.name);
    note(look.note);
  }
  note(state.name);
  for (const CameraPath& path : state.paths) {
    note(path.name);
    for (const PathKey& key : path.keys) note(key.name);
  }
  for (const auto* names : {&facts.environment_files, &facts.brdf_files, &facts.recent_files, &facts.cameras,
                            &state.browser.folders, &state.browser.files})
    for (const std::string& name : *names) note(name);
  note(state.browser.folder);
  note(std::string(state.path.data()));
  note(facts.loading);
  if (!facts.messages) return;
  for (const Message& message : *facts.messages) note(message.text);
}

}  // namespace maquette
