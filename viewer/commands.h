#pragma once

namespace maquette {

struct CommandLine;

/// The whole program: parses the command line, runs one command, turns errors into one line and an exit code
/// (0 done, 1 the work failed, 2 the call was wrong).
int run_program(int argc, char** argv);

/// One each; they throw Error and return the exit code.
int run_view(const CommandLine& line);
int run_render(const CommandLine& line);
int run_play(const CommandLine& line);
int run_report(const CommandLine& line);
int run_measure(const CommandLine& line);
int run_compare(const CommandLine& line);
int run_inspect(const CommandLine& line);
int run_doctor(const CommandLine& line);
int run_help(const CommandLine& line);

}  // namespace maquette
