#include "viewer/window_thumbnails.h"

#include <cstdio>
#include <filesystem>
#include <span>

#include "review/journal.h"
#include "review/json_text.h"
#include "review/look_json.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/texture_formats.h"
#include "viewer/overlay_texture.h"

namespace maquette {

namespace fs = std::filesystem;

namespace {

std::string file_of(const std::string& key) {
  const std::string folder = state_folder() + "/looks";
  fs::create_directories(folder);
  return folder + "/" + key + ".png";
}

}  // namespace

std::string WindowThumbnails::key_of(const Look& look) const {
  Look shown = canonical(look);
  shown.name.clear();
  shown.note.clear();
  const std::string text = scene_ + json_text(look_json(shown, [](const std::string& source) { return source; }));
  char digits[20];
  std::snprintf(digits, sizeof digits, "%016llx",
                static_cast<unsigned long long>(content_hash(std::as_bytes(std::span(text.data(), text.size())))));
  return digits;
}

/// From the file of an earlier time.
bool WindowThumbnails::take(const std::string& key) {
  const std::string file = file_of(key);
  if (!fs::exists(file)) return false;
  TextureImage picture;
  std::vector<std::string> notes;
  decode_texture(read_file(file), &picture, &notes);
  Image display(picture.width, picture.height, 4);
  for (std::size_t i = 0; i < display.data.size(); ++i) display.data[i] = static_cast<float>(picture.rgba[i]) / 255.0f;
  pictures_[key] = overlay_texture(display, "look", GL_LINEAR);
  return true;
}

void WindowThumbnails::update(const WindowSession& session, bool may_draw) {
  try {
    std::string error;
    if (drawing_.poll(&error) && !take(drawn_key_)) pictures_[drawn_key_] = Texture();
    const EditorState& state = session.state;
    const Review& review = session.review().review();
    const std::string scene = review.scene + "#" + review.scene_of_file + "\n";
    if (scene != scene_ || state.looks != looks_) {
      scene_ = scene;
      looks_ = state.looks;
      keys_.clear();
      for (const Look& look : looks_) keys_[look.name] = key_of(look);
    }
    if (drawing_.busy()) return;
    for (const Look& look : looks_) {
      const std::string& key = keys_[look.name];
      if (pictures_.contains(key) || take(key)) continue;
      if (!may_draw) return;
      Review small = review;
      small.look = look;
      small.looks.clear();
      SettledFrame settled;
      settled.size.width = kWidth;
      settled.size.height = kHeight;
      drawn_key_ = key;
      return drawing_.start(small, settled, file_of(key));
    }
  } catch (const std::exception&) {  // a look without a picture is no reason to trouble the user
    if (!drawn_key_.empty()) pictures_[drawn_key_] = Texture();
  }
}

std::map<std::string, unsigned> WindowThumbnails::textures(const EditorState& state) const {
  std::map<std::string, unsigned> found;
  for (const Look& look : state.looks) {
    const auto key = keys_.find(look.name);
    if (key == keys_.end()) continue;
    const auto picture = pictures_.find(key->second);
    if (picture != pictures_.end() && picture->second) found[look.name] = picture->second.get();
  }
  return found;
}

}  // namespace maquette
