// What settings make of one frame: shadows, indirect light, several samples a pixel, transport, paints.
#include "tests/pictures/cases.h"

namespace maquette::pictures {

namespace {

using SettingValues = std::vector<std::pair<std::string, std::string>>;

PictureCase with_settings(const std::string& name, const std::string& mode, const std::string& scene,
                          const SettingValues& settings) {
  return {name, [=](Stage* s) {
            s->show(scene);
            s->request.mode = mode;
            for (const auto& [setting, value] : settings) s->set(setting, value);
            s->frame_and_save("1");
          }};
}

PictureCase with_msaa(const std::string& mode, const std::string& scene, int msaa) {
  return {"msaa" + std::to_string(msaa) + "-" + mode + "-" + scene, [=](Stage* s) {
            s->show("builtin:" + scene);
            s->size(112, 64);
            s->request.mode = mode;
            s->request.msaa = msaa;
            s->request.samples = mode == "reference" ? 2 : 16;
            s->frame_and_save("1");
          }};
}

void add_visibility(std::vector<PictureCase>* cases) {
  const std::string plate = "builtin:plate", cockpit = "builtin:cockpit";
  for (const std::string mode : {"bandwidth", "uniform"}) {
    cases->push_back(with_settings("visibility-baked-" + mode, mode, plate, {{"shading.visibility", "baked"}}));
    cases->push_back(with_settings("visibility-traced-" + mode, mode, plate,
                                   {{"shading.visibility", "traced"}, {"octree.depth", "7"}}));
  }
  cases->push_back(with_settings("visibility-none-cockpit", "bandwidth", cockpit, {{"shading.visibility", "none"}}));
  cases->push_back(with_settings("visibility-traced-cockpit", "bandwidth", cockpit,
                                 {{"shading.visibility", "traced"}, {"octree.depth", "7"}}));
  cases->push_back(with_settings("indirect-none-plate", "uniform", plate,
                                 {{"shading.visibility", "baked"}, {"shading.indirect", "none"}}));
  cases->push_back(with_settings("indirect-none-cockpit", "bandwidth", cockpit, {{"shading.indirect", "none"}}));
  cases->push_back(with_settings("indirect-none-cockpit-sg", "sg", cockpit, {{"shading.indirect", "none"}}));
}

}  // namespace

std::vector<PictureCase> shading_cases() {
  std::vector<PictureCase> cases;
  add_visibility(&cases);
  cases.push_back(with_msaa("bandwidth", "cockpit", 4));
  cases.push_back(with_msaa("bandwidth", "plate", 16));
  cases.push_back(with_msaa("uniform", "plate", 4));
  cases.push_back(with_msaa("splitsum", "cockpit", 16));
  cases.push_back(with_msaa("sg", "plate", 4));
  cases.push_back(with_msaa("reference", "plate", 4));
  cases.push_back(with_settings("reference-direct", "reference", "builtin:plate",
                                {{"reference.transport", "direct"}, {"reference.adaptive", "false"}}));
  cases.push_back(with_settings("reference-bounces-1", "reference", "builtin:cornell", {{"reference.bounces", "1"}}));
  cases.push_back(with_settings("bandwidth-level-0", "bandwidth", "builtin:plate", {{"bandwidth.max_level", "0"}}));
  cases.push_back(with_settings("bandwidth-quality-4", "bandwidth", "builtin:plate", {{"bandwidth.quality", "4"}}));
  for (const std::string mode : {"bandwidth", "splitsum", "sg"})
    cases.push_back({"paints-" + mode, [=](Stage* s) {
                       s->show("builtin:cockpit", "builtin:studio");
                       s->look_through("exterior");
                       s->request.mode = mode;
                       s->renderer.set_material("Paint", "builtin:paint-blue-metallic");
                       s->renderer.set_material("Ground", "builtin:wood-satin");
                       s->renderer.set_material("Mirror", "builtin:metal-gunmetal");
                       s->frame_and_save("1");
                     }});
  for (const int variant : {0, 1, 2})
    cases.push_back({"variant-" + std::to_string(variant), [=](Stage* s) {
                       s->show("builtin:cockpit");
                       s->request.variant = variant;
                       s->frame_and_save("1");
                     }});
  cases.push_back({"views-bandwidth", [](Stage* s) {
                     s->show("builtin:cockpit");
                     s->frame_and_save("1");
                     for (const char* view : {"shaded", "level", "samples", "borrowed", "bandwidth", "variance",
                                              "curvature", "angular_bandwidth", "footprint_stretch", "footprint_angle",
                                              "depth", "normal", "base_color", "material"})
                       s->save_view(view);
                   }});
  cases.push_back({"views-uniform", [](Stage* s) {
                     s->show("builtin:plate");
                     s->request.mode = "uniform";
                     s->frame_and_save("1");
                     for (const char* view : {"depth", "normal", "base_color", "material"}) s->save_view(view);
                   }});
  return cases;
}

}  // namespace maquette::pictures
