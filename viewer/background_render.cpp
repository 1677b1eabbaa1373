#include "viewer/background_render.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "review/journal.h"
#include "review/json_reader.h"
#include "scenes/error.h"
#include "viewer/picture_command.h"

namespace maquette {

namespace fs = std::filesystem;

void BackgroundRender::start(const Review& review, const SettledFrame& settled, const std::string& output,
                             const std::string& command) {
  cancel();
  static int number = 0;
  const std::string base = state_folder() + "/render-" + std::to_string(::getpid()) + "-" + std::to_string(++number);
  review_file_ = base + ".maquette.json";
  log_ = base + ".log";
  output_ = output;
  save_review(review_file_, review);
  const FrameSize& size = settled.size;
  std::vector<std::string> words = {"maquette",
                                    "render",
                                    review_file_,
                                    "-o",
                                    output_,
                                    "--size",
                                    std::to_string(size.width) + "x" + std::to_string(size.height),
                                    "--msaa",
                                    std::to_string(size.msaa),
                                    "--seed",
                                    std::to_string(size.seed),
                                    "--average",
                                    std::to_string(settled.frames)};
  if (size.samples > 0) words.insert(words.end(), {"--samples", std::to_string(size.samples)});
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  process_ = fork();
  if (process_ == 0) {
    setpriority(PRIO_PROCESS, 0, 10);
    setenv(kPictureCommand, command.c_str(), 1);
    const int log = open(log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    if (log >= 0) {
      dup2(log, STDOUT_FILENO);
      dup2(log, STDERR_FILENO);
    }
    execv("/proc/self/exe", argv.data());
    _exit(127);
  }
  if (process_ < 0) throw Error(output, "no other program can be started for it", "close other programs");
}

double BackgroundRender::progress() const {
  try {
    const std::string told = read_text_file(log_);
    const std::size_t at = told.rfind("render: ");
    return at == std::string::npos ? 0.0 : 0.01 * std::strtod(told.c_str() + at + 8, nullptr);
  } catch (const Error&) {
    return 0.0;  // nothing yet
  }
}

void BackgroundRender::cancel() {
  if (process_ <= 0) return;
  kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
  process_ = -1;
  clean_up();
}

void BackgroundRender::clean_up() {
  std::error_code ignored;
  fs::remove(review_file_, ignored);
  fs::remove(log_, ignored);
}

bool BackgroundRender::poll(std::string* error) {
  int status = 0;
  if (process_ <= 0 || waitpid(process_, &status, WNOHANG) != process_) return false;
  process_ = -1;
  error->clear();
  if (status != 0) {
    std::error_code code;
    *error = fs::exists(log_, code) ? read_text_file(log_) : "";
    while (!error->empty() && error->back() == '\n') error->pop_back();
    *error = error->substr(error->rfind('\n') + 1);
    if (error->empty()) *error = output_ + ": it could not be drawn";
  }
  clean_up();
  return true;
}

}  // namespace maquette
