#include "viewer/command_line.h"

#include <gtest/gtest.h>

#include <set>

#include "scenes/error.h"
#include "tests/support/text.h"
#include "viewer/manual.h"

namespace maquette {
namespace {

using Words = std::vector<std::string>;

CommandLine parse(const Words& words) { return parse_command_line(words); }

/// The message of the UsageError that parsing throws.
std::string usage_error(const Words& words) {
  try {
    parse(words);
  } catch (const UsageError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no usage error";
  return {};
}

using test::contains;

TEST(CommandLine, NothingIsTheCockpitInAWindow) {
  const CommandLine line = parse({});
  EXPECT_EQ(line.command, "view");
  EXPECT_EQ(line.options.scene, "builtin:cockpit");
  EXPECT_EQ(line.options.mode, "bandwidth");
  EXPECT_EQ(line.options.reflections, "auto");
}

TEST(CommandLine, EveryOptionReachesItsField) {
  const CommandLine line = parse({"render",
                                  "car.glb",
                                  "-o",
                                  "a.exr",
                                  "--mode",
                                  "uniform",
                                  "--reflections",
                                  "off",
                                  "--env",
                                  "sky.hdr",
                                  "--env-rotation",
                                  "-30.5",
                                  "--env-scale",
                                  "2.5",
                                  "--exposure",
                                  "-1.25",
                                  "--tonemap",
                                  "reinhard",
                                  "--material",
                                  "Paint=red.binary",
                                  "--material",
                                  "*=builtin:glass",
                                  "--variant",
                                  "Night",
                                  "--eye",
                                  "-1,2.5,-3e-2",
                                  "--target",
                                  "0,0,1",
                                  "--up=0,0,1",
                                  "--fov",
                                  "35",
                                  "--size",
                                  "640x360",
                                  "--samples",
                                  "17",
                                  "--seed",
                                  "4294967295",
                                  "--msaa",
                                  "4",
                                  "--frames",
                                  "9",
                                  "--dent",
                                  "-0.1,0,1,0.02,0.2",
                                  "--set",
                                  "bandwidth.max_level=2",
                                  "--stats",
                                  "s.json",
                                  "--reference",
                                  "r.exr"});
  const SceneOptions& o = line.options;
  EXPECT_EQ(line.command, "render");
  EXPECT_EQ(o.scene, "car.glb");
  EXPECT_EQ(o.output, "a.exr");
  EXPECT_EQ(o.mode, "uniform");
  EXPECT_EQ(o.environment, "sky.hdr");
  EXPECT_FLOAT_EQ(o.env_rotation_deg, -30.5f);
  EXPECT_FLOAT_EQ(o.env_scale, 2.5f);
  EXPECT_FLOAT_EQ(o.exposure_ev.value(), -1.25f);
  EXPECT_EQ(o.tonemap, "reinhard");
  ASSERT_EQ(o.materials.size(), 2u);
  EXPECT_EQ(o.materials[0].first, "Paint");
  EXPECT_EQ(o.materials[1].second, "builtin:glass");
  EXPECT_EQ(o.variant, "Night");
  EXPECT_EQ(o.eye, glm::vec3(-1.0f, 2.5f, -3e-2f));
  EXPECT_EQ(o.target, glm::vec3(0, 0, 1));
  EXPECT_EQ(o.up, glm::vec3(0, 0, 1));
  EXPECT_FLOAT_EQ(o.fov_deg.value(), 35.0f);
  EXPECT_EQ(o.width, 640);
  EXPECT_EQ(o.height, 360);
  EXPECT_EQ(o.samples, 17);
  EXPECT_EQ(o.seed, 4294967295u);
  EXPECT_EQ(o.msaa, 4);
  EXPECT_EQ(o.frames, 9);
  ASSERT_EQ(o.dents.size(), 1u);
  EXPECT_FLOAT_EQ(o.dents[0].radius_m, 0.2f);
  EXPECT_EQ(o.settings.get_int("bandwidth.max_level"), 2);
  EXPECT_EQ(o.stats, "s.json");
  EXPECT_EQ(o.reference, "r.exr");
  const CommandLine timed =
      parse({"render", "-o", "a.png", "--time", "2", "--target-error", "0.02", "--camera", "driver"});
  EXPECT_EQ(timed.options.time_s, 2.0);
  EXPECT_EQ(timed.options.target_error, 0.02);
  EXPECT_EQ(timed.options.camera, "driver");
}

TEST(CommandLine, TheSceneMayComeAfterAnyOption) {
  EXPECT_EQ(parse({"render", "-o", "a.png", "car.glb"}).options.scene, "car.glb");
  EXPECT_EQ(parse({"render", "--material", "A=b", "car.glb", "--output=a.png"}).options.scene, "car.glb");
  EXPECT_EQ(parse({"--mode", "sg"}).command, "view");
  EXPECT_EQ(parse({"view", "car.glb", "--exposure", "-2"}).options.exposure_ev, -2.0f);
}

TEST(CommandLine, WrongValuesAreNamed) {
  const Words base = {"render", "-o", "a.png"};
  const std::vector<std::pair<Words, std::string>> cases = {
      {{"--size", "640"}, "WxH"},
      {{"--size", "12x"}, "of the form WxH; write width and height"},
      {{"--size", "x12"}, "WxH"},
      {{"--size", "12x-3"}, "WxH"},
      {{"--enviroment", "a.hdr"}, "did you mean --env?"},
      {{"--environment-rotation", "3"}, "--env"},
      {{"--resolution", "8x8"}, "did you mean --size?"},
      {{"--widht", "8"}, "did you mean --size?"},
      {{"--zzzz", "8"}, "render --help lists them"},
      {{"--size", "0x10"}, "out of range"},
      {{"--size", "640x360x2"}, "WxH"},
      {{"--size", "99999x10"}, "out of range"},
      {{"--eye", "1,2"}, "x,y,z"},
      {{"--eye", "1,2,3,4"}, "x,y,z"},
      {{"--eye", "1,,3"}, "x,y,z"},
      {{"--eye", "1,nan,3"}, "not a number"},
      {{"--fov", "180"}, "out of range"},
      {{"--orthographic", "0"}, "out of range"},
      {{"--orthographic", "2", "--fov", "20"}, "it does not go with --fov"},
      {{"--exposure", "bright"}, "not a number"},
      {{"--exposure", "inf"}, "not a number"},
      {{"--samples", "0"}, "out of range"},
      {{"--samples", "1.5"}, "whole number"},
      {{"--seed", "-1"}, "out of range"},
      {{"--msaa", "3"}, "1, 4 or 16"},
      {{"--mode", "bandwith"}, "did you mean bandwidth?"},
      {{"--tonemap", "agxx"}, "did you mean agx?"},
      {{"--view", "levle"}, "did you mean level"},
      {{"--material", "Paint"}, "NAME=FILE"},
      {{"--material", "=x"}, "NAME=FILE"},
      {{"--set", "bandwidth.quality"}, "SETTING=VALUE"},
      {{"--set", "bandwidth.qualty=2"}, "did you mean bandwidth.quality?"},
      {{"--set", "bandwidth.quality=1e9"}, "out of range"},
      {{"--dent", "1,2,3,0.1,0"}, "radius"},
      {{"--dent", "1,2,3"}, "x,y,z,depth,radius"},
      {{"--up", "0,0,0"}, "no direction"},
      {{"--eye", "1,1,1", "--target", "1,1,1"}, "where the eye is"},
      {{"--camera", "driver", "--eye", "0,0,0"}, "excludes"},
      {{"--frames", "3", "--time", "1"}, "excludes"},
      {{"--time", "0"}, "out of range"},
      {{"--target-error", "-1"}, "out of range"},
      {{"--env", ""}, "empty"},
      {{"--camera", ""}, "--camera: its value is empty"},
      {{"--reflections", "off", "--reflector", "windshield"}, "while --reflections is off"},
      {{"--mode", "uniform", "--mode", "sg"}, "given twice"},
      {{"--moed", "uniform"}, "did you mean --mode"},
      {{"--json"}, "it belongs to compare"},
      {{"a.glb", "b.glb"}, "one argument too many"},
      {{"--mode"}, "--mode"},
  };
  for (const auto& [words, expected] : cases) {
    Words all = base;
    all.insert(all.end(), words.begin(), words.end());
    const std::string message = usage_error(all);
    EXPECT_TRUE(contains(message, expected)) << words.front() << ": " << message;
    EXPECT_FALSE(contains(message, "\n")) << message;
  }
}

TEST(CommandLine, AFileAloneIsViewed) {
  for (const std::string scene : {"car.glb", "car.gltf", "builtin:seat", "cars/one", "./render"}) {
    const CommandLine line = parse({scene, "--mode", "uniform"});
    EXPECT_EQ(line.command, "view") << scene;
    EXPECT_EQ(line.options.scene, scene);
    EXPECT_EQ(line.options.mode, "uniform") << scene;
  }
  const CommandLine review = parse({"car.maquette.json"});
  EXPECT_EQ(review.command, "view");
  EXPECT_EQ(review.options.review, "car.maquette.json");
  EXPECT_TRUE(contains(usage_error({"car.glb", "other.glb"}), "one argument too many"));
}

TEST(CommandLine, CommandsAreChecked) {
  EXPECT_TRUE(contains(usage_error({"rendr"}), "did you mean render?"));
  EXPECT_TRUE(contains(usage_error({"compare", "a.exr"}), "A.exr B.exr"));
  EXPECT_TRUE(contains(usage_error({"inspect"}), "FILE"));
  EXPECT_TRUE(contains(usage_error({"render"}), "--output"));
  for (const Words& words : {Words{"--mode", "sg", "render"}, Words{"-o", "a.png", "render", "car.glb"},
                             Words{"--json", "inspect", "car.glb"}, Words{"--set=octree.depth=7", "view"}}) {
    const std::string message = usage_error(words);
    EXPECT_TRUE(contains(message, "options come behind it: maquette ")) << message;
  }
  EXPECT_EQ(parse({"--camera", "report"}).options.camera, "report") << "a value, no command";
  EXPECT_TRUE(contains(usage_error({"play"}), "PATH.path.json"));
}

TEST(CommandLine, TurnsNodes) {
  const SceneOptions o = parse({"render", "-o", "a.png", "--turn", "seat=0,2,0,25", "--turn", "*=1,0,0,-90"}).options;
  ASSERT_EQ(o.turns.size(), 2u);
  EXPECT_EQ(o.turns[0].node, "seat");
  EXPECT_EQ(o.turns[0].axis, glm::vec3(0, 1, 0));
  EXPECT_FLOAT_EQ(o.turns[1].angle_deg, -90.0f);
  for (const char* wrong : {"seat", "seat=0,0,0,10", "seat=1,2,3", "=1,0,0,9"})
    EXPECT_THROW(parse({"render", "-o", "a.png", "--turn", wrong}), UsageError) << wrong;
}

/// Names of files have whatever somebody typed.
TEST(CommandLine, NamesMayHaveAnEqualsSign) {
  const auto material = [](const std::string& text) {
    return parse({"render", "car.glb", "-o", "a.exr", "--material", text}).options.materials.back();
  };
  EXPECT_EQ(material("Paint=a=b.binary"), (std::pair<std::string, std::string>{"Paint", "a=b.binary"}));
  EXPECT_EQ(material("a=b=builtin:matte-white"), (std::pair<std::string, std::string>{"a=b", "builtin:matte-white"}));
  EXPECT_EQ(material("=a=builtin:glass"), (std::pair<std::string, std::string>{"=a", "builtin:glass"}));
  EXPECT_EQ(parse({"render", "car.glb", "-o", "a.exr", "--turn", "door=left=0,1,0,30"}).options.turns.back().node,
            "door=left");
  const SceneOptions named = parse({"render", "car.glb", "-o", "a.exr", "--animation", "open=wide"}).options;
  EXPECT_EQ(named.animation.name, "open=wide");
  const SceneOptions timed = parse({"render", "car.glb", "-o", "a.exr", "--animation", "open=wide=1.5"}).options;
  EXPECT_EQ(timed.animation.name, "open=wide");
  EXPECT_EQ(timed.animation.time_s, 1.5);
}

TEST(CommandLine, ReviewsAndPathsAreToldFromScenes) {
  EXPECT_TRUE(contains(usage_error({"render", "-o", "a.png", "--look", "A"}), "there is no review"));
  const SceneOptions review = parse({"render", "a.maquette.json", "--look", "A", "-o", "a.png"}).options;
  EXPECT_EQ(review.review, "a.maquette.json");
  EXPECT_EQ(review.look, "A");
  EXPECT_EQ(review.scene, SceneOptions().scene);
  const SceneOptions path = parse({"play", "a.path.json", "car.glb", "-o", "frames"}).options;
  EXPECT_EQ(path.path, "a.path.json");
  EXPECT_EQ(path.scene, "car.glb");
  EXPECT_TRUE(contains(usage_error({"play", "a.maquette.json", "-o", "frames"}), "--path NAME"));
}

TEST(CommandLine, DeclarationsAreSound) {
  std::set<std::string> names;
  std::set<std::string> commands;
  for (const CommandDeclaration& command : command_declarations()) EXPECT_TRUE(commands.insert(command.name).second);
  for (const OptionDeclaration& option : option_declarations()) {
    EXPECT_TRUE(names.insert(option.name).second) << option.name;
    EXPECT_TRUE(option.alias.empty() || names.insert(option.alias).second) << option.alias;
    EXPECT_FALSE(option.help.empty()) << option.name;
    for (const std::string& command : option.commands) EXPECT_TRUE(commands.contains(command)) << option.name;
  }
  // The contract's options.
  for (const char* name :
       {"--mode",     "--reflections", "--reflector", "--env",          "--env-rotation", "--env-scale",
        "--exposure", "--tonemap",     "--material",  "--variant",      "--camera",       "--eye",
        "--target",   "--up",          "--fov",       "--orthographic", "--size",         "--samples",
        "--seed",     "--msaa",        "--frames",    "--target-error", "--time",         "--view",
        "--dent",     "--set",         "--stats",     "--reference",    "--look",         "--output"})
    EXPECT_TRUE(names.contains(name)) << name;
}

TEST(Manual, NamesEveryDeclarationAndFitsATerminal) {
  const std::string text = manual_text();
  for (const OptionDeclaration& option : option_declarations()) EXPECT_TRUE(contains(text, option.name)) << option.name;
  for (const SettingDeclaration& setting : setting_declarations())
    EXPECT_TRUE(contains(text, setting.name)) << setting.name;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    EXPECT_LE(end - begin, 80u) << text.substr(begin, end - begin);
    begin = end + 1;
  }
  EXPECT_TRUE(contains(manual_text("render"), "--output"));
  EXPECT_FALSE(contains(manual_text("doctor"), "--output"));
  EXPECT_THROW(manual_text("rendr"), UsageError);
  EXPECT_TRUE(contains(manual_text("settings"), "octree.depth"));
  EXPECT_FALSE(contains(manual_text("settings"), "--output"));
  EXPECT_TRUE(contains(manual_text("octree.depth"), "octree.depth"));
  EXPECT_FALSE(contains(manual_text("octree"), "shading.visibility"));
  try {
    manual_text("setings");
    ADD_FAILURE();
  } catch (const UsageError& error) {
    EXPECT_TRUE(contains(error.what(), "did you mean settings")) << error.what();
  }
}

}  // namespace
}  // namespace maquette
