#include "render/btf/btf_source.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <numbers>
#include <optional>
#include <span>

#include "render/btf/builtin_geometry.h"
#include "render/btf/generate.h"
#include "scenes/btf/btf_file.h"
#include "scenes/btf/btf_values.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/parallel.h"
#include "scenes/suggest.h"

namespace maquette {

namespace {

namespace fs = std::filesystem;

/// Raised whenever a BTF of the same source comes out otherwise.
constexpr int kBtfVersion = 1, kMeanVersion = 1;
constexpr const char* kBuiltin = "builtin:";
constexpr const char* kBuiltinBtf = "builtin:btf-";
constexpr int kBuiltinTexels = 256, kCellsATexel = 2;
/// Rotations about the normal that a mean table averages: an odd number, as weaves repeat after a quarter turn.
constexpr int kRotations = 5;
/// Entries of phi_d from one that is computed to the next: 3 degrees, where lights are 15 apart.
constexpr int kPhiStep = 3;

struct BuiltinName {
  std::string name;
  int texels = kBuiltinTexels;
};

/// Of `btf-leather@32`.
BuiltinName parse_builtin(const std::string& text) {
  BuiltinName parsed{text.substr(0, text.find('@'))};
  if (parsed.name.size() < text.size()) {
    const char *begin = text.data() + parsed.name.size() + 1, *end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(begin, end, parsed.texels);
    if (error != std::errc() || stop != end || parsed.texels < 4 || parsed.texels > 1024)
      throw UsageError(kBuiltin + text, "its texels are not a number from 4 to 1024",
                       "for example builtin:btf-leather@64");
  }
  if (find_builtin_geometry(parsed.name)) return parsed;
  std::vector<std::string> names;
  for (const BuiltinGeometry& geometry : builtin_geometries()) names.push_back(geometry.name);
  throw UsageError(kBuiltin + text, "there is no such built-in BTF", did_you_mean(parsed.name, names));
}

double number_of(const std::string& source, const std::string& text, double least, double most) {
  double value = 0.0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size() || !(value >= least && value <= most))
    throw UsageError(source, "\"" + text + "\" is not a number from " + btf_number(least) + " to " + btf_number(most));
  return value;
}

/// False where `text` is no list of readings: then it belongs to the name of the file.
bool read_query(const std::string& source, const std::string& text, BtfReading* reading) {
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find('&', at), text.size());
    const std::string entry = text.substr(at, end - at);
    const std::size_t equals = entry.find('=');
    if (equals == std::string::npos) return false;
    const std::string name = entry.substr(0, equals), value = entry.substr(equals + 1);
    if (name == "cosine" && (value == "true" || value == "false"))
      reading->cosine = value == "true";
    else if (name == "gamma")
      reading->gamma = number_of(source, value, 0.0, 8.0);
    else if (name == "texel_mm")
      reading->texel_m = 1e-3 * number_of(source, value, 0.0, 1000.0);
    else if (name == "components")
      reading->components = static_cast<int>(number_of(source, value, 0.0, kMostBtfComponents));
    else
      return false;
    at = end + 1;
  }
  return true;
}

bool is_builtin(const std::string& place) { return place.starts_with(kBuiltin); }

Btf make_builtin(const std::string& place, const BtfReading& reading, const BtfTask& task) {
  const BuiltinName name = parse_builtin(place.substr(std::strlen(kBuiltin)));
  const BuiltinGeometry& builtin = *find_builtin_geometry(name.name);
  BtfGeneratorOptions options;
  options.texels = name.texels;
  options.components = reading.components;
  options.tile_m = reading.texel_m > 0.0 ? reading.texel_m * name.texels : builtin.tile_m;
  options.views = options.lights = ubo_directions();
  return generate_btf(name.name, builtin.make(kCellsATexel * name.texels), options, task);
}

Btf make_btf(const BtfSource& source, const BtfTask& task) {
  if (is_builtin(source.place)) return make_builtin(source.place, source.reading, task);
  std::error_code code;
  if (fs::is_directory(source.place, code)) return read_btf_folder(source.place, source.reading, task);
  return read_btf_container(source.place, source.reading, task);
}

std::uint64_t key_of(const BtfSource& source) {
  if (is_builtin(source.place)) parse_builtin(source.place.substr(std::strlen(kBuiltin)));
  std::error_code code;
  if (!is_builtin(source.place) && !fs::exists(source.place, code))
    throw Error(source.place, "does not exist", "check the path; `maquette inspect library` lists what is built in");
  const std::vector<double> numbers = {static_cast<double>(kBtfVersion), source.reading.cosine ? 1.0 : 0.0,
                                       source.reading.gamma, source.reading.texel_m,
                                       static_cast<double>(source.reading.components)};
  const std::uint64_t of_reading = content_hash(std::as_bytes(std::span(numbers)));
  if (is_builtin(source.place)) return content_hash(std::as_bytes(std::span(source.place)), of_reading);
  const std::array<std::uint64_t, 1> content = {btf_content_key(source.place)};
  return content_hash(std::as_bytes(std::span(content)), of_reading);
}

std::string cache_path(std::uint64_t key) {
  const std::optional<fs::path> folder = cache_folder();
  if (!folder) return {};
  char name[64];
  std::snprintf(name, sizeof name, "btf-%d-%016llx.exr", kBtfVersion, static_cast<unsigned long long>(key));
  return (*folder / name).string();
}

bool is_factorised(const BtfSource& source) { return lower_extension(source.place) == ".exr"; }

/// What is made is used, whether or not it can be kept.
void keep(const std::string& path, const Btf& btf, const BtfTask& task) {
  if (path.empty()) return;
  try {
    std::error_code ignored;
    fs::create_directories(fs::path(path).parent_path(), ignored);
    task.report("storing " + btf.name, 0.0);
    save_btf(path, btf);
    task.report("storing " + btf.name, 1.0);
  } catch (const Error& error) {
    task.report(std::string("the BTF is not kept in the cache: ") + error.what(), 1.0);
  }
}

Btf load_or_make(const BtfSource& source, std::uint64_t key, const BtfTask& task) {
  const std::string path = cache_path(key);
  std::error_code code;
  if (!path.empty() && fs::exists(path, code)) {
    try {
      Btf btf = load_factorised_btf(path);
      if (!is_builtin(source.place)) btf.provenance["source"] = source.place;  // the folder may have been moved
      return btf;
    } catch (const Error&) {
      // Damaged: as good as absent.
    }
  }
  Btf btf = make_btf(source, task);
  keep(path, btf, task);
  return btf;
}

/// Directions of a table's entry, turned about the normal. Source: Rusinkiewicz 1998.
struct EntryDirections {
  glm::vec3 wi{}, wo{};
};
EntryDirections directions_of(double theta_h, double theta_d, double phi_d, double phi_h) {
  const glm::dvec3 d(std::sin(theta_d) * std::cos(phi_d), std::sin(theta_d) * std::sin(phi_d), std::cos(theta_d));
  const auto turn = [&](const glm::dvec3& v) {
    const glm::dvec3 tilted(std::cos(theta_h) * v.x + std::sin(theta_h) * v.z, v.y,
                            std::cos(theta_h) * v.z - std::sin(theta_h) * v.x);
    glm::dvec3 w(std::cos(phi_h) * tilted.x - std::sin(phi_h) * tilted.y,
                 std::sin(phi_h) * tilted.x + std::cos(phi_h) * tilted.y, tilted.z);
    w.z = std::max(w.z, 1e-3);  // entries below the horizon are read by interpolation alone
    return glm::vec3(glm::normalize(w));
  };
  return {turn(d), turn({-d.x, -d.y, d.z})};
}

}  // namespace

bool is_btf_source(const std::string& source) {
  const std::string place = source.substr(0, source.rfind('?'));
  for (const std::string& name : {source, place}) {
    if (name.starts_with(kBuiltinBtf)) return true;
    if (name.starts_with(kBuiltin)) return false;
    std::error_code code;
    const std::string extension = lower_extension(name);
    if (extension == ".btf" || extension == ".exr" || fs::is_directory(name, code)) return true;
  }
  return false;
}

std::string with_btf_reading(const std::string& source, const Settings& settings) {
  if (!is_btf_source(source)) return source;
  std::string query;
  const auto add = [&](const std::string& name) {
    const auto changed = settings.changed().find("btf." + name);
    if (changed != settings.changed().end())
      query += (query.empty() ? "?" : "&") + name + "=" + to_text(changed->second);
  };
  const BtfSource parsed = parse_btf_source(source);
  if (is_factorised(parsed) || parsed.place != source) return source;  // it says so itself
  if (!is_builtin(source))
    for (const char* name : {"cosine", "gamma"}) add(name);
  for (const char* name : {"texel_mm", "components"}) add(name);
  return source + query;
}

BtfSource parse_btf_source(const std::string& source) {
  BtfSource parsed{source, {}};
  const std::size_t query = source.rfind('?');
  BtfReading reading;
  if (query == std::string::npos || !read_query(source, source.substr(query + 1), &reading)) return parsed;
  return {source.substr(0, query), reading};
}

std::shared_ptr<const Btf> load_btf(const std::string& source, const BtfTask& task) {
  const BtfSource parsed = parse_btf_source(source);
  if (is_factorised(parsed)) return std::make_shared<const Btf>(load_factorised_btf(parsed.place));
  return std::make_shared<const Btf>(load_or_make(parsed, key_of(parsed), task));
}

BrdfTable mean_table(const Btf& btf) {
  BrdfTable table;
  table.name = btf.name;
  table.rgb.resize(kBrdfEntryCount);
  constexpr double kHalfPi = 0.5 * std::numbers::pi;
  const BtfLookup all{{0.5f, 0.5f}, 1.0f};
  parallel_for(0, kThetaHCount, [&](int h) {
    const double root = (h + 0.5) / kThetaHCount, theta_h = root * root * kHalfPi;
    for (int d = 0; d < kThetaDCount; ++d) {
      std::array<glm::vec3, kPhiDCount / kPhiStep> coarse{};
      for (std::size_t p = 0; p < coarse.size(); ++p) {
        coarse[p] = glm::vec3(0.0f);
        const double phi_d = (static_cast<double>(p) + 0.5) * kPhiStep / kPhiDCount * std::numbers::pi;
        for (int r = 0; r < kRotations; ++r) {
          const EntryDirections w = directions_of(theta_h, (d + 0.5) / kThetaDCount * kHalfPi, phi_d,
                                                  2.0 * std::numbers::pi * r / kRotations);
          coarse[p] += (evaluate_btf(btf, all, w.wi, w.wo) + evaluate_btf(btf, all, w.wo, w.wi)) / (2.0f * kRotations);
        }
      }
      glm::vec3* row = &table.rgb[static_cast<std::size_t>((h * kThetaDCount + d) * kPhiDCount)];
      for (int p = 0; p < kPhiDCount; ++p) {  // phi_d wraps after half a turn
        const float at = (static_cast<float>(p) + 0.5f) / kPhiStep - 0.5f, before = std::floor(at);
        const auto first = static_cast<std::size_t>(before + static_cast<float>(coarse.size())) % coarse.size();
        row[p] = glm::mix(coarse[first], coarse[(first + 1) % coarse.size()], at - before);
      }
    }
  });
  table.hash = content_hash(std::as_bytes(std::span(table.rgb)));
  return table;
}

std::uint64_t material_source_stamp(const std::string& source) {
  if (source.empty() || source.starts_with("builtin:")) return 0;
  return file_stamp(is_btf_source(source) ? parse_btf_source(source).place : source);
}

std::uint64_t material_source_key(const std::string& source) {
  if (is_btf_source(source) && !is_factorised(parse_btf_source(source))) return key_of(parse_btf_source(source));
  return content_hash(read_file(source));
}

BrdfTable load_material_table(const std::string& source, const BtfTask& task) {
  if (!is_btf_source(source)) return load_brdf(source);
  const BtfSource parsed = parse_btf_source(source);
  const std::shared_ptr<const Btf> factorised = is_factorised(parsed) ? load_btf(source, task) : nullptr;
  const std::uint64_t key = factorised ? factorised->hash : key_of(parsed);
  const std::string& name = factorised ? factorised->name : parsed.place;
  if (const auto bytes = cache_load("btf-mean", kMeanVersion, key);
      bytes && bytes->size() == kBrdfEntryCount * sizeof(glm::vec3)) {
    BrdfTable table;
    table.name = name;
    table.rgb.resize(kBrdfEntryCount);
    std::memcpy(static_cast<void*>(table.rgb.data()), bytes->data(), bytes->size());
    table.hash = content_hash(std::as_bytes(std::span(table.rgb)));
    return table;
  }
  BrdfTable table = factorised ? mean_table(*factorised) : mean_table(load_or_make(parsed, key, task));
  table.name = name;
  cache_store("btf-mean", kMeanVersion, key, std::as_bytes(std::span(table.rgb)));
  return table;
}

}  // namespace maquette
