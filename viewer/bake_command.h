#pragma once

namespace maquette {

struct CommandLine;

/// `maquette bake KIND [SCENE]`. Throws Error, also when it was interrupted; what is done by then is kept.
int run_bake(const CommandLine& line);

}  // namespace maquette
