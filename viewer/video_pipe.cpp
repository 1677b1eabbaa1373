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
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t program = getpid();
  process_ = fork();
  if (process_ == 0) {
    // Killed with us, so that the next run may remove what it wrote.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != program) _exit(1);
    dup2(ends[0], STDIN_FILENO);
    const int log = open(log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    if (log >= 0) {
      dup2(log, STDOUT_FILENO);
      dup2(log, STDERR_FILENO);
    }
    setpgid(0, 0);  // Ctrl-C is for us: what is done is kept
    execvp("ffmpeg", argv.data());
    _exit(127);
  }
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
}

void VideoPipe::finish() {
  if (wait() != 0) fail();
  std::error_code code;
  fs::rename(beside_, path_, code);
  if (code) throw Error(path_, "cannot be written (" + code.message() + ")", "choose a writable folder");
}

}  // namespace maquette
