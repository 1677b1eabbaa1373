#pragma once

#include <epoxy/gl.h>

#include <chrono>
#include <ctime>
#include <string>
#include <vector>

namespace maquette {

struct PassTime {
  std::string name;
  double ms = 0.0;
  double cpu_ms = 0.0;  ///< processor time of the process, on a software device; else 0
  int layer = -1;       ///< index in FramePlan::layers; -1: of the whole frame
};

/// Times the passes of one frame in order. A software device runs at once, so waiting after each pass is exact and
/// free, and the processor time of the process beside it says what a busy machine's clock cannot; on hardware,
/// timestamps are queried at the end.
class PassTimer {
 public:
  explicit PassTimer(bool software) : software_(software) {}
  ~PassTimer() {
    if (!queries_.empty()) glDeleteQueries(static_cast<GLsizei>(queries_.size()), queries_.data());
  }
  PassTimer(const PassTimer&) = delete;
  PassTimer& operator=(const PassTimer&) = delete;

  void start() {
    mark();
    names_.clear();
  }
  /// What passed since the last mark is of no pass.
  void begin_run() {
    names_.push_back({{}, -1});
    mark();
  }
  /// Ends the pass that began at the last mark.
  void end(const std::string& name) {
    names_.push_back({all_as_.empty() ? name : all_as_, layer_});
    mark();
  }
  /// What ends from now on counts as this pass, whatever it calls itself; empty: no more.
  void count_all_as(const std::string& name) { all_as_ = name; }
  /// The layer that passes are of from now on.
  void set_layer(int layer) { layer_ = layer; }
  std::vector<PassTime> finish();

 private:
  struct Ended {
    std::string name;
    int layer;
  };
  void mark() {
    if (software_) {
      glFinish();
      times_.push_back(std::chrono::steady_clock::now());
      cpu_ms_.push_back(processor_ms());
      return;
    }
    GLuint query = 0;
    glGenQueries(1, &query);
    glQueryCounter(query, GL_TIMESTAMP);
    queries_.push_back(query);
  }
  /// Of all threads of the process.
  static double processor_ms() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
  }
  bool software_;
  std::string all_as_;
  int layer_ = -1;
  std::vector<Ended> names_;
  std::vector<std::chrono::steady_clock::time_point> times_;
  std::vector<double> cpu_ms_;
  std::vector<GLuint> queries_;
};

inline std::vector<PassTime> PassTimer::finish() {
  std::vector<PassTime> result;
  const auto add = [&](const Ended& ended, double ms, double cpu_ms) {
    for (PassTime& pass : result) {
      if (pass.name == ended.name && pass.layer == ended.layer) {
        pass.ms += ms;
        pass.cpu_ms += cpu_ms;
        return;
      }
    }
    result.push_back({ended.name, ms, cpu_ms, ended.layer});
  };
  for (std::size_t i = 0; i < names_.size(); ++i) {
    if (names_[i].name.empty()) continue;
    if (software_) {
      add(names_[i], std::chrono::duration<double, std::milli>(times_[i + 1] - times_[i]).count(),
          cpu_ms_[i + 1] - cpu_ms_[i]);
    } else {
      GLuint64 a = 0, b = 0;
      glGetQueryObjectui64v(queries_[i], GL_QUERY_RESULT, &a);
      glGetQueryObjectui64v(queries_[i + 1], GL_QUERY_RESULT, &b);
      add(names_[i], static_cast<double>(b - a) * 1e-6, 0.0);
    }
  }
  return result;
}

}  // namespace maquette
