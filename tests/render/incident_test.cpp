#include "render/slf/incident.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <tbb/global_control.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <random>
#include <thread>

#include "render/math/low_discrepancy.h"
#include "render/reference/path_sampler.h"
#include "render/reference/path_scene.h"
#include "render/slf/incident_bake.h"
#include "scenes/bake_file.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "tests/scenes/temporary_folder.h"
#include "tests/support/never.h"
#include "tests/support/small_sun.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

struct Stage {
  std::shared_ptr<const PathScene> scene;
  std::shared_ptr<LightFieldAtlas> atlas = std::make_shared<LightFieldAtlas>();
};

Stage set_up(const Scene& scene, const std::shared_ptr<const Environment>& sky, int side,
             std::vector<AtlasPart> parts = {}) {
  Stage s;
  s.scene = build_path_scene({.scene = scene, .environment = sky});
  if (parts.empty())
    for (std::size_t i = 0; i < s.scene->geometry.items.size(); ++i) parts.push_back({i, false});
  *s.atlas = make_atlas(s.scene->geometry, parts, {.side = side});
  return s;
}

std::vector<float> trace(const IncidentTracer& tracer, std::size_t texel) {
  std::vector<float> out(static_cast<std::size_t>(3 * tracer.lumisphere().count()));
  tracer.trace(texel, out);
  return out;
}

double irradiance(const Lumisphere& sphere, const std::vector<float>& bins, std::size_t channel) {
  double sum = 0.0;
  for (int b = 0; b < sphere.count(); ++b)
    sum += static_cast<double>(bins[3 * static_cast<std::size_t>(b) + channel]) * sphere.projected(b);
  return sum;
}

TEST(IncidentLight, AConstantSkyFillsEveryBinOfAConvexBody) {
  const Stage s = set_up(test::sphere_of(test::matte(glm::vec3(0.5f))), test::constant_sky({2.0f, 3.0f, 4.0f}), 24);
  const IncidentTracer tracer(s.scene, s.atlas, {.paths = 2});
  for (std::size_t t = 0; t < s.atlas->texels.size(); t += 13) {
    const std::vector<float> bins = trace(tracer, t);
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(irradiance(tracer.lumisphere(), bins, c), 3.14159265 * (2.0 + static_cast<double>(c)),
                  0.01 * 3.14159265 * (2.0 + static_cast<double>(c)))
          << t;
  }
}

/// A path scene turns the corners of triangles round, and the atlas is made of the geometry before.
TEST(IncidentLight, TexelsLieWhereTheAtlasHasThemInAPathSceneToo) {
  const Scene scene = test::box_scene(5, 4, test::matte(glm::vec3(0.5f)));
  const FlatGeometry geometry = flatten(scene);
  const auto traced = build_path_scene({.scene = scene, .environment = test::constant_sky(1.0f)});
  ASSERT_NE(traced->geometry.indices, geometry.indices);
  const LightFieldAtlas atlas = make_atlas(geometry, {{0, false}, {3, false}}, {.side = 48});
  for (std::size_t t = 0; t < atlas.texels.size(); ++t) {
    const AtlasTexel& texel = atlas.texels[t];
    const AtlasSide& side = atlas.sides[texel.side];
    glm::vec3 expected(0.0f);
    const float weights[] = {1.0f - texel.barycentric.x - texel.barycentric.y, texel.barycentric.x,
                             texel.barycentric.y};
    for (std::size_t k = 0; k < 3; ++k)
      expected += weights[k] * geometry.positions[geometry.indices[3 * static_cast<std::size_t>(side.triangle) + k]];
    EXPECT_LT(glm::length(frame_of_texel(traced->geometry, atlas, t).position - expected), 1e-5f) << t;
  }
}

TEST(IncidentLight, IrradianceOfASmallSunIsWithinAPercent) {
  for (int trial = 0; trial < 60; ++trial) EXPECT_LT(std::abs(test::sun_irradiance_error(trial)), 0.01) << trial;
}

/// Against paths in directions that this test draws, bin by bin, in a box with a lamp.
TEST(IncidentLight, BinsAgreeWithThePlainTracer) {
  Scene scene = test::box_scene(6, 2, test::matte({0.6f, 0.5f, 0.4f}));
  Material glow = test::matte(glm::vec3(0.0f));
  glow.emissive = glm::vec3(10.0f);
  scene.materials.push_back(glow);
  test::add(&scene, test::make_grid({-0.4f, 0.98f, -0.4f}, {0.8f, 0, 0}, {0, 0, 0.8f}, 1, 1), "lamp");
  const Stage s = set_up(scene, test::constant_sky(0.0f), 32, {{0, false}});
  const std::size_t t = s.atlas->texels.size() / 2 + 7;
  const IncidentTracer tracer(s.scene, s.atlas, {.side = 6, .paths = 512});
  const Lumisphere& sphere = tracer.lumisphere();
  const std::vector<float> bins = trace(tracer, t);
  const TexelFrame frame = frame_of_texel(s.scene->geometry, *s.atlas, t);
  for (int b = 0; b < sphere.count(); ++b) {
    constexpr std::uint32_t kPaths = 2048;
    double sum = 0.0, squares = 0.0;
    for (std::uint32_t i = 0; i < kPaths; ++i) {
      const Lumisphere::Sample d = sphere.draw(b, PathSampler{99u + static_cast<std::uint32_t>(b), i}.pair(5));
      const double v = d.weight > 0.0f
                           ? static_cast<double>(d.weight * estimate_radiance(*s.scene, {}, frame.origin,
                                                                              frame.to_world(d.direction),
                                                                              7u + static_cast<std::uint32_t>(b), i)
                                                                .y)
                           : 0.0;
      sum += v, squares += v * v;
    }
    const double mean = sum / kPaths, deviation = std::sqrt(std::max(squares / kPaths - mean * mean, 0.0) / kPaths);
    EXPECT_NEAR(static_cast<double>(bins[3 * static_cast<std::size_t>(b) + 1]), mean,
                5.0 * deviation + 0.01 * mean + 1e-3)
        << b;
  }
}

TEST(IncidentLight, TexelsInsideABodyAreFound) {
  Scene scene;
  scene.materials.push_back(test::matte(glm::vec3(0.5f)));
  test::add(&scene, test::make_grid({-3, 0, 3}, {6, 0, 0}, {0, 0, -6}, 1, 0), "sheet");
  Scene sphere = test::sphere_of(test::matte(glm::vec3(0.5f)));
  test::add(&scene, sphere.meshes[0].primitives[0], "ball");
  scene.meshes[1].primitives[0].material = 0;
  const Stage s = set_up(scene, test::constant_sky(1.0f), 40, {{0, false}});
  const IncidentTracer tracer(s.scene, s.atlas, {.paths = 1});
  std::vector<float> out(static_cast<std::size_t>(3 * tracer.lumisphere().count()));
  int inside = 0;
  for (std::size_t t = 0; t < s.atlas->texels.size(); ++t) {
    const glm::vec3 p = frame_of_texel(s.scene->geometry, *s.atlas, t).position;
    const float r = glm::length(p);
    if (std::abs(r - 1.0f) < 0.05f) continue;
    EXPECT_EQ(tracer.trace(t, out), r < 1.0f) << r;
    inside += r < 0.95f ? 1 : 0;
  }
  EXPECT_GT(inside, 50);
}

using IncidentBakeFolder = test::TemporaryFolder;

IncidentJob small_job(const std::string& folder) {
  IncidentJob job;
  auto scene = std::make_shared<Scene>(test::box_scene(5, 2, test::matte({0.6f, 0.5f, 0.4f})));
  scene->name = "box";
  job.geometry = std::make_shared<FlatGeometry>(flatten(*scene));
  job.scene = scene;
  job.environment = test::constant_sky(1.0f);
  job.parts = {{0, false}, {1, true}};
  job.atlas.side = 64;
  job.options.side = 4;
  job.options.paths = 1;
  job.folder = folder;
  job.must_work = true;
  return job;
}

TEST_F(IncidentBakeFolder, IsTheSameForAnyThreadsRanksAndInterruptions) {
  std::shared_ptr<const IncidentBake> alone;
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    IncidentJob job = small_job("");
    alone = bake_incident(job, {}, kNever, {});
  }
  ASSERT_TRUE(alone);
  ASSERT_GT(alone->atlas.texels.size(), 2 * kIncidentBlock);
  // Two ranks take turns: the second finds what the first left.
  const std::string shared_folder = path("ranks");
  std::shared_ptr<const IncidentBake> first, second;
  std::thread other([&] { first = bake_incident(small_job(shared_folder), {0, 2}, kNever, {}); });
  second = bake_incident(small_job(shared_folder), {1, 2}, kNever, {});
  other.join();
  EXPECT_EQ(first->field.radiance, alone->field.radiance);
  EXPECT_EQ(second->field.radiance, alone->field.radiance);
  // A process that waits for one that was lost makes what is missing itself.
  const std::string lonely = path("lost");
  std::vector<std::string> said;
  const BakeRanks of_two{
      .rank = 0, .count = 2, .patience_s = 0.05, .say = [&](const std::string& text) { said.push_back(text); }};
  const auto lost = bake_incident(small_job(lonely), of_two, kNever, {});
  ASSERT_EQ(said.size(), 2u);
  EXPECT_NE(said[0].find("waiting for 1 blocks"), std::string::npos) << said[0];
  ASSERT_TRUE(lost);
  EXPECT_EQ(lost->field.radiance, alone->field.radiance);
  EXPECT_EQ(summarize_incident(lonely).blocks_done, summarize_incident(lonely).blocks);
  // Stopped after one block, then resumed.
  const std::string stopped = path("stopped");
  std::atomic<bool> cancel{false};
  EXPECT_FALSE(bake_incident(small_job(stopped), {}, cancel, [&](double) { cancel = true; }));
  EXPECT_EQ(summarize_incident(stopped).blocks_done, 1u);
  const auto resumed = bake_incident(small_job(stopped), {}, kNever, {});
  EXPECT_EQ(resumed->reused, kIncidentBlock);
  EXPECT_EQ(resumed->field.radiance, alone->field.radiance);
  EXPECT_EQ(resumed->field.masked, alone->field.masked);
}

std::string failure_of(const IncidentJob& job) {
  try {
    bake_incident(job, {}, kNever, {});
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST_F(IncidentBakeFolder, SaysWhatIsWrongWithAFolder) {
  const std::string at = path("bake");
  IncidentJob show = small_job(at);
  show.may_make = false;
  EXPECT_NE(failure_of(show).find("there is no surface light field"), std::string::npos);
  ASSERT_EQ(failure_of(small_job(at)), "");
  EXPECT_EQ(failure_of(show), "");
  const auto differs = [&](const char* text, const std::function<void(IncidentJob*)>& change) {
    IncidentJob job = show;
    change(&job);
    EXPECT_NE(failure_of(job).find(text), std::string::npos) << failure_of(job);
  };
  differs("another geometry", [](IncidentJob* job) {
    auto moved = std::make_shared<FlatGeometry>(*job->geometry);
    moved->positions[0].x += 0.1f;
    job->geometry = moved;
  });
  differs("moved, dented or recoloured: /", [](IncidentJob* job) {
    auto moved = std::make_shared<FlatGeometry>(*job->geometry);
    moved->positions[0].x += 0.1f;
    job->geometry = moved;
  });
  differs("moved, dented or recoloured: /", [](IncidentJob* job) {
    auto painted = std::make_shared<FlatGeometry>(*job->geometry);
    for (glm::vec4& color : painted->colors) color = glm::vec4(1.0f, 0.0f, 0.0f, 1.0f);
    ASSERT_FALSE(painted->colors.empty());
    job->geometry = painted;
  });
  differs("moved, dented or recoloured: /", [](IncidentJob* job) {
    auto mapped = std::make_shared<FlatGeometry>(*job->geometry);
    ASSERT_FALSE(mapped->uv0.empty());
    mapped->uv0[0].x += 0.25f;
    job->geometry = mapped;
  });
  differs("with texels only in it: /", [](IncidentJob* job) { job->parts.pop_back(); });
  differs("scene box instead of ball", [](IncidentJob* job) {
    auto scene = std::make_shared<Scene>(*job->scene);
    scene->name = "ball";
    job->scene = scene;
  });
  differs("an atlas of 64 texels", [](IncidentJob* job) { job->atlas.side = 32; });
  const auto dim = [](IncidentJob* job) { job->options.env_scale = 0.5f; };
  differs("stale", dim);
  IncidentJob stale = show;
  dim(&stale);
  stale.show_stale = true;
  const auto shown = bake_incident(stale, {}, kNever, {});
  ASSERT_TRUE(shown);
  EXPECT_FALSE(shown->stale.empty());
  // Other materials are what a bake is for.
  IncidentJob exchanged = show;
  auto scene = std::make_shared<Scene>(*show.scene);
  scene->materials[0].base_color = glm::vec4(0.1f);
  exchanged.scene = scene;
  EXPECT_EQ(failure_of(exchanged), "");

  // A truncated block: refused where it is shown, made again by the bake.
  const std::string block = at + "/incident-00001.exr";
  std::vector<std::byte> bytes = read_file(block);
  bytes.resize(bytes.size() / 2);
  write_file_atomically(block, bytes);
  EXPECT_NE(failure_of(show).find("incident-00001.exr"), std::string::npos);
  const auto mended = bake_incident(small_job(at), {}, kNever, {});
  EXPECT_EQ(mended->reused % kIncidentBlock, mended->atlas.texels.size() % kIncidentBlock);
  EXPECT_EQ(failure_of(show), "");
  // Another block of the same bake in its place.
  write_file_atomically(block, read_file(at + "/incident-00000.exr"));
  EXPECT_NE(failure_of(show).find("another one of the bake"), std::string::npos) << failure_of(show);
  std::filesystem::remove(block);
  EXPECT_NE(failure_of(show).find("not complete"), std::string::npos);
}

/// A limit of the process on the size of files stands for a disk that fills up after the first block.
TEST_F(IncidentBakeFolder, AFullDiskKeepsWhatWasBaked) {
  const std::string at = path("full");
  rlimit usual{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &usual), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  std::string failure;
  try {
    bake_incident(small_job(at), {}, kNever, [&](double) {
      const rlimit small{512, usual.rlim_max};
      setrlimit(RLIMIT_FSIZE, &small);
    });
  } catch (const Error& error) {
    failure = error.what();
  }
  setrlimit(RLIMIT_FSIZE, &usual);
  std::signal(SIGXFSZ, handler);
  EXPECT_NE(failure.find("incident-00001"), std::string::npos) << failure;
  EXPECT_EQ(summarize_incident(at).blocks_done, 1u);
  for (const auto& entry : std::filesystem::directory_iterator(at))
    EXPECT_EQ(entry.path().extension(), ".exr") << "nothing half written is left";
  EXPECT_EQ(bake_incident(small_job(at), {}, kNever, {})->reused, kIncidentBlock);
}

/// Nothing can be made there.
TEST(IncidentBake, AFolderThatCannotBeWrittenIsNamed) {
  IncidentJob job = small_job("/proc/maquette-bake");
  EXPECT_NE(failure_of(job).find("/proc/maquette-bake"), std::string::npos);
  job.must_work = false;
  EXPECT_EQ(failure_of(job), "") << "the cache is not needed";
}

}  // namespace
}  // namespace maquette
