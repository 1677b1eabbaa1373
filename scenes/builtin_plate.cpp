#include <algorithm>
#include <cmath>
#include <utility>

#include "scenes/builtin.h"
#include "scenes/modelling.h"

namespace maquette::builtin {

using namespace modelling;

namespace {

/// White marble with grey-brown veins; tileable.
TextureImage make_marble(int side) {
  TextureImage image{"marble", side, side, {}, {}};
  image.rgba.resize(static_cast<std::size_t>(side) * static_cast<std::size_t>(side) * 4);
  std::size_t at = 0;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const double u = 3.0 * x / side, v = 3.0 * y / side;
      const double warp_u = u + 1.1 * tileable_fbm(u, v, 3, 5, 11u), warp_v = v + 1.1 * tileable_fbm(u, v, 3, 5, 23u);
      // Veins follow the zero crossings of warped noise, and are strong in some regions only.
      const double broad = std::abs(tileable_noise(warp_u, warp_v, 3, 5u));
      const double fine = std::abs(tileable_noise(2.0 * warp_u + 0.37, 2.0 * warp_v, 6, 7u));
      const double strength = smoother(-0.35, 0.35, tileable_noise(u + 0.5, v + 0.5, 3, 41u));
      const double vein = (0.25 + 0.55 * strength) * std::exp(-34.0 * broad) + 0.28 * std::exp(-40.0 * fine);
      const double cloud = 0.5 + 0.8 * tileable_fbm(warp_u, warp_v, 3, 3, 31u);
      const double shade = std::clamp(0.94 - 0.62 * vein - 0.10 * cloud, 0.0, 1.0);
      const double tint[3] = {shade, shade * (1.0 - 0.03 * vein), shade * (1.0 - 0.1 * vein) - 0.02};
      for (const double c : tint)
        image.rgba[at++] = static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(c, 0.0, 1.0)));
      image.rgba[at++] = 255;
    }
  }
  return image;
}

/// A ball on a lathe-turned foot, 1.16 m tall.
Primitive make_statue() {
  std::vector<Vec2> foot{{0.0, 0.0},   {0.40, 0.0},  {0.40, 0.06}, {0.34, 0.10}, {0.34, 0.13},
                         {0.20, 0.17}, {0.13, 0.26}, {0.19, 0.31}, {0.19, 0.34}, {0.10, 0.37}};
  Primitive statue = revolve(round_corners(foot, 0.03, 4, false), 80);
  append(&statue, transformed(make_sphere(0.42, 44), translation(0.0, 0.74, 0.0)));
  return statue;
}

}  // namespace

Scene build_plate() {
  SceneBuilder builder("builtin:plate");
  Material marble = plain_material("Marble", {1.0f, 1.0f, 1.0f}, 0.0f, 0.35f);
  marble.base_color_texture.image = builder.add_image(make_marble(512));
  const int floor = builder.add_material(marble);
  const Material statues[4] = {
      measured_material("Metal", "metal-chrome", srgb(225, 225, 228), 1.0f, 0.06f),
      measured_material("Paint", "paint-red-metallic", srgb(150, 16, 22), 0.6f, 0.3f),
      measured_material("Plastic", "plastic-piano-black", srgb(18, 18, 20), 0.0f, 0.1f),
      measured_material("Matte", "matte-white", srgb(225, 225, 225), 0.0f, 1.0f),
  };
  builder.add_part("plate", transformed(make_rounded_box({5.6, 0.2, 3.6}, 0.05, 4), translation(0.0, -0.1, 0.0)),
                   floor);
  Primitive& plate = builder.scene().meshes[0].primitives[0];
  split_long_edges(&plate, 0.2);
  map_box_uvs(&plate, 0.4);
  const char* names[4] = {"statue_metal", "statue_paint", "statue_plastic", "statue_matte"};
  for (int i = 0; i < 4; ++i)
    builder.add_part(names[i], make_statue(), builder.add_material(statues[i]),
                     translation(-1.8 + 1.2 * i, 0.0, i % 2 == 0 ? -0.25 : 0.25));
  builder.add_camera("front", {0.0, 2.1, 6.0}, {0.0, 0.38, 0.0}, 30.0);
  return std::move(builder.scene());
}

}  // namespace maquette::builtin
