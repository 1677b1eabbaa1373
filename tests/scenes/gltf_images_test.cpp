#include <gtest/gtest.h>
#include <webp/encode.h>

#include "gltf_fixture.h"
#include "texture_bytes.h"

namespace maquette {
namespace {

using test::Json;

class GltfImages : public test::GltfFixture {
 protected:
  GltfImages() {
    add_quad();
    primitive()["material"] = 0;
    primitive()["attributes"]["TEXCOORD_0"] = add_accessor<float>({0, 0, 1, 0, 1, 1, 0, 1}, 5126, "VEC2", 2);
    root_["materials"] = Json::parse(R"([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])");
    root_["textures"] = Json::array({Json::object()});
    root_["images"] = Json::array();
  }

  int add_image(const std::string& bytes, const char* mime) {
    const int view = add_view(std::vector<char>(bytes.begin(), bytes.end()));
    root_["images"].push_back({{"bufferView", view}, {"mimeType", mime}});
    return static_cast<int>(root_["images"].size()) - 1;
  }
  Json& texture() { return root_["textures"][0]; }
  void set_webp(int image) {
    texture()["extensions"]["EXT_texture_webp"]["source"] = image;
    root_["extensionsUsed"] = {"EXT_texture_webp"};
  }

  static std::string grey_png(int value) {
    return test::png_bytes(1, 1, 8, 0, std::string(1, '\0') + static_cast<char>(value));
  }
  static std::string grey_webp(int value) {
    const std::vector<std::uint8_t> rgba = {static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(value),
                                            static_cast<std::uint8_t>(value), 255};
    std::uint8_t* data = nullptr;
    const std::size_t size = WebPEncodeLosslessRGBA(rgba.data(), 1, 1, 4, &data);
    std::string out(reinterpret_cast<const char*>(data), size);
    WebPFree(data);
    return out;
  }
  /// Red of the one texel that the base colour shows; -1 without a texture.
  static int shown(const Scene& scene) {
    const TextureRef& ref = scene.materials[0].base_color_texture;
    return ref ? scene.images[static_cast<std::size_t>(ref.image)].rgba[0] : -1;
  }
};

TEST_F(GltfImages, WebpIsPreferred) {
  texture()["source"] = add_image(grey_png(10), "image/png");
  set_webp(add_image(grey_webp(20), "image/webp"));
  const Scene scene = load();
  EXPECT_EQ(shown(scene), 20);
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_EQ(scene.images[0].width, 0) << "the other image is not needed";
}

TEST_F(GltfImages, WebpMayBeRequiredAndWithoutAnotherImage) {
  set_webp(add_image(grey_webp(20), "image/webp"));
  root_["extensionsRequired"] = {"EXT_texture_webp"};
  const Scene scene = load();
  EXPECT_EQ(shown(scene), 20);
  EXPECT_TRUE(scene.warnings.empty());
}

TEST_F(GltfImages, TheOtherImageStandsInForADamagedWebp) {
  texture()["source"] = add_image(grey_png(10), "image/png");
  set_webp(add_image(grey_webp(20).substr(0, 20), "image/webp"));
  const Scene scene = load();
  EXPECT_EQ(shown(scene), 10);
  ASSERT_EQ(scene.warnings.size(), 1u);
  expect_warning(scene, "images[1]: the other image of its textures is used");
}

TEST_F(GltfImages, WithoutAReadableImageTheTextureIsLeftOut) {
  set_webp(add_image(grey_webp(20).substr(0, 20), "image/webp"));
  Scene scene = load();
  EXPECT_EQ(shown(scene), -1);
  ASSERT_EQ(scene.warnings.size(), 1u);
  expect_warning(scene, "images[0]: its textures are left out");
  texture()["source"] = add_image(grey_png(10).substr(0, 40), "image/png");
  scene = load();
  EXPECT_EQ(shown(scene), -1);
  ASSERT_EQ(scene.warnings.size(), 2u);
  expect_warning(scene, "images[1]: its textures are left out: is cut short");
}

TEST_F(GltfImages, AnImageSharedWithOtherTexturesIsRead) {
  const int png = add_image(grey_png(10), "image/png");
  texture()["source"] = png;
  set_webp(add_image(grey_webp(20), "image/webp"));
  root_["textures"].push_back({{"source", png}});
  root_["materials"][0]["emissiveTexture"]["index"] = 1;
  const Scene scene = load();
  EXPECT_EQ(shown(scene), 20);
  EXPECT_EQ(scene.materials[0].emissive_texture.image, png);
  EXPECT_EQ(scene.images[0].rgba[0], 10);
}

TEST_F(GltfImages, AnExtensionWithoutSourceLeavesTheCore) {
  texture()["source"] = add_image(grey_png(10), "image/png");
  texture()["extensions"]["EXT_texture_webp"] = Json::object();
  EXPECT_EQ(shown(load()), 10);
}

TEST_F(GltfImages, WebpAsACoreImageIsReadWithOneWarning) {
  texture()["source"] = add_image(grey_webp(20), "image/webp");
  const Scene scene = load();
  EXPECT_EQ(shown(scene), 20);
  ASSERT_EQ(scene.warnings.size(), 1u);
  expect_warning(scene, "images[0]: is a WebP image without the extension EXT_texture_webp");
}

TEST_F(GltfImages, TheBytesCountAndNotTheMimeType) {
  texture()["source"] = add_image(grey_png(10), "image/jpeg");
  const Scene scene = load();
  EXPECT_EQ(shown(scene), 10);
  ASSERT_EQ(scene.warnings.size(), 1u);
  expect_warning(scene, "images[0]: is a PNG image, although its mimeType says otherwise");
}

TEST_F(GltfImages, SourcesOutOfRangeAreRefused) {
  texture()["extensions"]["EXT_texture_webp"]["source"] = 3;
  expect_error("textures[0].extensions.EXT_texture_webp.source: 3 is out of range (the file has 0 images)");
  texture()["extensions"] = 5;
  expect_error("textures[0].extensions");
}

TEST_F(GltfImages, ASceneWithAnImageLeftOutIsSaved) {
  texture()["source"] = add_image(grey_png(10), "image/png");
  set_webp(add_image(grey_webp(20), "image/webp"));
  save_glb(path("saved.glb"), load());
  const Scene back = load_gltf(path("saved.glb"));
  EXPECT_EQ(shown(back), 20);
  EXPECT_TRUE(back.warnings.empty());
}

}  // namespace
}  // namespace maquette
