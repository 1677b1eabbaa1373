#pragma once

#include <OpenEXR/ImfThreading.h>

#include <mutex>
#include <thread>

namespace maquette {

/// Before the first EXR file is read or written.
inline void use_all_cores_for_exr() {
  static std::once_flag once;
  std::call_once(once, [] { Imf::setGlobalThreadCount(static_cast<int>(std::thread::hardware_concurrency())); });
}

}  // namespace maquette
