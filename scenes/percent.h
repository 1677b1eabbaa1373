#pragma once

#include <cstdio>
#include <string>

namespace maquette {

/// Two digits: "0.12 %", "9.1 %", "42 %".
inline std::string percent_text(double share) {
  char text[32];
  std::snprintf(text, sizeof text, share >= 0.0995 ? "%.0f %%" : "%.2g %%", 100.0 * share);
  return text;
}

}  // namespace maquette
