#include "scenes/image_exr_channels.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfPartType.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string_view>

#include "scenes/error.h"

namespace maquette {
namespace {

using Layout = ExrPicture::Layout;
constexpr std::size_t kMaxNamed = 12;  // in one message
constexpr std::size_t kMaxNameLength = 40;

/// Channels of one name space by their last name: R, G, B, A, Y, RY, BY.
struct Group {
  std::string layer;  ///< empty for the plain channels
  std::string name;   ///< for messages
  std::map<std::string, ExrChannel, std::less<>> channels;
};

bool is_flat(const Imf::Header& header) {
  return !header.hasType() || header.type() == Imf::SCANLINEIMAGE || header.type() == Imf::TILEDIMAGE;
}

bool is_read_channel(std::string_view name) {
  static constexpr std::array<std::string_view, 7> kRead = {"R", "G", "B", "A", "Y", "RY", "BY"};
  return std::find(kRead.begin(), kRead.end(), name) != kRead.end();
}

std::string shortened(const std::string& name) {
  return name.size() > kMaxNameLength ? name.substr(0, kMaxNameLength) + "..." : name;
}

std::string join_names(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i == kMaxNamed) return text + ", ...";
    text += (text.empty() ? "" : ", ") + shortened(names[i]);
  }
  return text.empty() ? "none" : text;
}

std::string describe_part(const Imf::Header& header) {
  if (!is_flat(header)) return "a deep image";
  std::vector<std::string> names;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) names.emplace_back(it.name());
  return join_names(names);
}

/// `left` of the part `left.R` when that holds the channel R: such parts hold one layer together.
std::string stem_of_part(const std::string& part, const std::string& channel) {
  if (part == channel) return {};
  return part.ends_with("." + channel) ? part.substr(0, part.size() - channel.size() - 1) : std::string();
}

class Finder {
 public:
  explicit Finder(const Imf::MultiPartInputFile& file) : file_(file) {
    for (int p = 0; p < file.parts(); ++p)
      if (is_flat(file.header(p))) add_part(p);
  }

  /// All complete pictures, the best first; luminance alone only when there is no colour.
  std::vector<ExrPicture> pictures() const {
    std::vector<ExrPicture> found;
    for (const bool colour : {true, false}) {
      if (!found.empty()) break;
      for (const bool plain : {true, false}) {
        for (const std::vector<Group>* groups : {&of_part_, &joined_}) {
          for (const Group& group : *groups) {
            if (group.layer.empty() != plain) continue;
            std::optional<ExrPicture> picture = picture_of(group, colour);
            if (picture && (groups == &of_part_ || spans_parts(*picture))) found.push_back(std::move(*picture));
          }
        }
      }
    }
    return found;
  }

 private:
  void add_part(int p) {
    const Imf::Header& header = file_.header(p);
    const std::string part = header.hasName() ? header.name() : std::string();
    const std::string view = header.hasView() ? header.view() : std::string();
    for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
      const std::string full = it.name();
      const std::size_t dot = full.rfind('.');
      const std::string layer = dot == std::string::npos ? "" : full.substr(0, dot);
      const std::string last = dot == std::string::npos ? full : full.substr(dot + 1);
      if (!is_read_channel(last)) continue;
      const ExrChannel channel{p, full, it.channel().xSampling, it.channel().ySampling};
      const std::string own_name = file_.parts() > 1 ? part + (layer.empty() ? "" : ":" + layer) : layer;
      insert(&of_part_, std::to_string(p) + ":" + layer, {layer, own_name, {}}, last, channel);
      const std::string stem = layer.empty() ? stem_of_part(part, last) : layer;
      const Imath::Box2i& window = header.dataWindow();
      const std::string key = view + ":" + stem + ":" + std::to_string(window.min.x) + ":" +
                              std::to_string(window.min.y) + ":" + std::to_string(window.max.x) + ":" +
                              std::to_string(window.max.y);
      // A stem comes from parts that are made for this, and counts as plain.
      insert(&joined_, key, {layer, stem.empty() ? (view.empty() ? part : view) : stem, {}}, last, channel);
    }
  }

  void insert(std::vector<Group>* groups, const std::string& key, const Group& empty, const std::string& last,
              const ExrChannel& channel) {
    auto& index = groups == &of_part_ ? part_index_ : joined_index_;
    const auto [found, is_new] = index.try_emplace(key, groups->size());
    if (is_new) groups->push_back(empty);
    (*groups)[found->second].channels.try_emplace(last, channel);
  }

  /// Whether the colour comes from several parts; otherwise the picture is already known as that of its part.
  static bool spans_parts(const ExrPicture& picture) {
    const auto end = picture.channels.end() - (picture.has_alpha ? 1 : 0);
    return std::any_of(picture.channels.begin(), end,
                       [&](const ExrChannel& channel) { return channel.part != picture.channels[0].part; });
  }

  static std::optional<ExrPicture> picture_of(const Group& group, bool colour) {
    const auto has = [&](const char* name) { return group.channels.count(name) > 0; };
    const auto take = [&](Layout layout, std::initializer_list<const char*> names) {
      ExrPicture picture{layout, group.name, {}, has("A")};
      for (const char* name : names) picture.channels.push_back(group.channels.find(name)->second);
      if (picture.has_alpha) picture.channels.push_back(group.channels.find("A")->second);
      return picture;
    };
    const bool rgb = has("R") && has("G") && has("B");
    const bool chroma = has("Y") && has("RY") && has("BY");
    if (colour && rgb) return take(Layout::rgb, {"R", "G", "B"});
    if (colour && chroma) return take(Layout::luminance_chroma, {"Y", "RY", "BY"});
    // Y with one of two chroma channels is damaged rather than grey.
    if (!colour && !rgb && has("Y") && !has("RY") && !has("BY")) return take(Layout::luminance, {"Y"});
    return std::nullopt;
  }

  const Imf::MultiPartInputFile& file_;
  std::vector<Group> of_part_, joined_;
  std::map<std::string, std::size_t> part_index_, joined_index_;
};

}  // namespace

ExrPicture choose_exr_picture(const std::string& path, const Imf::MultiPartInputFile& file,
                              std::vector<std::string>* warnings) {
  const std::vector<ExrPicture> pictures = Finder(file).pictures();
  if (pictures.empty()) {
    std::vector<std::string> parts;
    for (int p = 0; p < file.parts() && p < 4; ++p) parts.push_back(describe_part(file.header(p)));
    std::string found;
    for (const std::string& part : parts) found += (found.empty() ? "" : "; ") + part;
    if (file.parts() > 4) found += "; ...";
    throw Error(path, "the EXR file has neither R, G, B nor Y, RY, BY nor Y channels (found: " + found + ")",
                "store it as RGB");
  }
  // Further layers beside the plain channels of the only part are what this program writes itself.
  if (pictures.size() > 1 && !pictures[0].name.empty()) {
    std::vector<std::string> names;
    for (const ExrPicture& picture : pictures) names.push_back(picture.name);
    warnings->push_back("holds " + std::to_string(names.size()) + " pictures (" + join_names(names) + "): \"" +
                        shortened(names[0]) + "\" is read");
  }
  return pictures[0];
}

}  // namespace maquette
