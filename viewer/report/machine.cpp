#include "viewer/report/machine.h"

#include <embree3/rtcore_config.h>
#include <sys/sysinfo.h>
#include <sys/utsname.h>
#include <tbb/version.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>
#include <thread>

namespace maquette::report {

namespace {

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[40];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", &utc);
  return text;
}

std::string one_decimal(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

}  // namespace

std::vector<NamedValue> describe_machine(const DeviceInfo& device) {
  utsname system{};
  uname(&system);
  struct sysinfo info {};
  sysinfo(&info);
  double load[1] = {0.0};
  const bool has_load = getloadavg(load, 1) == 1;
  const double memory_gib = static_cast<double>(info.totalram) * info.mem_unit / (1 << 30);
#ifdef NDEBUG
  const std::string build = "optimised";
#else
  const std::string build = "debug";
#endif
  return {{"date", today()},
          {"maquette", std::string(MAQUETTE_VERSION) + ", " + build + ", " + __VERSION__},
          {"processor", processor_name()},
          {"threads", std::to_string(std::thread::hardware_concurrency())},
          {"memory", one_decimal(memory_gib) + " GiB"},
          {"system", std::string(system.sysname) + " " + system.release + " " + system.machine},
          {"load at the start", has_load ? one_decimal(load[0]) : "unknown"},
          {"graphics", device.renderer + (device.software ? " (software)" : "")},
          {"OpenGL", device.version},
          {"Embree", RTC_VERSION_STRING},
          {"TBB", std::to_string(TBB_VERSION_MAJOR) + "." + std::to_string(TBB_VERSION_MINOR)}};
}

}  // namespace maquette::report
