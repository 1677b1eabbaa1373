// The file dialog, and materials that are dragged out of the library.
#include "ui/file_browser.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "scenes/brdf.h"
#include "tests/ui/headless_editor.h"

namespace maquette {
namespace {

namespace fs = std::filesystem;
using test::HeadlessEditor;

class Browser : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("maquette-browser-" + std::to_string(::getpid()));
    fs::create_directories(folder_ / "cars");
    fs::create_directories(folder_ / ".hidden");
    for (const char* name : {"b.glb", "A.GLTF", "sky.hdr", "notes.txt", "r.maquette.json", "x.json", ".c.glb"})
      std::ofstream(folder_ / name) << "x";
    std::ofstream(folder_ / "cars" / "red.glb") << "x";
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST_F(Browser, ListsWhatCanBeOpened) {
  const FileBrowser browser = browse_folder(folder_.string());
  EXPECT_EQ(browser.folder, folder_.string());
  EXPECT_EQ(browser.folders, (std::vector<std::string>{"cars"}));
  EXPECT_EQ(browser.files, (std::vector<std::string>{"A.GLTF", "b.glb", "r.maquette.json", "sky.hdr"}));
  EXPECT_TRUE(browse_folder("/nowhere/at/all").files.empty()) << "a folder that is not there has nothing in it";
}

TEST_F(Browser, ClicksGoIntoAFolderAndOpenAFile) {
  Scene scene;
  scene.name = "s.glb";
  HeadlessEditor editor(1280.0f, 720.0f);
  editor.facts.scene = &scene;
  editor.step(3);
  editor.state.open_path_popup = true;
  editor.step(2);
  editor.state.browser = browse_folder(folder_.string());
  ASSERT_TRUE(editor.click("browse/cars"));
  EXPECT_EQ(editor.state.browser.folder, (folder_ / "cars").string());
  ASSERT_TRUE(editor.click("browse/red.glb")) << "the dialog is still open";
  EXPECT_EQ(editor.actions.open_path, (folder_ / "cars" / "red.glb").string());
  EXPECT_FALSE(editor.frame.items.contains("browse/red.glb")) << "it has closed";
}

TEST(LibraryDrag, IsLetGoOverThePicture) {
  Scene scene;
  scene.name = "s.glb";
  Material paint;
  paint.name = "paint";
  scene.materials = {paint};
  HeadlessEditor editor(1280.0f, 720.0f);
  editor.facts.scene = &scene;
  editor.state.selected_material = 0;
  editor.step(3);
  const std::string source = "builtin:" + builtin_brdfs()[1].name;
  const Rect row = editor.frame.items.at("library/" + source);
  const Rect picture = editor.frame.layout.picture;
  ImGuiIO& io = ImGui::GetIO();
  const auto drag_to = [&](const ImVec2& end) {
    io.MousePos = {row.x + 30.0f, row.y + 0.5f * row.height};
    editor.step();
    io.MouseDown[0] = true;
    editor.step();
    for (int i = 1; i <= 4; ++i) {
      const float t = 0.25f * static_cast<float>(i);
      io.MousePos = {row.x + 30.0f + t * (end.x - row.x), row.y + t * (end.y - row.y)};
      editor.step();
    }
    io.MousePos = end;
    editor.step();
    io.MouseDown[0] = false;
    editor.step();
    return editor.actions.drop_source;
  };
  EXPECT_EQ(drag_to({picture.x + 200.0f, picture.y + 200.0f}), source);
  EXPECT_TRUE(editor.state.edits.materials.empty()) << "the row itself was not clicked";
  EXPECT_EQ(drag_to({picture.x + 200.0f, 5.0f}), "") << "over the toolbar it is nothing";
  const Rect material = editor.frame.items.at("material/paint");
  EXPECT_EQ(drag_to({material.x + 20.0f, material.y + 10.0f}), source) << "a material in the list takes it too";
  EXPECT_EQ(editor.frame.hovered_material, 0);
}

}  // namespace
}  // namespace maquette
