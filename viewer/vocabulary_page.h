#pragma once

#include <string>

namespace maquette {

/// docs/vocabulary.md, which a test keeps current: the words of plans, stats and reports.
std::string vocabulary_markdown();

}  // namespace maquette
