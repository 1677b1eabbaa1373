#pragma once

#include <string>
#include <vector>

namespace maquette {

struct ManualEntry {
  std::string term;
  std::string help;
};

struct ManualSection {
  std::string title;
  std::string text;  ///< before the entries
  std::vector<ManualEntry> entries;
};

/// The manual of the whole program; the texts below are made of it.
std::vector<ManualSection> manual_sections();

/// The manual as text for a terminal (80 columns), of the whole program or of one command; made from the declarations
/// of commands, options, techniques and settings.
std::string manual_text(const std::string& command = {});
/// The same as Markdown: docs/manual.md, which a test keeps current.
std::string manual_markdown();

}  // namespace maquette
