#include "render/slf/atlas.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "scenes/error.h"
#include "scenes/modelling.h"

namespace maquette {
namespace {

FlatGeometry geometry_of(const Primitive& primitive) {
  Scene scene;
  scene.meshes.push_back({"part", {primitive}, nullptr});
  Node node;
  node.name = "part";
  node.mesh = 0;
  scene.nodes.push_back(node);
  scene.roots.push_back(0);
  return flatten(scene);
}

std::vector<AtlasPart> all_parts(const FlatGeometry& g) {
  std::vector<AtlasPart> parts;
  for (std::size_t i = 0; i < g.items.size(); ++i) parts.push_back({i, false});
  return parts;
}

/// Every bilinear read on a side stays in its chart; every texel lies on its side where it says.
void expect_sound(const FlatGeometry& g, const LightFieldAtlas& atlas) {
  std::vector<bool> has_texel(atlas.axes.size(), false);
  for (const AtlasTexel& texel : atlas.texels) {
    const AtlasSide& side = atlas.sides[texel.side];
    has_texel[side.chart] = true;
    EXPECT_GE(std::min(texel.barycentric.x, texel.barycentric.y), 0.0f);
    EXPECT_LE(texel.barycentric.x + texel.barycentric.y, 1.0f + 1e-6f);
  }
  for (const bool has : has_texel) EXPECT_TRUE(has);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit;
  std::size_t wrong = 0;
  for (int i = 0; i < 20000 && !atlas.sides.empty(); ++i) {
    const AtlasSide& side = atlas.sides[random() % atlas.sides.size()];
    float u = unit(random), v = unit(random);
    if (u + v > 1.0f) u = 1.0f - u, v = 1.0f - v;
    if (i % 3 == 0) u = 0.0f;
    const glm::vec2 p = side.at[0] + u * (side.at[1] - side.at[0]) + v * (side.at[2] - side.at[0]) - 0.5f;
    const glm::vec2 floor = glm::floor(p), f = p - floor;
    for (int k = 0; k < 4; ++k) {
      const float weight = (k % 2 ? f.x : 1.0f - f.x) * (k / 2 ? f.y : 1.0f - f.y);
      if (weight < 1e-6f) continue;
      const int x = static_cast<int>(floor.x) + k % 2, y = static_cast<int>(floor.y) + k / 2;
      ASSERT_TRUE(x >= 0 && y >= 0 && x < atlas.side && y < atlas.side);
      const std::uint32_t texel = atlas.texel_of_cell[static_cast<std::size_t>(y * atlas.side + x)];
      wrong += texel == LightFieldAtlas::kNone || atlas.sides[atlas.texels[texel].side].chart != side.chart ? 1 : 0;
    }
  }
  EXPECT_EQ(wrong, 0u);
  (void)g;
}

/// The texels of a chart do not show a place twice, and each shows the place where it is read.
void expect_texels_on_their_sides(const LightFieldAtlas& atlas) {
  std::set<std::pair<int, int>> cells;
  for (const AtlasTexel& t : atlas.texels) {
    EXPECT_TRUE(cells.insert({t.x, t.y}).second);
    const AtlasSide& side = atlas.sides[t.side];
    const glm::vec2 p =
        side.at[0] + t.barycentric.x * (side.at[1] - side.at[0]) + t.barycentric.y * (side.at[2] - side.at[0]);
    EXPECT_LT(glm::length(p - glm::vec2(t.x + 0.5f, t.y + 0.5f)), 1.0f);
  }
}

double area_of(const FlatGeometry& g) {
  double area = 0.0;
  for (std::size_t i = 0; i + 2 < g.indices.size(); i += 3) {
    const glm::dvec3 a(g.positions[g.indices[i]]), b(g.positions[g.indices[i + 1]]), c(g.positions[g.indices[i + 2]]);
    area += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  return area;
}

TEST(LightFieldAtlas, CoversASphereWithoutUvs) {
  const FlatGeometry g = geometry_of(modelling::make_sphere(0.5, 24));
  const LightFieldAtlas atlas = make_atlas(g, all_parts(g), {.side = 128});
  EXPECT_EQ(atlas.sides.size(), g.indices.size() / 3);
  EXPECT_LT(atlas.axes.size(), 40u);
  EXPECT_EQ(atlas.own_charts.size(), 1u);
  expect_sound(g, atlas);
  expect_texels_on_their_sides(atlas);
  // Charts are projected along their axes: they have at least half of the area's texels, and not more than it.
  const double texels = area_of(g) * atlas.texels_per_m * atlas.texels_per_m;
  EXPECT_LT(static_cast<double>(atlas.texels.size()), 1.02 * texels);
  EXPECT_GT(static_cast<double>(atlas.texels.size()), 0.5 * texels);
  EXPECT_GT(static_cast<double>(atlas.texels.size()), 0.35 * 128 * 128) << "of the atlas is used";
  for (const AtlasSide& side : atlas.sides) {
    const glm::vec3 a = g.positions[g.indices[3 * side.triangle]];
    EXPECT_GT(glm::dot(glm::normalize(a), atlas.axes[side.chart]), 0.3f) << "in the cone";
  }
}

Primitive sheet(int n) { return modelling::make_quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, n); }

TEST(LightFieldAtlas, UsesAValidSecondUvSet) {
  Primitive p = sheet(4);
  p.uvs[1] = p.uvs[0];
  const FlatGeometry g = geometry_of(p);
  EXPECT_EQ(check_second_uvs(g, 0), "");
  const LightFieldAtlas atlas = make_atlas(g, all_parts(g), {.side = 34});
  EXPECT_EQ(atlas.axes.size(), 1u);
  EXPECT_TRUE(atlas.own_charts.empty());
  EXPECT_EQ(atlas.texels.size(), 32u * 32u);
  expect_sound(g, atlas);
  expect_texels_on_their_sides(atlas);
}

TEST(LightFieldAtlas, BadSecondUvSetsAreNamedAndReplaced) {
  const float nan = std::nanf("");
  const auto check = [&](const char* fault, const std::function<void(std::vector<glm::vec2>*)>& spoil) {
    Primitive p = sheet(4);
    p.uvs[1] = p.uvs[0];
    spoil(&p.uvs[1]);
    const FlatGeometry g = geometry_of(p);
    EXPECT_EQ(check_second_uvs(g, 0), fault);
    const LightFieldAtlas atlas = make_atlas(g, all_parts(g), {.side = 40});
    ASSERT_EQ(atlas.own_charts.size(), 1u);
    EXPECT_NE(atlas.own_charts[0].second.find(fault), std::string::npos);
    EXPECT_EQ(atlas.axes.size(), 1u);
    expect_sound(g, atlas);
    expect_texels_on_their_sides(atlas);
  };
  check("there is none", [](auto* uvs) { uvs->clear(); });
  check("there is none", [](auto* uvs) { std::fill(uvs->begin(), uvs->end(), glm::vec2(0.5f)); });
  check("a coordinate is not finite", [&](auto* uvs) { (*uvs)[3].x = nan; });
  check("a coordinate is outside the unit square", [](auto* uvs) { (*uvs)[3].x = 1.7f; });
  check("a triangle has no area in it", [](auto* uvs) { (*uvs)[0] = (*uvs)[1]; });
  // Folded about the middle: one half mirrored onto the other.
  check("it overlaps itself", [](auto* uvs) {
    for (glm::vec2& uv : *uvs) uv.x = 0.5f - std::abs(uv.x - 0.5f);
  });
}

TEST(LightFieldAtlas, AMirroredUvSetIsUsed) {
  Primitive p = sheet(4);
  p.uvs[1] = p.uvs[0];
  for (glm::vec2& uv : p.uvs[1]) uv.x = 1.0f - uv.x;
  const FlatGeometry g = geometry_of(p);
  EXPECT_EQ(check_second_uvs(g, 0), "");
  const LightFieldAtlas atlas = make_atlas(g, all_parts(g), {.side = 34});
  expect_sound(g, atlas);
  expect_texels_on_their_sides(atlas);
}

TEST(LightFieldAtlas, TrianglesWithoutAreaOrWithNaNHaveNoSide) {
  Primitive p = sheet(4);
  const auto n = static_cast<std::uint32_t>(p.positions.size());
  p.positions.insert(p.positions.end(), {glm::vec3(2, 0, 0), glm::vec3(3, 0, 0), glm::vec3(std::nanf(""), 0, 0)});
  p.normals.insert(p.normals.end(), 3, glm::vec3(0, 0, 1));
  p.uvs[0].insert(p.uvs[0].end(), 3, glm::vec2(0));
  p.indices.insert(p.indices.end(), {n, n + 1, n, n, n + 1, n + 2});
  const FlatGeometry g = geometry_of(p);
  const LightFieldAtlas atlas = make_atlas(g, all_parts(g), {.side = 40});
  EXPECT_EQ(atlas.sides.size(), 32u);
  expect_sound(g, atlas);
  Primitive flat;
  flat.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  flat.normals = {3, glm::vec3(0, 0, 1)};
  flat.indices = {0, 1, 2};
  const FlatGeometry empty = geometry_of(flat);
  const LightFieldAtlas none = make_atlas(empty, all_parts(empty), {.side = 8});
  EXPECT_TRUE(none.texels.empty());
}

TEST(LightFieldAtlas, OneTexelIsEnoughForOneChart) {
  const FlatGeometry g = geometry_of(sheet(2));
  const LightFieldAtlas atlas = make_atlas(g, all_parts(g), {.side = 1});
  EXPECT_EQ(atlas.texels.size(), 1u);
  expect_sound(g, atlas);
  const FlatGeometry box = geometry_of(modelling::make_rounded_box({1, 1, 1}, 0.1));
  try {
    make_atlas(box, all_parts(box), {.side = 1});
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("slf.texels"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("charts"), std::string::npos);
  }
}

TEST(LightFieldAtlas, DensityDecidesTheSide) {
  const FlatGeometry g = geometry_of(modelling::make_rounded_box({1, 1, 1}, 0.1));
  const LightFieldAtlas atlas = make_atlas(g, all_parts(g), {.texels_per_m = 50.0});
  EXPECT_EQ(atlas.texels_per_m, 50.0);
  EXPECT_EQ(atlas.side % 16, 0);
  EXPECT_GT(static_cast<double>(atlas.texels.size()), 0.7 * 6.0 * 50.0 * 50.0);
  expect_sound(g, atlas);
  EXPECT_THROW(make_atlas(g, all_parts(g), {.texels_per_m = 1e6}), Error);
}

TEST(LightFieldAtlas, BothSidesHaveTexels) {
  const FlatGeometry g = geometry_of(sheet(2));
  const LightFieldAtlas atlas = make_atlas(g, {{0, true}}, {.side = 64});
  ASSERT_EQ(atlas.axes.size(), 2u);
  EXPECT_NEAR(glm::dot(atlas.axes[0], atlas.axes[1]), -1.0f, 1e-6f);
  expect_sound(g, atlas);
}

/// A sheet that turns about itself like a stair: no cone of normals divides it, its projection covers itself.
TEST(LightFieldAtlas, ASpiralDoesNotCoverItself) {
  const Primitive spiral = modelling::make_grid(200, 4, [](double u, double v) {
    const double turn = 6.0 * std::numbers::pi * u;
    return glm::dvec3((0.3 + v) * std::cos(turn), 0.4 * u, (0.3 + v) * std::sin(turn));
  });
  const FlatGeometry g = geometry_of(spiral);
  const LightFieldAtlas atlas = make_atlas(g, all_parts(g), {.side = 256});
  EXPECT_GE(atlas.axes.size(), 3u);
  expect_sound(g, atlas);
  expect_texels_on_their_sides(atlas);
  const double texels = area_of(g) * atlas.texels_per_m * atlas.texels_per_m;
  EXPECT_GT(static_cast<double>(atlas.texels.size()), 0.8 * texels);
}

TEST(LightFieldAtlas, AMeshOfAMillionTrianglesIsCut) {
  const FlatGeometry g = geometry_of(modelling::make_sphere(1.0, 290));
  ASSERT_GT(g.indices.size() / 3, 1000000u);
  const LightFieldAtlas atlas = make_atlas(g, all_parts(g), {.side = 64});
  EXPECT_EQ(atlas.sides.size(), g.indices.size() / 3);
  EXPECT_LT(atlas.axes.size(), 60u);
  expect_sound(g, atlas);
}

TEST(LightFieldAtlas, MaskedTexelsTakeTheirNeighbours) {
  const FlatGeometry g = geometry_of(sheet(2));
  LightFieldAtlas atlas = make_atlas(g, all_parts(g), {.side = 18});
  std::vector<bool> masked(atlas.texels.size());
  for (std::size_t t = 0; t < masked.size(); ++t) masked[t] = atlas.texels[t].x < 9;
  fill_masked_texels(masked, &atlas);
  for (const std::uint32_t t : atlas.texel_of_cell) EXPECT_TRUE(t == LightFieldAtlas::kNone || !masked[t]);
  LightFieldAtlas other = make_atlas(g, all_parts(g), {.side = 18});
  fill_masked_texels(std::vector<bool>(other.texels.size(), true), &other);
  EXPECT_NE(other.texel_of_cell[static_cast<std::size_t>(5 * 18 + 5)], LightFieldAtlas::kNone);
}

}  // namespace
}  // namespace maquette
