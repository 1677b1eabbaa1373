#include "ui/file_browser.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string_view>

namespace maquette {

bool can_be_opened(const std::string& file) {
  static constexpr std::array<std::string_view, 8> kEndings = {".glb", ".gltf", ".maquette.json", ".path.json",
                                                               ".hdr", ".exr",  ".binary",        ".btf"};
  std::string name = file;
  std::ranges::transform(name, name.begin(),
                         [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return std::ranges::any_of(kEndings, [&](std::string_view ending) { return name.ends_with(ending); });
}

FileBrowser browse_folder(const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::path whole = fs::absolute(folder.empty() ? "." : folder, error).lexically_normal();
  if (!whole.has_filename() && whole.has_parent_path()) whole = whole.parent_path();
  FileBrowser browser{whole.string(), {}, {}};
  for (fs::directory_iterator at(whole, fs::directory_options::skip_permission_denied, error), end; at != end;
       at.increment(error)) {
    if (error) break;
    const std::string name = at->path().filename().string();
    std::error_code ignored;
    if (name.starts_with(".")) continue;
    if (at->is_directory(ignored))
      browser.folders.push_back(name);
    else if (can_be_opened(name))
      browser.files.push_back(name);
  }
  std::ranges::sort(browser.folders);
  std::ranges::sort(browser.files);
  return browser;
}

}  // namespace maquette
