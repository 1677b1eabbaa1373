// Names in scripts beyond Latin: the font has what occurs.
#include "ui/glyphs.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/ui/headless_editor.h"
#include "tests/ui/small_scene.h"

namespace maquette {
namespace {

bool has_glyph(char16_t c) { return ImGui::GetIO().Fonts->Fonts[0]->FindGlyphNoFallback(c) != nullptr; }

TEST(Glyphs, AreThoseThatOccurInNames) {
  Scene scene = test::small_scene();
  scene.nodes[0].name = "Приборная панель";
  scene.materials[0].name = "\u6f06\u5857\u308a\ud55c\uad6d";  // lacquer in Japanese, and Korea
  test::HeadlessEditor editor(1280.0f, 720.0f);
  editor.facts.scene = &scene;
  Look look;
  look.name = "\u53d6\x1b\xff";
  editor.state.looks.push_back(look);
  Glyphs glyphs;
  glyphs.note(editor.state, editor.facts);
  EXPECT_EQ(glyphs.all(), (std::set<char16_t>{u'\u308a', u'\u53d6', u'\u5857', u'\u6f06', u'\uad6d', u'\ud55c'}));
  for (const char16_t c : {u'я', u'Ω', u'ệ', u'é'}) EXPECT_TRUE(has_glyph(c)) << static_cast<int>(c);
}

TEST(Glyphs, AreMadeOrSaidToBeMissing) {
  test::HeadlessEditor editor(640.0f, 480.0f);
  const std::set<char16_t> wanted{u'\u6f06', u'\ud55c', u'\u308a', u'\u0e01'};
  const std::set<char16_t> missing = apply_theme(1.0f, 1.0f, wanted);
  for (const char16_t c : wanted) EXPECT_EQ(has_glyph(c), !missing.contains(c)) << static_cast<int>(c);
  EXPECT_TRUE(has_glyph('A'));
  if ((!std::filesystem::exists("/usr/share/fonts/truetype/droid/DroidSansFallbackFull.ttf") ||
       !std::filesystem::exists("/usr/share/fonts/truetype/nanum/NanumGothic.ttf")) &&
      !std::filesystem::exists("/usr/share/fonts/opentype/noto/NotoSansCJK-Regular.ttc"))
    GTEST_SKIP() << "no fonts with Chinese and Korean are installed";
  for (const char16_t c : {u'\u6f06', u'\ud55c', u'\u308a'}) EXPECT_TRUE(has_glyph(c)) << static_cast<int>(c);
  unsigned char* pixels = nullptr;
  int width = 0, height = 0;
  ImGui::GetIO().Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
  EXPECT_LT(height, 2048) << "only what occurs";
}

}  // namespace
}  // namespace maquette
