// What mirrors and panes show: every reflector technique, and what settings make of it.
#include "tests/pictures/cases.h"
#include "tests/pictures/made_scenes.h"

namespace maquette::pictures {

namespace {

const std::vector<std::string> kTechniques = {"bezier", "triangle", "octree", "raytraced"};

void reflect(Stage* s, const std::string& technique) {
  s->request.reflections = technique;
  s->set("octree.depth", "7");
}

void look_into_mirror(Stage* s) { s->look({0.1f, 0.35f, 1.8f}, {0.0f, 0.0f, -1.0f}, 29.0f); }

/// On a car, through its driver's eyes, which see the windshield and the mirror.
void add_on_cockpit(std::vector<PictureCase>* cases) {
  const auto add = [&](const std::string& name, const std::string& technique, const std::string& mode,
                       const std::string& camera, const std::vector<std::pair<std::string, std::string>>& settings) {
    cases->push_back({"reflections-cockpit-" + name, [=](Stage* s) {
                        s->show("builtin:cockpit");
                        s->look_through(camera);
                        s->request.mode = mode;
                        reflect(s, technique);
                        for (const auto& [setting, value] : settings) s->set(setting, value);
                        s->frame_and_save("1");
                        s->save_view("reflection");
                      }});
  };
  for (const std::string& technique : kTechniques) {
    add(technique, technique, "bandwidth", "driver", {});
    add(technique + "-exterior", technique, "splitsum", "exterior", {});
  }
  add("uniform", "raytraced", "uniform", "driver", {});
  add("sg", "octree", "sg", "driver", {});
  add("ghost-raytraced", "raytraced", "bandwidth", "driver",
      {{"reflections.ghost", "true"}, {"reflections.wedge", "2"}});
  add("ghost-octree", "octree", "splitsum", "driver", {{"reflections.ghost", "true"}});
  add("quarter", "raytraced", "bandwidth", "driver", {{"reflections.resolution", "quarter"}});
  add("glossy-none", "octree", "bandwidth", "door", {{"reflections.glossy", "0"}});
  add("traced", "octree", "bandwidth", "driver", {{"shading.visibility", "traced"}});
}

/// Before a mirror in an open room.
void add_in_room(std::vector<PictureCase>* cases) {
  const auto add = [&](const std::string& name, const std::string& technique, MirrorShape shape,
                       const std::string& mode, const std::vector<std::pair<std::string, std::string>>& settings) {
    cases->push_back({"reflections-room-" + name, [=](Stage* s) {
                        s->show(mirror_room(shape));
                        look_into_mirror(s);
                        s->request.mode = mode;
                        reflect(s, technique);
                        s->set("reflections.resolution", "full");
                        for (const auto& [setting, value] : settings) s->set(setting, value);
                        s->frame_and_save("1");
                        for (const char* view : {"reflection", "reflection_distance", "reflection_doubt"})
                          s->save_view(view);
                      }});
  };
  for (const std::string& technique : kTechniques) {
    add(technique + "-curved", technique, MirrorShape::curved_patch, "bandwidth", {});
    add(technique + "-flat", technique, MirrorShape::flat_patch, "splitsum", {});
    add(technique + "-mesh", technique, MirrorShape::curved_mesh, "uniform", {});
  }
  add("bezier-points", "bezier", MirrorShape::curved_patch, "splitsum", {{"bezier.draw", "points"}});
  add("bezier-coarse", "bezier", MirrorShape::curved_patch, "splitsum",
      {{"bezier.tolerance", "4"}, {"reflections.mark", "none"}});
  add("triangle-side-4", "triangle", MirrorShape::curved_patch, "splitsum", {{"triangle.side", "4"}});
  add("octree-mixed", "octree", MirrorShape::flat_patch, "uniform", {{"octree.depth", "6"}, {"octree.brdf", "mixed"}});
  add("octree-all", "octree", MirrorShape::flat_patch, "splitsum", {{"octree.depth", "5"}, {"octree.brdf", "all"}});
  add("octree-baked", "octree", MirrorShape::flat_patch, "bandwidth", {{"shading.visibility", "baked"}});
}

/// Rays that are not followed in pictures for the eye.
PictureCase skipping(const std::string& name, const std::string& technique, const std::string& visibility) {
  return {"reflections-skip-" + name,
          [=](Stage* s) {
            s->show("builtin:cockpit");
            reflect(s, technique);
            s->request.display = true;
            s->set("shading.visibility", visibility);
            s->set("reflections.skip", "0.2");
            s->frame_and_save("1");
            s->save_view("rays_skipped");
            s->claim(s->counter("rays_skipped") > 0.0, "rays are skipped");
            s->turn(40.0f);
            s->frame_and_save("turned");
            s->accumulate_and_save(2, "rest");
          },
          true};
}

PictureCase pane(const std::string& technique) {
  return {"reflections-pane-" + technique, [=](Stage* s) {
            s->show(pane_room(), "builtin:studio");
            look_into_mirror(s);
            reflect(s, technique);
            s->set("reflections.ghost", "true");
            s->frame_and_save("1");
            s->save_view("ghost");
            s->request.msaa = 4;
            s->frame_and_save("msaa4");
          }};
}

PictureCase glossy(const std::string& mode) {
  return {"glossy-" + mode, [=](Stage* s) {
            s->show(painted_box());
            s->look({0.3f, 0.2f, 3.4f}, {0.0f, -0.1f, 0.0f}, 40.0f);
            s->request.mode = mode;
            s->renderer.set_material("ball", "builtin:metal-chrome");
            reflect(s, "octree");
            s->set("reflections.glossy", "0.5");
            s->set("shading.visibility", "baked");
            s->frame_and_save("1");
            s->claim(s->counter("glossy_rays") > 0.0, "glossy rays are followed");
            s->save_view("glossy");
            s->renderer.set_material("floor", "builtin:paint-red-metallic");
            s->frame_and_save("painted");
          }};
}

}  // namespace

std::vector<PictureCase> reflection_cases() {
  std::vector<PictureCase> cases;
  add_on_cockpit(&cases);
  add_in_room(&cases);
  cases.push_back(skipping("octree", "octree", "baked"));
  cases.push_back(skipping("raytraced", "raytraced", "traced"));
  for (const std::string& technique : kTechniques) cases.push_back(pane(technique));
  cases.push_back(glossy("bandwidth"));
  cases.push_back(glossy("uniform"));
  cases.push_back({"reflections-named", [](Stage* s) {
                     s->show("builtin:cockpit");
                     reflect(s, "raytraced");
                     s->request.reflectors = {"interior_mirror"};
                     s->request.mode = "splitsum";
                     s->frame_and_save("1");
                     s->request.reflectors = {"windshield"};
                     s->frame_and_save("other");
                   }});
  return cases;
}

}  // namespace maquette::pictures
