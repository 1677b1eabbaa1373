#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "render/renderer.h"

/// What a case draws with: the library's public interface alone, so that the same sources compile against two versions.
namespace maquette::pictures {

/// A case that cannot be drawn here (a file that is not there).
class Skipped : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Scenes and environments, loaded once.
class Library {
 public:
  explicit Library(std::string data) : data_(std::move(data)) {}
  /// `builtin:NAME`, or a path below the data folder. Throws Skipped when there is no such file, and Error.
  std::shared_ptr<const Scene> scene(const std::string& source);
  std::shared_ptr<const Environment> environment(const std::string& source);

 private:
  std::string path_of(const std::string& source) const;
  std::string data_;
  std::map<std::string, std::shared_ptr<const Scene>> scenes_;
  std::map<std::string, std::shared_ptr<const Environment>> environments_;
};

/// A renderer of one case, and the folder where its pictures go: `CASE--LABEL.exr`.
class Stage {
 public:
  /// The request starts with 160 x 96 pixels and 16 samples.
  Stage(Library* library, std::filesystem::path folder, std::string case_name);

  void show(const std::string& scene, const std::string& environment = "builtin:clear-sky");
  void show(std::shared_ptr<const Scene> scene, const std::string& environment = "builtin:clear-sky");
  void light_by(const std::string& environment);
  /// Through a camera of the scene, by its name.
  void look_through(const std::string& camera);
  void look(const glm::vec3& eye, const glm::vec3& target, float fov_deg);
  void set(const std::string& setting, const std::string& value) { request.settings.set_from_text(setting, value); }
  void size(int width, int height);
  void turn(float degrees) { request.env_rotation_rad += degrees * 0.017453292519943295f; }

  /// One frame, after all background work that it wants is done: what it shows does not depend on time.
  const FrameStats& frame();
  /// Frames that are averaged while nothing changes.
  const FrameStats& accumulate(int frames = 1);
  /// Writes the last frame.
  void save(const std::string& label);
  void save_view(const std::string& view, const std::string& label = {});
  void frame_and_save(const std::string& label);
  void accumulate_and_save(int frames, const std::string& label);

  /// Presses the subdivision surfaces near `center` (m, world) inwards along `push` by `depth_m`.
  void dent(const glm::vec3& center, const glm::vec3& push, float depth_m, float radius_m);
  int node(const std::string& name) const;

  /// Throws Error when the case does not show what its name says.
  void claim(bool holds, const std::string& what) const;
  /// The counter of the last frame; 0 without one.
  double counter(const std::string& name) const;

  Renderer renderer;
  FrameRequest request;

 private:
  const FrameStats& draw(bool accumulate);
  void note();
  void write(const Image& image, const std::string& label);

  Library* library_;
  std::filesystem::path folder_;
  std::string case_name_;
  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<Scene> dented_;  ///< with the dents so far
  FrameStats stats_;
  std::string notes_;
};

}  // namespace maquette::pictures
