// The window reads again what has changed on disk: the scene, its buffers and images, tables of materials.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "render/gl/context.h"
#include "scenes/brdf.h"
#include "tests/scenes/temporary_folder.h"
#include "tests/support/test_scenes.h"
#include "tests/support/waiting.h"
#include "viewer/window_session.h"

namespace maquette {
namespace {

class WindowFiles : public test::TemporaryFolder {
 protected:
  /// A triangle of side `size`, whose buffer is a file of its own.
  void write_buffer(float size) const {
    const float positions[] = {0, 0, 0, size, 0, 0, 0, size, 0};
    std::string bytes(sizeof positions, '\0');
    std::memcpy(bytes.data(), positions, sizeof positions);
    write("triangle.bin", bytes);
  }
  std::string write_scene() const {
    write_buffer(1.0f);
    return write("triangle.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
      "nodes": [{"mesh": 0}], "materials": [{"name": "Paint"}],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0],
                     "max": [2, 2, 0]}],
      "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"uri": "triangle.bin", "byteLength": 36}]})");
  }
  static bool said(WindowSession* session, const std::string& file) {
    EditorFacts facts;
    session->fill_facts(&facts);
    return std::ranges::any_of(*facts.messages, [&](const Message& message) {
      return message.text.find(file + " has changed") != std::string::npos;
    });
  }
  /// Iterations of the window's loop, two seconds apart, until nothing is read any more.
  void look(WindowSession* session, int times) {
    for (int i = 0; i < times; ++i) {
      session->update(false, now_s_ += 2.0);
      EXPECT_TRUE(test::comes_true([&] {
        session->update(false, now_s_);
        return !session->loading();
      }));
    }
  }

  GlContext context_ = GlContext::create_headless();
  double now_s_ = 0.0;
};

TEST_F(WindowFiles, ThatChangeAreReadAgain) {
  const std::string table = path("own.binary");
  save_merl(table, make_builtin_brdf("matte-white"));
  SceneOptions options;
  options.scene = write_scene();
  options.materials = {{"Paint", table}};
  options.screenshot = "none.png";  // such a window leaves no journal
  options.environment = "builtin:studio";
  options.settings.set("ground.kind", "none");
  options.settings_given = {"ground.kind"};
  WindowSession session(options);
  look(&session, 3);
  EXPECT_FALSE(said(&session, "triangle.gltf"));
  EXPECT_FALSE(said(&session, "own.binary"));
  EXPECT_NEAR(session.bounds().max.x, 1.0f, 1e-5f);

  write_buffer(2.0f);
  look(&session, 4);
  EXPECT_TRUE(said(&session, "triangle.gltf")) << "its buffer is another";
  EXPECT_NEAR(session.bounds().max.x, 2.0f, 1e-5f);

  const auto albedo = [&] {
    FrameRequest request = session.make_frame_request(32, 32);
    session.renderer().render(request);
    const Image picture = session.renderer().read_radiance();
    double sum = 0.0;
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x) sum += picture.at(x, y, 3) > 0.0f ? static_cast<double>(picture.at(x, y, 0)) : 0.0;
    return sum;
  };
  const double white = albedo();
  ASSERT_GT(white, 0.0);
  BrdfTable dark = make_builtin_brdf("matte-white");
  for (glm::vec3& value : dark.rgb) value *= 0.25f;
  save_merl(table, dark);
  look(&session, 4);
  EXPECT_TRUE(said(&session, "own.binary"));
  EXPECT_NEAR(albedo(), 0.25 * white, 0.03 * white) << "the table that is there now";
}

}  // namespace
}  // namespace maquette
