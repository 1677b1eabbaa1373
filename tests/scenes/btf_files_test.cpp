#include <gtest/gtest.h>
#include <stb/stb_image_write.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "scenes/btf/btf_file.h"
#include "scenes/btf/btf_reading.h"
#include "scenes/btf/half_floats.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/image_io.h"
#include "temporary_folder.h"

namespace {

using namespace maquette;
using maquette::test::TemporaryFolder;
namespace fs = std::filesystem;

constexpr int kFileWidth = 4, kFileHeight = 3;

/// rho of a made BTF: rank 2 over lights, differs by view and texel.
float made_rho(const glm::dvec3& light, const glm::dvec3& view, int texel, int channel) {
  return static_cast<float>(0.05 + 0.02 * std::sin(texel + channel) * light.x + 0.03 * light.z * (1 + channel) +
                            0.01 * view.y);
}

struct Rings {
  std::vector<glm::dvec2> angles_deg = {{0, 0}, {30, 0}, {30, 120}, {30, 240}, {60, 45}, {60, 165}, {60, 285}};
  glm::dvec3 direction(std::size_t i) const { return direction_of_angles(angles_deg[i].x, angles_deg[i].y); }
};

std::string image_name(const glm::dvec2& light, const glm::dvec2& view, const std::string& extension) {
  char text[96];
  std::snprintf(text, sizeof text, "00017 tl%03.4g pl%03.4g tv%03.4g pv%03.4g", light.x, light.y, view.x, view.y);
  return text + extension;
}

class BtfFolder : public TemporaryFolder {
 protected:
  std::string at(const std::string& name) const { return TemporaryFolder::path(name); }
  std::string folder() const { return TemporaryFolder::path("."); }
  /// `scaled`: what is stored for rho under a light.
  template <typename Stored>
  void write_images(const std::string& extension, const Stored& stored) {
    const Rings rings;
    for (std::size_t v = 0; v < rings.angles_deg.size(); ++v)
      for (std::size_t l = 0; l < rings.angles_deg.size(); ++l) {
        Image image(kFileWidth, kFileHeight, 3);
        for (int t = 0; t < kFileWidth * kFileHeight; ++t)
          for (int c = 0; c < 3; ++c)
            image.data[static_cast<std::size_t>(3 * t + c)] =
                stored(made_rho(rings.direction(l), rings.direction(v), t, c), rings.direction(l));
        const std::string path = at(image_name(rings.angles_deg[l], rings.angles_deg[v], extension));
        if (extension == ".exr") save_exr(path, image);
        if (extension == ".png") save_png(path, image);
        if (extension == ".jpg") write_jpeg(path, image);
      }
  }

  static void write_jpeg(const std::string& path, const Image& image) {
    std::vector<std::uint8_t> bytes;
    for (const float v : image.data) bytes.push_back(static_cast<std::uint8_t>(v * 255.0f + 0.5f));
    stbi_write_jpg(path.c_str(), image.width, image.height, 3, bytes.data(), 100);
  }
  void write_linear() {
    write_images(".exr", [](float rho, const glm::dvec3& light) {
      return static_cast<float>(std::numbers::pi * light.z) * rho;
    });
  }
  std::string fault(const BtfReading& reading = {}) const {
    try {
      read_btf_folder(folder(), reading);
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }
};

void expect_made(const Btf& btf, double tolerance) {
  const Rings rings;
  ASSERT_EQ(btf.width, kFileWidth);
  ASSERT_EQ(btf.height, kFileHeight);
  ASSERT_EQ(btf.views.size(), rings.angles_deg.size());
  for (std::size_t v = 0; v < rings.angles_deg.size(); ++v)
    for (std::size_t l = 0; l < rings.angles_deg.size(); ++l)
      for (int t = 0; t < kFileWidth * kFileHeight; ++t) {
        const glm::vec2 uv((static_cast<float>(t % kFileWidth) + 0.5f) / kFileWidth,
                           (static_cast<float>(t / kFileWidth) + 0.5f) / kFileHeight);
        const glm::vec3 rho =
            evaluate_btf(btf, {uv, 0.0f}, glm::vec3(rings.direction(l)), glm::vec3(rings.direction(v)));
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(rho[c], made_rho(rings.direction(l), rings.direction(v), t, c), tolerance) << v << " " << l;
      }
}

TEST(BtfAngles, StandInNamesInAnyOrder) {
  BtfAngles a;
  for (const char* name : {"00000 tl010 pl020 tv030 pv040.jpg", "LEATHER256_00084_tl010_pl020_tv030_pv040.jpg",
                           "tv030_pv040-tl010pl020.png", "x_TV30.0_PV40_TL10.00_PL20.exr"}) {
    ASSERT_TRUE(parse_btf_angles(name, &a)) << name;
    EXPECT_EQ(std::vector<double>({a.theta_l, a.phi_l, a.theta_v, a.phi_v}), std::vector<double>({10, 20, 30, 40}));
  }
  ASSERT_TRUE(parse_btf_angles("bottle_tl23.5_pl337.5_tv0_pv0.png", &a));
  EXPECT_EQ(a.theta_l, 23.5);
  EXPECT_EQ(a.phi_l, 337.5);
  for (const char* name : {"", "tl010_pl020_tv030.jpg", "tl_pl_tv_pv.png", "total.png"})
    EXPECT_FALSE(parse_btf_angles(name, &a)) << name;
}

TEST_F(BtfFolder, OfLinearImagesComesBack) {
  write_linear();
  const Btf btf = read_btf_folder(folder(), {});
  expect_made(btf, 1e-4);
  EXPECT_NEAR(btf_energy_kept(btf, 2), 1.0, 1e-5);
  EXPECT_EQ(btf.texel_m, kUnknownTexel_m);
  EXPECT_EQ(btf.provenance.at("btf.cosine"), "true");
  EXPECT_EQ(read_btf_folder(folder(), {.texel_m = 1e-4}).texel_m, 1e-4);
}

TEST_F(BtfFolder, OfSrgbPngAndOfGammaJpegComesBack) {
  write_images(".png", [](float rho, const glm::dvec3&) {  // without the cosine
    const double v = std::numbers::pi * static_cast<double>(rho);
    return static_cast<float>(v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055);
  });
  expect_made(read_btf_folder(folder(), {.cosine = false}), 2e-3);
  for (const fs::path& path : fs::directory_iterator(folder())) fs::remove(path);
  write_images(".jpg", [](float, const glm::dvec3&) { return 0.5f; });
  const Btf btf = read_btf_folder(folder(), {.gamma = 2.2});
  const glm::vec3 rho = evaluate_btf(btf, {}, glm::vec3(direction_of_angles(60, 45)), {0.0f, 0.0f, 1.0f});
  EXPECT_NEAR(rho.x, std::pow(128.0 / 255.0, 2.2) / std::numbers::pi / 0.5, 2e-3);
}

TEST_F(BtfFolder, MayMoveSingleLights) {
  write_linear();
  const Rings rings;
  fs::rename(at(image_name({0, 0}, {0, 0}, ".exr")), at(image_name({10, 0}, {0, 0}, ".exr")));
  const Btf btf = read_btf_folder(folder(), {});
  EXPECT_NE(btf.views[0].lights, btf.views[1].lights);
  EXPECT_EQ(btf.views[2].lights, btf.views[1].lights);
}

TEST_F(BtfFolder, NamesWhatIsMissing) {
  EXPECT_NE(fault().find("is a folder without images"), std::string::npos);
  write_linear();
  fs::remove(at(image_name({30, 120}, {60, 45}, ".exr")));
  EXPECT_NE(fault().find("1 of 49 images are missing: tl30 pl120 tv60 pv45;"), std::string::npos) << fault();
  for (const double phi : {45.0, 165.0, 285.0}) fs::remove(at(image_name({60, phi}, {30, 0}, ".exr")));
  for (const double phi : {0.0, 120.0, 240.0}) fs::remove(at(image_name({30, phi}, {0, 0}, ".exr")));
  EXPECT_NE(fault().find("7 of 49 images are missing: tl30 pl0 tv0 pv0, "), std::string::npos) << fault();
  EXPECT_NE(fault().find(", ...;"), std::string::npos) << fault();
}

TEST_F(BtfFolder, RefusesWhatDoesNotFit) {
  write_linear();
  const std::string victim = at(image_name({30, 0}, {60, 45}, ".exr"));
  const Image good = load_hdr_image(victim);
  save_exr(victim, Image(kFileWidth + 1, kFileHeight, 3));
  EXPECT_NE(fault().find("has 5 x 3 texels"), std::string::npos) << fault();
  Image bad = good;
  bad.data[7] = NAN;
  save_exr(victim, bad);
  EXPECT_NE(fault().find("not finite (entry 7)"), std::string::npos) << fault();
  std::ofstream(victim, std::ios::binary) << "nothing";
  EXPECT_NE(fault().find("tl030 pl000 tv060 pv045.exr: is neither"), std::string::npos) << fault();
  save_exr(victim, good);
  EXPECT_EQ(fault(), "");
  fs::copy(victim, at("again tl030 pl000 tv060 pv045.exr"));
  EXPECT_NE(fault().find("has the angles of"), std::string::npos) << fault();
  fs::remove(at("again tl030 pl000 tv060 pv045.exr"));
  fs::copy(victim, at("tl120 pl000 tv000 pv000.exr"));
  EXPECT_NE(fault().find("angle of 120 degrees"), std::string::npos) << fault();
}

TEST_F(BtfFolder, OfOneViewLooksTheSameFromEverywhere) {
  const Rings rings;
  for (std::size_t l = 0; l < rings.angles_deg.size(); ++l)
    save_exr(at(image_name(rings.angles_deg[l], {0, 0}, ".exr")), Image(2, 2, 3, 0.25f));
  const Btf btf = read_btf_folder(folder(), {.cosine = false});
  ASSERT_EQ(btf.views.size(), 1u);
  for (const double theta : {0.0, 40.0, 85.0})
    EXPECT_NEAR(evaluate_btf(btf, {}, {0.0f, 0.0f, 1.0f}, glm::vec3(direction_of_angles(theta, 70))).x,
                0.25 / std::numbers::pi, 1e-4);
}

TEST_F(BtfFolder, IsCancelledAndReportsProgress) {
  write_linear();
  int calls = 0;
  double last = -1.0;
  BtfTask task;
  task.progress = [&](const std::string&, double share) {
    EXPECT_GE(share, last);
    last = share;
  };
  task.cancelled = [&] { return ++calls > 3; };
  EXPECT_THROW(read_btf_folder(folder(), {}, task), Error);
  EXPECT_EQ(calls, 4);
  EXPECT_GT(last, 0.0);
  EXPECT_LT(last, 1.0);
}

class BtfFile : public BtfFolder {
 protected:
  Btf made() {
    write_linear();
    return read_btf_folder(folder(), {.components = 3});
  }
  std::string load_fault(const std::string& path) const {
    try {
      load_factorised_btf(path);
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }
};

TEST_F(BtfFile, ComesBackTheSame) {
  const Btf btf = made();
  save_btf(at("made.exr"), btf);
  EXPECT_TRUE(is_factorised_btf(at("made.exr")));
  EXPECT_FALSE(is_factorised_btf(at(image_name({30, 0}, {60, 45}, ".exr"))));
  EXPECT_FALSE(is_factorised_btf(at("absent.exr")));
  const Btf again = load_factorised_btf(at("made.exr"));
  EXPECT_EQ(again.hash, btf.hash);
  EXPECT_EQ(again.name, btf.name);
  EXPECT_EQ(again.texel_m, btf.texel_m);
  EXPECT_EQ(again.provenance, btf.provenance);
  for (std::size_t v = 0; v < btf.views.size(); ++v) {
    EXPECT_EQ(again.views[v].factors, btf.views[v].factors);
    EXPECT_EQ(again.views[v].light_weights, btf.views[v].light_weights);
    EXPECT_NEAR(again.views[v].figures.contrast, btf.views[v].figures.contrast, 1e-6);
  }
  EXPECT_EQ(again.views[0].lights, again.views[1].lights);  // shared, as before
  EXPECT_NEAR(btf_energy_kept(again, 1), btf_energy_kept(btf, 1), 1e-6);
}

TEST_F(BtfFile, DamagedOrTruncatedIsRefused) {
  save_btf(at("made.exr"), made());
  const std::vector<std::byte> good = read_file(at("made.exr"));
  const auto write = [&](const std::vector<std::byte>& bytes) { write_file_atomically(at("bad.exr"), bytes); };
  for (const std::size_t size : {std::size_t{0}, std::size_t{3}, good.size() / 3, good.size() - 1}) {
    write({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)});
    EXPECT_NE(load_fault(at("bad.exr")), "") << size;
  }
  // What is read in spite of it is what was written: some bytes are only figures of views.
  const std::uint64_t hash = load_factorised_btf(at("made.exr")).hash;
  int refused = 0;
  for (std::size_t i = good.size() / 2; i < good.size(); i += good.size() / 40) {
    std::vector<std::byte> bytes = good;
    bytes[i] ^= std::byte{0x55};
    write(bytes);
    if (load_fault(at("bad.exr")).empty())
      EXPECT_EQ(load_factorised_btf(at("bad.exr")).hash, hash) << i;
    else
      ++refused;
  }
  EXPECT_GT(refused, 10);
  EXPECT_NE(load_fault(at("absent.exr")).find("does not exist"), std::string::npos);
  EXPECT_NE(load_fault(at(image_name({30, 0}, {60, 45}, ".exr"))).find("no factorised BTF"), std::string::npos);
}

TEST_F(BtfFile, AFullDiskLeavesWhatWasThere) {
  const Btf btf = made();
  save_btf(at("made.exr"), btf);
  const std::vector<std::byte> good = read_file(at("made.exr"));
  EXPECT_THROW(save_btf("/dev/full", btf), Error);
  EXPECT_THROW(save_btf(at("none/made.exr"), btf), Error);
  EXPECT_EQ(read_file(at("made.exr")), good);
  for (const fs::directory_entry& entry : fs::directory_iterator(folder()))
    EXPECT_EQ(entry.path().filename().string().find("partial"), std::string::npos);
}

/// Writes containers by the rules of docs/formats.md.
struct ContainerWriter {
  std::string bytes;
  template <typename T>
  void put(T value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void put_half(float value) { put(half_of_float(value)); }

  void header(const std::string& signature, bool cosine, const Rings& rings) {
    bytes = signature;
    std::string description;
    std::swap(bytes, description);
    const std::string xml = "<btf/>";
    ContainerWriter d;
    d.put<std::uint32_t>(4);
    d.bytes.append(240, ' ');
    d.put(5.0f);  // pixels a mm
    for (int i = 0; i < 3; ++i) d.put(1.0f);
    d.put<std::uint32_t>(cosine ? 1 : 0);
    d.put(static_cast<std::uint32_t>(xml.size()));
    d.bytes += xml;
    d.put<std::uint32_t>(3);
    for (const char* name : {"R", "G", "B"}) {
      d.put<std::uint32_t>(1);
      d.bytes += name;
    }
    bytes = description;
    put(static_cast<std::uint32_t>(d.bytes.size() + 4));
    bytes += d.bytes;
    const auto angles = [&](const glm::dvec2& a) {
      put(static_cast<float>(a.x * std::numbers::pi / 180.0));
      put(static_cast<float>(a.y * std::numbers::pi / 180.0));
    };
    put(static_cast<std::uint32_t>(rings.angles_deg.size()));
    for (const glm::dvec2& view : rings.angles_deg) {
      angles(view);
      put(static_cast<std::uint32_t>(rings.angles_deg.size()));
      for (const glm::dvec2& light : rings.angles_deg) angles(light);
    }
    put<std::uint32_t>(kFileWidth);
    put<std::uint32_t>(kFileHeight);
  }

  /// Each channel a full factorisation: U holds the images, S V the identity.
  static std::string dfmf(int model, bool cosine) {
    const Rings rings;
    const std::size_t n = rings.angles_deg.size(), texels = kFileWidth * kFileHeight;
    ContainerWriter w;
    w.header("!DFMF08FCR", cosine, rings);
    w.put<std::uint32_t>(0);  // rotations
    w.put(static_cast<std::uint32_t>(texels));
    w.put<std::int32_t>(model);
    for (int i = 0; i < 12; ++i) w.put(0.0f);
    for (int channel = 0; channel < 3; ++channel) {
      w.put<std::uint8_t>(4);
      w.put(static_cast<std::uint32_t>(texels));
      w.put(static_cast<std::uint32_t>(n * n));
      w.put(static_cast<std::uint32_t>(texels));
      for (std::size_t t = 0; t < texels; ++t) w.put(1.0f);
      for (std::size_t v = 0; v < n; ++v)
        for (std::size_t l = 0; l < n; ++l)
          for (std::size_t t = 0; t < texels; ++t) {
            glm::dvec3 rgb;
            for (int c = 0; c < 3; ++c)
              rgb[c] = made_rho(rings.direction(l), rings.direction(v), static_cast<int>(t), c) * std::numbers::pi *
                       (cosine ? rings.direction(l).z : 1.0);
            w.put(static_cast<float>(model == 0 ? rgb[channel] : log_yuv(rgb)[channel]));
          }
      for (std::size_t t = 0; t < texels; ++t)
        for (std::size_t k = 0; k < texels; ++k) w.put(k == t ? 1.0f : 0.0f);
    }
    return w.bytes;
  }

  static glm::dvec3 log_yuv(const glm::dvec3& rgb) {
    const double y = 0.299 * rgb.r + 0.587 * rgb.g + 0.114 * rgb.b;
    const double u = 0.492 * (rgb.b - y), v = 0.877 * (rgb.r - y);
    return {std::log(y + 1e-5), u / (y + 1e-5), v / (y + 1e-5)};
  }

  /// Two rows a chunk; `masked`: a texel that is left out.
  static std::string bdif(int masked = -1) {
    const Rings rings;
    const std::size_t n = rings.angles_deg.size();
    ContainerWriter w;
    w.header("!BDIF06R2!", true, rings);
    w.put<std::uint32_t>(2);
    w.put<std::uint8_t>(2);
    std::vector<int> stored;
    for (int t = 0; t < kFileWidth * kFileHeight; ++t) {
      w.put<std::uint8_t>(t == masked ? 0 : 1);
      if (t != masked) stored.push_back(t);
    }
    w.put<std::uint32_t>(0);
    for (std::size_t begin = 0; begin < stored.size(); begin += 2 * kFileWidth) {
      const std::size_t end = std::min(stored.size(), begin + 2 * kFileWidth);
      w.put(static_cast<std::uint32_t>((end - begin) * n * n * 6));
      for (std::size_t i = begin; i < end; ++i)
        for (std::size_t v = 0; v < n; ++v)
          for (std::size_t l = 0; l < n; ++l)
            for (int c = 0; c < 3; ++c)
              w.put_half(static_cast<float>(made_rho(rings.direction(l), rings.direction(v), stored[i], c) *
                                            std::numbers::pi * rings.direction(l).z));
    }
    return w.bytes;
  }
};

class BtfContainer : public TemporaryFolder {
 protected:
  std::string at(const std::string& name) const { return TemporaryFolder::path(name); }
  std::string store(const std::string& bytes) {
    std::ofstream(at("made.btf"), std::ios::binary) << bytes;
    return at("made.btf");
  }
  std::string fault(const std::string& bytes) {
    try {
      read_btf_container(store(bytes), {});
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }
};

TEST_F(BtfContainer, DfmfComesBack) {
  for (const int model : {0, 11})
    for (const bool cosine : {false, true}) {
      const Btf btf = read_btf_container(store(ContainerWriter::dfmf(model, cosine)), {.cosine = !cosine});
      expect_made(btf, model == 0 ? 2e-4 : 1e-3);
      EXPECT_NEAR(btf.texel_m, 2e-4, 1e-12);
      EXPECT_EQ(btf.provenance.at("btf.cosine"), cosine ? "true" : "false");
    }
}

TEST_F(BtfContainer, BdifComesBack) {
  expect_made(read_btf_container(store(ContainerWriter::bdif()), {}), 2e-4);
  const Btf masked = read_btf_container(store(ContainerWriter::bdif(2)), {});
  EXPECT_EQ(evaluate_btf(masked, {{2.5f / kFileWidth, 0.5f / kFileHeight}, 0.0f}, {0, 0, 1}, {0, 0, 1}),
            glm::vec3(0.0f));
}

TEST_F(BtfContainer, OthersAreRefusedByName) {
  EXPECT_NE(fault("!FMF12FCER" + std::string(400, 'x')).find("of kind !FMF12FCER, which is not read"),
            std::string::npos);
  EXPECT_NE(fault("!PVF06FCR " + std::string(400, 'x')).find("of kind !PVF06FCR"), std::string::npos);
  EXPECT_NE(fault("something else").find("is no .btf container"), std::string::npos);
  EXPECT_NE(fault("!D").find("ends within its signature"), std::string::npos);
}

/// Every length is refused, and lies about sizes take no memory.
TEST_F(BtfContainer, ThatLiesOrIsCutShortIsRefused) {
  for (const std::string& good : {ContainerWriter::dfmf(11, true), ContainerWriter::bdif()}) {
    EXPECT_EQ(fault(good), "");
    for (std::size_t size = 0; size < good.size(); size += 1 + good.size() / 97)
      EXPECT_NE(fault(good.substr(0, size)), "") << size;
    // Every count of the header in turn becomes huge.
    int refused = 0;
    for (std::size_t i = 10; i + 4 < std::min<std::size_t>(good.size(), 900); i += 7) {
      std::string bad = good;
      bad.replace(i, 4, "\xff\xff\xff\x7f");
      refused += fault(bad).empty() ? 0 : 1;
    }
    EXPECT_GT(refused, 60);
  }
}

TEST_F(BtfContainer, NanIsRefused) {
  std::string bad = ContainerWriter::bdif();
  bad.replace(bad.size() - 2, 2, std::string("\x00\x7e", 2));
  EXPECT_NE(fault(bad).find("not finite"), std::string::npos) << fault(bad);
  bad = ContainerWriter::dfmf(0, true);
  bad.replace(bad.size() - 4, 4, std::string("\x00\x00\xc0\x7f", 4));
  EXPECT_NE(fault(bad).find("not finite"), std::string::npos) << fault(bad);
}

TEST_F(BtfFolder, ItsKeyFollowsItsContent) {
  write_linear();
  const std::uint64_t key = btf_content_key(folder());
  EXPECT_EQ(btf_content_key(folder()), key);
  save_exr(at(image_name({30, 0}, {60, 45}, ".exr")), Image(kFileWidth, kFileHeight, 3, 0.5f));
  EXPECT_NE(btf_content_key(folder()), key);
}

}  // namespace
