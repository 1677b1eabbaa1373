#include "viewer/video_pipe.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <utility>
#include <vector>

#include "scenes/error.h"
#include "scenes/files.h"

namespace maquette {

namespace fs = std::filesystem;

bool VideoPipe::is_video(const std::string& path) {
  static const std::vector<std::string> kKinds = {".mp4", ".mkv", ".mov"};
  return std::ranges::find(kKinds, lower_extension(path)) != kKinds.end();
}

void VideoPipe::require_ffmpeg() {
  const char* folders = std::getenv("PATH");
  std::string rest = folders ? folders : "";
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(':'), rest.size());
    if (access((fs::path(rest.substr(0, end)) / "ffmpeg").c_str(), X_OK) == 0) return;
    rest.erase(0, end + 1);
  }
  throw Error("ffmpeg", "it makes the video and is not installed",
              "install it (apt install ffmpeg), or give a folder instead, for single pictures");
}

namespace {

/// Starts a program; -1 where that is not possible. Descriptors below 0 are left as they are.
pid_t start(std::vector<std::string> words, int input, int output) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t program = getpid(), child = fork();
  if (child != 0) return child;
  // Killed with us, so that the next run may remove what it wrote.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != program) _exit(1);
  if (input >= 0) dup2(input, STDIN_FILENO);
  if (output >= 0) {
    dup2(output, STDOUT_FILENO);
    dup2(output, STDERR_FILENO);
  }
  setpgid(0, 0);  // Ctrl-C is for us: what is done is kept
  execvp(argv[0], argv.data());
  _exit(127);
}

/// Frames that can be read from a video: ffmpeg ends with success where a full disk cut off what it wrote.
int frames_in(const std::string& video) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return 0;
  const pid_t child = start(
      {"ffmpeg", "-nostdin", "-loglevel", "quiet", "-i", video, "-map", "0:v", "-c", "copy", "-f", "framecrc", "-"}, -1,
      ends[1]);
  close(ends[1]);
  std::string lines = "\n";
  char chunk[4096];
  for (ssize_t count = 0; (count = read(ends[0], chunk, sizeof chunk)) > 0 || (count < 0 && errno == EINTR);)
    if (count > 0) lines.append(chunk, static_cast<std::size_t>(count));
  close(ends[0]);
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) < 0 || status != 0) return 0;
  // One line a frame; those of the header begin with #.
  int frames = 0;
  for (std::size_t at = 0; (at = lines.find('\n', at)) != std::string::npos && ++at < lines.size();)
    if (lines[at] != '#') ++frames;
  return frames;
}

}  // namespace

VideoPipe::VideoPipe(std::string path, double frames_per_second) : path_(std::move(path)) {
  path_ = link_target(path_);
  beside_ = temporary_path(fs::absolute(path_).string());  // a name with a colon is no protocol
  log_ = beside_ + ".log";
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw Error(path_, "no pipe can be made to ffmpeg");
  const std::string rate = std::to_string(frames_per_second);
  std::vector<std::string> words = {"ffmpeg", "-nostdin", "-loglevel", "error", "-y", "-f", "image2pipe", "-c:v", "png",
                                    "-framerate", rate, "-i", "pipe:0", "-an",
                                    // Two pixels share a colour: even sides. ITU-R BT.709, black at 16, white at 235.
                                    "-vf",
                                    "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=in_range=pc:out_range=tv:"
                                    "out_color_matrix=bt709:flags=accurate_rnd+full_chroma_int,format=yuv420p",
                                    "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709",
                                    "-color_range", "tv", "-c:v", "libx264", "-crf", "18", beside_};
  const int log = open(log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  process_ = start(words, ends[0], log);
  if (log >= 0) close(log);
  close(ends[0]);
  input_ = ends[1];
  if (process_ < 0) throw Error(path_, "ffmpeg cannot be started", "close other programs");
  std::signal(SIGPIPE, SIG_IGN);  // an ffmpeg that has ended is an error of `write`
}

int VideoPipe::wait() {
  if (input_ >= 0) close(std::exchange(input_, -1));
  int status = 0;
  if (process_ > 0)
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) continue;
  process_ = -1;
  return status;
}

VideoPipe::~VideoPipe() {
  if (process_ > 0) {
    kill(process_, SIGKILL);
    wait();
  }
  std::error_code ignored;
  fs::remove(beside_, ignored);
  fs::remove(log_, ignored);
}

void VideoPipe::fail() {
  wait();
  std::string said;
  if (std::error_code code; fs::exists(log_, code)) {
    const std::vector<std::byte> bytes = read_file(log_);
    said.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    while (!said.empty() && said.back() == '\n') said.pop_back();
    said = said.substr(said.rfind('\n') + 1);
  }
  throw Error(path_, "ffmpeg stopped" + (said.empty() ? std::string() : ": " + said),
              "make room or choose another name; the same command continues, its frames are kept");
}

void VideoPipe::add(const std::string& png_file) {
  const std::vector<std::byte> bytes = read_file(png_file);
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = write(input_, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail();
    done += static_cast<std::size_t>(count);
  }
  ++frames_;
}

void VideoPipe::finish() {
  if (wait() != 0) fail();
  if (const int found = frames_in(beside_); found != frames_)
    throw Error(path_,
                "only " + std::to_string(found) + " of " + std::to_string(frames_) +
                    " frames could be written: the disk may be full",
                "make room or choose another name; the same command continues, its frames are kept");
  std::error_code code;
  fs::rename(beside_, path_, code);
  if (code) throw Error(path_, "cannot be written (" + code.message() + ")", "choose a writable folder");
}

}  // namespace maquette
