#include "tests/viewer/run_program.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "test_paths.h"

namespace maquette {

std::string read_text(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "maquette-test-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::vector<std::string> TemporaryFolder::names() const {
  std::vector<std::string> found;
  for (const auto& entry : std::filesystem::directory_iterator(path_)) found.push_back(entry.path().filename());
  std::sort(found.begin(), found.end());
  return found;
}

ProgramResult run_maquette(const std::vector<std::string>& arguments,
                           const std::map<std::string, std::string>& environment) {
  return run_in_folder(".", MAQUETTE_PROGRAM, arguments, environment);
}

ProgramResult run_in_folder(const std::string& folder, const std::string& program,
                            const std::vector<std::string>& arguments,
                            const std::map<std::string, std::string>& environment) {
  const TemporaryFolder captured;
  const std::string out = captured.file("out"), error = captured.file("error");
  std::map<std::string, std::string> variables = {{"DISPLAY", ""}, {"WAYLAND_DISPLAY", ""}};
  for (const auto& [name, value] : environment) variables[name] = value;
  const pid_t child = fork();
  if (child == 0) {
    dup2(open(out.c_str(), O_CREAT | O_WRONLY, 0600), STDOUT_FILENO);
    dup2(open(error.c_str(), O_CREAT | O_WRONLY, 0600), STDERR_FILENO);
    for (const auto& [name, value] : variables)
      value.empty() ? unsetenv(name.c_str()) : setenv(name.c_str(), value.c_str(), 1);
    std::vector<char*> words = {const_cast<char*>(program.c_str())};
    for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    if (chdir(folder.c_str()) == 0) execvp(program.c_str(), words.data());
    _exit(127);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read_text(out), read_text(error)};
}

}  // namespace maquette
