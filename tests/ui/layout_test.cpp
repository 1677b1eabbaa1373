#include "ui/layout.h"

#include <gtest/gtest.h>

namespace maquette {
namespace {

void expect_parts_apart(const LayoutRequest& request) {
  const auto parts = compute_layout(request).parts();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto& [name, rect] = parts[i];
    EXPECT_GE(rect.x, 0.0f) << name;
    EXPECT_GE(rect.y, 0.0f) << name;
    EXPECT_LE(rect.x + rect.width, std::max(request.width, 1.0f)) << name << " at width " << request.width;
    EXPECT_LE(rect.y + rect.height, std::max(request.height, 1.0f)) << name << " at height " << request.height;
    for (std::size_t j = i + 1; j < parts.size(); ++j)
      EXPECT_FALSE(overlap(rect, parts[j].second))
          << name << " over " << parts[j].first << " at " << request.width << " x " << request.height;
  }
}

TEST(Layout, PartsNeverOverlap) {
  for (const float width : {1.0f, 17.0f, 320.0f, 640.0f, 801.0f, 1280.0f, 1920.0f, 7680.0f})
    for (const float height : {1.0f, 40.0f, 211.0f, 720.0f, 1080.0f, 4320.0f})
      for (const float scale : {1.0f, 1.25f, 2.0f, 3.0f})
        for (const bool open : {false, true})
          for (const float strip : {0.0f, 40.0f, 4000.0f}) {
            LayoutRequest request{width, height, scale, open, open, strip};
            expect_parts_apart(request);
            request.right_open = !open;
            expect_parts_apart(request);
          }
}

TEST(Layout, CoversTheWholeWindow) {
  const LayoutRequest request{1280.0f, 720.0f, 1.0f, true, true, 50.0f};
  float area = 0.0f;
  for (const auto& [name, rect] : compute_layout(request).parts()) area += rect.width * rect.height;
  EXPECT_FLOAT_EQ(area, 1280.0f * 720.0f);
}

TEST(Layout, ShowsBothSidesAt1280) {
  const Layout layout = compute_layout({});
  EXPECT_TRUE(layout.left_shown);
  EXPECT_TRUE(layout.right_shown);
  EXPECT_GE(layout.picture.width, 600.0f);
  EXPECT_GE(layout.picture.height, 600.0f);
}

TEST(Layout, SidesGiveWayToThePicture) {
  const Layout small = compute_layout({.width = 500.0f});
  EXPECT_TRUE(small.left_shown != small.right_shown || !small.left_shown);
  EXPECT_GE(small.picture.width, 500.0f / 3.0f);
  EXPECT_GE(compute_layout({.width = 1.0f, .height = 1.0f}).picture.width, 1.0f);
}

TEST(Layout, OverlapSeesWhatOverlaps) {
  EXPECT_TRUE(overlap({0, 0, 10, 10}, {9, 9, 10, 10}));
  EXPECT_FALSE(overlap({0, 0, 10, 10}, {10, 0, 10, 10}));
  EXPECT_FALSE(overlap({0, 0, 10, 10}, {2, 2, 0, 5}));
}

}  // namespace
}  // namespace maquette
