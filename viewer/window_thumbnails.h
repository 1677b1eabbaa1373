#pragma once

#include <map>
#include <string>

#include "render/gl/objects.h"
#include "viewer/background_render.h"
#include "viewer/window_session.h"

namespace maquette {

/// Small settled pictures of the kept looks, one after another in the background, kept by content in the state folder.
class WindowThumbnails {
 public:
  static constexpr int kWidth = 96, kHeight = 54;

  /// `may_draw`: nothing else needs the device. Needs a current context.
  void update(const WindowSession& session, bool may_draw);
  /// Name of a look -> texture, where ready.
  std::map<std::string, unsigned> textures(const EditorState& state) const;

 private:
  /// Of what the picture shows: names and notes do not count.
  std::string key_of(const Look& look) const;
  bool take(const std::string& key);

  std::string scene_;
  std::map<std::string, Texture> pictures_;  ///< by key; empty where it cannot be drawn
  std::map<std::string, std::string> keys_;  ///< by the name of the look, of the looks below
  std::vector<Look> looks_;
  BackgroundRender drawing_;
  std::string drawn_key_;
};

}  // namespace maquette
