// The command that a picture of the window names.
#include "viewer/picture_command.h"

#include <gtest/gtest.h>

#include "tests/scenes/temporary_folder.h"
#include "viewer/command_line.h"

namespace maquette {
namespace {

TEST(PictureCommand, WordsAreThoseOfAShell) {
  EXPECT_EQ(shell_word("a/b-1.exr"), "a/b-1.exr");
  EXPECT_EQ(shell_word("evening, red"), "'evening, red'");
  EXPECT_EQ(shell_word("it's"), "'it'\\''s'");
  EXPECT_EQ(shell_word("$HOME"), "'$HOME'");
  EXPECT_EQ(shell_word(""), "''");
}

TEST(PictureCommand, SaysAllThatDecidesThePicture) {
  SettledFrame settled;
  settled.size.width = 656;
  settled.size.height = 650;
  EXPECT_EQ(picture_command("a.maquette.json", "", settled, "a.exr"),
            "maquette render a.maquette.json -o a.exr --size 656x650");
  settled.frames = 16;
  settled.size.msaa = 4;
  settled.size.samples = 8;
  settled.size.seed = 3;
  EXPECT_EQ(picture_command("a.maquette.json", "night", settled, "a.exr"),
            "maquette render a.maquette.json --look night -o a.exr --size 656x650 --msaa 4 --samples 8 --seed 3 "
            "--average 16");
}

class RepeatingCommand : public test::TemporaryFolder {
 protected:
  static bool names(const std::optional<std::string>& command, const std::string& part) {
    return command && command->find(part) != std::string::npos;
  }
};

TEST_F(RepeatingCommand, NamesTheLookThatTheFileHas) {
  Review review;
  review.scene = "builtin:sphere";
  OpenReview open(review, false);
  EXPECT_FALSE(repeating_command(open, {}, "a.exr")) << "there is no file";
  review.look.auto_exposure = false;
  review.look.exposure_ev = 3.0f;
  review.look.name = "night";
  review.looks = {review.look};
  open.observe(review, false);
  open.save(path("a.maquette.json"));
  EXPECT_TRUE(names(repeating_command(open, {}, "a.exr"), "--look night"));

  Review changed = review;
  changed.look.exposure_ev = 4.0f;
  open.observe(changed, false);
  EXPECT_FALSE(repeating_command(open, {}, "a.exr")) << "the file does not have this look";
  open.save(path("a.maquette.json"));
  const auto at_hand = repeating_command(open, {}, "a.exr");
  EXPECT_TRUE(at_hand && !names(at_hand, "--look")) << "the one that was at hand";
}

}  // namespace
}  // namespace maquette
