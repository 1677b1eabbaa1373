// What changes between the frames of one renderer: geometry, materials, visibility, size, mode.
#include "tests/pictures/cases.h"
#include "tests/pictures/made_scenes.h"

namespace maquette::pictures {

namespace {

/// Dents in the seat's cushion, between single frames and while pictures gather.
PictureCase dents(const std::string& name, const std::string& mode, const std::string& visibility) {
  return {"dents-" + name,
          [=](Stage* s) {
            s->show("builtin:seat");
            s->request.mode = mode;
            s->set("shading.visibility", visibility);
            s->set("octree.depth", "6");
            s->frame_and_save("0");
            s->dent({0.0f, 0.55f, 0.1f}, {0.0f, -1.0f, 0.0f}, 0.06f, 0.25f);
            s->frame_and_save("1");
            s->accumulate_and_save(2, "gathered");
            s->dent({0.1f, 0.55f, 0.2f}, {0.0f, -1.0f, 0.0f}, 0.05f, 0.25f);
            s->accumulate_and_save(1, "2");
            s->accumulate_and_save(2, "again");
          },
          mode == "bandwidth"};
}

void look_into_box(Stage* s) { s->look({0.3f, 0.2f, 3.4f}, {0.0f, -0.1f, 0.0f}, 40.0f); }

/// Tables for tables: the G-buffer stays, and points of other materials are kept.
PictureCase repaints(const std::string& name, const std::string& visibility, const std::string& reflections) {
  return {"repaint-" + name,
          [=](Stage* s) {
            s->show(painted_box());
            look_into_box(s);
            s->set("shading.visibility", visibility);
            s->set("octree.depth", "6");
            s->request.reflections = reflections;
            s->renderer.set_material("back", "builtin:rubber-black");
            s->renderer.set_material("ball", "builtin:metal-chrome");
            s->frame_and_save("0");
            s->renderer.set_material("back", "builtin:paint-red-metallic");
            s->frame_and_save("1");
            s->accumulate_and_save(4, "gathered");
            s->renderer.set_material("ball", "builtin:paint-blue-metallic");
            s->accumulate_and_save(1, "2");
            s->accumulate_and_save(3, "2-gathered");
            s->renderer.set_material("back", "builtin:rubber-black");
            s->accumulate_and_save(2, "back");
          },
          true};
}

/// Swaps that make another surface: glass, a table for analytic lobes, and back.
void other_surface(Stage* s) {
  s->show(textured_box());
  look_into_box(s);
  s->frame_and_save("0");
  s->renderer.set_material("back", "builtin:paint-red-metallic");
  s->frame_and_save("table");
  s->renderer.set_material("ball", "builtin:glass");
  s->frame_and_save("glass");
  s->accumulate_and_save(3, "gathered");
  s->renderer.set_material("ball", "");
  s->frame_and_save("no-glass");
  s->renderer.set_material("*", "builtin:leather-black");
  s->frame_and_save("all");
  s->renderer.set_material("*", "");
  s->frame_and_save("none");
}

void hidden_nodes(Stage* s) {
  s->show(painted_box());
  look_into_box(s);
  s->set("shading.visibility", "baked");
  s->frame_and_save("0");
  s->renderer.set_node_visible(s->node("ball"), false);
  s->frame_and_save("hidden");
  s->accumulate_and_save(3, "gathered");
  s->renderer.set_node_visible(s->node("ball"), true);
  s->accumulate_and_save(2, "shown");
  s->request.mode = "uniform";
  s->request.reflections = "octree";
  s->set("octree.depth", "6");
  s->set("reflections.glossy", "0.5");
  s->renderer.set_node_visible(s->node("left"), false);
  s->frame_and_save("octree");
}

void hidden_reflector(Stage* s) {
  s->show(mirror_room(MirrorShape::curved_patch));
  s->look({0.1f, 0.35f, 1.8f}, {0.0f, 0.0f, -1.0f}, 29.0f);
  s->request.reflections = "bezier";
  s->frame_and_save("0");
  s->renderer.set_node_visible(s->node("box"), false);
  s->frame_and_save("1");
  s->request.reflections = "triangle";
  s->frame_and_save("triangle");
  s->renderer.set_material("red", "builtin:metal-gunmetal");
  s->request.reflections = "octree";
  s->set("octree.depth", "6");
  s->frame_and_save("octree");
}

void without_reuse(Stage* s) {
  s->show("builtin:cockpit");
  s->set("shading.reuse", "false");
  s->frame_and_save("0");
  s->turn(2.0f);
  s->frame_and_save("turned");
  s->renderer.set_material("Decor", "builtin:wood-satin");
  s->frame_and_save("painted");
  s->frame_and_save("again");
}

void resized(Stage* s) {
  s->show("builtin:plate");
  s->frame_and_save("0");
  for (const auto& [width, height] : {std::pair{97, 61}, {16, 16}, {200, 33}, {1, 1}, {160, 96}}) {
    s->size(width, height);
    s->frame_and_save(std::to_string(width) + "x" + std::to_string(height));
  }
}

void modes_in_turn(Stage* s) {
  s->show("builtin:cockpit");
  int k = 0;
  for (const char* mode : {"bandwidth", "uniform", "bandwidth", "sg", "splitsum", "reference", "bandwidth"}) {
    s->request.mode = mode;
    s->request.samples = s->request.mode == "reference" ? 1 : 16;
    s->request.reflections = k % 2 == 1 ? "raytraced" : "off";
    s->frame_and_save(std::to_string(++k) + mode);
  }
}

void scenes_in_turn(Stage* s) {
  s->show("builtin:plate");
  s->frame_and_save("plate");
  s->show("builtin:cornell");
  s->frame_and_save("cornell");
  s->show(textured_box(), "builtin:studio");
  look_into_box(s);
  s->frame_and_save("box");
  s->show("builtin:plate");
  s->accumulate_and_save(3, "plate-again");
}

void settings_in_turn(Stage* s) {
  s->show("builtin:plate");
  s->frame_and_save("0");
  s->set("shading.visibility", "baked");
  s->frame_and_save("baked");
  s->set("shading.indirect", "none");
  s->frame_and_save("no-indirect");
  s->set("shading.visibility", "traced");
  s->set("octree.depth", "6");
  s->frame_and_save("traced");
  s->request.msaa = 4;
  s->frame_and_save("msaa4");
  s->request.msaa = 1;
  s->request.samples = 64;
  s->set("shading.visibility", "none");
  s->frame_and_save("many");
}

}  // namespace

std::vector<PictureCase> edit_cases() {
  return {
      dents("bandwidth", "bandwidth", "none"),
      dents("baked", "bandwidth", "baked"),
      dents("traced", "uniform", "traced"),
      dents("splitsum", "splitsum", "auto"),
      repaints("bandwidth", "none", "off"),
      repaints("baked", "baked", "off"),
      repaints("reflections", "baked", "octree"),
      {"swap-surface", other_surface, true},
      {"nodes-hidden", hidden_nodes, true},
      {"nodes-hidden-in-mirror", hidden_reflector},
      {"no-reuse", without_reuse},
      {"resize", resized},
      {"modes-in-turn", modes_in_turn},
      {"scenes-in-turn", scenes_in_turn, true},
      {"settings-in-turn", settings_in_turn},
      {"repaint-cockpit",
       [](Stage* s) {
         s->show("builtin:cockpit");
         s->look_through("exterior");
         s->frame_and_save("0");
         s->renderer.set_material("Paint", "builtin:paint-blue-metallic");
         s->frame_and_save("1");
         s->renderer.set_material("Paint", "builtin:paint-pearl-white");
         s->turn(2.0f);
         s->frame_and_save("turned");
         s->accumulate_and_save(2, "rest");
       },
       true},
  };
}

}  // namespace maquette::pictures
