// A camera path, settled frame by settled frame.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "render/gl/context.h"
#include "review/json_reader.h"
#include "review/json_text.h"
#include "review/look_json.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/image_io.h"
#include "scenes/texture_formats.h"
#include "viewer/bake_lines.h"
#include "viewer/command_line.h"
#include "viewer/commands.h"
#include "viewer/interrupt.h"
#include "viewer/look_stage.h"
#include "viewer/outputs.h"
#include "viewer/pose.h"
#include "viewer/print.h"
#include "viewer/report/content_key.h"
#include "viewer/review_options.h"
#include "viewer/video_pipe.h"

namespace maquette {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double kQuiet_s = 2.0;  // between two lines of progress

/// All that decides the frames.
struct Play {
  Review review;  ///< of a path file: a state without looks
  CameraPath path;
  SettledFrame settled;
  double fps = 25.0;
  bool exr = false;
  std::string folder;  ///< of the frames
  std::string video;   ///< empty: none
  int count = 0;
};

std::string frame_file(const Play& play, int frame) {
  char name[32];
  std::snprintf(name, sizeof name, "/frame-%05d.%s", frame, play.exr ? "exr" : "png");
  return play.folder + name;
}

/// Whether a frame of an earlier run is there and can be read: a killed machine may leave empty files.
bool is_drawn(const std::string& file, bool exr) {
  if (!fs::is_regular_file(file)) return false;
  try {
    if (exr) {
      load_hdr_image(file);
    } else {
      TextureImage image;
      std::vector<std::string> notes;
      decode_texture(read_file(file), &image, &notes);
    }
    return true;
  } catch (const Error&) {
    return false;
  }
}

/// Of a scene without a path: that of the animation, for the camera that is asked for.
CameraPath path_of_options(const Scene& scene, const SceneOptions& options) {
  const std::string& name = options.animation.name;
  const Animation& animation = scene.animations[static_cast<std::size_t>(find_animation(scene, name))];
  const std::vector<CameraPath> paths = paths_of_animation(scene, animation, camera_of_options(scene, options));
  if (paths.empty()) throw Error(scene.name, "animation \"" + name + "\" has no duration", "render shows its one pose");
  for (const CameraPath& path : paths)
    if (path.name == name + " (" + options.camera + ")") return path;
  if (options.camera.empty() || paths.front().name == name) return paths.front();
  CameraPath rests = paths.front();  // a camera that the animation does not move
  rests.keys.resize(2);
  for (PathKey& key : rests.keys) key.camera = camera_by_name(scene, options.camera);
  for (PathKey& key : rests.keys) key.duration_s = animation.duration_s;
  return rests;
}

/// The looks of the path's keys, with what the command changes of them; `--look` takes the place of the first one's.
void take_looks(const Review& review, const Scene& scene, const SceneOptions& options, Play* play) {
  const auto first = std::ranges::find(play->path.keys, false, &PathKey::skip);
  if (!options.look.empty())
    first->look.reset();
  else if (!first->look)
    print_line(stderr,
               "warning: path %s begins with the state at hand, which each saving of the review may change: "
               "its first key names no look",
               play->path.name.c_str());
  std::set<std::string> names;
  for (const PathKey& key : play->path.keys)
    if (key.look && !key.skip) names.insert(find_look(review, *key.look).name);
  for (Look& look : play->review.looks) {
    if (!names.contains(look.name)) continue;
    SceneOptions of_look = options;
    of_look.look = look.name;
    look = look_of_review(review, scene, of_look);
  }
}

std::shared_ptr<const Scene> load_played(const SceneOptions& options, Play* play) {
  if (const std::optional<Review> review = review_of(options)) {
    play->review = *review;
    auto scene = std::make_shared<Scene>(load_scene(review->scene, review->scene_of_file));
    play->review.look = look_of_review(*review, *scene, options);
    play->path = find_path(*review, options.path);
    check_path(play->path, options.review + ": path " + options.path);
    if (!options.animation.name.empty()) play->path.animation = options.animation.name;
    if (!play->path.animation.empty()) find_animation(*scene, play->path.animation);
    take_looks(*review, *scene, options, play);
    return scene;
  }
  const std::shared_ptr<Scene> scene = load_session_scene(without_edits(options));
  if (options.path.empty()) {
    play->path = path_of_options(*scene, options);
  } else {
    play->path = load_path(options.path);
    if (!options.animation.name.empty()) play->path.animation = options.animation.name;
  }
  if (!play->path.animation.empty()) find_animation(*scene, play->path.animation);
  for (const PathKey& key : play->path.keys)
    if (key.look && !key.skip)
      throw Error(options.path, "the path changes to look \"" + *key.look + "\", and there is no review",
                  "play it from the review that has the look");
  play->review.scene = absolute_source(options.scene, fs::current_path().string());
  play->review.scene_of_file = options.scene_of_file;
  play->review.look = absolute_sources(look_of_options(*scene, options));
  return scene;
}

/// Changes with everything that the frames show.
std::string key_of(const Play& play, const Scene& scene) {
  const FrameSize& size = play.settled.size;
  report::ContentKey key = report::scene_key(scene);
  const auto same = [](const std::string& source) { return source; };
  key.mix(json_text(look_json(canonical(play.review.look), same))).mix(json_text(path_json(play.path)));
  for (const PathKey& at : play.path.keys)
    if (at.look && !at.skip) key.mix(json_text(look_json(canonical(find_look(play.review, *at.look)), same)));
  for (const std::string& source : review_sources(play.review)) key.mix(source_hash(source));
  for (const double value : {static_cast<double>(size.width), static_cast<double>(size.height),
                             static_cast<double>(size.msaa), static_cast<double>(size.samples),
                             static_cast<double>(size.seed), static_cast<double>(play.settled.frames), play.fps})
    key.mix(value);
  return key.text();
}

/// Frames that are there already belong to the same key, or the folder is refused.
void begin_folder(const Play& play, const std::string& key, bool resumes_anything) {
  prepare_folder("--output", play.folder);
  const std::string manifest = play.folder + "/play.json";
  if (fs::exists(manifest)) {
    std::string known;
    try {
      known = nlohmann::json::parse(read_text_file(manifest)).at("key").get<std::string>();
    } catch (const nlohmann::json::exception&) {
    }
    if (known == key) return;
    if (!resumes_anything)
      throw Error("--output " + play.folder, "it has frames of another path, look, size or scene",
                  "choose another folder, or remove it");
    fs::remove_all(play.folder);  // the frames beside a video, which nobody else names
    prepare_folder("--output", play.folder);
  } else if (!play.video.empty() && !fs::is_empty(play.folder)) {
    throw Error(play.folder, "the frames of the video would go there, and it has other files", "move them away");
  }
  write_text(manifest,
             nlohmann::json{{"key", key}, {"frames", play.count}, {"frames_per_second", play.fps}}.dump(1) + "\n");
}

/// Draws frames of a path; which ones, and in which order, does not matter to any of them.
class Player {
 public:
  Player(const Play& play, const SceneOptions& options, std::shared_ptr<const Scene> scene)
      : play_(play), options_(options), stage_(std::move(scene)) {}

  void draw(int frame) {
    const PathMoment moment = path_at(play_.path, frame / play_.fps);
    Look look = moment.look ? find_look(play_.review, *moment.look) : play_.review.look;
    if (!std::exchange(told_, true)) warn(moment.look.value_or(""), look);
    float exposure_ev = 0.0f;
    if (!play_.exr)
      exposure_ev = moment.exposure_ev ? *moment.exposure_ev : exposure_of_look(moment.look.value_or(""), look);
    look.camera = moment.camera;
    if (!play_.path.animation.empty()) look.edits.animation = {play_.path.animation, moment.time_s};
    if (moment.env_rotation_deg) look.edits.env_rotation_deg = *moment.env_rotation_deg;
    stage_.render(look, play_.settled);
    const std::string file = frame_file(play_, frame);
    if (play_.exr)
      save_exr(file, stage_.renderer().read_radiance());
    else
      save_png(file, stage_.renderer().read_display(exposure_ev, look.tonemap));
  }

 private:
  /// Of bakes that are to be made, before the first frame waits for them.
  void warn(const std::string& name, const Look& look) {
    std::vector<std::string> looks{path_at(play_.path, 0.0).look.value_or("")};
    for (const PathKey& key : play_.path.keys)
      if (key.look && !key.skip && *key.look != looks.front()) looks.push_back(*key.look);
    warn_of_bakes(options_, looks, name, look, [&](const std::string& bake) { return stage_.bake_key(look, bake); });
  }
  /// One for all frames of a look, so that brightness does not jump.
  float exposure_of_look(const std::string& name, const Look& look) {
    const auto found = exposures_.find(name);
    if (found != exposures_.end()) return found->second;
    return exposures_[name] = stage_.exposure_ev(look);
  }

  const Play& play_;
  const SceneOptions& options_;
  LookStage stage_;
  bool told_ = false;
  std::map<std::string, float> exposures_;
};

/// While a video is made nobody else draws or removes its frames. The file beside it goes with the lock.
class VideoLock {
 public:
  explicit VideoLock(const fs::path& video)
      : name_((video.parent_path() / ("." + video.filename().string() + ".lock")).string()),
        file_(open(name_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
    struct stat own {
    }, named{};
    const bool locked = file_ >= 0 && flock(file_, LOCK_EX | LOCK_NB) == 0 && fstat(file_, &own) == 0 &&
                        stat(name_.c_str(), &named) == 0 && own.st_ino == named.st_ino;
    if (locked) return;
    if (file_ >= 0) close(file_);
    throw Error(video.string(), "another maquette play is making it", "wait for that, or choose another name");
  }
  ~VideoLock() {
    unlink(name_.c_str());
    close(file_);
  }
  VideoLock(const VideoLock&) = delete;
  VideoLock& operator=(const VideoLock&) = delete;

 private:
  std::string name_;
  int file_;
};

class Progress {
 public:
  explicit Progress(int count) : count_(count) {}
  void frame_done(int done, int drawn) {
    const double now_s = std::chrono::duration<double>(Clock::now() - begin_).count();
    if (now_s - last_s_ < kQuiet_s && done < count_) return;
    last_s_ = now_s;
    const double left_s = drawn > 0 ? now_s / drawn * (count_ - done) : 0.0;
    print_line(stderr, "frame %d of %d, about %.0f s left\n", done, count_, left_s);
  }

 private:
  int count_;
  double last_s_ = -kQuiet_s;
  Clock::time_point begin_ = Clock::now();
};

int play_frames(const Play& play, const SceneOptions& options, std::shared_ptr<const Scene> scene) {
  const InterruptGuard guard;
  Player player(play, options, std::move(scene));
  Progress progress(play.count);
  std::unique_ptr<VideoPipe> video;
  if (!play.video.empty()) video = std::make_unique<VideoPipe>(play.video, play.fps);
  int drawn = 0;
  for (int frame = 0; frame < play.count; ++frame) {
    if (InterruptGuard::asked())
      throw Error("maquette play", "stopped at frame " + std::to_string(frame) + " of " + std::to_string(play.count),
                  "the same command continues there");
    if (!is_drawn(frame_file(play, frame), play.exr)) {
      player.draw(frame);
      ++drawn;
    }
    if (video) video->add(frame_file(play, frame));
    progress.frame_done(frame + 1, drawn);
  }
  if (video) {
    video->finish();
    fs::remove_all(play.folder);
  }
  return drawn;
}

Play play_of(const SceneOptions& options) {
  Play play;
  play.settled.size = {options.width, options.height, options.msaa, options.samples, options.seed};
  play.settled.frames = options.average;
  play.fps = options.fps;
  play.exr = options.frame_format == "exr";
  play.folder = options.output;
  if (VideoPipe::is_video(options.output)) {
    if (play.exr) throw UsageError("--format exr", "a video has no EXR frames", "give a folder as --output");
    VideoPipe::require_ffmpeg();
    check_writable("--output", options.output);
    play.video = options.output;
    play.folder = options.output + ".frames";
  } else if (!lower_extension(options.output).empty() && !fs::is_directory(options.output)) {
    throw UsageError("--output " + options.output, "this is neither a folder nor a video",
                     "name a folder without an extension, or a .mp4, .mkv or .mov file");
  }
  return play;
}

}  // namespace

int run_play(const CommandLine& line) {
  const SceneOptions& options = line.options;
  Play play = play_of(options);
  const std::shared_ptr<const Scene> scene = load_played(options, &play);
  const double frames = path_duration_s(play.path) * play.fps;
  // The last key of an open path has a frame of its own; a closed one ends where it begins.
  play.count = play.path.closed ? std::max(static_cast<int>(std::lround(frames)), 1)
                                : static_cast<int>(std::floor(frames + 1e-6)) + 1;
  std::optional<VideoLock> lock;
  if (!play.video.empty()) {
    lock.emplace(play.video);
    if (play.settled.size.width % 2 + play.settled.size.height % 2 > 0)
      print_line(stderr, "%s: the video has black borders of one pixel: its sides must be even\n", play.video.c_str());
  }
  begin_folder(play, key_of(play, *scene), !play.video.empty());
  const GlContext context = GlContext::create_headless();
  query_device();
  const int drawn = play_frames(play, options, scene);
  print_line(stdout, "%s: %d frames of %dx%d, %d of them drawn now\n", options.output.c_str(), play.count,
             play.settled.size.width, play.settled.size.height, drawn);
  return 0;
}

}  // namespace maquette
