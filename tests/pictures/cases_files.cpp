// Scenes and environments of files: made here, or of the data folder where it is at hand.
#include "tests/pictures/cases.h"
#include "tests/pictures/made_scenes.h"

namespace maquette::pictures {

namespace {

const std::string kCar = "scenes/ferrari458.glb", kWorkshop = "environments/autoshop_01_1k.hdr",
                  kCathedral = "environments/grace_latlong.exr";

void view_car(Stage* s, const std::string& mode) {
  s->show(kCar, kWorkshop);
  s->look({3.9f, 1.5f, 4.6f}, {0.0f, 0.55f, 0.0f}, 32.0f);
  s->request.mode = mode;
}

void add_car(std::vector<PictureCase>* cases) {
  for (const std::string mode : {"bandwidth", "splitsum", "sg", "reference"})
    cases->push_back({"car-" + mode, [=](Stage* s) {
                        view_car(s, mode);
                        if (mode == "reference") s->request.samples = 1;
                        s->frame_and_save("1");
                      }});
  cases->push_back({"car-paint",
                    [](Stage* s) {
                      view_car(s, "bandwidth");
                      s->light_by(kCathedral);
                      s->look({-3.6f, 1.1f, -4.4f}, {0.0f, 0.55f, 0.0f}, 32.0f);
                      s->renderer.set_material("Body_Color", "builtin:paint-blue-metallic");
                      s->frame_and_save("1");
                      s->renderer.set_material("Body_Color", "builtin:paint-red-metallic");
                      s->frame_and_save("2");
                      s->turn(2.0f);
                      s->frame_and_save("turned");
                      s->accumulate_and_save(3, "rest");
                    },
                    true});
  for (const std::string technique : {"raytraced", "octree"})
    cases->push_back({"car-reflections-" + technique, [=](Stage* s) {
                        view_car(s, "bandwidth");
                        s->request.reflections = technique;
                        s->renderer.set_material("Glass_Gray", "builtin:glass");
                        s->frame_and_save("1");
                      }});
}

/// The folder's files are small: an eye 3 m before the origin, as their README has it.
PictureCase of_file(const std::string& file, const std::string& environment) {
  std::string name = "file-" + file;
  for (char& c : name)
    if (c == '/' || c == '.') c = '-';
  return {name, [=](Stage* s) {
            s->show("cases/" + file, environment);
            s->size(64, 64);
            for (const std::string mode : {"bandwidth", "splitsum"}) {
              s->look({0.0f, 0.0f, 3.0f}, {0.0f, 0.0f, 0.0f}, 30.0f);
              s->request.mode = mode;
              s->frame_and_save(mode);
            }
          }};
}

}  // namespace

std::vector<PictureCase> file_cases() {
  std::vector<PictureCase> cases;
  for (const std::string mode : {"bandwidth", "uniform", "splitsum", "sg", "reference"})
    cases.push_back({"textured-" + mode, [=](Stage* s) {
                       s->show(textured_box());
                       s->look({0.3f, 0.2f, 3.4f}, {0.0f, -0.1f, 0.0f}, 40.0f);
                       s->request.mode = mode;
                       if (mode == "reference") s->request.samples = 2;
                       s->frame_and_save("1");
                       if (mode != "reference") s->save_view("normal");
                       s->request.msaa = 4;
                       s->frame_and_save("msaa4");
                     }});
  add_car(&cases);
  for (const char* file : {"03-mask-alpha/color-times-texture-hidden.gltf", "03-mask-alpha/blend-color-texture.gltf",
                           "07-normalmap-uv1/set1.gltf", "09-spot-cones/default.gltf",
                           "14-vertex-colour-precision/float-0.02.gltf", "28-blend-surface/metal-blend.gltf"})
    cases.push_back(of_file(file, "cases/00-baseline/one.exr"));
  return cases;
}

}  // namespace maquette::pictures
