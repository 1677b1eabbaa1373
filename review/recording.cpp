// Thinning of cameras that were noted while flying.
#include <algorithm>
#include <cmath>
#include <set>

#include "review/camera_path.h"
#include "review/spline.h"

namespace maquette {

namespace {

CameraPath path_through(const std::vector<RecordedView>& views, const std::set<std::size_t>& chosen) {
  CameraPath path;
  path.name = "recorded";
  for (auto at = chosen.begin(); at != chosen.end(); ++at) {
    PathKey key;
    key.camera = views[*at].camera;
    const auto next = std::next(at);
    key.duration_s = next == chosen.end() ? 0.0 : views[*next].time_s - views[*at].time_s;
    path.keys.push_back(key);
  }
  return path;
}

}  // namespace

double deviation(const CameraPath& path, const RecordedView& view, const ThinTolerance& tolerance) {
  const CameraView camera = path_at(path, view.time_s).camera;
  const double position = glm::distance(glm::dvec3(camera.eye), glm::dvec3(view.camera.eye)) / tolerance.position_m;
  return std::max(position, angle_between(camera, view.camera) / tolerance.angle_rad);
}

CameraPath thinned(const std::vector<RecordedView>& recorded, const ThinTolerance& tolerance) {
  std::vector<RecordedView> views;
  for (const RecordedView& view : recorded)  // later ones of the same moment add nothing
    if (views.empty() || view.time_s - recorded.front().time_s > views.back().time_s)
      views.push_back({view.time_s - recorded.front().time_s, view.camera});
  std::set<std::size_t> chosen;
  if (!views.empty()) chosen = {0, views.size() - 1};
  while (chosen.size() >= 2 && chosen.size() < views.size()) {
    const CameraPath path = path_through(views, chosen);
    // The worst view of every move at once: a key moves its neighbours only.
    std::set<std::size_t> added;
    for (auto from = chosen.begin(); std::next(from) != chosen.end(); ++from) {
      double worst = 1.0;
      std::size_t at = 0;
      for (std::size_t i = *from + 1; i < *std::next(from); ++i)
        if (const double off = deviation(path, views[i], tolerance); off > worst) {
          worst = off;
          at = i;
        }
      if (at > 0) added.insert(at);
    }
    if (added.empty()) return path;
    chosen.insert(added.begin(), added.end());
  }
  return path_through(views, chosen);
}

}  // namespace maquette
