#pragma once

#include <string>

namespace maquette::test {

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace maquette::test
