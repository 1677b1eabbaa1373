// Pictures that gather over frames, and light and cameras that move.
#include "tests/pictures/cases.h"
#include "tests/pictures/made_scenes.h"

namespace maquette::pictures {

namespace {

PictureCase gathering(const std::string& name, const std::string& mode, const std::string& scene, int msaa,
                      const std::string& reflections) {
  return {"accumulate-" + name,
          [=](Stage* s) {
            s->show("builtin:" + scene);
            s->size(112, 64);
            s->request.mode = mode;
            s->request.msaa = msaa;
            s->request.reflections = reflections;
            s->request.samples = mode == "reference" ? 1 : 16;
            s->set("octree.depth", "7");
            s->accumulate_and_save(1, "1");
            s->accumulate_and_save(1, "2");
            s->accumulate_and_save(3, "5");
            s->claim(s->accumulate().accumulated_frames == 6, "frames are averaged");
            s->save("6");
            s->frame_and_save("alone");
          },
          mode == "bandwidth"};
}

/// The light turns, rests while pictures gather, and turns again.
PictureCase turning(const std::string& name, const std::string& mode, const std::string& scene,
                    const std::string& environment, const std::string& visibility, const std::string& reflections) {
  return {"turning-" + name,
          [=](Stage* s) {
            s->show("builtin:" + scene, environment);
            s->request.mode = mode;
            s->request.reflections = reflections;
            if (mode == "reference") s->request.samples = 1;
            s->set("shading.visibility", visibility);
            s->set("octree.depth", "7");
            s->frame_and_save("0");
            for (int f = 1; f <= 5; ++f) {
              s->turn(2.0f);
              s->frame();
              if (f % 2 == 1) s->save(std::to_string(f));
            }
            s->claim(mode != "bandwidth" || s->counter("continued_points") > 0.0, "points go on from their past");
            s->accumulate_and_save(1, "rest1");
            s->accumulate_and_save(3, "rest4");
            s->turn(-3.0f);
            s->frame_and_save("back");
          },
          mode == "bandwidth"};
}

void add_cameras(std::vector<PictureCase>* cases) {
  for (const std::string mode : {"bandwidth", "splitsum"})
    cases->push_back({"camera-there-and-back-" + mode,
                      [=](Stage* s) {
                        s->show("builtin:cockpit");
                        s->request.mode = mode;
                        s->frame_and_save("1");
                        s->look_through("passenger");
                        s->frame_and_save("there");
                        s->accumulate_and_save(2, "there-gathered");
                        s->look_through("driver");
                        s->frame_and_save("back");
                        s->request.camera.eye.x += 0.01f;
                        s->frame_and_save("step");
                      },
                      mode == "bandwidth"});
  cases->push_back({"camera-reflections", [](Stage* s) {
                      s->show("builtin:cockpit");
                      s->request.reflections = "bezier";
                      for (int f = 0; f < 3; ++f) {
                        s->request.camera.eye.y += 0.02f;
                        s->frame_and_save(std::to_string(f));
                      }
                    }});
}

void add_light(std::vector<PictureCase>* cases) {
  cases->push_back({"rotation-huge", [](Stage* s) {
                      s->show("builtin:plate");
                      s->request.env_rotation_rad = 1.0e4f;
                      s->frame_and_save("1");
                      s->request.env_rotation_rad = -3.0e5f;
                      s->request.mode = "splitsum";
                      s->frame_and_save("2");
                    }});
  cases->push_back({"environment-change", [](Stage* s) {
                      s->show("builtin:cockpit");
                      for (const std::string mode : {"bandwidth", "sg"}) {
                        s->request.mode = mode;
                        s->light_by("builtin:clear-sky");
                        s->frame_and_save(mode + "-1");
                        s->light_by("builtin:studio");
                        s->frame_and_save(mode + "-2");
                      }
                    }});
  cases->push_back({"environment-scale", [](Stage* s) {
                      s->show("builtin:cockpit");
                      for (const float scale : {1.0f, 0.001f, 50.0f}) {
                        s->request.env_scale = scale;
                        s->frame_and_save("x" + std::to_string(scale));
                      }
                    }});
  cases->push_back({"seeds", [](Stage* s) {
                      s->show("builtin:plate");
                      for (const char* mode : {"bandwidth", "uniform", "reference"})
                        for (const std::uint32_t seed : {1u, 77u, 4000000000u}) {
                          s->request.mode = mode;
                          s->request.seed = seed;
                          s->request.samples = s->request.mode == "reference" ? 1 : 16;
                          s->frame_and_save(mode + std::to_string(seed));
                        }
                    }});
}

}  // namespace

std::vector<PictureCase> motion_cases() {
  std::vector<PictureCase> cases;
  cases.push_back(gathering("bandwidth-sphere", "bandwidth", "sphere", 1, "off"));
  cases.push_back(gathering("bandwidth-cockpit", "bandwidth", "cockpit", 1, "off"));
  cases.push_back(gathering("bandwidth-msaa4", "bandwidth", "plate", 4, "off"));
  cases.push_back(gathering("bandwidth-reflections", "bandwidth", "cockpit", 1, "raytraced"));
  cases.push_back(gathering("bandwidth-glossy", "bandwidth", "cockpit", 1, "octree"));
  cases.push_back(gathering("uniform", "uniform", "plate", 1, "off"));
  cases.push_back(gathering("uniform-msaa16", "uniform", "plate", 16, "off"));
  cases.push_back(gathering("splitsum", "splitsum", "cockpit", 1, "bezier"));
  cases.push_back(gathering("sg-msaa4", "sg", "plate", 4, "off"));
  cases.push_back(gathering("reference", "reference", "cornell", 1, "off"));
  const std::string sky = "builtin:clear-sky", studio = "builtin:studio";
  cases.push_back(turning("sphere", "bandwidth", "sphere", sky, "none", "off"));
  cases.push_back(turning("no-sun", "bandwidth", "sphere", studio, "none", "off"));
  cases.push_back(turning("plate-baked", "bandwidth", "plate", sky, "baked", "off"));
  cases.push_back(turning("cockpit", "bandwidth", "cockpit", sky, "baked", "off"));
  cases.push_back(turning("cockpit-reflections", "bandwidth", "cockpit", sky, "baked", "raytraced"));
  cases.push_back(turning("traced", "bandwidth", "plate", sky, "traced", "off"));
  cases.push_back(turning("uniform", "uniform", "plate", sky, "baked", "off"));
  cases.push_back(turning("splitsum", "splitsum", "cockpit", sky, "auto", "triangle"));
  cases.push_back(turning("reference", "reference", "plate", sky, "none", "off"));
  add_cameras(&cases);
  add_light(&cases);
  return cases;
}

}  // namespace maquette::pictures
