#include "tests/pictures/stage.h"

#include <cstdio>
#include <fstream>

#include "render/gl/context.h"
#include "scenes/error.h"
#include "scenes/image_io.h"
#include "scenes/subdivision.h"

namespace maquette::pictures {

std::string Library::path_of(const std::string& source) const {
  if (source.starts_with("builtin:")) return source;
  const std::filesystem::path path = std::filesystem::path(data_) / source;
  if (data_.empty() || !std::filesystem::exists(path)) throw Skipped(source + " is not there");
  return path.string();
}

std::shared_ptr<const Scene> Library::scene(const std::string& source) {
  std::shared_ptr<const Scene>& scene = scenes_[source];
  if (!scene) scene = std::make_shared<Scene>(load_scene(path_of(source)));
  return scene;
}

std::shared_ptr<const Environment> Library::environment(const std::string& source) {
  std::shared_ptr<const Environment>& environment = environments_[source];
  if (!environment) environment = std::make_shared<Environment>(load_environment(path_of(source)));
  return environment;
}

Stage::Stage(Library* library, std::filesystem::path folder, std::string case_name)
    : library_(library), folder_(std::move(folder)), case_name_(std::move(case_name)) {
  size(160, 96);
  request.samples = 16;
}

void Stage::show(const std::string& scene, const std::string& environment) {
  show(library_->scene(scene), environment);
}

void Stage::show(std::shared_ptr<const Scene> scene, const std::string& environment) {
  scene_ = std::move(scene);
  dented_.reset();
  renderer.set_scene(scene_);
  light_by(environment);
  for (const Node& n : scene_->nodes)
    if (n.camera >= 0) return look_through(n.name);
}

void Stage::light_by(const std::string& environment) { renderer.set_environment(library_->environment(environment)); }

void Stage::look_through(const std::string& camera) {
  const std::vector<glm::mat4> world = compute_world_transforms(*scene_);
  for (std::size_t i = 0; i < scene_->nodes.size(); ++i) {
    const Node& n = scene_->nodes[i];
    if (n.camera < 0 || (n.name != camera && scene_->cameras[static_cast<std::size_t>(n.camera)].name != camera))
      continue;
    CameraView& view = request.camera;
    view = CameraView();
    view.eye = glm::vec3(world[i][3]);
    view.target = view.eye - glm::normalize(glm::vec3(world[i][2]));
    view.up = glm::normalize(glm::vec3(world[i][1]));
    view.fov_y_rad = scene_->cameras[static_cast<std::size_t>(n.camera)].fov_y_rad;
    return;
  }
  throw Error(case_name_, "the scene has no camera '" + camera + "'");
}

void Stage::look(const glm::vec3& eye, const glm::vec3& target, float fov_deg) {
  request.camera = CameraView();
  request.camera.eye = eye;
  request.camera.target = target;
  request.camera.fov_y_rad = fov_deg * 0.017453292519943295f;
}

void Stage::size(int width, int height) {
  request.width = width;
  request.height = height;
}

const FrameStats& Stage::draw(bool accumulate) {
  if (!renderer.finish_background_work(request)) throw Error(case_name_, "background work was not finished");
  stats_ = renderer.render(request, accumulate);
  note();
  const std::vector<std::string> errors = take_gl_errors();
  if (!errors.empty()) throw Error(case_name_, "OpenGL: " + errors.front());
  claim(request.reflections == "off" || request.mode == "reference" || stats_.plan.reflections == request.reflections ||
            stats_.plan.glossy,
        "reflections are drawn");
  return stats_;
}

const FrameStats& Stage::frame() { return draw(false); }

const FrameStats& Stage::accumulate(int frames) {
  for (int i = 0; i < frames; ++i) draw(true);
  return stats_;
}

void Stage::frame_and_save(const std::string& label) {
  frame();
  save(label);
}

void Stage::accumulate_and_save(int frames, const std::string& label) {
  accumulate(frames);
  save(label);
}

void Stage::save(const std::string& label) { write(renderer.read_radiance(), label); }

void Stage::save_view(const std::string& view, const std::string& label) {
  write(renderer.read_debug_view(view), (label.empty() ? "" : label + "-") + view);
}

void Stage::write(const Image& image, const std::string& label) {
  save_exr((folder_ / (case_name_ + "--" + label + ".exr")).string(), image);
}

/// What the frame was, for the reader of a difference.
void Stage::note() {
  char text[160];
  std::snprintf(text, sizeof text, "frame %d: %zu visible, %zu shaded, %zu samples\n", stats_.accumulated_frames,
                stats_.visible_pixels, stats_.shaded_pixels, stats_.shading_samples);
  notes_ += text;
  for (const auto& [name, value] : stats_.technique) {
    std::snprintf(text, sizeof text, "  %s %.9g\n", name.c_str(), value);
    notes_ += text;
  }
  for (const PlannedPass& pass : stats_.plan.passes) notes_ += "  + " + pass.name + ": " + pass.reason + "\n";
  for (const LeftOut& left : stats_.plan.left_out) notes_ += "  - " + left.what + ": " + left.why + "\n";
  std::ofstream(folder_ / (case_name_ + ".notes")) << notes_;
}

void Stage::dent(const glm::vec3& center, const glm::vec3& push, float depth_m, float radius_m) {
  if (!dented_) dented_ = std::make_unique<Scene>(*scene_);
  const std::vector<glm::mat4> world = compute_world_transforms(*dented_);
  int moved = 0;
  std::vector<bool> done(dented_->meshes.size(), false);  // a mesh with several instances is pressed once
  for (std::size_t i = 0; i < dented_->nodes.size(); ++i) {
    const int m = dented_->nodes[i].mesh;
    if (m < 0 || done[static_cast<std::size_t>(m)] || !dented_->meshes[static_cast<std::size_t>(m)].cage) continue;
    Mesh& mesh = dented_->meshes[static_cast<std::size_t>(m)];
    const glm::mat4 node_from_world = glm::inverse(world[i]);
    SubdivisionCage cage = *mesh.cage;
    const int count = dent_cage(&cage, glm::vec3(node_from_world * glm::vec4(center, 1.0f)),
                                glm::normalize(glm::mat3(node_from_world) * push), depth_m, radius_m);
    if (count == 0) continue;
    moved += count;
    done[static_cast<std::size_t>(m)] = true;
    mesh.cage = std::make_shared<const SubdivisionCage>(std::move(cage));
    tessellate_cage(&mesh);
    renderer.update_mesh(m, mesh.primitives[0].positions, mesh.primitives[0].normals);
  }
  claim(moved > 0, "a dent is pressed");
}

int Stage::node(const std::string& name) const {
  for (std::size_t i = 0; i < scene_->nodes.size(); ++i)
    if (scene_->nodes[i].name == name) return static_cast<int>(i);
  throw Error(case_name_, "the scene has no node '" + name + "'");
}

void Stage::claim(bool holds, const std::string& what) const {
  if (!holds) throw Error(case_name_, "it does not hold that " + what);
}

double Stage::counter(const std::string& name) const {
  const auto found = stats_.technique.find(name);
  return found == stats_.technique.end() ? 0.0 : found->second;
}

}  // namespace maquette::pictures
