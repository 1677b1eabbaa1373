// The real window on a separate screen, driven by mouse and keyboard events.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "scenes/modelling.h"
#include "tests/support/test_scenes.h"
#include "tests/ui/window_fixture.h"

namespace maquette {
namespace {

TEST_F(Window, MouseAndKeysChangeThePicture) {
  const Scene scene = load_scene("builtin:cockpit");
  Controls controls(scene);
  const Rect picture = controls.picture(), middle = middle_of(picture);
  start({"builtin:cockpit", "--camera", "door", "--samples", "4", "--set", "shading.visibility=none"});
  ASSERT_TRUE(wait_for_picture(middle)) << desktop_->errors();

  ScreenPicture before = settled();
  const float cx = picture.x + 0.5f * picture.width, cy = picture.y + 0.5f * picture.height;
  desktop_->move(cx, cy);
  desktop_->input({"click", "4", "click", "4", "click", "4"});
  EXPECT_TRUE(wait_for_change(before, middle)) << "the wheel moves the camera";

  before = settled();
  desktop_->input({"keydown", "ctrl", "mousedown", "1"});
  desktop_->move(cx + 120.0f, cy);
  desktop_->input({"mouseup", "1", "keyup", "ctrl"});
  EXPECT_TRUE(wait_for_change(before, middle)) << "Ctrl and drag rotate the light";
  EXPECT_TRUE(wait_for_change(before, controls.item("rotation"), 0.2)) << "and the slider shows it";

  before = settled();
  desktop_->move(cx, cy);
  desktop_->input({"key", "d"});
  desktop_->input({"mousedown", "1"});
  desktop_->move(cx, cy + 60.0f);
  desktop_->input({"mouseup", "1"});
  EXPECT_TRUE(wait_for_change(before, middle)) << "the dent";
  const ScreenPicture dented = settled();
  desktop_->input({"key", "ctrl+z"});
  EXPECT_TRUE(desktop_->wait_until([&](const ScreenPicture& p) {
    return difference(before, p, middle) < 0.5 * difference(before, dented, middle);
  })) << "undo removes the dent";
  desktop_->input({"key", "d"});

  desktop_->input({"key", "ctrl+q"});
  EXPECT_EQ(desktop_->wait_for_exit(), 0) << desktop_->errors();
  EXPECT_EQ(desktop_->errors(), "");
}

TEST_F(Window, TheLightTurnsOverPrecomputedTransfer) {
  Scene ball;
  ball.materials.push_back(test::matte(glm::vec3(0.5f)));
  ball.materials[0].specular = 1.0f;  // without gloss a message takes its place from the picture
  ball.materials[0].roughness = 0.7f;
  test::add(&ball, modelling::make_sphere(1.0, 6), "ball");
  const std::string file =
      (std::filesystem::temp_directory_path() / ("ball-" + std::to_string(::getpid()) + ".glb")).string();
  save_glb(file, ball);
  const Scene scene = load_scene(file);
  Controls controls(scene);
  const Rect picture = controls.picture();
  const float side = 0.4f * picture.height;  // within the sphere: the sky turns beside it in any case
  const Rect middle{picture.x + 0.5f * (picture.width - side), picture.y + 0.5f * (picture.height - side), side, side};
  std::vector<std::string> begin{file,    "--eye",  "0,0.6,4", "--target",          "0,0,0",
                                 "--fov", "35",     "--env",   "builtin:clear-sky", "--exposure",
                                 "-14",   "--mode", "prt"};
  for (const char* set : {"prt.faces=4", "prt.clusters=16", "prt.rays=1", "prt.components=4", "prt.btf_components=1"})
    begin.insert(begin.end(), {"--set", set});
  const auto turned_by = [&](const std::string& degrees) {
    std::vector<std::string> arguments = begin;
    arguments.insert(arguments.end(), {"--env-rotation", degrees});
    return arguments;
  };
  start(turned_by("30"));
  ASSERT_TRUE(wait_for_picture(middle)) << desktop_->errors();
  const ScreenPicture before = settled();
  const float cx = picture.x + 0.5f * picture.width, cy = picture.y + 0.5f * picture.height;
  desktop_->move(cx, cy);
  desktop_->input({"keydown", "ctrl", "mousedown", "1"});
  for (int i = 1; i <= 6; ++i) desktop_->move(cx + 20.0f * static_cast<float>(i), cy);
  desktop_->input({"mouseup", "1", "keyup", "ctrl"});
  EXPECT_TRUE(wait_for_change(before, middle)) << "Ctrl and drag turn the light";
  const ScreenPicture turned = settled();
  desktop_->input({"key", "ctrl+q"});
  EXPECT_EQ(desktop_->wait_for_exit(), 0) << desktop_->errors();

  start(turned_by("72"));  // 0.35 degrees a pixel
  ASSERT_TRUE(wait_for_picture(middle)) << desktop_->errors();
  const ScreenPicture given = settled();
  EXPECT_LT(difference(given, turned, middle), 0.25 * difference(before, turned, middle)) << "as --env-rotation says";
  desktop_->input({"key", "ctrl+q"});
  EXPECT_EQ(desktop_->wait_for_exit(), 0) << desktop_->errors();
  std::filesystem::remove(file);
}

TEST_F(Window, TwoClicksReplaceAMaterial) {
  const Scene scene = load_scene("builtin:sphere");
  Controls controls(scene);
  const Rect picture = controls.picture(), middle = middle_of(picture);
  start({"builtin:sphere", "--samples", "4"});
  ASSERT_TRUE(wait_for_picture(middle)) << desktop_->errors();
  const ScreenPicture before = settled();
  desktop_->click(controls.item("material/" + scene.materials.front().name));
  controls.state().selected_material = 0;
  const std::string current = scene.materials.front().measured;
  const std::string source = "builtin:" + builtin_brdfs()[current.ends_with(builtin_brdfs()[1].name) ? 2 : 1].name;
  ASSERT_TRUE(wait_for_change(before, controls.item("library/" + source), 2.0)) << "the library opens";
  desktop_->click(controls.item("library/" + source));
  EXPECT_TRUE(wait_for_change(before, middle)) << "the sphere shows the new material";
  const ScreenPicture replaced = settled();
  desktop_->click(controls.item("undo"));
  EXPECT_TRUE(desktop_->wait_until([&](const ScreenPicture& p) {
    return difference(before, p, middle) < 0.5 * difference(before, replaced, middle);
  })) << "undo restores the old material";
}

TEST_F(Window, AnErrorIsShownAndThePictureStays) {
  const Scene scene = load_scene("builtin:sphere");
  Controls controls(scene);
  const Rect picture = controls.picture(), middle = middle_of(picture);
  start({"builtin:sphere", "--samples", "4"});
  ASSERT_TRUE(wait_for_picture(middle)) << desktop_->errors();
  const ScreenPicture before = settled();
  desktop_->input({"key", "o"});
  desktop_->input({"type", "--delay", "1", "/nowhere/to/be/found.hdr"});
  desktop_->input({"key", "Return"});
  const Rect strip{picture.x, picture.y + picture.height - 34.0f, picture.width, 30.0f};
  EXPECT_TRUE(desktop_->wait_until([&](const ScreenPicture& p) { return difference(before, p, strip) > 5.0; }))
      << "the error appears below the picture";
  EXPECT_TRUE(desktop_->running());
  const ScreenPicture after = settled();
  EXPECT_GT(test::contrast(after, middle), 0.5 * test::contrast(before, middle)) << "the last good picture stays";
}

TEST_F(Window, TheErrorTabShowsAFigureAndWhereItIs) {
  const Scene scene = load_scene("builtin:sphere");
  Controls controls(scene);
  const Rect picture = controls.picture(), middle = middle_of(picture);
  start({"builtin:sphere", "--samples", "4", "--env", "builtin:studio", "--mode", "splitsum"});
  ASSERT_TRUE(wait_for_picture(middle)) << desktop_->errors();
  const ScreenPicture before = settled();
  desktop_->click(controls.item("tab/Error"));
  controls.state().right_tab = 3;
  const Rect heat = controls.item("error/heat");
  const Rect figure{heat.x - 60.0f, heat.y + heat.height + 4.0f, 60.0f, 26.0f};
  ASSERT_TRUE(wait_for_change(before, heat, 1.0)) << "the tab opens";
  EXPECT_TRUE(desktop_->wait_until([&](const ScreenPicture& p) { return test::contrast(p, figure) > 12.0; }))
      << "a figure appears";
  const ScreenPicture plain = settled();
  desktop_->click(controls.item("error/heat"));
  EXPECT_TRUE(wait_for_change(plain, middle, 4.0)) << "the heat map covers the sphere once there is a reference";
  desktop_->click(controls.item("error/picture"));
  EXPECT_TRUE(desktop_->wait_until([&](const ScreenPicture& p) { return difference(plain, p, middle) < kSeen; }))
      << "and goes";
  const float line = picture.x + 0.5f * picture.width, way = 0.2f * picture.width;
  const Rect between{line + 8.0f, middle.y, way - 16.0f, middle.height};
  desktop_->click(controls.item("error/wiper"));
  EXPECT_TRUE(wait_for_change(plain, between)) << "the reference lies at the right of the wiper";
  desktop_->move(line + 2.0f, picture.y + 20.0f);
  desktop_->input({"mousedown", "1"});
  desktop_->move(line + way, picture.y + 60.0f);
  desktop_->input({"mouseup", "1"});
  EXPECT_TRUE(desktop_->wait_until([&](const ScreenPicture& p) { return difference(plain, p, between) < kSeen; }))
      << "its line is dragged to the right, and the camera stays";
  desktop_->input({"key", "ctrl+q"});
  EXPECT_EQ(desktop_->wait_for_exit(), 0) << desktop_->errors();
  EXPECT_EQ(desktop_->errors(), "");
}

TEST_F(Window, TheGroundIsLeftAwayWhereThatIsAsked) {
  Scene ball;
  ball.materials.push_back(test::matte(glm::vec3(0.5f)));
  test::add(&ball, modelling::make_sphere(1.0, 6), "ball");
  const std::string file =
      (std::filesystem::temp_directory_path() / ("ground-" + std::to_string(::getpid()) + ".glb")).string();
  save_glb(file, ball);
  Scene scene = load_scene(file);
  scene.materials.push_back(test::matte(glm::vec3(1.0f)));  // what the ground adds to the list
  scene.materials.back().name = "Ground";
  Controls controls(scene);
  const Rect picture = controls.picture(), listed = controls.item("material/" + scene.materials.back().name);
  const Rect below{picture.x, picture.y + 0.5f * picture.height, picture.width, 0.49f * picture.height};
  const auto open = [&](const std::string& kind) {
    // No bake changes a picture that is settled.
    std::vector<std::string> words{file,
                                   "--samples",
                                   "2",
                                   "--env",
                                   "builtin:clear-sky",
                                   "--exposure",
                                   "-13",
                                   "--set",
                                   "shading.indirect=none",
                                   "--set",
                                   "shading.visibility=traced"};
    if (!kind.empty()) words.insert(words.end(), {"--set", "ground.kind=" + kind});
    start(words);
    EXPECT_TRUE(wait_for_picture(middle_of(picture))) << desktop_->errors();
  };
  const auto close = [&] {
    desktop_->input({"key", "ctrl+q"});
    EXPECT_EQ(desktop_->wait_for_exit(), 0) << desktop_->errors();
  };
  open("none");
  const ScreenPicture none = settled();
  EXPECT_LT(test::contrast(none, listed), 1.0) << "no ground where none is asked";
  close();
  for (const char* kind : {"projected", ""}) {
    open(kind);
    EXPECT_TRUE(wait_for_change(none, listed, 3.0)) << "a scene without a ground gets one";
    EXPECT_TRUE(wait_for_change(none, below, 1.0)) << "on which the ball throws its shadow";
    close();
  }
  std::filesystem::remove(file);
}

TEST_F(Window, TextGrowsAndComesBack) {
  const Scene scene = load_scene("builtin:sphere");
  Controls controls(scene);
  const Rect picture = controls.picture(), middle = middle_of(picture);
  start({"builtin:sphere", "--samples", "2"});
  ASSERT_TRUE(wait_for_picture(middle)) << desktop_->errors();
  const Rect right{picture.x + picture.width, 0.0f, kWidth - picture.x - picture.width, kHeight};
  desktop_->move(middle.x, middle.y);
  const ScreenPicture usual = settled();
  for (int i = 0; i < 3; ++i) desktop_->input({"key", "ctrl+plus"});
  EXPECT_TRUE(wait_for_change(usual, right, 3.0)) << desktop_->errors();
  desktop_->input({"key", "ctrl+0"});
  EXPECT_TRUE(desktop_->wait_until([&](const ScreenPicture& p) { return difference(usual, p, right) < 1.0; }))
      << desktop_->errors();
  EXPECT_TRUE(desktop_->running()) << desktop_->errors();
}

TEST_F(Window, ClosesByItselfWithAScreenshot) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("maquette-screenshot-" + std::to_string(::getpid()) + ".png");
  start({"builtin:sphere", "--samples", "2", "--frames", "2", "--screenshot", file.string()});
  EXPECT_EQ(desktop_->wait_for_exit(), 0) << desktop_->errors();
  EXPECT_TRUE(std::filesystem::exists(file));
  std::filesystem::remove(file);
}

TEST(WindowWithoutDisplay, NamesRender) {
  const std::string command = std::string("env -u DISPLAY -u WAYLAND_DISPLAY ") + MAQUETTE_PROGRAM + " view 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string text;
  char buffer[256];
  while (std::fgets(buffer, sizeof(buffer), pipe)) text += buffer;
  const int status = pclose(pipe);
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_NE(text.find("maquette render"), std::string::npos) << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
}

}  // namespace
}  // namespace maquette
