
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>

#include "scenes/btf/btf_reading.h"
#include "scenes/btf/btf_values.h"
#include "scenes/btf/half_floats.h"
#include "scenes/error.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr std::size_t kSignature = 10;
constexpr std::uint32_t kMostComponents = 4096;
constexpr std::uint32_t kMostVersion = 16;
constexpr double kLogOffset = 1e-5;  // of colour model 11
constexpr int kPlainColours = 0, kLogLuminance = 11;

/// Reads numbers in order, never beyond the end.
class ByteReader {
 public:
  explicit ByteReader(const std::string& path) : path_(path), stream_(path, std::ios::binary | std::ios::ate) {
    if (!stream_) throw Error(path, "cannot be read", "check the path and its permissions");
    size_ = static_cast<std::uint64_t>(stream_.tellg());
    stream_.seekg(0);
  }
  std::uint64_t position() { return static_cast<std::uint64_t>(stream_.tellg()); }
  std::uint64_t left() { return size_ - position(); }

  void read(void* to, std::uint64_t bytes, const char* what) {
    need(bytes, what);
    stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes));
    if (!stream_) throw Error(path_, std::string("cannot be read: ") + what, "copy it again");
  }
  template <typename T>
  T get(const char* what) {
    T value;
    read(&value, sizeof value, what);
    return value;
  }
  std::uint32_t count(const char* what, std::uint32_t least, std::uint32_t most) {
    const auto value = get<std::uint32_t>(what);
    if (value < least || value > most)
      throw Error(path_,
                  std::string("says that it has ") + std::to_string(value) + " " + what + ", expected " +
                      std::to_string(least) + " to " + std::to_string(most),
                  "copy it again");
    return value;
  }
  void skip(std::uint64_t bytes, const char* what) {
    need(bytes, what);
    stream_.seekg(static_cast<std::streamoff>(bytes), std::ios::cur);
  }
  void seek(std::uint64_t position) { stream_.seekg(static_cast<std::streamoff>(position)); }
  void need(std::uint64_t bytes, const char* what) {
    if (bytes <= left()) return;
    throw Error(path_,
                std::string("ends within its ") + what + ": " + std::to_string(bytes) + " bytes expected, " +
                    std::to_string(left()) + " there",
                "copy it again");
  }

 private:
  const std::string& path_;
  std::ifstream stream_;
  std::uint64_t size_ = 0;
};

struct Header {
  std::string signature;
  bool cosine = false;
  double texel_m = 0.0;
  std::vector<glm::dvec3> views;
  std::vector<std::vector<glm::dvec3>> lights;  ///< of each view
  std::uint32_t width = 0, height = 0, rotations = 0;
  std::size_t texels() const { return static_cast<std::size_t>(width) * height; }
};

class Container {
 public:
  Container(const std::string& path, const BtfReading& reading, const BtfTask& task)
      : path_(path), reading_(reading), task_(task), in_(path) {}

  Btf read() {
    read_signature();
    read_description();
    read_directions();
    header_.width = in_.count("texels a row", 1, kMostBtfSide);
    header_.height = in_.count("rows", 1, kMostBtfSide);
    for (const auto& lights : header_.lights)
      if (lights.size() * header_.texels() * 3 * sizeof(float) > kMostViewBytes)
        throw Error(path_, "the images of one view are more than 4 GiB", "use a smaller one");
    begin();
    if (header_.signature.starts_with("!DFMF")) {
      read_rotations();
      read_factors();
    } else {
      read_images();
    }
    complete_btf(&btf_);
    task_.report("reading " + btf_.name, 1.0);
    return std::move(btf_);
  }

 private:
  void read_signature() {
    std::array<char, kSignature> text{};
    in_.read(text.data(), text.size(), "signature");
    header_.signature.assign(text.begin(), text.end());
    const std::string& s = header_.signature;
    if (s == "!DFMF08FCR" || s == "!BDIF06R2!") return;
    for (const char* known : {"!FMF", "!PVF", "!DFMF", "!BDIF", "!LPCA", "!DTF"})
      if (s.starts_with(known))
        throw Error(path_, "is a container of kind " + s + ", which is not read",
                    "convert it to DFMF08FCR or BDIF06R2");
    throw Error(path_, "is no .btf container: it does not begin with a known signature",
                "use !DFMF08FCR or !BDIF06R2!");
  }

  void read_description() {
    const std::uint64_t begin = in_.position();
    const auto size = in_.get<std::uint32_t>("header");
    const std::uint32_t version = in_.count("as its version", 1, kMostVersion);
    in_.skip(std::uint64_t{3} * 80, "texts");
    const auto pixels_per_mm = in_.get<float>("scale");
    in_.skip(3 * sizeof(float), "colour scales");
    header_.cosine = reading_.cosine;
    if (version > 1) header_.cosine = in_.get<std::uint32_t>("cosine flag") != 0;
    if (version > 2) in_.skip(in_.get<std::uint32_t>("XML"), "XML");
    if (version > 3) {
      const std::uint32_t channels = in_.count("channels", 3, 3);
      for (std::uint32_t i = 0; i < channels; ++i) in_.skip(in_.get<std::uint32_t>("channel name"), "channel name");
    }
    if (in_.position() - begin != size)
      throw Error(
          path_, "its header has " + std::to_string(in_.position() - begin) + " bytes and says " + std::to_string(size),
          "copy it again");
    header_.texel_m =
        std::isfinite(pixels_per_mm) && pixels_per_mm > 0.0f ? 1e-3 / static_cast<double>(pixels_per_mm) : 0.0;
  }

  glm::dvec3 read_direction(const char* what) {
    const auto theta = in_.get<float>(what), phi = in_.get<float>(what);
    constexpr float kHalfPi = 1.5707964f, kMostPhi = 100.0f;
    if (!(theta >= 0.0f && theta <= kHalfPi) || !(std::abs(phi) < kMostPhi))
      throw Error(path_, std::string("a direction of its ") + what + " is not above the surface", "copy it again");
    const double sine = std::sin(static_cast<double>(theta));
    return {sine * std::cos(static_cast<double>(phi)), sine * std::sin(static_cast<double>(phi)),
            std::cos(static_cast<double>(theta))};
  }

  void check_distinct(const std::vector<glm::dvec3>& directions, char of) {
    for (std::size_t i = 0; i < directions.size(); ++i)
      for (std::size_t k = 0; k < i; ++k)
        if (glm::length(directions[i] - directions[k]) < 1e-5)
          throw Error(path_, "has the direction " + btf_angles_text(directions[i], of) + " twice", "remove one");
  }

  void read_directions() {
    const std::uint32_t views = in_.count("views", 1, kMostBtfViews);
    for (std::uint32_t v = 0; v < views; ++v) {
      header_.views.push_back(read_direction("views"));
      const std::uint32_t count = in_.count("lights of a view", 1, kMostBtfLights);
      std::vector<glm::dvec3> lights;
      for (std::uint32_t l = 0; l < count; ++l) {
        lights.push_back(read_direction("lights"));
        if (header_.cosine && lights.back().z < 0.017)
          throw Error(path_, "has a light along the surface, where values with the cosine say nothing",
                      "use one without the cosine");
      }
      if (v == 0 || lights != header_.lights.back()) check_distinct(lights, 'l');
      header_.lights.push_back(std::move(lights));
    }
    check_distinct(header_.views, 'v');
  }

  void begin() {
    btf_.name = std::filesystem::path(path_).stem().string();
    btf_.width = static_cast<int>(header_.width);
    btf_.height = static_cast<int>(header_.height);
    btf_.components = reading_.components;
    const double said = reading_.texel_m > 0.0 ? reading_.texel_m : header_.texel_m;
    btf_.texel_m = said > 0.0 ? said : kUnknownTexel_m;
    btf_.provenance = {{"source", path_},
                       {"container", header_.signature},
                       {"btf.cosine", header_.cosine ? "true" : "false"},
                       {"btf.gamma", btf_number(reading_.gamma)},
                       {"texel", reading_.texel_m > 0.0 ? "btf.texel_mm"
                                 : said > 0.0           ? "from the file"
                                                        : "assumed: the file does not say it"}};
  }

  void read_rotations() {
    header_.rotations = in_.get<std::uint32_t>("rotations");
    in_.skip(std::uint64_t{header_.rotations} * 9 * sizeof(float), "rotations");
    if (header_.rotations > 0) btf_.provenance["rotations"] = "of texels: not applied";
  }

  /// rho of the values of a view, [light][texel][rgb].
  void add_view(std::size_t v, std::vector<float>* values) {
    const std::size_t row = header_.texels() * 3;
    const std::vector<glm::dvec3>& lights = header_.lights[v];
    parallel_for(std::size_t{0}, lights.size(), [&](std::size_t l) {
      const float scale = rho_of_value(header_.cosine, lights[l]);
      for (float* x = values->data() + l * row; x != values->data() + (l + 1) * row; ++x)
        *x = (reading_.gamma > 0.0 && reading_.gamma != 1.0 ? linear_of_encoded(*x, reading_.gamma) : *x) * scale;
    });
    check_finite(path_, "view " + std::to_string(v), values->data(), values->size());
    btf_.views.push_back(factorise_btf_view(header_.views[v], sets_.find(lights), btf_.components, values));
    task_.report("reading " + btf_.name, static_cast<double>(v + 1) / static_cast<double>(header_.views.size()));
    task_.check(path_);
  }

  // ---- DFMF: a factorisation of all views, by colour channel ----

  using RowMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  struct Channel {
    RowMatrix directions;  ///< U: [light and view][component]
    RowMatrix texels;      ///< S V: [texel][component]
  };

  RowMatrix read_matrix(std::uint64_t rows, std::uint64_t columns, unsigned scalar, const char* what) {
    in_.need(rows * columns * scalar, what);
    RowMatrix matrix(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns));
    std::vector<std::byte> row(columns * scalar);
    for (std::uint64_t r = 0; r < rows; ++r) {
      in_.read(row.data(), row.size(), what);
      for (std::uint64_t c = 0; c < columns; ++c)
        matrix(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = scalar_at(row.data() + c * scalar, scalar);
    }
    check_finite(path_, std::string("its ") + what, matrix.data(), static_cast<std::size_t>(matrix.size()));
    return matrix;
  }

  static float scalar_at(const std::byte* bytes, unsigned scalar) {
    const auto as = [&]<typename T>(T value) {
      std::memcpy(&value, bytes, sizeof value);
      return value;
    };
    if (scalar == 4) return as(float{});
    if (scalar == 8) return static_cast<float>(as(double{}));
    const auto half = as(std::uint16_t{});
    return (half & 0x7c00) == 0x7c00 ? NAN : float_of_half(half);
  }

  Channel read_channel() {
    const auto scalar = in_.get<std::uint8_t>("scalar size");
    if (scalar != 2 && scalar != 4 && scalar != 8)
      throw Error(path_, "has scalars of " + std::to_string(scalar) + " bytes, expected 2, 4 or 8", "copy it again");
    const std::uint32_t components = in_.count("components", 1, kMostComponents);
    const auto rows = in_.get<std::uint32_t>("rows"), columns = in_.get<std::uint32_t>("columns");
    std::size_t pairs = 0;
    for (const auto& lights : header_.lights) pairs += lights.size();
    if (rows != pairs || columns != header_.texels())
      throw Error(path_,
                  "has factors of " + std::to_string(rows) + " directions and " + std::to_string(columns) +
                      " texels, its header says " + std::to_string(pairs) + " and " + std::to_string(header_.texels()),
                  "copy it again");
    in_.skip(std::uint64_t{components} * scalar, "singular values");  // they are in S V
    Channel channel;
    channel.directions = read_matrix(rows, components, scalar, "factors of directions");
    channel.texels = read_matrix(columns, components, scalar, "factors of texels");
    return channel;
  }

  /// Source: formats.md of the UBO 2014 sets: Y = exp(v0) - 1e-5, U and V = v (Y + 1e-5), then BT.601 to RGB.
  static glm::vec3 decode(int model, const glm::vec3& v) {
    if (model == kPlainColours) return v;
    const double scale = std::exp(static_cast<double>(v.x)), y = scale - kLogOffset;
    const double u = scale * static_cast<double>(v.y), w = scale * static_cast<double>(v.z);
    return {y + 1.13983 * w, y - 0.39465 * u - 0.58060 * w, y + 2.03211 * u};
  }

  void read_factors() {
    in_.count("components", 1, kMostComponents);
    const auto model = in_.get<std::int32_t>("colour model");
    if (model != kPlainColours && model != kLogLuminance)
      throw Error(path_,
                  "has colour model " + std::to_string(model) + ", expected 0 (RGB) or 11 (logarithm of Y, U, V)",
                  "convert it");
    in_.skip((3 + 9) * sizeof(float), "colour matrix");
    std::array<Channel, 3> channels;
    for (Channel& channel : channels) channel = read_channel();
    Eigen::Index first = 0;
    for (std::size_t v = 0; v < header_.views.size(); ++v) {
      const auto lights = static_cast<Eigen::Index>(header_.lights[v].size());
      std::vector<float> values(static_cast<std::size_t>(lights) * header_.texels() * 3);
      const auto texels = static_cast<Eigen::Index>(header_.texels());
      constexpr Eigen::Index kBlock = 1024;
      parallel_for(Eigen::Index{0}, (texels + kBlock - 1) / kBlock, [&](Eigen::Index b) {
        const Eigen::Index begin = b * kBlock, count = std::min(kBlock, texels - begin);
        std::array<RowMatrix, 3> part;
        for (std::size_t c = 0; c < 3; ++c)
          part[c] = channels[c].directions.middleRows(first, lights) *
                    channels[c].texels.middleRows(begin, count).transpose();
        for (Eigen::Index l = 0; l < lights; ++l)
          for (Eigen::Index t = 0; t < count; ++t) {
            const glm::vec3 rgb = decode(model, {part[0](l, t), part[1](l, t), part[2](l, t)});
            for (int c = 0; c < 3; ++c) values[static_cast<std::size_t>((l * texels + begin + t) * 3 + c)] = rgb[c];
          }
      });
      add_view(v, &values);
      first += lights;
    }
  }

  // ---- BDIF: half floats, [texel][view][light][rgb], in chunks of rows, without the texels that a mask leaves out
  // ----

  void read_images() {
    const std::uint32_t chunk_rows = in_.count("rows a chunk", 1, kMostBtfSide);
    const auto compression = in_.get<std::uint8_t>("compression");
    if (compression != 2)
      throw Error(path_, "is a BDIF of compression " + std::to_string(compression) + ", only 2 (plain) is read",
                  "convert it");
    std::vector<std::uint8_t> mask(header_.texels());
    in_.read(mask.data(), mask.size(), "mask");
    read_rotations();
    std::size_t pairs = 0;
    for (const auto& lights : header_.lights) pairs += lights.size();
    const std::uint64_t texel_bytes = pairs * 3 * sizeof(std::uint16_t);
    const std::vector<std::uint64_t> places = find_texels(mask, texel_bytes, chunk_rows);
    std::uint64_t offset = 0;
    for (std::size_t first = 0; first < header_.views.size();) {
      std::size_t end = first, bytes = 0, lights = 0;  // as many views as fit in memory at once
      while (end < header_.views.size()) {
        const std::size_t more = header_.lights[end].size() * header_.texels() * 3 * sizeof(float);
        if (end > first && bytes + more > kViewsAtOnce) break;
        bytes += more;
        lights += header_.lights[end++].size();
      }
      read_views(first, end, lights, offset, places);
      offset += lights * 3 * sizeof(std::uint16_t);
      first = end;
    }
  }

  /// Where each texel begins; 0: left out.
  std::vector<std::uint64_t> find_texels(const std::vector<std::uint8_t>& mask, std::uint64_t texel_bytes,
                                         std::uint32_t chunk_rows) {
    std::vector<std::uint64_t> places(mask.size(), 0);
    std::vector<std::size_t> stored;
    for (std::size_t t = 0; t < mask.size(); ++t)
      if (mask[t]) stored.push_back(t);
    const std::size_t per_chunk = static_cast<std::size_t>(chunk_rows) * header_.width;
    for (std::size_t begin = 0; begin < stored.size(); begin += per_chunk) {
      const std::size_t count = std::min(per_chunk, stored.size() - begin);
      const auto said = in_.get<std::uint32_t>("chunk");
      if (said != static_cast<std::uint32_t>(count * texel_bytes))
        throw Error(path_,
                    "a chunk says that it has " + std::to_string(said) + " bytes, expected " +
                        std::to_string(count * texel_bytes),
                    "copy it again");
      for (std::size_t i = 0; i < count; ++i) places[stored[begin + i]] = in_.position() + i * texel_bytes;
      in_.skip(count * texel_bytes, "chunk");
    }
    return places;
  }

  void read_views(std::size_t first, std::size_t end, std::size_t lights, std::uint64_t offset,
                  const std::vector<std::uint64_t>& places) {
    std::vector<std::vector<float>> values;
    for (std::size_t v = first; v < end; ++v)
      values.emplace_back(header_.lights[v].size() * header_.texels() * 3, 0.0f);
    std::vector<std::uint16_t> row(lights * 3);
    for (std::size_t t = 0; t < places.size(); ++t) {
      if (places[t] == 0) continue;
      in_.seek(places[t] + offset);
      in_.read(row.data(), row.size() * sizeof(std::uint16_t), "texel");
      const std::uint16_t* next = row.data();
      for (std::size_t v = first; v < end; ++v)
        for (std::size_t l = 0; l < header_.lights[v].size(); ++l)
          for (std::size_t c = 0; c < 3; ++c, ++next)
            values[v - first][(l * places.size() + t) * 3 + c] =
                (*next & 0x7c00) == 0x7c00 ? NAN : float_of_half(*next);
      if (t % 4096 == 0) task_.check(path_);
    }
    for (std::size_t v = first; v < end; ++v) {
      add_view(v, &values[v - first]);
      std::vector<float>().swap(values[v - first]);
    }
  }

  static constexpr std::size_t kViewsAtOnce = std::size_t{768} << 20;

  const std::string& path_;
  const BtfReading& reading_;
  const BtfTask& task_;
  ByteReader in_;
  Header header_;
  BtfLightSets sets_;
  Btf btf_;
};

}  // namespace

Btf read_btf_container(const std::string& path, const BtfReading& reading, const BtfTask& task) {
  try {
    return Container(path, reading, task).read();
  } catch (const std::bad_alloc&) {
    throw Error(path, "not enough memory for this BTF", "use a smaller one");
  }
}

}  // namespace maquette
