#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "render/frame/camera.h"

namespace maquette {

/// How the time of a move is spent: `smooth` begins and ends at rest.
enum class Ease { linear, in, out, smooth };

/// One key of a camera path: where the camera is, and how it leaves.
struct PathKey {
  std::string name;
  CameraView camera;
  double delay_s = 0.0;     ///< rest at this key before the move to the next one
  double duration_s = 2.0;  ///< of the move to the next key; of the last one, when the path is closed, to the first
  Ease ease = Ease::linear;
  bool skip = false;                      ///< as if it were not there, without being forgotten
  std::optional<std::string> look;        ///< from here on; the look itself, but for camera, light and exposure below
  std::optional<float> env_rotation_deg;  ///< changes evenly from key to key that says it
  std::optional<float> exposure_ev;       ///< likewise
  bool operator==(const PathKey&) const = default;
};

struct CameraPath {
  std::string name;
  std::vector<PathKey> keys;
  bool closed = false;    ///< the last key leads back to the first
  std::string animation;  ///< of the scene, which plays along from its begin; empty: none
  bool operator==(const CameraPath&) const = default;
};

/// What a path says of one moment.
struct PathMoment {
  CameraView camera;
  std::optional<std::string> look;
  std::optional<float> env_rotation_deg, exposure_ev;
  double time_s = 0.0;  ///< within the path
  std::size_t key = 0;  ///< the last one that was passed, of the keys with the skipped ones
};

/// Throws Error under `where`: fewer than two keys that are not skipped, no duration, too many keys.
void check_path(const CameraPath& path, const std::string& where);
double path_duration_s(const CameraPath& path);
/// Begin of each key's rest, s; of skipped keys that of the key before them.
std::vector<double> key_times_s(const CameraPath& path);

/// Moves a key to another time, as far as the keys beside it let it; these stay where they are. The first key, and one
/// that is skipped, stay; the last one of an open path makes it longer or shorter.
void move_key(CameraPath* path, std::size_t key, double time_s);

/// `time_s` is clamped to the path, or wraps around in a closed one. Position: centripetal Catmull-Rom (Yuksel,
/// Schaefer and Keyser 2011, "Parameterization and applications of Catmull-Rom curves"), which neither overshoots nor
/// loops between keys. Orientation: the same curve with great arcs between unit quaternions, of signs that take the
/// short way. Distance of the target and angle of view: geometric means. Needs a checked path.
PathMoment path_at(const CameraPath& path, double time_s);

/// Playback: time on the path after `elapsed_s`.
enum class Playing { once, loop, ping_pong, reverse };
double playing_time_s(const CameraPath& path, Playing playing, double elapsed_s);

/// One round about the target of a view, of `keys` keys, closed.
CameraPath turntable(const CameraView& view, double duration_s, int keys = 8);

/// A camera that was noted while it flew.
struct RecordedView {
  double time_s = 0.0;
  CameraView camera;
};
struct ThinTolerance {
  double position_m = 0.01;
  double angle_rad = 0.01;  ///< of the orientation
};
/// The path through as few of the views as it takes to stay within the tolerance at the times of all of them: keys are
/// added where it is farthest off, one in each move at a time.
CameraPath thinned(const std::vector<RecordedView>& views, const ThinTolerance& tolerance);
/// Distance of the path from a view at its time, in tolerances: at most 1 is within.
double deviation(const CameraPath& path, const RecordedView& view, const ThinTolerance& tolerance);

nlohmann::json path_json(const CameraPath& path);
CameraPath path_from_json(const nlohmann::json& json, const std::string& where);
/// `NAME.path.json`. Throw Error.
CameraPath load_path(const std::string& file);
void save_path(const std::string& file, const CameraPath& path);

}  // namespace maquette
