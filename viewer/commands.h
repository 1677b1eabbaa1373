#pragma once

namespace maquette {

/// The whole program: parses the command line, runs one command, turns errors into one line and an exit code
/// (0 done, 1 the work failed, 2 the call was wrong).
int run_program(int argc, char** argv);

}  // namespace maquette
