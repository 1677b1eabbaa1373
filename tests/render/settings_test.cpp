#include "render/technique/settings.h"

#include <gtest/gtest.h>

#include <set>

#include "render/technique/registry.h"
#include "scenes/error.h"
#include "tests/support/text.h"

namespace maquette {
namespace {

/// The message of the exception of type E that `call` throws; fails the test when there is none.
template <typename E, typename Call>
std::string message_of(const Call& call) {
  try {
    call();
  } catch (const E& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

using test::contains;

TEST(Settings, DeclarationsAreValid) {
  std::set<std::string> names;
  for (const SettingDeclaration& declaration : setting_declarations()) {
    EXPECT_TRUE(names.insert(declaration.name).second) << declaration.name << " twice";
    EXPECT_NE(declaration.name.find('.'), std::string::npos) << declaration.name;
    EXPECT_FALSE(declaration.help.empty()) << declaration.name;
    EXPECT_LE(declaration.min, declaration.max) << declaration.name;
    // The default itself must be a legal value, also when given as text.
    Settings settings;
    settings.set_from_text(declaration.name, to_text(declaration.default_value));
    EXPECT_EQ(settings.get(declaration.name), declaration.default_value) << declaration.name;
    EXPECT_TRUE(settings.changed().empty()) << declaration.name;
  }
  EXPECT_TRUE(names.contains("shading.visibility"));
  EXPECT_TRUE(names.contains("bandwidth.samples"));
}

TEST(Settings, EveryDeclarationRoundTripsThroughText) {
  for (const SettingDeclaration& declaration : setting_declarations()) {
    SettingValue other;
    if (const bool* flag = std::get_if<bool>(&declaration.default_value)) other = !*flag;
    if (std::holds_alternative<int>(declaration.default_value)) other = static_cast<int>(declaration.max);
    if (std::holds_alternative<double>(declaration.default_value)) other = declaration.min + 0.1;
    if (std::holds_alternative<std::string>(declaration.default_value))
      other = declaration.choices.empty() ? std::string("a b=c") : declaration.choices.back();
    Settings settings;
    settings.set(declaration.name, other);
    Settings copy;
    copy.set_from_text(declaration.name, to_text(settings.get(declaration.name)));
    EXPECT_EQ(copy, settings) << declaration.name;
    copy.reset(declaration.name);
    EXPECT_EQ(copy.get(declaration.name), declaration.default_value);
  }
}

TEST(Settings, WrongValuesNameTheRangeAndChangeNothing) {
  Settings settings;
  settings.set("bandwidth.max_level", 2);
  EXPECT_TRUE(contains(message_of<UsageError>([&] { settings.set("bandwidth.max_level", 6); }), "from 0 to 5"));
  EXPECT_TRUE(
      contains(message_of<UsageError>([&] { settings.set_from_text("bandwidth.max_level", "two"); }), "whole number"));
  EXPECT_THROW(settings.set_from_text("bandwidth.max_level", "3.5"), UsageError);
  EXPECT_THROW(settings.set_from_text("bandwidth.max_level", ""), UsageError);
  EXPECT_THROW(settings.set_from_text("bandwidth.max_level", "99999999999999"), UsageError);
  EXPECT_THROW(settings.set_from_text("bandwidth.quality", "nan"), UsageError);
  EXPECT_THROW(settings.set_from_text("bandwidth.quality", "inf"), UsageError);
  EXPECT_THROW(settings.set("bandwidth.max_level", std::string("2")), UsageError);
  EXPECT_EQ(settings.get_int("bandwidth.max_level"), 2);
  settings.set("bandwidth.quality", 2);  // a whole number for a real setting
  EXPECT_EQ(settings.get_double("bandwidth.quality"), 2.0);
}

TEST(Settings, UnknownNamesGetTheNearest) {
  Settings settings;
  EXPECT_TRUE(contains(message_of<UsageError>([&] { settings.set_from_text("shading.visibilty", "none"); }),
                       "did you mean shading.visibility?"));
  EXPECT_TRUE(contains(message_of<UsageError>([&] { settings.set_from_text("shading.visibility", "bakd"); }),
                       "did you mean baked?"));
}

TEST(Registry, EveryNameIsDistinctAndLaterOnesSaySo) {
  std::set<std::string> names;
  for (const Technique& technique : builtin_registry().techniques) {
    EXPECT_TRUE(names.insert(technique.name).second);
    EXPECT_FALSE(technique.help.empty());
    for (const SettingDeclaration& setting : technique.settings) EXPECT_EQ(setting.name.find(technique.name + "."), 0u);
    if (technique.kind == TechniqueKind::mode) {
      EXPECT_EQ(builtin_registry().find_mode(technique.name).name, technique.name);
    }
  }
  Registry with_later = builtin_registry();
  with_later.later_modes = {{"later", "a mode of a later version"}};
  EXPECT_TRUE(contains(message_of<Error>([&] { with_later.find_mode("later"); }), "not available in this version"));
  EXPECT_EQ(builtin_registry().find_reflector("off"), nullptr);
  EXPECT_TRUE(
      contains(message_of<UsageError>([] { builtin_registry().find_mode("unifrom"); }), "did you mean uniform?"));
  EXPECT_THROW(builtin_registry().find_mode("shading"), UsageError);  // settings, not a mode
}

}  // namespace
}  // namespace maquette
