#pragma once

#include <string>

namespace maquette {

/// A script that completes commands, options and the names that options take; made from their declarations. `shell`:
/// bash or zsh. Throws UsageError for another.
std::string shell_completion(const std::string& shell);
/// The manual as a page for man(1), in roff.
std::string manual_roff();

}  // namespace maquette
