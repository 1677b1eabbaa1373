#pragma once

#include <stdexcept>
#include <string>

namespace maquette {

/// `text` with `\x00` for the character U+0000, which would end a message.
inline std::string without_nul(std::string text) {
  for (std::size_t at = 0; (at = text.find('\0', at)) != std::string::npos;) text.replace(at, 1, "\\x00");
  return text;
}

/// An unusable file, user input or driver: one line that says where, what was expected and found, and what to do. Never
/// used for our own mistakes, which are assertions.
class Error : public std::runtime_error {
 public:
  /// `where` is a path, an option or a key (may be empty); `what` names the fault; `remedy` what to do.
  Error(const std::string& where, const std::string& what, const std::string& remedy = {})
      : std::runtime_error(
            without_nul((where.empty() ? "" : where + ": ") + what + (remedy.empty() ? "" : "; " + remedy))) {}
};

/// Wrong usage of the command line (unknown option, bad value): exit code 2 instead of 1.
class UsageError : public Error {
 public:
  using Error::Error;
};

}  // namespace maquette
