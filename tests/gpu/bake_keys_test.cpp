// Keys of bakes: of what a frame draws with, by content, and what a window says of them.
#include "render/bake/bake_keys.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>

#include "scenes/node_paths.h"
#include "tests/gpu/light_field_stage.h"
#include "tests/gpu/transfer_fixture.h"
#include "tests/support/test_scenes.h"
#include "viewer/look_stage.h"
#include "viewer/window_session.h"

namespace maquette {
namespace {

namespace fs = std::filesystem;

class KeysOfBakes : public test::TemporaryFolder {
 protected:
  void SetUp() override {
    TemporaryFolder::SetUp();
    if (const char* cache = std::getenv("MAQUETTE_CACHE")) before_ = cache;
    setenv("MAQUETTE_CACHE", path("cache").c_str(), 1);
  }
  void TearDown() override {
    if (before_)
      setenv("MAQUETTE_CACHE", before_->c_str(), 1);
    else
      unsetenv("MAQUETTE_CACHE");
    TemporaryFolder::TearDown();
  }
  /// A room without a roof.
  static std::shared_ptr<Scene> room() {
    return std::make_shared<Scene>(test::box_scene(5, 3, test::matte(glm::vec3(0.4f))));
  }
  static FrameRequest request(const std::string& visibility = "baked") {
    FrameRequest r;
    r.mode = "uniform";
    r.width = 64;
    r.height = 48;
    r.settings.set("shading.visibility", visibility);
    return r;
  }
  static void show(Renderer* renderer, const std::shared_ptr<Scene>& scene) {
    renderer->set_scene(scene);
    renderer->set_environment(std::make_shared<const Environment>(load_environment("builtin:studio")));
  }
  static BakeKeys keys(Renderer* renderer, const FrameRequest& r) {
    return renderer->bake_keys(r).value_or(BakeKeys{{"?", "?"}});
  }
  static bool kept(const std::string& bake, const std::string& key, const FrameRequest& r = request()) {
    return is_bake_kept(builtin_registry(), bake, key, "", r.settings);
  }

  std::optional<std::string> before_;
  GlContext context_ = GlContext::create_headless();
};

std::vector<std::string> names(const BakeKeys& keys) {
  std::vector<std::string> all;
  for (const auto& [name, key] : keys) all.push_back(name);
  return all;
}

TEST_F(KeysOfBakes, AreOfWhatALookDrawsWithAlone) {
  Renderer renderer;
  show(&renderer, room());
  EXPECT_EQ(names(keys(&renderer, request())), (std::vector<std::string>{"indirect", "visibility"}));
  FrameRequest direct = request();
  direct.settings.set("shading.indirect", std::string("none"));
  EXPECT_EQ(names(keys(&renderer, direct)), std::vector<std::string>{"visibility"});
  EXPECT_TRUE(keys(&renderer, request("none")).empty());
  FrameRequest reference = request();
  reference.mode = "reference";
  EXPECT_TRUE(keys(&renderer, reference).empty());
  EXPECT_EQ(renderer.bake_key(request(), "slf"), "") << "of another mode";
  EXPECT_EQ(keys(&renderer, request("auto")), keys(&renderer, request()));

  show(&renderer, std::make_shared<Scene>(test::box_scene(2, 3, test::matte(glm::vec3(0.4f)))));
  EXPECT_FALSE(renderer.bake_keys(request("auto"))) << "what the walls hide is not counted yet";
  EXPECT_EQ(renderer.bake_key(request("auto"), "visibility"), keys(&renderer, request()).at("visibility"));
  ASSERT_TRUE(renderer.finish_background_work(request("auto")));
  EXPECT_EQ(keys(&renderer, request("auto")), keys(&renderer, request()));
}

TEST_F(KeysOfBakes, AreOfContent) {
  const std::shared_ptr<Scene> scene = room();
  Renderer renderer, again;
  show(&renderer, scene);
  show(&again, scene);
  const BakeKeys first = keys(&renderer, request());
  for (const auto& [name, key] : first) EXPECT_TRUE(is_bake_key(key)) << name << " " << key;
  EXPECT_EQ(keys(&again, request()), first);

  FrameRequest turned = request();
  turned.env_rotation_rad = 0.5f;
  EXPECT_EQ(keys(&renderer, turned).at("visibility"), first.at("visibility"));
  EXPECT_NE(keys(&renderer, turned).at("indirect"), first.at("indirect"));

  renderer.set_material("*", "builtin:paint-pearl-white");
  EXPECT_EQ(keys(&renderer, request()).at("visibility"), first.at("visibility"));
  EXPECT_NE(keys(&renderer, request()).at("indirect"), first.at("indirect"));
  renderer.set_material("*", "");
  EXPECT_EQ(keys(&renderer, request()), first);

  const Primitive& wall = scene->meshes[1].primitives[0];
  std::vector<glm::vec3> moved = wall.positions;
  moved[0].x += 0.1f;
  again.update_mesh(1, moved, wall.normals);
  EXPECT_NE(keys(&again, request()).at("visibility"), first.at("visibility"));
  EXPECT_NE(keys(&again, request()).at("indirect"), first.at("indirect"));
}

TEST_F(KeysOfBakes, NameWhatTheCacheHolds) {
  Renderer renderer;
  show(&renderer, room());
  const BakeKeys wanted = keys(&renderer, request());
  for (const auto& [name, key] : wanted) EXPECT_FALSE(kept(name, key)) << name;
  ASSERT_TRUE(renderer.finish_background_work(request()));
  EXPECT_EQ(keys(&renderer, request()), wanted) << "before as after the bake";
  for (const auto& [name, key] : wanted) {
    EXPECT_TRUE(kept(name, key)) << name;
    EXPECT_FALSE(kept(name, "0123456789abcdef"));
    EXPECT_FALSE(kept(name, key + "0"));
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(path("cache")))
    if (entry.path().filename().string().starts_with("visibility")) fs::resize_file(entry.path(), 100);
  EXPECT_FALSE(kept("visibility", wanted.at("visibility"))) << "cut off";
  EXPECT_TRUE(kept("indirect", wanted.at("indirect")));
  setenv("MAQUETTE_CACHE", path("other").c_str(), 1);
  EXPECT_FALSE(kept("indirect", wanted.at("indirect")));
}

TEST_F(KeysOfBakes, OfAModesOwnBakesAreThoseOfTheirFolders) {
  for (const FrameRequest& r : {request_for(16), small_request()}) {
    Renderer renderer;
    show(&renderer, room());
    const BakeKeys wanted = keys(&renderer, r);
    ASSERT_EQ(names(wanted), std::vector<std::string>{r.mode});
    const std::string key = wanted.at(r.mode), folder = path("cache/" + r.mode + "-" + key);
    EXPECT_FALSE(fs::exists(folder)) << "nothing is made for a key";
    ASSERT_TRUE(renderer.finish_background_work(r));
    EXPECT_TRUE(fs::exists(folder + "/bake.exr"));
    EXPECT_TRUE(kept(r.mode, key, r));
    EXPECT_EQ(keys(&renderer, r), wanted);
    Renderer again;
    show(&again, room());
    EXPECT_EQ(keys(&again, r), wanted);
    auto other = room();
    other->meshes[0].primitives[0].positions[0].y += 0.1f;
    show(&again, other);
    EXPECT_NE(keys(&again, r), wanted);
    FrameRequest named = r;
    named.settings.set(r.mode + ".bake", path("named"));
    EXPECT_FALSE(kept(r.mode, key, named));
    fs::create_directories(path("named"));
    fs::copy(folder, path("named/-" + r.mode));  // as the scene has no name
    EXPECT_TRUE(kept(r.mode, key, named));
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
      if (entry.path().filename() != "bake.exr") {
        fs::remove(entry.path());
        break;
      }
    EXPECT_FALSE(kept(r.mode, key, r)) << "not whole";
  }
}

/// A window on a stored room.
class WindowBakes : public KeysOfBakes {
 protected:
  void SetUp() override {
    KeysOfBakes::SetUp();
    save_glb(path("room.glb"), *room());
    file_ = path("a.maquette.json");
  }
  SceneOptions options(const std::string& review = {}) {
    SceneOptions result;
    result.scene = path("room.glb");
    result.review = review;
    result.screenshot = "none.png";  // such a window leaves no journal
    result.environment = "builtin:studio";
    result.mode = "uniform";
    result.settings_given = {"ground.kind"};
    result.settings.set("shading.visibility", std::string("baked"));
    return result;
  }
  static void settle(WindowSession* session) {
    for (int i = 0; i < 3; ++i) {
      session->update(false, 0.0);
      session->renderer().finish_background_work(session->make_frame_request(64, 48));
    }
  }
  void keep(WindowSession* session, const std::string& name) {
    Look look = session->state;
    look.name = name;
    session->state.looks.push_back(look);
    settle(session);
  }
  /// What is said of bakes when the review is opened, a line each.
  std::vector<std::string> said(const std::string& look = {}) {
    SceneOptions opened = options(file_);
    opened.look = look;
    WindowSession session(opened);
    session.update(false, 0.0);
    session.update(false, 0.0);
    EditorFacts facts;
    session.fill_facts(&facts);
    std::vector<std::string> lines;
    for (const Message& message : *facts.messages)
      if (message.text.find(": bake ") != std::string::npos) lines.push_back(message.text);
    EXPECT_FALSE(session.review().changed());
    return lines;
  }
  std::vector<ReviewBake> bakes() const {
    std::vector<ReviewBake> all;
    load_review(file_, &all);
    return all;
  }
  std::string file_;
};

TEST_F(WindowBakes, AreNamedInTheFileAndSaidToBeMadeElsewhere) {
  {
    WindowSession session(options());
    settle(&session);
    session.save(file_);
    settle(&session);
    EXPECT_FALSE(session.review().changed()) << "a bake is no change";
    EXPECT_FALSE(session.review().can_undo());
  }
  const std::vector<ReviewBake> named = bakes();
  ASSERT_EQ(named.size(), 2u);
  EXPECT_EQ(named[0].bake, "indirect");
  EXPECT_EQ(named[1].bake, "visibility");
  for (const ReviewBake& bake : named) EXPECT_TRUE(bake.at_hand && bake.looks.empty());
  EXPECT_TRUE(said().empty()) << said().front();
  setenv("MAQUETTE_CACHE", path("elsewhere").c_str(), 1);
  EXPECT_EQ(said(),
            (std::vector<std::string>{
                "a.maquette.json: bake indirect of the state at hand is not in the cache: to be made; it changes "
                "shadows of the sky, and light that other surfaces send",
                "a.maquette.json: bake visibility of the state at hand is not in the cache: to be made; it "
                "changes shadows of the sky, which come with indirect light"}));
}

TEST_F(WindowBakes, OfAnotherSceneAreSaidToBeMadeAnew) {
  {
    WindowSession session(options());
    settle(&session);
    session.save(file_);
  }
  Scene other = *room();
  other.meshes[1].primitives[0].positions[0].x += 0.2f;
  save_glb(path("room.glb"), other);
  const std::vector<std::string> lines = said();
  ASSERT_EQ(lines.size(), 2u);
  for (const std::string& line : lines)
    EXPECT_NE(line.find(" of the state at hand: the scene is not as it was when the review was saved; it is made anew; "
                        "it changes shadows"),
              std::string::npos)
        << line;
  {
    WindowSession session(options());
    settle(&session);  // bakes it
  }
  const std::vector<std::string> baked = said();
  ASSERT_EQ(baked.size(), 2u);
  EXPECT_NE(baked[0].find("what it needs now is there"), std::string::npos) << baked[0];
  {
    WindowSession session(options(file_));
    settle(&session);
    session.save(file_);
  }
  EXPECT_TRUE(said().empty()) << "saved again";
}

TEST_F(WindowBakes, KeptLooksHaveTheirOwn) {
  {
    WindowSession session(options());
    settle(&session);
    keep(&session, "noon");
    session.state.edits.env_rotation_deg = 90.0f;
    settle(&session);
    keep(&session, "evening");
    session.state.settings.set("shading.visibility", std::string("none"));
    settle(&session);
    session.save(file_);
  }
  const std::vector<ReviewBake> named = bakes();
  ASSERT_EQ(named.size(), 3u);
  EXPECT_EQ(named[0].bake, "indirect");
  EXPECT_EQ(named[1].bake, "indirect");
  EXPECT_NE(named[0].key, named[1].key);
  EXPECT_EQ(named[0].looks.size(), 1u);
  EXPECT_EQ(named[1].looks.size(), 1u);
  EXPECT_EQ(named[2].looks.size(), 2u);
  for (const ReviewBake& bake : named) EXPECT_FALSE(bake.at_hand) << "the state at hand needs none";
  {
    WindowSession session(options(file_));
    settle(&session);
    session.save(file_);
  }
  EXPECT_EQ(bakes(), named) << "looks that were not shown keep what the file said";
  setenv("MAQUETTE_CACHE", path("elsewhere").c_str(), 1);
  const std::vector<std::string> lines = said();
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_NE(lines[2].find("visibility of looks \"evening\", \"noon\" is not in the cache"), std::string::npos)
      << lines[2];
}

/// Dents, turns, hidden parts, materials and a ground come to the renderer in another order in a window than in the
/// commands, which compare with what it saved.
TEST_F(WindowBakes, AreThoseThatCommandsFind) {
  std::vector<Look> looks;
  {
    SceneOptions car = options();
    car.scene = "builtin:cockpit";
    WindowSession session(car);
    EditorState& state = session.state;
    const Scene& scene = session.scene();
    const auto shown = [&](const char* name) {
      for (int i = 0; i < 3 || session.loading(); ++i) session.update(false, 0.0);
      Look look = state;
      look.name = name;
      state.looks.push_back(look);
      session.update(false, 0.0);
      looks.push_back(look);
    };
    shown("plain");
    state.edits.env_rotation_deg = 33.3f;
    state.edits.env_scale = 1.7f;
    shown("light");
    state.edits.materials[scene.materials.front().name] = "builtin:paint-pearl-white";
    shown("paint");
    state.edits.hidden_nodes = {node_paths(scene)[3]};
    shown("hidden");
    state.edits.dents.push_back({glm::vec3(0.8f, 0.7f, 0.2f), 0.02f, 0.3f});
    shown("dent");
    state.edits.turns.push_back({node_paths(scene)[2], glm::vec3(0.0f, 1.0f, 0.0f), 12.0f});
    shown("turn");
    state.edits.environment = "builtin:clear-sky";
    state.settings.set("ground.kind", std::string("projected"));
    shown("ground");
    session.save(file_);
  }
  LookStage stage(std::make_shared<const Scene>(load_scene("builtin:cockpit")));
  std::set<std::string> indirect, visibility;
  for (const Look& look : looks) {
    const BakeKeys saved = keys_of_look(bakes(), look.name);
    ASSERT_EQ(names(saved), (std::vector<std::string>{"indirect", "visibility"})) << look.name;
    for (const auto& [name, key] : saved) EXPECT_EQ(stage.bake_key(look, name), key) << look.name << " " << name;
    indirect.insert(saved.at("indirect"));
    visibility.insert(saved.at("visibility"));
  }
  EXPECT_EQ(indirect.size(), looks.size());
  EXPECT_EQ(visibility.size(), 5u) << "neither light nor paint changes what surfaces hide";
}

}  // namespace
}  // namespace maquette
