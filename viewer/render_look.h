#pragma once

namespace maquette {

struct CommandLine;

/// `render REVIEW [--look NAME]`: a look as a settled frame.
int render_look(const CommandLine& line);

}  // namespace maquette
