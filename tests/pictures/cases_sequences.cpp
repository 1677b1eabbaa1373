// Frames that one program draws one after the other: what changes between them is a look or a key of a path.
#include <algorithm>
#include <cmath>

#include "review/review.h"
#include "tests/pictures/cases.h"
#include "tests/pictures/made_scenes.h"

namespace maquette::pictures {

namespace {

using Words = std::vector<std::string>;

CameraView view_of(const glm::vec3& eye, const glm::vec3& target, float fov_deg) {
  CameraView view;
  view.eye = eye;
  view.target = target;
  view.fov_y_rad = fov_deg * 0.017453292519943295f;
  return view;
}

const CameraView kBoxView = view_of({0.3f, 0.2f, 3.4f}, {0.0f, -0.1f, 0.0f}, 40.0f),
                 kMirrorView = view_of({0.1f, 0.35f, 1.8f}, {0.0f, 0.0f, -1.0f}, 29.0f),
                 kDriver = view_of({0.37f, 1.1f, -0.3f}, {0.26f, 0.92f, 0.68f}, 58.0f),
                 kPassenger = view_of({-0.37f, 1.12f, -0.34f}, {0.07f, 0.85f, 0.52f}, 58.0f),
                 kOntoSeat = view_of({0.35f, 0.95f, 0.85f}, {0.03f, 0.46f, 0.04f}, 36.0f),
                 kOntoPlate = view_of({1.5f, 1.2f, 2.2f}, {0.0f, 0.3f, 0.0f}, 40.0f),
                 kOntoSphere = view_of({0.0f, 0.8f, 3.2f}, {0.0f, 0.0f, 0.0f}, 45.0f);

/// A look that is drawn for a second.
class Step {
 public:
  Step(const CameraView& camera, const std::string& mode) {
    look_.camera = camera;
    look_.mode = mode;
    look_.reflections = "off";
    look_.auto_exposure = false;
    look_.settings.set_from_text("octree.depth", "6");
  }
  Step& set(const std::string& setting, const std::string& value) {
    look_.settings.set_from_text(setting, value);
    return *this;
  }
  Step& mode(const std::string& mode) { return look_.mode = mode, *this; }
  Step& camera(const CameraView& camera) { return look_.camera = camera, *this; }
  Step& reflect(const std::string& technique) { return look_.reflections = technique, *this; }
  Step& paint(const std::string& material, const std::string& source) {
    if (source.empty())
      look_.edits.materials.erase(material);
    else
      look_.edits.materials[material] = source;
    return *this;
  }
  Step& light(const std::string& environment) { return look_.edits.environment = environment, *this; }
  Step& turn(float degrees) { return look_.edits.env_rotation_deg += degrees, *this; }
  Step& hide(const std::string& node) { return look_.edits.hidden_nodes.insert(node), *this; }
  Step& show(const std::string& node) { return look_.edits.hidden_nodes.erase(node), *this; }
  Step& dent(const glm::vec3& center, float depth_m, float radius_m) {
    return look_.edits.dents.push_back({center, depth_m, radius_m}), *this;
  }
  Step& section(const glm::vec4& plane) { return look_.edits.section = plane, *this; }
  const Look& look() const { return look_; }

 private:
  Look look_;
};

/// Writes the review of a sequence, and the case that plays it: a frame each second, a look each frame.
class Sequences {
 public:
  explicit Sequences(const Places& places) : places_(places) {}

  void add(const std::string& name, const std::string& scene, const std::vector<Step>& steps, bool adaptive = false,
           const Words& more = {}) {
    Review review;
    review.scene = scene;
    CameraPath path;
    path.name = "steps";
    for (const Step& step : steps) {
      Look look = step.look();
      look.name = std::to_string(review.looks.size());
      PathKey key;
      key.camera = look.camera;
      key.duration_s = 1.0;
      key.look = look.name;
      key.env_rotation_deg = look.edits.env_rotation_deg;
      path.keys.push_back(key);
      review.looks.push_back(look);
    }
    review.look = review.looks.front();
    review.paths = {path};
    const std::string file = (places_.inputs / (name + ".maquette.json")).string();
    save_review(file, review);
    PictureCase c{name,
                  {"play", file, "--path", path.name, "--format", "exr", "--fps", "1", "-o", kPictures + "/" + name},
                  adaptive};
    c.words.insert(c.words.end(), more.begin(), more.end());
    for (const auto& [option, value] : {std::pair{"--size", "160x96"}, {"--samples", "16"}})
      if (std::ranges::find(more, option) == more.end()) c.words.insert(c.words.end(), {option, value});
    cases.push_back(std::move(c));
  }

  /// A scene that no file holds, and its path.
  std::string stored(const std::string& name, const std::shared_ptr<const Scene>& scene) const {
    std::string path = (places_.inputs / (name + ".glb")).string();
    save_glb(path, *scene);
    return path;
  }

  std::vector<PictureCase> cases;

 private:
  const Places& places_;
};

void add_edits(Sequences* s) {
  const std::string painted = s->stored("painted-box", painted_box()),
                    textured = s->stored("textured-box", textured_box()),
                    mirror = s->stored("curved-mirror", mirror_room(MirrorShape::curved_patch));
  for (const auto& [name, visibility, reflections] :
       {std::tuple{"bandwidth", "none", "off"}, {"baked", "baked", "off"}, {"reflections", "baked", "octree"}}) {
    Step first(kBoxView, "bandwidth");
    first.set("shading.visibility", visibility).reflect(reflections);
    first.paint("back", "builtin:rubber-black").paint("ball", "builtin:metal-chrome");
    Step red = first, blue = first, back = first;
    red.paint("back", "builtin:paint-red-metallic");
    blue.paint("back", "builtin:paint-red-metallic").paint("ball", "builtin:paint-blue-metallic");
    back.paint("ball", "builtin:paint-blue-metallic");
    s->add(std::string("repaint-") + name, painted, {first, red, blue, back}, true);
  }
  const Step plain(kBoxView, "bandwidth");
  s->add("swap-surface", textured,
         {plain, Step(plain).paint("back", "builtin:paint-red-metallic"),
          Step(plain).paint("back", "builtin:paint-red-metallic").paint("ball", "builtin:glass"),
          Step(plain).paint("back", "builtin:paint-red-metallic"), Step(plain).paint("*", "builtin:leather-black"),
          plain});
  const Step baked = Step(plain).set("shading.visibility", "baked");
  s->add("nodes-hidden", painted,
         {baked, Step(baked).hide("ball"), baked,
          Step(baked).mode("uniform").reflect("octree").set("reflections.glossy", "0.5").hide("left")});
  const Step before(kMirrorView, "bandwidth");
  s->add("nodes-hidden-in-mirror", mirror,
         {Step(before).reflect("bezier"), Step(before).reflect("bezier").hide("box"),
          Step(before).reflect("triangle").hide("box"),
          Step(before).reflect("octree").paint("red", "builtin:metal-gunmetal").hide("box")});
  s->add("section", "builtin:seat",
         {Step(kOntoSeat, "bandwidth"), Step(kOntoSeat, "bandwidth").section({1.0f, 0.0f, 0.0f, 0.05f}),
          Step(kOntoSeat, "splitsum").section({0.0f, 1.0f, 0.0f, 0.6f}), Step(kOntoSeat, "bandwidth")});
  for (const auto& [name, mode, visibility] : {std::tuple{"bandwidth", "bandwidth", "none"},
                                               {"baked", "bandwidth", "baked"},
                                               {"traced", "uniform", "traced"},
                                               {"splitsum", "splitsum", "auto"}}) {
    Step whole(kOntoSeat, mode);
    whole.set("shading.visibility", visibility);
    const Step once = Step(whole).dent({0.0f, 0.55f, 0.1f}, 0.06f, 0.25f),
               twice = Step(once).dent({0.1f, 0.55f, 0.2f}, 0.05f, 0.25f);
    s->add(std::string("dents-") + name, "builtin:seat", {whole, once, twice, whole});
  }
}

void add_turns(Sequences* s) {
  std::vector<Step> modes;
  for (const char* mode : {"bandwidth", "uniform", "bandwidth", "sg", "splitsum", "bandwidth"})
    modes.push_back(Step(kDriver, mode).reflect(modes.size() % 2 == 1 ? "raytraced" : "off"));
  s->add("modes-in-turn", "builtin:cockpit", modes);
  const Step plate(kOntoPlate, "bandwidth");
  s->add("settings-in-turn", "builtin:plate",
         {plate, Step(plate).set("shading.visibility", "baked"),
          Step(plate).set("shading.visibility", "baked").set("shading.indirect", "none"),
          Step(plate).set("shading.visibility", "traced"), Step(plate).set("shading.visibility", "none")});
  std::vector<Step> lights;
  for (const char* mode : {"bandwidth", "sg"})
    for (const char* light : {"builtin:clear-sky", "builtin:studio"})
      lights.push_back(Step(kDriver, mode).light(light));
  s->add("environment-change", "builtin:cockpit", lights);
  for (const char* mode : {"bandwidth", "splitsum"})
    s->add(std::string("camera-there-and-back-") + mode, "builtin:cockpit",
           {Step(kDriver, mode), Step(kPassenger, mode), Step(kDriver, mode)});
  const auto turning = [&](const std::string& name, const std::string& scene, const Step& first,
                           const Words& more = {}) {
    std::vector<Step> steps{first};
    for (int i = 0; i < 3; ++i) steps.push_back(Step(steps.back()).turn(2.0f));
    steps.push_back(Step(steps.back()).turn(-3.0f));
    s->add("turning-" + name, scene, steps, first.look().mode == "bandwidth", more);
  };
  turning("sphere", "builtin:sphere", Step(kOntoSphere, "bandwidth").set("shading.visibility", "none"));
  turning("no-sun", "builtin:sphere", Step(kOntoSphere, "bandwidth").light("builtin:studio"));
  turning("plate-baked", "builtin:plate", Step(kOntoPlate, "bandwidth").set("shading.visibility", "baked"));
  turning("cockpit-reflections", "builtin:cockpit", Step(kDriver, "bandwidth").reflect("raytraced"));
  turning("traced", "builtin:plate", Step(kOntoPlate, "bandwidth").set("shading.visibility", "traced"));
  turning("uniform", "builtin:plate", Step(kOntoPlate, "uniform").set("shading.visibility", "baked"));
  turning("splitsum", "builtin:cockpit", Step(kDriver, "splitsum").reflect("triangle"));
  turning("reference", "builtin:plate", Step(kOntoPlate, "reference"), {"--samples", "1"});
  turning("prt", "builtin:open-seat",
          Step(kOntoSeat, "prt")
              .set("prt.rays", "1")
              .set("prt.faces", "4")
              .set("prt.clusters", "4")
              .set("prt.components", "1")
              .set("ground.kind", "none"));
}

/// Frames that are averaged to one picture.
void add_averages(Sequences* s) {
  const auto add = [&](const std::string& name, const std::string& scene, const Step& step, const char* msaa) {
    s->add("average-" + name, scene, {step, step}, step.look().mode == "bandwidth",
           {"--average", "4", "--msaa", msaa, "--size", "112x64", "--samples",
            step.look().mode == "reference" ? "1" : "16"});
  };
  add("bandwidth-sphere", "builtin:sphere", Step(kOntoSphere, "bandwidth"), "1");
  add("bandwidth-cockpit", "builtin:cockpit", Step(kDriver, "bandwidth"), "1");
  add("bandwidth-msaa4", "builtin:plate", Step(kOntoPlate, "bandwidth"), "4");
  add("bandwidth-reflections", "builtin:cockpit", Step(kDriver, "bandwidth").reflect("raytraced"), "1");
  add("bandwidth-glossy", "builtin:cockpit", Step(kDriver, "bandwidth").reflect("octree"), "1");
  add("uniform", "builtin:plate", Step(kOntoPlate, "uniform"), "1");
  add("uniform-msaa16", "builtin:plate", Step(kOntoPlate, "uniform"), "16");
  add("splitsum", "builtin:cockpit", Step(kDriver, "splitsum").reflect("bezier"), "1");
  add("sg-msaa4", "builtin:plate", Step(kOntoPlate, "sg"), "4");
  add("reference", "builtin:cornell", Step(view_of({0.0f, 1.0f, 3.2f}, {0.0f, 1.0f, 0.0f}, 40.0f), "reference"), "1");
}

}  // namespace

std::vector<PictureCase> sequence_cases(const Places& places) {
  Sequences sequences(places);
  add_edits(&sequences);
  add_turns(&sequences);
  add_averages(&sequences);
  return std::move(sequences.cases);
}

}  // namespace maquette::pictures
