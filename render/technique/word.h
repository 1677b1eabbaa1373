#pragma once

#include <string>

namespace maquette {

/// One word of the frame plan, of `--stats` and of the report, which means one thing everywhere.
struct Word {
  enum class Kind {
    pass,      ///< planned, executed or skipped, and timed
    feature,   ///< what a frame has or does besides its passes
    resource,  ///< a key of `gpu_bytes`, or what passes read and write
    counter,   ///< a key of `technique`
  };
  Kind kind = Kind::pass;
  std::string name;
  std::string meaning;
};

}  // namespace maquette
