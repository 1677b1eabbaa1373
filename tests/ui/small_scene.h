#pragma once

#include "scenes/scene.h"

namespace maquette::test {

/// Three materials, a node with a mesh below another one, two variants.
inline Scene small_scene() {
  Scene scene;
  scene.name = "small.glb";
  for (const char* name : {"paint", "leather", "a material with a name that is much too long for its row"}) {
    Material material;
    material.name = name;
    scene.materials.push_back(material);
  }
  Mesh mesh;
  mesh.name = "door";
  mesh.primitives.resize(1);
  mesh.primitives[0].material = 1;
  scene.meshes.push_back(mesh);
  Node root, door;
  root.name = "car";
  root.children = {1};
  door.name = "door_left";
  door.parent = 0;
  door.mesh = 0;
  scene.nodes = {root, door};
  scene.roots = {0};
  scene.variants = {"base", "touring"};
  return scene;
}

}  // namespace maquette::test
