#include <gtest/gtest.h>

#include "gltf_fixture.h"

namespace maquette {
namespace {

/// How integers, URIs and containers may be spelled. Every file here is the quad of the fixture.
class GltfStructure : public test::GltfFixture {
 protected:
  GltfStructure() { add_quad(); }

  /// The file as text, its buffer at `uri`.
  std::string text_with(const std::string& uri) const {
    test::Json root = root_;
    root["buffers"] = {{{"byteLength", bytes_.size()}, {"uri", uri}}};
    return root.dump();
  }
  std::string write_text(const std::string& name, const std::string& text) const {
    return write(name, {text.begin(), text.end()});
  }
  std::size_t triangles_with(const std::string& uri) const {
    return count_triangles(load_gltf(write_text("scene.gltf", text_with(uri))));
  }
  /// `bytes` with every byte as %XX.
  template <typename Bytes>
  static std::string percent(const Bytes& bytes) {
    std::string out;
    for (const char c : bytes) {
      char text[4];
      std::snprintf(text, sizeof text, "%%%02X", static_cast<unsigned char>(c));
      out += text;
    }
    return out;
  }
  std::string base64() const {
    static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes_.size(); i += 3) {
      unsigned bits = 0;
      for (std::size_t k = 0; k < 3; ++k)
        bits = bits << 8 | (i + k < bytes_.size() ? static_cast<unsigned char>(bytes_[i + k]) : 0u);
      for (int k = 3; k >= 0; --k) out += kDigits[bits >> (6 * k) & 63u];
    }
    for (std::size_t k = 0; k < (3 - bytes_.size() % 3) % 3; ++k) out[out.size() - 1 - k] = '=';
    return out;
  }
  /// Replaces `"key":value` wherever it stands.
  static std::string respell(std::string text, const std::string& from, const std::string& to) {
    int count = 0;
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size(), ++count)
      text.replace(at, from.size(), to);
    EXPECT_GT(count, 0) << from;
    return text;
  }
};

TEST_F(GltfStructure, NumbersBeyondDoubleAreOutOfRange) {
  write("data.bin", bytes_);
  root_["cameras"] = test::Json::parse(R"([{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 77}}])");
  root_["nodes"] = test::Json::parse(R"([{"mesh": 0, "name": "1e309 \" 1e309"}, {"camera": 0}])");
  root_["scenes"][0]["nodes"] = {0, 1};
  const Scene scene = load_gltf(write_text("scene.gltf", respell(text_with("data.bin"), "77", "-1.5e+309")));
  expect_warning(scene, "cameras[0]: znear is not a number");
  EXPECT_EQ(scene.nodes.at(0).name, "1e309 \" 1e309");
  root_["nodes"][0]["translation"] = {77, 0, 0};
  expect_error(write_text("scene.gltf", respell(text_with("data.bin"), "[77", "[1e999")),
               "its transform is not finite");
}

TEST_F(GltfStructure, ABufferThatNothingNeedsRefusesNothing) {
  write("data.bin", bytes_);
  test::Json root = root_;
  root["buffers"] = {{{"byteLength", bytes_.size()}, {"uri", "data.bin"}}, {{"byteLength", 4}, {"uri", "gone.bin"}}};
  const Scene scene = load_gltf(write_text("scene.gltf", root.dump()));
  EXPECT_EQ(count_triangles(scene), 2u);
  expect_warning(scene, "gone.bin");
  root["bufferViews"][0]["buffer"] = 1;
  expect_error(write_text("scene.gltf", root.dump()), "gone.bin");
}

TEST_F(GltfStructure, HiddenNodes) {
  root_["extensionsUsed"] = root_["extensionsRequired"] = {"KHR_node_visibility", "KHR_lights_punctual"};
  root_["extensions"]["KHR_lights_punctual"]["lights"] = test::Json::parse(R"([{"type": "point"}])");
  root_["nodes"] = test::Json::parse(R"([{"mesh": 0}, {"mesh": 0, "children": [2, 3],
      "extensions": {"KHR_node_visibility": {"visible": false}}}, {"mesh": 0, "extensions":
      {"KHR_node_visibility": {"visible": true}}}, {"extensions": {"KHR_lights_punctual": {"light": 0}}},
      {"mesh": 0, "extensions": {"KHR_node_visibility": {}}}])");
  root_["scenes"][0]["nodes"] = {0, 1, 4};
  const Scene scene = load();
  EXPECT_TRUE(scene.warnings.empty());
  for (const auto& [node, visible] : {std::pair(0, true), std::pair(1, false), std::pair(2, false), std::pair(4, true)})
    EXPECT_EQ(scene.nodes.at(static_cast<std::size_t>(node)).visible, visible) << node;
  EXPECT_EQ(scene.nodes.at(3).light, -1);
}

TEST_F(GltfStructure, IntegersAreSpelledInManyWays) {
  primitive()["material"] = 0;
  primitive()["mode"] = 4;
  root_["materials"] = test::Json::parse(R"([{"normalTexture": {"index": 0, "texCoord": 1}}, {}])");
  root_["images"] = test::Json::parse(
      R"([{"uri": "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8/5+hHgAHggJ/PchI7wAAAABJRU5ErkJggg=="}])");
  root_["samplers"] = test::Json::parse(R"([{"magFilter": 9728, "wrapS": 33071}])");
  root_["textures"] = test::Json::parse(R"([{"source": 0, "sampler": 0}])");
  root_["extensions"]["KHR_lights_punctual"]["lights"] = test::Json::parse(R"([{"type": "point"}])");
  root_["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  root_["extensions"]["KHR_materials_variants"]["variants"] = test::Json::parse(R"([{"name": "a"}, {"name": "b"}])");
  primitive()["extensions"]["KHR_materials_variants"]["mappings"] =
      test::Json::parse(R"([{"material": 1, "variants": [1]}])");
  std::string text = text_with("data:application/octet-stream;base64," + base64());
  for (const auto& [from, to] :
       std::vector<std::pair<std::string, std::string>>{{"\"componentType\":5126", "\"componentType\":5.126e3"},
                                                        {"\"componentType\":5123", "\"componentType\":5123.0"},
                                                        {"\"count\":4", "\"count\":0.04E+2"},
                                                        {"\"mesh\":0", "\"mesh\":-0"},
                                                        {"\"buffer\":0", "\"buffer\":-0.0"},
                                                        {"\"bufferView\":1", "\"bufferView\":1.0"},
                                                        {"\"scene\":0", "\"scene\":0e0"},
                                                        {"\"nodes\":[0]", "\"nodes\":[0.0]"},
                                                        {"\"POSITION\":0", "\"POSITION\":0.0"},
                                                        {"\"indices\":1", "\"indices\":1e0"},
                                                        {"\"index\":0", "\"index\":0.0"},
                                                        {"\"texCoord\":1", "\"texCoord\":1.0"},
                                                        {"\"light\":0", "\"light\":0.0"},
                                                        {"\"variants\":[1]", "\"variants\":[1.0]"},
                                                        {"\"magFilter\":9728", "\"magFilter\":9.728e3"},
                                                        {"\"wrapS\":33071", "\"wrapS\":33071.0"},
                                                        {"\"source\":0", "\"source\":0.0"},
                                                        {"\"sampler\":0", "\"sampler\":0.0"},
                                                        {"\"mode\":4", "\"mode\":4.0"},
                                                        {"\"material\":1", "\"material\":1.0"}})
    text = respell(text, from, to);
  const Scene scene = load_gltf(write_text("spelled.gltf", text));
  EXPECT_EQ(count_triangles(scene), 2u);
  EXPECT_EQ(scene.warnings.size(), 1u);
  expect_warning(scene, "meshes[0].primitives[0]: its textures use TEXCOORD_1, which it does not have");
  const Primitive& out = scene.meshes[0].primitives[0];
  EXPECT_EQ(out.positions[2], glm::vec3(1, 1, 0));
  EXPECT_EQ(out.material, 0);
  EXPECT_EQ(out.variant_materials.at(1), 1);
  EXPECT_EQ(scene.nodes[0].light, 0);
  EXPECT_EQ(scene.materials[0].normal_texture.image, 0);
  EXPECT_EQ(scene.materials[0].normal_texture.uv_set, 1);
  EXPECT_TRUE(scene.materials[0].normal_texture.nearest);
  EXPECT_EQ(scene.materials[0].normal_texture.wrap_s, Wrap::clamp_to_edge);
  for (const char* broken : {"\"mesh\":0.5", "\"mesh\":-1", "\"mesh\":-1.0", "\"mesh\":1e300", "\"mesh\":\"0\""})
    expect_error(write_text("broken.gltf", respell(text, "\"mesh\":-0", broken)), "nodes[0].mesh");
  expect_error(write_text("broken.gltf", respell(text, "\"texCoord\":1.0", "\"texCoord\":0.5")), "texCoord");
  expect_error(write_text("broken.gltf", respell(text, "5.126e3", "4294972422")), "accessors[0].componentType");
}

TEST_F(GltfStructure, DataUrisFollowTheirRfc) {
  const std::string encoded = base64();
  EXPECT_EQ(triangles_with("data:application/octet-stream;base64," + encoded), 2u);
  EXPECT_EQ(triangles_with("DATA:Application/Octet-Stream;BASE64," + encoded), 2u);
  EXPECT_EQ(triangles_with("data:application/gltf-buffer;charset=utf-8;base64," + encoded), 2u);
  EXPECT_EQ(triangles_with("data:;base64," + encoded), 2u);
  EXPECT_EQ(triangles_with("data:application/octet-stream;base64," + percent(encoded)), 2u);
  EXPECT_EQ(triangles_with("data:application/octet-stream," + percent(bytes_)), 2u);
  EXPECT_EQ(triangles_with("data:," + percent(bytes_)), 2u);
  EXPECT_EQ(triangles_with("Data:," + percent(bytes_)), 2u);
}

/// Images too: their bytes come by the same rules.
TEST_F(GltfStructure, DataUrisOfImages) {
  root_["images"] = test::Json::parse(
      R"([{"uri": "DATA:image/png;charset=us-ascii;Base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8/5%2BhHgAHggJ/PchI7wAAAABJRU5ErkJggg%3D%3D"}])");
  const Scene scene = load();
  EXPECT_EQ(scene.images[0].width, 1);
  EXPECT_TRUE(scene.warnings.empty());
}

TEST_F(GltfStructure, RelativeUris) {
  write("a b.bin", bytes_);
  write("sph\xC3\xA8re+100%.bin", bytes_);
  write("real%20name.bin", bytes_);
  write("c#d?e.bin", bytes_);
  std::filesystem::create_directories(folder_ / "data");
  write("data/f.bin", bytes_);
  for (const char* uri : {"a%20b.bin", "a b.bin", "./a%20b.bin", "sph%C3%A8re%2B100%25.bin", "sph\xC3\xA8re+100%25.bin",
                          "sph\xC3\xA8re+100%.bin", "real%2520name.bin", "real%20name.bin", "c%23d%3Fe.bin",
                          "data/f.bin", "data%2Ff.bin", "data/../a%20b.bin", "nothing/../a%20b.bin", "data\\f.bin"})
    EXPECT_EQ(triangles_with(uri), 2u) << uri;
  expect_error(write_text("gone.gltf", text_with("gone%20.bin")), "gone .bin");
  expect_error(write_text("gone.gltf", text_with("nul%00.bin")), "nul%00.bin");
}

TEST_F(GltfStructure, ByteOrderMarkAndPadding) {
  const std::string text = text_with("data:;base64," + base64());
  EXPECT_EQ(count_triangles(load_gltf(write_text("bom.gltf", "\xEF\xBB\xBF" + text))), 2u);
  EXPECT_EQ(count_triangles(load_gltf(write_text("nul.gltf", text + std::string(3, '\0')))), 2u);
}

/// A GLB of the given chunks.
std::vector<char> chunks(const std::vector<std::pair<std::uint32_t, std::string>>& parts,
                         const std::string& rest = {}) {
  std::string body;
  const auto put = [](std::string* out, std::uint32_t value) {
    char four[4];
    std::memcpy(four, &value, 4);
    out->append(four, 4);
  };
  for (const auto& [type, content] : parts) {
    put(&body, static_cast<std::uint32_t>(content.size()));
    put(&body, type);
    body += content;
  }
  body += rest;
  std::string file = "glTF";
  put(&file, 2);
  put(&file, static_cast<std::uint32_t>(12 + body.size()));
  file += body;
  return {file.begin(), file.end()};
}

TEST_F(GltfStructure, ChunksOfAGlb) {
  constexpr std::uint32_t kJson = 0x4E4F534A, kBinary = 0x004E4942, kOther = 0x52485441;
  test::Json root = root_;
  root["buffers"] = {{{"byteLength", bytes_.size()}}};
  const std::string json = root.dump(), binary(bytes_.begin(), bytes_.end()), padded = json + std::string(3, '\0');
  const auto warnings = [this](const std::vector<char>& file) {
    const Scene scene = load_gltf(write("chunks.glb", file));
    EXPECT_EQ(count_triangles(scene), 2u);
    return scene.warnings.size();
  };
  EXPECT_EQ(warnings(chunks({{kJson, json}, {kBinary, binary}})), 0u);
  EXPECT_EQ(warnings(chunks({{kJson, padded}, {kBinary, binary}})), 0u);
  EXPECT_EQ(warnings(chunks({{kJson, "\xEF\xBB\xBF" + json}, {kBinary, binary}})), 0u);
  EXPECT_EQ(warnings(chunks({{kJson, json}, {kBinary, binary}, {kOther, "abcd"}})), 0u);
  EXPECT_EQ(warnings(chunks({{kJson, json}, {kOther, "abcd"}, {kBinary, binary}})), 1u);
  EXPECT_EQ(warnings(chunks({{kJson, json}, {kBinary, binary}}, "abc")), 1u);
  std::vector<char> longer = chunks({{kJson, json}, {kBinary, binary}});
  longer.resize(longer.size() + 5);
  EXPECT_EQ(warnings(longer), 1u);
  expect_error(write("order.glb", chunks({{kBinary, binary}, {kJson, json}})), "first GLB chunk is not JSON");
}

/// A buffer that nothing refers to needs no bytes.
TEST_F(GltfStructure, BuffersWithoutUse) {
  root_["buffers"] = {{{"byteLength", bytes_.size()}, {"uri", "data:;base64," + base64()}}, {{"byteLength", 10}}};
  const std::string text = root_.dump();
  EXPECT_EQ(count_triangles(load_gltf(write_text("unused.gltf", text))), 2u);
}

TEST_F(GltfStructure, MessagesQuoteNoPayload) {
  const std::string secret(5000, 'Q');
  const auto message_of = [&](const std::string& text) {
    try {
      load_gltf(write_text("secret.gltf", text));
    } catch (const Error& e) {
      return std::string(e.what());
    }
    ADD_FAILURE() << "accepted " << text.substr(0, 200);
    return std::string();
  };
  const std::string whole = text_with("data:;base64," + base64());
  const test::Json root = test::Json::parse(whole);
  std::vector<std::string> texts = {
      whole.substr(0, whole.find(";base64,") + 8) + secret,                      // ends within a string
      respell(whole, "\"mesh\":0", "\"mesh\":\"data:;base64," + secret + "\""),  // wrong type
      respell(whole, "\"mesh\":0", "\"mesh\":1" + std::string(5000, '0')),
      respell(whole, "\"type\":\"VEC3\"", "\"type\":\"data:,QQQQQQQQ\""),
      text_with("data:text/plain;base64;" + secret),
      text_with(secret),
      text_with("data:;base64,!!" + secret),
  };
  test::Json required = root;
  required["extensionsRequired"] = {secret + "\n"};
  texts.push_back(required.dump());
  for (const std::string& text : texts) {
    const std::string message = message_of(text);
    EXPECT_LT(message.size(), 500u) << message;
    EXPECT_EQ(message.find("QQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQQ"), std::string::npos);
    EXPECT_EQ(message.find('\n'), std::string::npos);
    EXPECT_EQ(message.find("data:,QQQ"), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace maquette
