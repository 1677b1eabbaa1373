#include "scenes/harmless.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "scenes/error.h"
#include "scenes/file_name.h"
#include "scenes/json_fault.h"
#include "scenes/suggest.h"

namespace maquette {
namespace {

TEST(Harmless, KeepsWhatIsText) {
  for (const std::string text : {"", "Paint red (2)", "Größe 3 µm", "Краска", "塗料", "صبغ", "🚗 \\x1b"})
    EXPECT_EQ(harmless(text), text);
  EXPECT_EQ(harmless("a\n\tb", true), "a\n\tb");
}

TEST(Harmless, WritesWhatSteersATerminalAsEscapes) {
  EXPECT_EQ(harmless("\x1b[31mred\x7f\n"), "\\x1b[31mred\\x7f\\x0a");
  EXPECT_EQ(harmless("a\xc2\x9b"
                     "31m"),
            "a\\u009b31m");
  EXPECT_EQ(harmless("a\xe2\x80\xae"
                     "gpj.exe"),
            "a\\u202egpj.exe");
  EXPECT_EQ(harmless(std::string("\xff\xc3(\xed\xa0\x80\0x", 8)), "\\xff\\xc3(\\xed\\xa0\\x80\\x00x");
}

/// Whatever bytes come: none steers, and text is UTF-8.
TEST(Harmless, HoldsForAnyBytes) {
  std::mt19937 random(49);
  for (int round = 0; round < 20000; ++round) {
    std::string bytes;
    for (std::size_t n = random() % 12; n > 0; --n)
      bytes += static_cast<char>(random() % 3 ? 128 + random() % 128 : random() % 128);
    const std::string text = harmless(bytes);
    EXPECT_EQ(harmless(text), text);
    EXPECT_NO_THROW(static_cast<void>(nlohmann::json(text).dump()));  // throws where it is no UTF-8
    for (const char c : text) EXPECT_TRUE(static_cast<unsigned char>(c) >= 32 && c != 127);
  }
}

TEST(Harmless, JsonStaysTheSameDocument) {
  const nlohmann::json json = {{"name", "a\xc2\x9b\xe2\x80\xae\x1b"}, {"b", {"塗料", 1}}};
  const std::string text = harmless_json(json.dump(2));
  EXPECT_EQ(text.find("\xc2\x9b"), std::string::npos);
  EXPECT_EQ(text.find("\xe2\x80\xae"), std::string::npos);
  EXPECT_NE(text.find("塗料"), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(text), json);
}

TEST(FileNames, OfDifferentNamesDiffer) {
  const std::vector<std::string> names = {"Cam a",
                                          "Cam-a",
                                          "Cam_a",
                                          "Cam/a",
                                          "Cam:a",
                                          "Cäm a",
                                          "",
                                          "-",
                                          ".",
                                          "..",
                                          std::string(300, 'x'),
                                          std::string(301, 'x'),
                                          "Cam a "};
  for (const auto& name_of : {file_name_of, readable_file_name})
    for (const std::string& a : names) {
      const std::string file = name_of(a);
      EXPECT_TRUE(!file.empty() && file.size() < 200 && file.front() != '.') << file;
      EXPECT_EQ(file.find('/'), std::string::npos);
      for (const std::string& b : names) EXPECT_EQ(file == name_of(b), a == b) << a << " and " << b;
    }
  EXPECT_EQ(file_name_of("driver-2"), "driver-2");
  EXPECT_EQ(readable_file_name("evening, rot 塗"), "evening, rot 塗");
}

TEST(Harmless, AnyNameComesBackFromUtf8) {
  std::mt19937 random(7);
  for (int i = 0; i < 2000; ++i) {
    std::string name(random() % 12, ' ');
    for (char& c : name) c = static_cast<char>(random() % 3 == 0 ? 0xc0u + random() % 64u : random() % 256u);
    if (i % 7 == 0) name += "caf\xc3\xa9 \xf4\x8f";
    const std::string text = as_utf8(name);
    EXPECT_EQ(from_utf8(text), name);
    EXPECT_NO_THROW(nlohmann::json(text).dump()) << harmless(name);
  }
  EXPECT_EQ(as_utf8("caf\xc3\xa9"), "caf\xc3\xa9");
}

TEST(Harmless, TagsThatNobodySeesAreWritten) {
  const std::string tag = "a\xf3\xa0\x81\x81z";  // U+E0041
  EXPECT_EQ(harmless(tag), "a\\ue0041z");
  const std::string json = harmless_json("\"" + tag + "\"");
  EXPECT_EQ(json, "\"a\\udb40\\udc41z\"");
  EXPECT_EQ(nlohmann::json::parse(json).get<std::string>(), tag);
}

TEST(Harmless, AMessageDoesNotEndAtACharacterZero) {
  const std::string name("red\0blue", 8);
  const Error error("a.glb", "material " + name + " is not there", "name another");
  EXPECT_EQ(std::string(error.what()), "a.glb: material red\\x00blue is not there; name another");
}

TEST(Harmless, LongNamesAreCutInListsAndDoNotTakeLong) {
  const std::string most(1000, 'm'), text = did_you_mean("wheel", {most + "a", most + "b"});
  EXPECT_LT(text.size(), 250u) << text;
  EXPECT_NE(text.find(" ... "), std::string::npos) << text;
  EXPECT_GT(edit_distance(std::string(1'000'000, 'a'), std::string(1'000'000, 'b')), 100);
}

TEST(JsonFault, SaysPlaceAndFault) {
  const auto said = [](const char* text) -> std::string {
    try {
      return nlohmann::json::parse(text).dump();
    } catch (const nlohmann::json::exception& e) {
      return json_fault(e.what());
    }
  };
  EXPECT_EQ(said("{\"a\": }"), "line 1, column 7: unexpected '}'; expected '[', '{', or a literal");
  EXPECT_TRUE(said("{\"a\nb\": 1}").starts_with("line 2, column 0: invalid string: control character U+000A (LF)"))
      << said("{\"a\nb\": 1}");
}

TEST(JsonFault, HasNoNumberOfTheLibraryAndNoPayload) {
  try {
    const nlohmann::json json = nlohmann::json::parse("{\"a\": " + std::string(5000, '1') + "x");
    FAIL();
  } catch (const nlohmann::json::exception& e) {
    const std::string text = json_fault(e.what());
    EXPECT_EQ(text.find("json.exception"), std::string::npos) << text;
    EXPECT_LT(text.size(), 200u) << text;
  }
}

}  // namespace
}  // namespace maquette
