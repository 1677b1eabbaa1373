// The review story in the real window: paints are swapped, looks kept, compared, saved; a kill; reopening.
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfStringAttribute.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "review/json_reader.h"
#include "scenes/image_io.h"
#include "tests/support/test_scenes.h"
#include "tests/ui/story_fixture.h"

namespace maquette {
namespace {

class ReviewStory : public Story {
 protected:
  /// Clicks on a material of the library, in the open list, and waits for it.
  void take_from_library(Controls* controls, const std::string& source) {
    desktop_->click(controls->item("library/" + source));
    ASSERT_TRUE(wait_for_review([&](const Review& r) {
      return !r.look.edits.materials.empty() && r.look.edits.materials.begin()->second == source;
    })) << source
        << "\n"
        << desktop_->errors();
  }
  void keep_look(std::size_t count) {
    key("l");
    ASSERT_TRUE(wait_for_review([&](const Review& r) { return r.looks.size() == count; }));
  }
  bool shows(const std::string& look) {
    return wait_for_review([&](const Review& r) { return r.look.name == look; });
  }
  /// From look 1, whose picture is `first`, with look 3 and its `third` under the wiper, swapped, and back.
  void compare(const ScreenPicture& first, const ScreenPicture& third, const Rect& middle) {
    const Rect left{middle.x, middle.y, 0.45f * middle.width, 0.8f * middle.height};
    const Rect right{middle.x + 0.55f * middle.width, middle.y, 0.45f * middle.width, 0.8f * middle.height};
    key("c");
    EXPECT_TRUE(comes_to(third, first, right)) << "B lies at the right of the wiper";
    EXPECT_TRUE(comes_to(first, third, left)) << "and A at the left";
    keep_screen("review-compare");
    key("x");
    EXPECT_TRUE(comes_to(third, first, left)) << "swapped";
    key("x");
    EXPECT_TRUE(shows("look 1"));
    key("c");
    EXPECT_TRUE(comes_to(first, third, right)) << "the comparison is over";
  }
  /// The key P has written a file, which names the command that writes the very same file again.
  void expect_repeated(const std::string& look) {
    const std::string written = (folder_ / (look + ".exr")).string();
    ASSERT_TRUE(wait_for_file(written));
    const Imf::InputFile picture(written.c_str());
    const auto* attribute = picture.header().findTypedAttribute<Imf::StringAttribute>("maquette.command");
    ASSERT_TRUE(attribute) << "the picture does not say what repeats it";
    const std::string command = attribute->value(), name = "maquette ";
    ASSERT_EQ(command.find(name), 0u) << command;
    const std::string first = read_text_file(written);
    ASSERT_GT(first.size(), 1000u);
    std::filesystem::remove(written);
    const std::string run = std::string(MAQUETTE_PROGRAM) + " " + command.substr(name.size()) + " > /dev/null";
    ASSERT_EQ(std::system(run.c_str()), 0) << run;
    EXPECT_TRUE(read_text_file(written) == first) << "other bits: " << run;
  }
};

TEST_F(ReviewStory, PaintsAreSwappedComparedSavedAndSurviveAKill) {
  const Scene scene = load_scene("builtin:sphere");
  const std::string material = scene.materials.front().name;
  Controls at = controls(scene);
  const Rect picture = at.picture(), middle = middle_of(picture);
  begin({"builtin:sphere"});
  ASSERT_TRUE(wait_for_picture(middle)) << desktop_->errors();
  key("bracketright");  // one exposure for all looks, so that only paints differ
  ASSERT_TRUE(wait_for_review([](const Review& r) { return !r.look.auto_exposure; }));
  const ScreenPicture first = settled();
  keep_look(1);
  desktop_->click(at.item("material/" + material));
  at.state().selected_material = 0;
  std::vector<std::string> sources;
  for (const BuiltinBrdf& brdf : builtin_brdfs())
    if (!scene.materials.front().measured.ends_with(brdf.name)) sources.push_back("builtin:" + brdf.name);
  ASSERT_TRUE(wait_for_change(first, at.item("library/" + sources[1]), 2.0)) << "the library opens";
  take_from_library(&at, sources[0]);
  ASSERT_TRUE(wait_for_change(first, middle)) << "the sphere shows the new material";
  const ScreenPicture second = settled();
  keep_look(2);
  take_from_library(&at, sources[1]);
  ASSERT_TRUE(wait_for_change(second, middle, 2.0)) << "and another";
  const ScreenPicture third = settled();
  keep_look(3);
  keep_screen("review-materials");

  desktop_->move(picture.x + 20.0f, picture.y + 20.0f);
  key("Page_Up");
  EXPECT_TRUE(shows("look 2"));
  key("Page_Up");
  EXPECT_TRUE(shows("look 1"));
  EXPECT_TRUE(comes_to(first, third, middle)) << "the first look again";
  key("Page_Up");
  EXPECT_TRUE(shows("look 3"));
  EXPECT_TRUE(comes_to(third, first, middle)) << "the last comes before the first";
  key("ctrl+z");
  EXPECT_TRUE(shows("look 1")) << "undo takes back the change of looks";
  key("ctrl+y");
  EXPECT_TRUE(shows("look 3")) << "and redo makes it again";

  const std::string file = (folder_ / "a.maquette.json").string();
  key("ctrl+s");
  desktop_->input({"type", "--delay", "1", file});
  key("Return");
  ASSERT_TRUE(wait_for_file(file)) << desktop_->errors();
  file_ = file;
  const Review saved = load_review(file);
  ASSERT_EQ(saved.looks.size(), 3u);
  EXPECT_TRUE(saved.looks[0].edits.materials.empty());
  EXPECT_EQ(saved.looks[1].edits.materials.at(material), sources[0]);
  EXPECT_EQ(saved.look.edits.materials.at(material), sources[1]);

  key("Page_Down");
  EXPECT_TRUE(shows("look 1"));
  EXPECT_TRUE(comes_to(first, third, middle));
  compare(first, third, middle);
  key("p");
  expect_repeated("look 1");

  desktop_->kill_program();
  open_desktop();
  begin({file});
  ASSERT_TRUE(wait_for_picture(middle)) << desktop_->errors();
  EXPECT_TRUE(shows("look 1")) << "the change that was not saved";
  dismiss(&at, file + ": changes that were not saved are there again; undo takes them back");
  EXPECT_TRUE(comes_to(first, third, middle)) << "it is shown too";
  const auto journal = read_journal(journal_file(file));
  ASSERT_TRUE(journal);
  EXPECT_GE(journal->history.undo_count(), 5u);
  key("ctrl+q");
  EXPECT_EQ(desktop_->wait_for_exit(), 0) << desktop_->errors();
}

// Everything at once, as a user in a hurry does it whose frames are slow.
TEST_F(ReviewStory, KeysWithoutAPauseArriveInTheirOrder) {
  begin({"builtin:sphere", "--mode", "uniform", "--set", "shading.visibility=traced"});
  const Rect picture = controls(load_scene("builtin:sphere")).picture();
  ASSERT_TRUE(wait_for_picture(middle_of(picture))) << desktop_->errors();
  const std::string file = (folder_ / "b.maquette.json").string();
  desktop_->move(picture.x + 20.0f, picture.y + 20.0f);
  desktop_->post({"key", "l", "key", "bracketright", "key", "l", "key", "bracketright", "key", "bracketright", "key",
                  "l", "key", "ctrl+s", "type", "--delay", "1", file});
  desktop_->post({"key", "Return", "key", "l"});
  ASSERT_TRUE(wait_for_file(file)) << desktop_->errors();
  file_ = file;
  ASSERT_TRUE(wait_for_review([](const Review& r) { return r.looks.size() == 4; })) << "the key behind Return";
  const Review saved = load_review(file);
  ASSERT_EQ(saved.looks.size(), 3u);
  EXPECT_TRUE(saved.looks[0].auto_exposure);
  EXPECT_FALSE(saved.looks[1].auto_exposure);
  EXPECT_FLOAT_EQ(saved.looks[2].exposure_ev, saved.looks[1].exposure_ev + 0.5f);
}

/// What the window saves of bakes is what the command looks for, and says where the cache is another.
TEST_F(ReviewStory, TheFileNamesItsBakes) {
  const std::string room = (folder_ / "room.glb").string(), file = (folder_ / "c.maquette.json").string();
  const Scene scene = test::box_scene(5, 3, test::matte(glm::vec3(0.4f)));
  save_glb(room, scene);
  const Rect picture = controls(scene).picture();
  begin({room, "--mode", "uniform", "--set", "shading.visibility=baked", "--set", "ground.kind=none"});
  ASSERT_TRUE(wait_for_picture(middle_of(picture))) << desktop_->errors();
  desktop_->move(picture.x + 20.0f, picture.y + 20.0f);
  key("l");
  ASSERT_TRUE(wait_for_review([](const Review& r) { return r.looks.size() == 1; }));
  settled();
  key("ctrl+s");
  desktop_->input({"type", "--delay", "1", file});
  key("Return");
  ASSERT_TRUE(wait_for_file(file)) << desktop_->errors();
  key("ctrl+q");
  EXPECT_EQ(desktop_->wait_for_exit(), 0) << desktop_->errors();
  std::vector<ReviewBake> bakes;
  load_review(file, &bakes);
  ASSERT_EQ(bakes.size(), 2u);
  for (const ReviewBake& bake : bakes) EXPECT_TRUE(bake.at_hand && bake.looks == std::vector<std::string>{"look 1"});
  const auto said = [&](const std::string& cache) {
    const std::string text = (folder_ / "said.txt").string();
    const std::string command = cache + " '" + std::string(MAQUETTE_PROGRAM) + "' render '" + file +
                                "' --look 'look 1' --size 48x32 -o '" + (folder_ / "c.exr").string() +
                                "' > /dev/null 2> '" + text + "'";
    EXPECT_EQ(std::system(command.c_str()), 0);
    return read_text_file(text);
  };
  EXPECT_EQ(said(""), "");
  const std::string elsewhere = said("MAQUETTE_CACHE='" + (folder_ / "elsewhere").string() + "'");
  for (const std::string bake : {"visibility", "indirect"})
    EXPECT_NE(elsewhere.find("bake " + bake + " of look \"look 1\" is not in the cache: to be made"), std::string::npos)
        << elsewhere;
}

}  // namespace
}  // namespace maquette
