// The command that "Copy as command" gives: it parses to the view that it was made from.
#include "viewer/rendered_view.h"

#include <gtest/gtest.h>

#include <sstream>

#include "tests/support/test_scenes.h"
#include "viewer/command_line.h"
#include "viewer/session.h"

namespace maquette {
namespace {

/// Words of a shell's command line that has plain and single-quoted ones.
std::vector<std::string> words_of(const std::string& line) {
  std::vector<std::string> words(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '\'')
      quoted = !quoted;
    else if (line[i] == '\\' && !quoted)
      words.back() += line[++i];
    else if (line[i] == ' ' && !quoted)
      words.emplace_back();
    else
      words.back() += line[i];
  }
  return words;
}

TEST(RenderedView, ParsesToWhatItWasMadeFrom) {
  Scene scene = load_scene("builtin:cockpit");
  EditorState state;
  state.edits.environment = "it's a place/hall.hdr";
  state.edits.env_rotation_deg = 37.5f;
  state.edits.env_scale = 900.0f;
  state.edits.materials["Paint red"] = "builtin:paint-pearl-white";
  state.edits.reflectors = {"windshield"};
  state.camera.eye = {1.25f, -0.5f, 3.0f};
  state.camera.target = {0.0f, 1.0f, 0.125f};
  state.camera.fov_y_rad = 0.5f;
  state.settings.set("ground.kind", std::string("projected"));
  state.auto_exposure = false;
  state.exposure_ev = -1.5f;
  std::vector<std::string> words = words_of(render_command(scene, state));
  ASSERT_GT(words.size(), 3u);
  EXPECT_EQ(words[0], "maquette");
  words.erase(words.begin());
  const CommandLine line = parse_command_line(words);
  EXPECT_EQ(line.command, "render");
  const SceneOptions& o = line.options;
  EXPECT_EQ(o.scene, "builtin:cockpit");
  EXPECT_EQ(o.environment, state.edits.environment);
  EXPECT_EQ(o.env_rotation_deg, 37.5f);
  EXPECT_EQ(o.env_scale, 900.0f);
  ASSERT_EQ(o.materials.size(), 1u);
  EXPECT_EQ(o.materials[0], std::pair(std::string("Paint red"), std::string("builtin:paint-pearl-white")));
  EXPECT_EQ(o.reflectors, std::vector<std::string>{"windshield"});
  EXPECT_EQ(o.settings, state.settings);
  EXPECT_EQ(o.exposure_ev, -1.5f);
  const CameraView view = camera_of_options(scene, o);
  for (int k : {0, 1, 2}) {
    EXPECT_FLOAT_EQ(view.eye[k], state.camera.eye[k]);
    EXPECT_FLOAT_EQ(view.target[k], state.camera.target[k]);
  }
  EXPECT_NEAR(view.fov_y_rad, 0.5f, 1e-5f);
}

}  // namespace
}  // namespace maquette
