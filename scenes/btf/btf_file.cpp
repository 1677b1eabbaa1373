#include "scenes/btf/btf_file.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "scenes/error.h"
#include "scenes/exr_stream.h"
#include "scenes/files.h"
#include "scenes/image_exr_threads.h"

namespace maquette {

namespace {

constexpr const char* kVersion = "1";
constexpr const char* kVersionName = "maquette.btf";
constexpr const char* kPrefix = "maquette.btf.";
constexpr std::size_t kMostFactors = std::size_t{1} << 33;  // of all views, in half floats

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string hex(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

std::string padded(std::size_t number, std::size_t digits) {
  const std::string text = std::to_string(number);
  return std::string(digits - std::min(digits, text.size()), '0') + text;
}

std::string view_name(std::size_t v) { return "view " + padded(v, 4); }

/// `mean.R`, `c01.G`, ...
std::string factor_channel(std::size_t k, std::size_t rgb) {
  return (k == 0 ? "mean" : "c" + padded(k, 2)) + "." + "RGB"[rgb];
}

std::string column_name(const std::string& prefix, std::size_t i) { return prefix + padded(i, 2); }

Imf::FrameBuffer factor_slices(int width, int height, std::size_t components, std::uint16_t* factors) {
  Imf::FrameBuffer buffer;
  const std::size_t texel = 3 * (1 + components) * sizeof(std::uint16_t);
  for (std::size_t k = 0; k <= components; ++k)
    for (std::size_t rgb = 0; rgb < 3; ++rgb)
      buffer.insert(factor_channel(k, rgb), Imf::Slice::Make(Imf::HALF, factors + 3 * k + rgb, {0, 0}, width, height,
                                                             texel, texel * static_cast<std::size_t>(width)));
  return buffer;
}

/// A table of floats as a part: rows of pixels, columns as channels.
struct FloatTable {
  int width = 0, height = 0;
  std::map<std::string, std::vector<float>> columns;

  std::vector<float>& add(const std::string& name) {
    return columns[name] = std::vector<float>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0.0f);
  }
  Imf::FrameBuffer slices() {
    Imf::FrameBuffer buffer;
    for (auto& [name, values] : columns)
      buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, values.data(), {0, 0}, width, height));
    return buffer;
  }
};

Imf::Header make_header(const std::string& name, int width, int height) {
  Imf::Header header(width, height);
  header.setName(name);
  header.setType(Imf::SCANLINEIMAGE);
  header.compression() = Imf::ZIP_COMPRESSION;
  return header;
}

FloatTable empty_views(std::size_t count) {
  FloatTable table{static_cast<int>(count), 1, {}};
  for (const char* name : {"x", "y", "z", "lights", "energy", "mean_energy", "contrast", "shadowed"}) table.add(name);
  for (std::size_t i = 0; i < kBtfSpectrum; ++i) table.add(column_name("spectrum", i));
  return table;
}

FloatTable empty_lights(std::size_t views, std::size_t most_lights, std::size_t components) {
  FloatTable table{static_cast<int>(most_lights), static_cast<int>(views), {}};
  for (const char* name : {"x", "y", "z"}) table.add(name);
  for (std::size_t c = 0; c < components; ++c) table.add(column_name("weight", c + 1));
  return table;
}

void fill_tables(const Btf& btf, FloatTable* views, FloatTable* lights) {
  for (std::size_t v = 0; v < btf.views.size(); ++v) {
    const BtfView& view = btf.views[v];
    const BtfViewFigures& f = view.figures;
    const auto set = [&](const char* name, double value) { views->columns[name][v] = static_cast<float>(value); };
    for (int k = 0; k < 3; ++k) set(k == 0 ? "x" : k == 1 ? "y" : "z", view.direction[k]);
    set("lights", static_cast<double>(view.lights->size()));
    set("energy", f.energy);
    set("mean_energy", f.mean_energy);
    set("contrast", f.contrast);
    set("shadowed", f.shadowed);
    for (std::size_t i = 0; i < f.spectrum.size(); ++i) views->columns[column_name("spectrum", i)][v] = f.spectrum[i];
    const std::size_t row = v * static_cast<std::size_t>(lights->width);
    const auto components = static_cast<std::size_t>(btf.components);
    for (std::size_t l = 0; l < view.lights->size(); ++l) {
      const glm::vec3 direction(view.lights->directions()[l]);
      lights->columns["x"][row + l] = direction.x;
      lights->columns["y"][row + l] = direction.y;
      lights->columns["z"][row + l] = direction.z;
      for (std::size_t c = 0; c < components; ++c)
        lights->columns[column_name("weight", c + 1)][row + l] = view.light_weights[l * components + c];
    }
  }
}

void write_parts(const std::string& path, const Btf& btf) {
  const auto components = static_cast<std::size_t>(btf.components);
  std::size_t most_lights = 1;
  for (const BtfView& view : btf.views) most_lights = std::max(most_lights, view.lights->size());
  FloatTable views = empty_views(btf.views.size());
  FloatTable lights = empty_lights(btf.views.size(), most_lights, components);
  fill_tables(btf, &views, &lights);

  std::vector<Imf::Header> headers;
  for (std::size_t v = 0; v < btf.views.size(); ++v) {
    headers.push_back(make_header(view_name(v), btf.width, btf.height));
    for (std::size_t k = 0; k <= components; ++k)
      for (std::size_t rgb = 0; rgb < 3; ++rgb)
        headers.back().channels().insert(factor_channel(k, rgb), Imf::Channel(Imf::HALF));
  }
  for (const auto& [name, table] : {std::pair{"views", &views}, std::pair{"lights", &lights}}) {
    headers.push_back(make_header(name, table->width, table->height));
    headers.back().displayWindow() = headers[0].displayWindow();  // one for all parts, says OpenEXR
    for (const auto& [column, values] : table->columns)
      headers.back().channels().insert(column, Imf::Channel(Imf::FLOAT));
  }
  const auto attribute = [&](const std::string& name, const std::string& value) {
    headers[0].insert(name, Imf::StringAttribute(value));
  };
  attribute(kVersionName, kVersion);
  attribute("maquette.btf_name", btf.name);
  attribute("maquette.btf_views", std::to_string(btf.views.size()));
  attribute("maquette.btf_components", std::to_string(btf.components));
  attribute("maquette.btf_texel_m", number_text(btf.texel_m));
  attribute("maquette.btf_hash", hex(btf.hash));
  for (const auto& [name, value] : btf.provenance) attribute(kPrefix + name, value);

  ExrStream stream(path);
  auto output = std::make_unique<Imf::MultiPartOutputFile>(stream, headers.data(), static_cast<int>(headers.size()));
  for (std::size_t v = 0; v < btf.views.size(); ++v) {
    Imf::OutputPart part(*output, static_cast<int>(v));
    // OpenEXR takes what it writes as not constant.
    part.setFrameBuffer(
        factor_slices(btf.width, btf.height, components, const_cast<std::uint16_t*>(btf.views[v].factors.data())));
    part.writePixels(btf.height);
  }
  int next = static_cast<int>(btf.views.size());
  for (FloatTable* table : {&views, &lights}) {
    Imf::OutputPart part(*output, next++);
    part.setFrameBuffer(table->slices());
    part.writePixels(table->height);
  }
  output.reset();
  stream.close();
}

std::optional<std::string> text_attribute(const Imf::Header& header, const std::string& name) {
  const auto* text = header.findTypedAttribute<Imf::StringAttribute>(name);
  return text ? std::optional(text->value()) : std::nullopt;
}

Error damaged(const std::string& path, const std::string& what) {
  return Error(path, "the BTF is damaged: " + what, "make it again");
}

std::size_t count_attribute(const std::string& path, const Imf::Header& header, const char* name, std::size_t least,
                            std::size_t most) {
  const std::string text = text_attribute(header, name).value_or("");
  char* end = nullptr;
  const unsigned long long value = std::strtoull(text.c_str(), &end, 10);
  if (text.empty() || *end != '\0' || value < least || value > most)
    throw damaged(path, std::string(name) + " is \"" + text + "\"");
  return static_cast<std::size_t>(value);
}

class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path), input_(checked_exr(path)) {}

  Btf read() {
    const Imf::Header& first = input_.header(0);
    if (text_attribute(first, kVersionName) != kVersion)
      throw Error(path_, "is no factorised BTF of this version",
                  "name a folder of images, a .btf file or builtin:btf-leather");
    Btf btf;
    const std::size_t views = count_attribute(path_, first, "maquette.btf_views", 1, kMostBtfViews);
    btf.components = static_cast<int>(
        count_attribute(path_, first, "maquette.btf_components", 0, static_cast<std::size_t>(kMostBtfComponents)));
    const Imath::Box2i window = first.dataWindow();
    btf.width = window.max.x + 1;
    btf.height = window.max.y + 1;
    check(btf, window, views);
    btf.name = text_attribute(first, "maquette.btf_name").value_or("");
    btf.texel_m = std::strtod(text_attribute(first, "maquette.btf_texel_m").value_or("0").c_str(), nullptr);
    if (!(btf.texel_m > 0.0) || !std::isfinite(btf.texel_m)) throw damaged(path_, "its texels have no size");
    const std::string prefix = kPrefix;
    for (auto it = first.begin(); it != first.end(); ++it)
      if (const std::string name = it.name(); name.starts_with(prefix))
        btf.provenance[name.substr(prefix.size())] = text_attribute(first, name).value_or("");
    btf.views.resize(views);
    read_tables(&btf);
    for (std::size_t v = 0; v < views; ++v) read_factors(btf, v, &btf.views[v].factors);
    complete_btf(&btf);
    if (hex(btf.hash) != text_attribute(first, "maquette.btf_hash")) throw damaged(path_, "its checksum does not fit");
    return btf;
  }

 private:
  void check(const Btf& btf, const Imath::Box2i& window, std::size_t views) {
    if (window.min.x != 0 || window.min.y != 0 || btf.width < 1 || btf.height < 1 || btf.width > kMostBtfSide ||
        btf.height > kMostBtfSide)
      throw damaged(path_, "it has " + std::to_string(btf.width) + " x " + std::to_string(btf.height) + " texels");
    const std::size_t factors = static_cast<std::size_t>(btf.width) * static_cast<std::size_t>(btf.height) * 3 *
                                (1 + static_cast<std::size_t>(btf.components)) * views;
    if (factors > kMostFactors) throw damaged(path_, "it has more than 2^33 factors");
    if (!can_hold(path_, factors * sizeof(std::uint16_t))) throw damaged(path_, "it is too small for its factors");
    if (input_.parts() != static_cast<int>(views) + 2)
      throw damaged(path_, std::to_string(views) + " views do not have " + std::to_string(input_.parts()) + " parts");
    for (int i = 0; i < input_.parts(); ++i)
      if (!input_.partComplete(i)) throw Error(path_, "the BTF is truncated", "make it again");
  }

  void read_table(int part, const char* name, FloatTable* table) {
    const Imf::Header& header = input_.header(part);
    const Imath::Box2i window = header.dataWindow();
    if (header.name() != name || window.min != Imath::V2i(0, 0) || window.max.x + 1 != table->width ||
        window.max.y + 1 != table->height)
      throw damaged(path_, std::string("its part `") + name + "` has another size");
    for (const auto& [column, values] : table->columns)
      if (!header.channels().findChannel(column)) throw damaged(path_, "it has no column " + column);
    Imf::InputPart input(input_, part);
    input.setFrameBuffer(table->slices());
    input.readPixels(0, table->height - 1);
    for (const auto& [column, values] : table->columns)
      for (const float value : values)
        if (!std::isfinite(value)) throw damaged(path_, "a value of its column " + column + " is not finite");
  }

  void read_tables(Btf* btf) {
    const std::size_t count = btf->views.size();
    const auto components = static_cast<std::size_t>(btf->components);
    FloatTable views = empty_views(count);
    read_table(static_cast<int>(count), "views", &views);
    const Imath::Box2i window = input_.header(static_cast<int>(count) + 1).dataWindow();
    const auto most = static_cast<std::size_t>(std::clamp(window.max.x + 1, 1, static_cast<int>(kMostBtfLights)));
    if (!can_hold(path_, count * most * (3 + components) * sizeof(float)))
      throw damaged(path_, "it is too small for its lights");
    FloatTable lights = empty_lights(count, most, components);
    read_table(static_cast<int>(count) + 1, "lights", &lights);
    std::map<std::vector<float>, std::shared_ptr<const DirectionMesh>> meshes;  // views often share theirs
    for (std::size_t v = 0; v < count; ++v) {
      BtfView& view = btf->views[v];
      view.direction = direction(views, v);
      BtfViewFigures& f = view.figures;
      f.energy = views.columns["energy"][v];
      f.mean_energy = views.columns["mean_energy"][v];
      f.contrast = views.columns["contrast"][v];
      f.shadowed = views.columns["shadowed"][v];
      for (std::size_t i = 0; i < kBtfSpectrum; ++i) f.spectrum.push_back(views.columns[column_name("spectrum", i)][v]);
      const float stored = views.columns["lights"][v];
      if (stored < 1.0f || stored > static_cast<float>(most)) throw damaged(path_, "a view has no lights");
      const auto light_count = static_cast<std::size_t>(stored);
      std::vector<glm::dvec3> directions;
      std::vector<float> key;
      for (std::size_t l = 0; l < light_count; ++l) {
        directions.push_back(direction(lights, v * most + l));
        for (int k = 0; k < 3; ++k) key.push_back(static_cast<float>(directions.back()[k]));
        for (std::size_t c = 0; c < components; ++c)
          view.light_weights.push_back(lights.columns[column_name("weight", c + 1)][v * most + l]);
      }
      std::shared_ptr<const DirectionMesh>& mesh = meshes[key];
      if (!mesh) mesh = std::make_shared<const DirectionMesh>(std::move(directions));
      view.lights = mesh;
    }
  }

  glm::dvec3 direction(FloatTable& table, std::size_t i) const {
    const glm::dvec3 d(table.columns["x"][i], table.columns["y"][i], table.columns["z"][i]);
    if (std::abs(glm::length(d) - 1.0) > 1e-4 || d.z < 0.0) throw damaged(path_, "a direction is not one");
    return d;
  }

  void read_factors(const Btf& btf, std::size_t v, std::vector<std::uint16_t>* factors) {
    const auto components = static_cast<std::size_t>(btf.components);
    const Imf::Header& header = input_.header(static_cast<int>(v));
    if (header.dataWindow() != input_.header(0).dataWindow()) throw damaged(path_, "its views differ in size");
    for (std::size_t k = 0; k <= components; ++k)
      for (std::size_t rgb = 0; rgb < 3; ++rgb) {
        const Imf::Channel* channel = header.channels().findChannel(factor_channel(k, rgb));
        if (!channel || channel->type != Imf::HALF) throw damaged(path_, "a view has no " + factor_channel(k, rgb));
      }
    factors->resize(static_cast<std::size_t>(btf.width) * static_cast<std::size_t>(btf.height) * 3 * (1 + components));
    Imf::InputPart part(input_, static_cast<int>(v));
    part.setFrameBuffer(factor_slices(btf.width, btf.height, components, factors->data()));
    part.readPixels(0, btf.height - 1);
    for (const std::uint16_t half : *factors)
      if ((half & 0x7c00) == 0x7c00) throw damaged(path_, "a factor of " + view_name(v) + " is not finite");
  }

  const std::string& path_;
  Imf::MultiPartInputFile input_;
};

}  // namespace

void save_btf(const std::string& path, const Btf& btf) {
  use_all_cores_for_exr();
  write_atomically(path, [&](const std::string& temporary) {
    try {
      write_parts(temporary, btf);
    } catch (const std::exception& e) {
      throw Error(path, "cannot be written: " + one_line(e.what()), "check the folder and the space left");
    }
  });
}

Btf load_factorised_btf(const std::string& path) {
  std::error_code code;
  if (!std::filesystem::exists(path, code)) throw Error(path, "does not exist", "check the path");
  use_all_cores_for_exr();
  try {
    return Reader(path).read();
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw Error(path, "not enough memory for this BTF", "use one of fewer texels or components");
  } catch (const std::exception& e) {
    throw Error(path, "is no readable BTF: " + one_line(e.what()), "make it again");
  }
}

bool is_factorised_btf(const std::string& path) {
  try {
    Imf::MultiPartInputFile input(checked_exr(path));
    return text_attribute(input.header(0), kVersionName).has_value();
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace maquette
