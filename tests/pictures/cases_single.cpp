// One picture a program: modes, settings, reflections, debug views, files.
#include <algorithm>

#include "tests/pictures/cases.h"
#include "tests/pictures/made_scenes.h"

namespace maquette::pictures {

namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

const std::string kPlate = "builtin:plate", kCockpit = "builtin:cockpit", kCornell = "builtin:cornell";
const Words kTechniques = {"bezier", "triangle", "octree", "raytraced"};
const Words kIntoBox = {"--eye", "0.3,0.2,3.4", "--target", "0,-0.1,0", "--fov", "40"};
const Words kIntoMirror = {"--eye", "0.1,0.35,1.8", "--target", "0,0,-1", "--fov", "29"};

Words operator+(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// `--set` before each.
Words set(const Words& settings) {
  Words words;
  for (const std::string& setting : settings) words.insert(words.end(), {"--set", setting});
  return words;
}

Words in_mode(const std::string& mode, const Words& more = {}) {
  const bool counted = std::ranges::find(more, "--samples") != more.end();
  return Words{"--mode", mode} + (mode == "reference" && !counted ? Words{"--samples", "2"} : Words{}) + more;
}

/// Every mode on every built-in scene.
void add_modes(std::vector<PictureCase>* cases) {
  const auto add = [&](const std::string& mode, const std::string& scene, const std::string& camera) {
    cases->push_back(picture_of(mode + "-" + scene + (camera.empty() ? "" : "-" + camera), "builtin:" + scene,
                                in_mode(mode) + (camera.empty() ? Words{} : Words{"--camera", camera})));
  };
  for (const char* mode : {"bandwidth", "uniform", "splitsum", "sg", "reference"}) {
    add(mode, "cockpit", "driver");
    add(mode, "cockpit", "exterior");
    for (const char* scene : {"sphere", "plate", "cornell", "seat", "open-seat"}) add(mode, scene, "");
  }
  for (const char* mode : {"bandwidth", "splitsum"}) {
    add(mode, "cockpit", "passenger");
    add(mode, "cockpit", "door");
  }
  const Words few = set({"slf.texels=48", "slf.directions=4", "slf.paths=1", "prt.rays=1", "prt.faces=4",
                         "prt.clusters=4", "prt.components=1"});
  for (const char* mode : {"slf", "prt"})
    cases->push_back(
        picture_of(std::string(mode) + "-seat", "builtin:open-seat", in_mode(mode, few) + set({"ground.kind=none"})));
  cases->push_back(
      picture_of("mode-of-seat", "builtin:seat", in_mode("bandwidth", {"--mode-of", "seat_backrest=splitsum"})));
}

/// What settings make of one frame: shadows, indirect light, several samples a pixel, transport, paints.
void add_shading(std::vector<PictureCase>* cases) {
  const auto add = [&](const std::string& name, const std::string& mode, const std::string& scene,
                       const Words& settings) {
    cases->push_back(picture_of(name, scene, in_mode(mode) + set(settings)));
  };
  for (const std::string mode : {"bandwidth", "uniform"}) {
    add("visibility-baked-" + mode, mode, kPlate, {"shading.visibility=baked"});
    add("visibility-traced-" + mode, mode, kPlate, {"shading.visibility=traced", "octree.depth=7"});
  }
  add("visibility-none-cockpit", "bandwidth", kCockpit, {"shading.visibility=none"});
  add("visibility-traced-cockpit", "bandwidth", kCockpit, {"shading.visibility=traced", "octree.depth=7"});
  add("indirect-none-plate", "uniform", kPlate, {"shading.visibility=baked", "shading.indirect=none"});
  add("indirect-none-cockpit", "bandwidth", kCockpit, {"shading.indirect=none"});
  add("indirect-none-cockpit-sg", "sg", kCockpit, {"shading.indirect=none"});
  add("reference-direct", "reference", kPlate, {"reference.transport=direct", "reference.adaptive=false"});
  add("reference-bounces-1", "reference", kCornell, {"reference.bounces=1"});
  add("bandwidth-level-0", "bandwidth", kPlate, {"bandwidth.max_level=0"});
  add("bandwidth-quality-4", "bandwidth", kPlate, {"bandwidth.quality=4"});
  for (const auto& [mode, scene, msaa] : {std::tuple{"bandwidth", kCockpit, "4"},
                                          {"bandwidth", kPlate, "16"},
                                          {"uniform", kPlate, "4"},
                                          {"splitsum", kCockpit, "16"},
                                          {"sg", kPlate, "4"},
                                          {"reference", kPlate, "4"}})
    cases->push_back(picture_of(std::string("msaa") + msaa + "-" + mode + "-" + scene.substr(scene.find(':') + 1),
                                scene, in_mode(mode, {"--msaa", msaa, "--size", "112x64"})));
  for (const std::string mode : {"bandwidth", "splitsum", "sg"})
    cases->push_back(picture_of(
        "paints-" + mode, kCockpit,
        in_mode(mode,
                {"--env", "builtin:studio", "--camera", "exterior", "--material", "Paint=builtin:paint-blue-metallic",
                 "--material", "Ground=builtin:wood-satin", "--material", "Mirror=builtin:metal-gunmetal"})));
  for (const char* size : {"97x61", "16x16", "200x33", "1x1"})
    cases->push_back(picture_of(std::string("size-") + size, kPlate, {"--size", size}));
  for (const char* scale : {"0.001", "50"})
    cases->push_back(picture_of(std::string("environment-scale-") + scale, kCockpit, {"--env-scale", scale}));
  for (const char* degrees : {"35000", "-35000"})
    cases->push_back(picture_of(std::string("rotation-") + degrees, kPlate, {"--env-rotation", degrees}));
  for (const char* mode : {"bandwidth", "uniform", "reference"})
    for (const char* seed : {"1", "4000000000"})
      cases->push_back(picture_of(std::string("seed-") + mode + seed, kPlate, in_mode(mode, {"--seed", seed})));
}

void add_views(std::vector<PictureCase>* cases) {
  for (const char* view :
       {"shaded", "level", "samples", "borrowed", "bandwidth", "variance", "curvature", "angular_bandwidth",
        "footprint_stretch", "footprint_angle", "depth", "normal", "base_color", "material"})
    cases->push_back(picture_of(std::string("view-") + view, kCockpit, {"--view", view}));
  for (const char* view : {"depth", "normal", "base_color", "material"})
    cases->push_back(picture_of(std::string("view-uniform-") + view, kPlate, in_mode("uniform", {"--view", view})));
}

/// Every reflector technique on a car, through its driver's eyes, which see the windshield and the mirror.
void add_reflections(std::vector<PictureCase>* cases) {
  const auto add = [&](const std::string& name, const std::string& technique, const std::string& mode,
                       const std::string& camera, const Words& settings) {
    const Words words =
        in_mode(mode, {"--camera", camera, "--reflections", technique}) + set({"octree.depth=7"}) + set(settings);
    cases->push_back(picture_of("reflections-cockpit-" + name, kCockpit, words));
    cases->push_back(picture_of("reflections-view-" + name, kCockpit, words + Words{"--view", "reflection"}));
  };
  for (const std::string& technique : kTechniques) {
    add(technique, technique, "bandwidth", "driver", {});
    add(technique + "-exterior", technique, "splitsum", "exterior", {});
  }
  add("uniform", "raytraced", "uniform", "driver", {});
  add("sg", "octree", "sg", "driver", {});
  add("ghost-raytraced", "raytraced", "bandwidth", "driver", {"reflections.ghost=true", "reflections.wedge=2"});
  add("ghost-octree", "octree", "splitsum", "driver", {"reflections.ghost=true"});
  add("quarter", "raytraced", "bandwidth", "driver", {"reflections.resolution=quarter"});
  add("glossy-none", "octree", "bandwidth", "door", {"reflections.glossy=0"});
  add("traced", "octree", "bandwidth", "driver", {"shading.visibility=traced"});
  for (const char* node : {"interior_mirror", "windshield"})
    cases->push_back(picture_of(std::string("reflections-named-") + node, kCockpit,
                                in_mode("splitsum", {"--reflections", "raytraced", "--reflector", node})));
}

/// Before a mirror and a pane in an open room.
void add_rooms(const Places& places, std::vector<PictureCase>* cases) {
  const auto stored = [&](const char* name, const std::shared_ptr<const Scene>& scene) {
    std::string path = (places.inputs / (std::string(name) + ".glb")).string();
    save_glb(path, *scene);
    return path;
  };
  const std::string curved = stored("curved-mirror", mirror_room(MirrorShape::curved_patch)),
                    flat = stored("flat-mirror", mirror_room(MirrorShape::flat_patch)),
                    mesh = stored("mesh-mirror", mirror_room(MirrorShape::curved_mesh)),
                    panes = stored("pane", pane_room()), painted = stored("painted-box", painted_box()),
                    textured = stored("textured-box", textured_box());
  const auto add = [&](const std::string& name, const std::string& technique, const std::string& scene,
                       const std::string& mode, const Words& settings) {
    const Words words = in_mode(mode, {"--reflections", technique}) + kIntoMirror +
                        set({"octree.depth=7", "reflections.resolution=full"}) + set(settings);
    cases->push_back(picture_of("reflections-room-" + name, scene, words));
    for (const char* view : {"reflection", "reflection_distance", "reflection_doubt"})
      cases->push_back(picture_of("reflections-room-" + name + "-" + view, scene, words + Words{"--view", view}));
  };
  for (const std::string& technique : kTechniques) {
    add(technique + "-curved", technique, curved, "bandwidth", {});
    add(technique + "-flat", technique, flat, "splitsum", {});
    add(technique + "-mesh", technique, mesh, "uniform", {});
  }
  add("bezier-points", "bezier", curved, "splitsum", {"bezier.draw=points"});
  add("bezier-coarse", "bezier", curved, "splitsum", {"bezier.tolerance=4", "reflections.mark=none"});
  add("triangle-side-4", "triangle", curved, "splitsum", {"triangle.side=4"});
  add("octree-mixed", "octree", flat, "uniform", {"octree.depth=6", "octree.brdf=mixed"});
  add("octree-all", "octree", flat, "splitsum", {"octree.depth=5", "octree.brdf=all"});
  add("octree-baked", "octree", flat, "bandwidth", {"shading.visibility=baked"});
  for (const std::string& technique : kTechniques)
    for (const char* msaa : {"1", "4"})
      cases->push_back(picture_of("reflections-pane-" + technique + "-msaa" + msaa, panes,
                                  Words{"--env", "builtin:studio", "--reflections", technique, "--msaa", msaa} +
                                      kIntoMirror + set({"octree.depth=7", "reflections.ghost=true"})));
  for (const char* mode : {"bandwidth", "uniform"})
    cases->push_back(picture_of(std::string("glossy-") + mode, painted,
                                in_mode(mode, {"--material", "ball=builtin:metal-chrome", "--reflections", "octree"}) +
                                    kIntoBox +
                                    set({"octree.depth=7", "reflections.glossy=0.5", "shading.visibility=baked"})));
  for (const std::string mode : {"bandwidth", "uniform", "splitsum", "sg", "reference"})
    for (const char* msaa : {"1", "4"})
      cases->push_back(
          picture_of("textured-" + mode + "-msaa" + msaa, textured, in_mode(mode, {"--msaa", msaa}) + kIntoBox));
}

/// Real files, where they are at hand.
void add_files(const Places& places, std::vector<PictureCase>* cases) {
  const auto path = [&](const char* file) { return (places.data / file).string(); };
  const std::string car = path("scenes/ferrari458.glb"), workshop = path("environments/autoshop_01_1k.hdr"),
                    cathedral = path("environments/grace_latlong.exr");
  const Words into_car = {"--eye", "3.9,1.5,4.6", "--target", "0,0.55,0", "--fov", "32"};
  if (fs::exists(car)) {
    for (const char* mode : {"bandwidth", "splitsum", "sg", "reference"})
      cases->push_back(picture_of(std::string("car-") + mode, car, in_mode(mode, {"--env", workshop}) + into_car));
    for (const char* paint : {"blue", "red"})
      cases->push_back(picture_of(
          std::string("car-paint-") + paint, car,
          Words{"--env", cathedral, "--material", std::string("Body_Color=builtin:paint-") + paint + "-metallic"} +
              into_car));
    for (const char* technique : {"raytraced", "octree"})
      cases->push_back(picture_of(
          std::string("car-reflections-") + technique, car,
          Words{"--env", workshop, "--reflections", technique, "--material", "Glass_Gray=builtin:glass"} + into_car));
  }
  for (const char* file : {"03-mask-alpha/color-times-texture-hidden.gltf", "03-mask-alpha/blend-color-texture.gltf",
                           "07-normalmap-uv1/set1.gltf", "09-spot-cones/default.gltf",
                           "14-vertex-colour-precision/float-0.02.gltf", "28-blend-surface/metal-blend.gltf"}) {
    const std::string scene = path("cases/") + file;
    if (!fs::exists(scene)) continue;
    std::string name = std::string("file-") + file;
    for (char& c : name)
      if (c == '/' || c == '.') c = '-';
    for (const char* mode : {"bandwidth", "splitsum"})
      cases->push_back(picture_of(name + "-" + mode, scene,
                                  in_mode(mode, {"--env", path("cases/00-baseline/one.exr"), "--eye", "0,0,3",
                                                 "--target", "0,0,0", "--fov", "30", "--size", "64x64"})));
  }
}

}  // namespace

std::vector<PictureCase> single_cases(const Places& places) {
  std::vector<PictureCase> cases;
  add_modes(&cases);
  add_shading(&cases);
  add_views(&cases);
  add_reflections(&cases);
  add_rooms(places, &cases);
  add_files(places, &cases);
  return cases;
}

}  // namespace maquette::pictures
