#pragma once

#include <set>
#include <string>

#include "ui/editor_state.h"

namespace maquette {

/// Characters that occur in names (of a scene, a review, files, in messages), beyond those that the panels' own words
/// have: fonts are made with those alone.
class Glyphs {
 public:
  void note(const std::string& text);
  void note(const EditorState& state, const EditorFacts& facts);
  const std::set<char16_t>& all() const { return all_; }

 private:
  std::set<char16_t> all_;
};

}  // namespace maquette
