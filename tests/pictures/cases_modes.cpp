// Every mode on every built-in scene.
#include "tests/pictures/cases.h"

namespace maquette::pictures {

std::vector<PictureCase> mode_cases() {
  std::vector<PictureCase> cases;
  const auto add = [&](const std::string& mode, const std::string& scene, const std::string& camera) {
    const std::string name = mode + "-" + scene + (camera.empty() ? "" : "-" + camera);
    cases.push_back({name, [=](Stage* s) {
                       s->show("builtin:" + scene);
                       if (!camera.empty()) s->look_through(camera);
                       s->request.mode = mode;
                       if (mode == "reference") s->request.samples = 2;
                       if (mode == "reference") s->request.seed = 7;
                       s->frame_and_save("1");
                     }});
  };
  for (const char* mode : {"bandwidth", "uniform", "splitsum", "sg", "reference"}) {
    add(mode, "cockpit", "driver");
    add(mode, "cockpit", "exterior");
    for (const char* scene : {"sphere", "plate", "cornell", "seat"}) add(mode, scene, "");
  }
  for (const char* mode : {"bandwidth", "splitsum"}) {
    add(mode, "cockpit", "passenger");
    add(mode, "cockpit", "door");
  }
  return cases;
}

}  // namespace maquette::pictures
