#pragma once

#include <string>

namespace maquette {

/// The manual as text for a terminal (80 columns), of the whole program or of one command; made from the declarations
/// of commands, options, techniques and settings.
std::string manual_text(const std::string& command = {});
/// The same as Markdown: docs/manual.md, which a test keeps current.
std::string manual_markdown();

}  // namespace maquette
