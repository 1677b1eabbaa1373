#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "render/gl/context.h"
#include "render/renderer.h"
#include "scenes/btf/btf_file.h"
#include "tests/gpu/drawn.h"
#include "tests/scenes/temporary_folder.h"
#include "tests/support/small_btf.h"
#include "tests/support/test_scenes.h"

/// Small scenes and requests of mode `prt`.
namespace maquette {

inline FrameRequest small_request() {
  FrameRequest r;
  r.mode = "prt";
  r.width = 64;
  r.height = 48;
  r.settings.set("prt.faces", 4);
  r.settings.set("prt.clusters", 4);
  r.settings.set("prt.components", 6);
  r.settings.set("prt.coefficients", 64);
  r.settings.set("shading.visibility", std::string("none"));
  return r;
}

/// RMSE over the mean, where `b` shows a surface.
inline double relative_difference(const Image& a, const Image& b) {
  double squares = 0.0, light = 0.0;
  for (int y = 0; y < b.height; ++y)
    for (int x = 0; x < b.width; ++x)
      for (int c = 0; c < 3 && b.at(x, y, 3) >= 1.0f; ++c) {
        squares += std::pow(static_cast<double>(a.at(x, y, c) - b.at(x, y, c)), 2.0);
        light += static_cast<double>(b.at(x, y, c));
      }
  const double count = 3.0 * b.width * b.height;
  return std::sqrt(squares / count) / (light / count);
}

class TransferMode : public maquette::test::TemporaryFolder {
 protected:
  /// A textured plate with a BTF below a block of plain material.
  std::shared_ptr<Scene> covered_plate() {
    save_btf(path("small.exr"), *test::small_btf(4, 2));
    auto scene = std::make_shared<Scene>();
    scene->materials.push_back(test::matte(glm::vec3(0.4f)));
    scene->materials[0].name = "cover";
    scene->materials[0].measured = path("small.exr");
    scene->materials.push_back(test::matte({0.6f, 0.3f, 0.2f}));
    Primitive plate = test::make_grid({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 8, 0);
    for (const glm::vec3& p : plate.positions) plate.uvs[0].emplace_back(0.5f + 0.5f * p.x, 0.5f + 0.5f * p.z);
    test::add(scene.get(), std::move(plate), "plate");
    test::add(scene.get(), test::make_grid({-0.5f, 0.0f, -0.2f}, {0.8f, 0, 0}, {0, 0.6f, 0}, 4, 1), "block");
    return scene;
  }
  /// The same before a mirror.
  std::shared_ptr<Scene> mirrored_plate() {
    auto scene = covered_plate();
    Material chrome;
    chrome.name = "chrome";
    chrome.roughness = 0.0f;
    scene->materials.push_back(chrome);
    test::add(scene.get(), test::make_grid({-1.0f, 0.0f, -0.9f}, {2, 0, 0}, {0, 1.2f, 0}, 1, 2), "mirror")->reflector =
        true;
    return scene;
  }
  static FrameRequest look(FrameRequest r) {
    r.camera.eye = {0.6f, 1.9f, 2.4f};
    r.camera.target = {0.0f, 0.1f, 0.0f};
    r.camera.fov_y_rad = 0.7f;
    return r;
  }
};

}  // namespace maquette
