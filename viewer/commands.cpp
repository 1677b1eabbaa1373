#include "viewer/commands.h"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <functional>
#include <map>
#include <new>

#include "scenes/error.h"
#include "viewer/bake_command.h"
#include "viewer/command_line.h"
#include "viewer/print.h"

namespace maquette {

namespace {

int fail(int code, const std::string& text) {
  std::string line = text;
  std::ranges::replace_if(
      line, [](char c) { return c == '\n' || c == '\r'; }, ' ');
  std::fflush(stdout);
  print_line(stderr, "maquette: %s\n", line.c_str());
  return code;
}

int run_command(const CommandLine& line) {
  static const std::map<std::string, std::function<int(const CommandLine&)>> kRunners = {
      {"view", run_view},       {"render", run_render}, {"compare", run_compare}, {"inspect", run_inspect},
      {"report", run_report},   {"doctor", run_doctor}, {"bake", run_bake},       {"help", run_help},
      {"measure", run_measure}, {"play", run_play},
  };
  return line.help ? run_help(line) : kRunners.at(line.command)(line);
}

}  // namespace

int run_program(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that reaches the limit of its size is an error of `write`
  try {
    const int code = run_command(parse_command_line(std::vector<std::string>(argv + (argc > 0 ? 1 : 0), argv + argc)));
    if (std::fflush(stdout) != 0 || std::ferror(stdout)) return fail(1, "standard output: cannot be written");
    return code;
  } catch (const UsageError& error) {
    return fail(2, error.what());
  } catch (const std::bad_alloc&) {
    return fail(1,
                "out of memory; close other programs or ask for less (--size, --msaa; of a bake fewer parts, or a "
                "coarser one)");
  } catch (const std::exception& error) {
    return fail(1, error.what());
  }
}

}  // namespace maquette
