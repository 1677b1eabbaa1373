#include "scenes/suggest.h"

#include <gtest/gtest.h>

namespace maquette {
namespace {

TEST(Suggest, EditDistanceCountsSlips) {
  EXPECT_EQ(edit_distance("bandwidth", "bandwidth"), 0);
  EXPECT_EQ(edit_distance("bandwith", "bandwidth"), 1);
  EXPECT_EQ(edit_distance("badnwidth", "bandwidth"), 1);  // transposition
  EXPECT_EQ(edit_distance("Uniform", "uniform"), 0);
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
}

TEST(Suggest, NearestFirstAndOnlyNearOnes) {
  const std::vector<std::string> names = {"driver", "passenger", "exterior", "door"};
  EXPECT_EQ(nearest_names("drivr", names), std::vector<std::string>{"driver"});
  EXPECT_EQ(nearest_names("dor", names).front(), "door");
  EXPECT_TRUE(nearest_names("windshield", names).empty());
  EXPECT_EQ(nearest_names("lether", {"paint-red", "leather-black"}), std::vector<std::string>{"leather-black"});
  EXPECT_EQ(nearest_names("pass", names), std::vector<std::string>{"passenger"});  // a part of the name
}

TEST(Suggest, SaysTheNearestOrListsAll) {
  EXPECT_EQ(did_you_mean("unform", {"uniform", "splitsum"}), "did you mean uniform?");
  EXPECT_EQ(did_you_mean("xyzzy", {"uniform", "splitsum"}), "known: uniform, splitsum");
  EXPECT_EQ(did_you_mean("xyzzy", {}), "");
}

}  // namespace
}  // namespace maquette
