#include "tests/ui/desktop.h"

#include <GLFW/glfw3.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "scenes/image_io.h"
#include "scenes/luminance.h"
#include "test_paths.h"

namespace maquette::test {

namespace {

namespace fs = std::filesystem;

bool on_path(const std::string& program) {
  std::istringstream path(std::getenv("PATH") ? std::getenv("PATH") : "");
  for (std::string folder; std::getline(path, folder, ':');)
    if (access((folder + "/" + program).c_str(), X_OK) == 0) return true;
  return false;
}

/// Starts a program with extra environment (`NAME=value`), output and errors into files when named.
int spawn(const std::vector<std::string>& arguments, const std::vector<std::string>& environment,
          const std::string& errors = {}) {
  const int process = fork();
  if (process != 0) return process;
  for (const std::string& entry : environment) {
    const std::size_t equals = entry.find('=');
    setenv(entry.substr(0, equals).c_str(), entry.substr(equals + 1).c_str(), 1);
  }
  const int sink = open(errors.empty() ? "/dev/null" : errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  dup2(sink, 2);
  if (errors.empty()) dup2(sink, 1);
  std::vector<char*> words;
  for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  execvp(words[0], words.data());
  _exit(127);
}

int finish(int process) {
  int status = 0;
  waitpid(process, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

void pause_ms(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

template <typename Visit>
void each_pixel(const ScreenPicture& picture, const Rect& rect, const Visit& visit) {
  const int x1 = std::min(static_cast<int>(rect.x + rect.width), picture.width);
  const int y1 = std::min(static_cast<int>(rect.y + rect.height), picture.height);
  for (int y = std::max(static_cast<int>(rect.y), 0); y < y1; ++y)
    for (int x = std::max(static_cast<int>(rect.x), 0); x < x1; ++x)
      visit(3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) + static_cast<std::size_t>(x)));
}

}  // namespace

double difference(const ScreenPicture& a, const ScreenPicture& b, const Rect& rect) {
  constexpr int kBlock = 8;
  if (a.rgb.size() != b.rgb.size() || a.rgb.empty()) return 255.0;
  double sum = 0.0, count = 0.0;
  for (float y = rect.y; y < rect.y + rect.height; y += kBlock) {
    for (float x = rect.x; x < rect.x + rect.width; x += kBlock) {
      const Rect block{x, y, std::min<float>(kBlock, rect.x + rect.width - x),
                       std::min<float>(kBlock, rect.y + rect.height - y)};
      std::array<double, 3> change{};
      double pixels = 0.0;
      each_pixel(a, block, [&](std::size_t i) {
        for (std::size_t c = 0; c < 3; ++c) change[c] += int(a.rgb[i + c]) - int(b.rgb[i + c]);
        pixels += 1.0;
      });
      for (const double c : change) sum += std::abs(c);
      count += 3.0 * pixels;
    }
  }
  return count > 0.0 ? sum / count : 0.0;
}

double contrast(const ScreenPicture& picture, const Rect& rect) {
  double sum = 0.0, squares = 0.0, count = 0.0;
  each_pixel(picture, rect, [&](std::size_t i) {
    const double luma = luminance(glm::dvec3(picture.rgb[i], picture.rgb[i + 1], picture.rgb[i + 2]));
    sum += luma;
    squares += luma * luma;
    count += 1.0;
  });
  if (count == 0.0) return 0.0;
  return std::sqrt(std::max(squares / count - (sum / count) * (sum / count), 0.0));
}

std::string Desktop::missing_tools() {
  for (const char* program : {"Xvfb", "xdotool"})
    if (!on_path(program)) return std::string(program) + " is not installed";
  return {};
}

Desktop::Desktop(int width, int height) : width_(width), height_(height) {
  std::string pattern = (fs::temp_directory_path() / "maquette-desktop-XXXXXX").string();
  if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
  folder_ = pattern;
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  const std::string screen = std::to_string(width) + "x" + std::to_string(height) + "x24";
  screen_process_ = spawn(
      {"Xvfb", "-displayfd", std::to_string(ends[1]), "-screen", "0", screen, "-nolisten", "tcp", "-noreset", "-r"},
      {});
  close(ends[1]);
  std::string number;
  for (char c = 0; read(ends[0], &c, 1) == 1 && c != '\n';) number += c;
  close(ends[0]);
  if (number.empty()) throw std::runtime_error("Xvfb did not start");
  display_ = "DISPLAY=:" + number;
}

Desktop::~Desktop() {
  for (const int process : {program_, screen_process_}) {
    if (process <= 0) continue;
    kill(process, SIGTERM);
    finish(process);
  }
  std::error_code error;
  fs::remove_all(folder_, error);
}

void Desktop::start(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {MAQUETTE_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  fs::remove(state_file());
  program_ = spawn(words,
                   {display_, "MAQUETTE_WINDOW_STATE=" + state_file(), "LIBGL_ALWAYS_SOFTWARE=1",
                    "WAYLAND_DISPLAY=", "XDG_STATE_HOME=" + folder_ + "/state"},
                   folder_ + "/errors");
  wait_for_state([](const WindowState& s) { return s.frames > 0; });
}

void Desktop::kill_program() {
  if (program_ <= 0) return;
  kill(program_, SIGKILL);
  finish(program_);
  program_ = exit_code_ = -1;
}

bool Desktop::running() {
  if (program_ <= 0) return false;
  int status = 0;
  if (waitpid(program_, &status, WNOHANG) == 0) return true;
  program_ = -1;
  exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return false;
}

int Desktop::wait_for_exit() {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(kLimit_s);
  while (running() && std::chrono::steady_clock::now() < end) {
    pause_ms(5);
  }
  return program_ > 0 ? -1 : exit_code_;
}

void Desktop::save_screen(const std::string& file) const {
  const ScreenPicture screen = grab();
  Image image(screen.width, screen.height, 3);
  std::ranges::transform(screen.rgb, image.data.begin(), [](std::uint8_t byte) { return float(byte) / 255.0f; });
  save_png(file, image);
}

void Desktop::post(const std::vector<std::string>& arguments) const {
  std::vector<std::string> words = {"xdotool"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  finish(spawn(words, {display_}));
}

void Desktop::input(const std::vector<std::string>& arguments) {
  post(arguments);
  wait_for_frames();
}

void Desktop::move(float x, float y) {
  input({"mousemove", std::to_string(std::lround(x)), std::to_string(std::lround(y))});
}

void Desktop::click(const Rect& rect) {
  input({"mousemove", std::to_string(std::lround(rect.x + 0.5f * rect.width)),
         std::to_string(std::lround(rect.y + 0.5f * rect.height)), "click", "1"});
}

bool Desktop::wait_for_frames() {
  // The first may have been begun before now, popups open in the second, and the third has laid them out.
  constexpr int kFrames = 3;
  const long before = state().frames;
  return wait_for_state([&](const WindowState& s) { return s.frames >= before + kFrames && s.waiting == 0; });
}

bool Desktop::wait_for_state(const std::function<bool(const WindowState&)>& done) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(kLimit_s);
  long seen = -1;
  while (std::chrono::steady_clock::now() < end) {
    const WindowState now = state();
    if (now.frames != seen && done(now)) return true;
    if (!running()) return false;
    if (now.frames == seen) pause_ms(5);
    seen = now.frames;
  }
  return false;
}

bool Desktop::wait_until(const std::function<bool(const ScreenPicture&)>& done) {
  return wait_for_state([&](const WindowState&) { return done(grab()); });
}

WindowState Desktop::state() const { return read_window_state(state_file()).value_or(WindowState{}); }

std::string Desktop::display() const { return display_.substr(display_.find('=') + 1); }

std::string Desktop::clipboard() const {
  const char* own = std::getenv("DISPLAY");
  const std::string before = own ? own : "";
  ::setenv("DISPLAY", display().c_str(), 1);
  std::string text;
  if (glfwInit() == GLFW_TRUE) {
    const char* found = glfwGetClipboardString(nullptr);
    if (found) text = found;
    glfwTerminate();
  }
  if (own)
    ::setenv("DISPLAY", before.c_str(), 1);
  else
    ::unsetenv("DISPLAY");
  return text;
}

std::string Desktop::errors() const {
  std::ifstream stream(folder_ + "/errors");
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace maquette::test
