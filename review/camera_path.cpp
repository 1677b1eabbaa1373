#include "review/camera_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "review/spline.h"
#include "scenes/error.h"

namespace maquette {

namespace {

constexpr std::size_t kMostKeys = 10000;

std::vector<std::size_t> kept_keys(const CameraPath& path) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < path.keys.size(); ++i)
    if (!path.keys[i].skip) kept.push_back(i);
  return kept;
}

/// Moves: one fewer than keys, or as many in a closed path.
std::size_t move_count(const CameraPath& path, std::size_t kept) { return path.closed ? kept : kept - 1; }

double eased(Ease ease, double t) {
  switch (ease) {
    case Ease::in:
      return t * t;
    case Ease::out:
      return t * (2.0 - t);
    case Ease::smooth:
      return t * t * (3.0 - 2.0 * t);
    case Ease::linear:
      break;
  }
  return t;
}

/// Value of a quantity that some keys say, at `time_s`; nothing when none says it.
template <typename Of>
std::optional<float> keyed(const CameraPath& path, const std::vector<std::size_t>& kept,
                           const std::vector<double>& times, double time_s, const Of& of) {
  std::optional<float> before;
  double left_s = 0.0;  // end of the rest at the key before
  for (const std::size_t k : kept) {
    const std::optional<float> value = of(path.keys[k]);
    if (!value) continue;
    if (time_s < times[k]) {
      if (!before) return value;
      const double share = (time_s - left_s) / std::max(times[k] - left_s, 1e-9);
      return static_cast<float>(static_cast<double>(*before) +
                                share * (static_cast<double>(*value) - static_cast<double>(*before)));
    }
    before = value;
    left_s = times[k] + path.keys[k].delay_s;
    if (time_s <= left_s) break;
  }
  return before;
}

/// The four keys around a move, for a spline: at the ends of an open path the end itself, mirrored by the spline.
std::array<const CameraView*, 4> around(const CameraPath& path, const std::vector<std::size_t>& kept,
                                        std::size_t move) {
  const auto n = static_cast<std::ptrdiff_t>(kept.size());
  std::array<const CameraView*, 4> views{};
  for (std::ptrdiff_t i = 0; i < 4; ++i) {
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(move) + i - 1;
    if (path.closed)
      views[static_cast<std::size_t>(i)] = &path.keys[kept[static_cast<std::size_t>((at + n) % n)]].camera;
    else if (at >= 0 && at < n)
      views[static_cast<std::size_t>(i)] = &path.keys[kept[static_cast<std::size_t>(at)]].camera;
  }
  return views;
}

}  // namespace

void check_path(const CameraPath& path, const std::string& where) {
  const std::size_t kept = kept_keys(path).size();
  if (path.keys.size() > kMostKeys)
    throw Error(where, "it has " + std::to_string(path.keys.size()) + " keys", "at most 10000 are followed");
  if (kept < 2)
    throw Error(where, kept == 0 ? "the path has no key that is not skipped" : "the path has one key only",
                "a move needs two");
  if (!(path_duration_s(path) > 0.0)) throw Error(where, "the path has no duration", "give a key a duration_s above 0");
}

std::vector<double> key_times_s(const CameraPath& path) {
  std::vector<double> times(path.keys.size(), 0.0);
  double next = 0.0, last = 0.0;
  for (std::size_t i = 0; i < path.keys.size(); ++i) {
    const PathKey& key = path.keys[i];
    if (!key.skip) {
      last = next;
      next += key.delay_s + key.duration_s;
    }
    times[i] = last;
  }
  return times;
}

void move_key(CameraPath* path, std::size_t key, double time_s) {
  constexpr double kLeast_s = 0.04;  // of a move: a frame
  const std::vector<std::size_t> kept = kept_keys(*path);
  const auto at = std::find(kept.begin(), kept.end(), key);
  if (at == kept.end() || at == kept.begin()) return;
  const std::vector<double> times = key_times_s(*path);
  PathKey& before = path->keys[*(at - 1)];
  PathKey& moved = path->keys[key];
  const double least = times[*(at - 1)] + before.delay_s + kLeast_s;
  const bool moves_on = at + 1 != kept.end() || path->closed;
  const double most = moves_on ? times[key] + moved.duration_s - kLeast_s : 86400.0;
  if (most < least) return;
  const double shift = std::clamp(time_s, least, most) - times[key];
  before.duration_s += shift;
  if (moves_on) moved.duration_s -= shift;
}

double path_duration_s(const CameraPath& path) {
  const std::vector<std::size_t> kept = kept_keys(path);
  double sum = 0.0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    sum += path.keys[kept[i]].delay_s;
    if (i < move_count(path, kept.size())) sum += path.keys[kept[i]].duration_s;
  }
  return sum;
}

PathMoment path_at(const CameraPath& path, double time_s) {
  const std::vector<std::size_t> kept = kept_keys(path);
  const std::vector<double> times = key_times_s(path);
  const double length_s = path_duration_s(path);
  if (path.closed && (time_s < 0.0 || time_s > length_s)) time_s -= length_s * std::floor(time_s / length_s);
  time_s = std::clamp(time_s, 0.0, length_s);
  std::size_t at = 0;
  while (at + 1 < kept.size() && times[kept[at + 1]] <= time_s) ++at;
  const PathKey& key = path.keys[kept[at]];
  PathMoment moment;
  moment.time_s = time_s;
  moment.key = kept[at];
  moment.camera = key.camera;
  const double left_s = times[kept[at]] + key.delay_s;
  if (time_s > left_s && at < move_count(path, kept.size())) {
    const double share = key.duration_s > 0.0 ? std::min((time_s - left_s) / key.duration_s, 1.0) : 1.0;
    moment.camera = between_views(around(path, kept, at), eased(key.ease, share));
  }
  for (std::size_t k = 0; k <= at; ++k)
    if (path.keys[kept[k]].look) moment.look = path.keys[kept[k]].look;
  moment.env_rotation_deg = keyed(path, kept, times, time_s, [](const PathKey& k) { return k.env_rotation_deg; });
  moment.exposure_ev = keyed(path, kept, times, time_s, [](const PathKey& k) { return k.exposure_ev; });
  return moment;
}

double playing_time_s(const CameraPath& path, Playing playing, double elapsed_s) {
  const double length_s = path_duration_s(path);
  const double round = elapsed_s - length_s * std::floor(elapsed_s / length_s);
  switch (playing) {
    case Playing::loop:
      return round;
    case Playing::reverse:
      return std::max(length_s - elapsed_s, 0.0);
    case Playing::ping_pong: {
      const double there_and_back = elapsed_s - 2.0 * length_s * std::floor(elapsed_s / (2.0 * length_s));
      return there_and_back <= length_s ? there_and_back : 2.0 * length_s - there_and_back;
    }
    case Playing::once:
      break;
  }
  return std::min(elapsed_s, length_s);
}

CameraPath turntable(const CameraView& view, double duration_s, int keys) {
  CameraPath path;
  path.name = "turntable";
  path.closed = true;
  const glm::dvec3 up = glm::normalize(glm::dvec3(view.up)), arm = glm::dvec3(view.eye) - glm::dvec3(view.target);
  for (int i = 0; i < keys; ++i) {
    PathKey key;
    key.camera = view;
    const double angle = 2.0 * glm::pi<double>() * i / keys;
    key.camera.eye = glm::vec3(glm::dvec3(view.target) + glm::angleAxis(angle, up) * arm);
    key.duration_s = duration_s / keys;
    path.keys.push_back(key);
  }
  return path;
}

}  // namespace maquette
