#include "review/camera_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "review/spline.h"
#include "scenes/error.h"
#include "tests/scenes/temporary_folder.h"
#include "tests/support/random_reviews.h"
#include "tests/support/text.h"

namespace maquette {
namespace {

using Json = nlohmann::json;
using PathFile = test::TemporaryFolder;

using test::contains;

CameraView looking(const glm::vec3& eye, const glm::vec3& direction) {
  CameraView view;
  view.eye = eye;
  view.target = eye + direction;
  return view;
}

PathKey key_at(const glm::vec3& eye, double duration_s = 1.0) {
  PathKey key;
  key.camera = looking(eye, {0.0f, 0.0f, -1.0f});
  key.duration_s = duration_s;
  return key;
}

CameraPath path_of(std::vector<PathKey> keys) {
  CameraPath path;
  path.name = "test";
  path.keys = std::move(keys);
  return path;
}

double distance_between(const CameraView& a, const CameraView& b) {
  return glm::distance(glm::dvec3(a.eye), glm::dvec3(b.eye));
}

TEST(CameraPath, PassesItsKeysAtTheirTimes) {
  test::RandomReviews random(10);
  for (int i = 0; i < 50; ++i) {
    const CameraPath path = random.random_path();
    check_path(path, "test");
    const std::vector<double> times = key_times_s(path);
    for (std::size_t k = 0; k < path.keys.size(); ++k) {
      for (const double rest_s : {0.0, path.keys[k].delay_s}) {
        const PathMoment moment = path_at(path, times[k] + rest_s);
        EXPECT_LT(distance_between(moment.camera, path.keys[k].camera), 1e-5);
        EXPECT_LT(angle_between(moment.camera, path.keys[k].camera), 1e-3);
        if (path.keys[k].exposure_ev) {
          EXPECT_FLOAT_EQ(*moment.exposure_ev, *path.keys[k].exposure_ev);
        }
      }
    }
  }
}

/// Position and orientation have no jumps and no kinks: with steps of h they differ by O(h), their differences by
/// O(h2).
TEST(CameraPath, IsSmooth) {
  test::RandomReviews random(11);
  for (int i = 0; i < 20; ++i) {
    CameraPath path = random.random_path();
    for (PathKey& key : path.keys) {
      key.delay_s = 0.0;
      key.ease = Ease::smooth;
    }
    const double end_s = path_duration_s(path), step_s = 1e-4;
    for (double t = step_s; t < end_s - step_s; t += 0.0137) {
      const CameraView a = path_at(path, t - step_s).camera, b = path_at(path, t).camera,
                       c = path_at(path, t + step_s).camera;
      EXPECT_LT(distance_between(a, b), 0.2);
      EXPECT_LT(std::abs(angle_between(b, c) - angle_between(a, b)), 5e-3);
    }
  }
}

TEST(CameraPath, AStraightLineStaysOneAndDoesNotOvershoot) {
  const CameraPath path = path_of({key_at({0, 0, 0}), key_at({1, 0, 0}), key_at({1.1f, 0, 0}), key_at({5, 0, 0})});
  double before = -1.0;
  for (double t = 0.0; t <= 3.0; t += 0.01) {
    const CameraView view = path_at(path, t).camera;
    EXPECT_NEAR(view.eye.y, 0.0f, 1e-6f);
    EXPECT_GE(static_cast<double>(view.eye.x), before - 1e-6) << t;
    before = static_cast<double>(view.eye.x);
  }
}

/// Uneven spacing, where uniform Catmull-Rom makes a loop: the centripetal curve stays near its chord.
TEST(CameraPath, MakesNoLoops) {
  const CameraPath path = path_of({key_at({0, 0, 0}), key_at({10, 0, 0}), key_at({10, 0.1f, 0}), key_at({0, 0.1f, 0})});
  float greatest = 0.0f;
  for (double t = 1.0; t <= 2.0; t += 0.001) {
    const float y = path_at(path, t).camera.eye.y;
    EXPECT_GE(y, greatest - 1e-5f) << "it turns back";
    greatest = std::max(greatest, y);
    EXPECT_LT(path_at(path, t).camera.eye.x, 10.3f);
  }
}

/// Quaternions that change their sign on the way would turn the camera round the long way.
TEST(CameraPath, TurnsTheShortWay) {
  const auto at = [](double degrees) {
    const double a = degrees * 0.017453292519943295;
    PathKey key = key_at({0, 0, 0});
    key.camera = looking({0, 0, 0}, glm::vec3(glm::dvec3(std::sin(a), 0.0, std::cos(a))));
    return key;
  };
  CameraPath path = path_of({});
  for (double degrees = 0.0; degrees <= 720.0; degrees += 40.0) path.keys.push_back(at(degrees));
  double turned = 0.0;
  for (double t = 0.0; t < path_duration_s(path) - 1e-9; t += 0.01) {
    const double step = angle_between(path_at(path, t).camera, path_at(path, t + 0.01).camera);
    EXPECT_LT(step, 0.02) << t;
    turned += step;
  }
  EXPECT_NEAR(turned, 720.0 * 0.017453292519943295, 0.05);
}

TEST(CameraPath, DelaySkipEaseAndLooks) {
  CameraPath path = path_of({key_at({0, 0, 0}, 2.0), key_at({9, 9, 9}, 5.0), key_at({4, 0, 0}, 1.0)});
  path.keys[0].delay_s = 1.0;
  path.keys[1].skip = true;
  path.keys[2].look = "red";
  path.keys[0].env_rotation_deg = 10.0f;
  path.keys[2].env_rotation_deg = 370.0f;
  EXPECT_DOUBLE_EQ(path_duration_s(path), 3.0);
  EXPECT_EQ(path_at(path, 0.9).camera.eye.x, 0.0f);
  EXPECT_NEAR(path_at(path, 2.0).camera.eye.x, 2.0f, 1e-5f);
  EXPECT_FLOAT_EQ(*path_at(path, 0.9).env_rotation_deg, 10.0f);
  EXPECT_FLOAT_EQ(*path_at(path, 2.0).env_rotation_deg, 190.0f);
  EXPECT_FALSE(path_at(path, 2.9).look);
  EXPECT_EQ(path_at(path, 3.0).look, "red");
  EXPECT_FALSE(path_at(path, 2.0).exposure_ev);
  for (const auto& [ease, x] : {std::pair{Ease::in, 1.0}, {Ease::out, 3.0}, {Ease::smooth, 2.0}}) {
    path.keys[0].ease = ease;
    EXPECT_NEAR(static_cast<double>(path_at(path, 2.0).camera.eye.x), x, 1e-5);
  }
}

TEST(CameraPath, AMovedKeyLeavesTheOthersWhereTheyAre) {
  CameraPath path = path_of({key_at({0, 0, 0}), key_at({1, 0, 0}), key_at({2, 0, 0}), key_at({3, 0, 0})});
  path.keys[0].delay_s = 0.5;
  path.keys[1].delay_s = 0.25;
  const std::vector<double> before = key_times_s(path);  // 0, 1.5, 2.75, 3.75
  move_key(&path, 1, 1.9);
  EXPECT_NEAR(key_times_s(path)[1], 1.9, 1e-12);
  for (const std::size_t k : {0u, 2u, 3u}) EXPECT_NEAR(key_times_s(path)[k], before[k], 1e-12);
  EXPECT_EQ(path.keys[1].delay_s, 0.25);
  move_key(&path, 1, 99.0);
  EXPECT_NEAR(path.keys[1].duration_s, 0.04, 1e-9) << "it stops before the next one";
  move_key(&path, 1, -99.0);
  EXPECT_NEAR(path.keys[0].duration_s, 0.04, 1e-9) << "and behind the rest of the one before";
  EXPECT_NEAR(key_times_s(path)[2], before[2], 1e-12);
  move_key(&path, 3, 6.0);
  EXPECT_NEAR(path_duration_s(path), 6.0, 1e-12) << "the last one makes the path longer";
  const CameraPath same = path;
  move_key(&path, 0, 1.0);
  EXPECT_EQ(path, same) << "the first one stays";
  path.closed = true;
  path.keys[3].duration_s = 2.0;
  move_key(&path, 3, 7.0);
  EXPECT_NEAR(path_duration_s(path), 8.0, 1e-12) << "the way back gets shorter";
  path.keys[1].skip = true;
  move_key(&path, 1, 2.0);
  move_key(&path, 2, 3.0);
  EXPECT_NEAR(key_times_s(path)[2], 3.0, 1e-12) << "skipped keys are as if they were not there";
  EXPECT_NO_THROW(check_path(path, "test"));
}

TEST(CameraPath, PlaysInEveryDirection) {
  const CameraPath path = path_of({key_at({0, 0, 0}, 2.0), key_at({1, 0, 0})});
  EXPECT_DOUBLE_EQ(playing_time_s(path, Playing::once, 5.0), 2.0);
  EXPECT_DOUBLE_EQ(playing_time_s(path, Playing::loop, 5.0), 1.0);
  EXPECT_DOUBLE_EQ(playing_time_s(path, Playing::reverse, 0.5), 1.5);
  EXPECT_DOUBLE_EQ(playing_time_s(path, Playing::ping_pong, 3.0), 1.0);
  EXPECT_DOUBLE_EQ(playing_time_s(path, Playing::ping_pong, 4.5), 0.5);
}

TEST(CameraPath, ATurntableKeepsItsDistance) {
  const CameraView view = looking({3, 1, 0}, {-3, -1, 0});
  const CameraPath path = turntable(view, 8.0);
  EXPECT_DOUBLE_EQ(path_duration_s(path), 8.0);
  for (double t = 0.0; t < 8.0; t += 0.05) {
    const CameraView at = path_at(path, t).camera;
    EXPECT_NEAR(glm::length(glm::vec2(at.eye.x, at.eye.z)), 3.0f, 0.03f) << t;
    EXPECT_NEAR(at.eye.y, 1.0f, 0.01f);
    EXPECT_LT(glm::distance(at.target, glm::vec3(0.0f)), 0.05f);
  }
  EXPECT_LT(distance_between(path_at(path, 7.999).camera, view), 0.01);
}

TEST(CameraPath, ThinningStaysWithinItsTolerance) {
  std::vector<RecordedView> views;
  for (int i = 0; i <= 600; ++i) {
    const double t = i / 60.0;
    const auto eye = glm::vec3(glm::dvec3(std::sin(t), 0.3 * std::cos(2.0 * t), t));
    views.push_back({t + 3.0, looking(eye, glm::vec3(glm::dvec3(std::cos(0.5 * t), 0.2, std::sin(0.5 * t))))});
  }
  const ThinTolerance tolerance{0.01, 0.01};
  const CameraPath path = thinned(views, tolerance);
  check_path(path, "test");
  EXPECT_LT(path.keys.size(), 100u);
  EXPECT_NEAR(path_duration_s(path), 10.0, 1e-9);
  for (const RecordedView& view : views) EXPECT_LE(deviation(path, {view.time_s - 3.0, view.camera}, tolerance), 1.0);
  EXPECT_EQ(thinned({views[0]}, tolerance).keys.size(), 1u);
  EXPECT_TRUE(thinned({}, tolerance).keys.empty());
}

TEST_F(PathFile, ComesBackAsItWas) {
  test::RandomReviews random(12);
  for (int i = 0; i < 20; ++i) {
    const CameraPath saved = random.random_path();
    save_path(path("a.path.json"), saved);
    EXPECT_EQ(load_path(path("a.path.json")), saved);
  }
}

TEST_F(PathFile, BadOnesAreRefused) {
  const auto problem = [&](const CameraPath& bad) {
    save_path(path("a.path.json"), bad);
    return test::message_of<Error>([&] { load_path(path("a.path.json")); });
  };
  EXPECT_TRUE(contains(problem(path_of({key_at({0, 0, 0})})), "one key only; a move needs two"));
  EXPECT_TRUE(contains(problem(path_of({})), "no key"));
  CameraPath skipped = path_of({key_at({0, 0, 0}), key_at({1, 0, 0})});
  skipped.keys[1].skip = true;
  EXPECT_TRUE(contains(problem(skipped), "one key only"));
  EXPECT_TRUE(contains(problem(path_of({key_at({0, 0, 0}, 0.0), key_at({1, 0, 0}, 0.0)})), "the path has no duration"));
  save_path(path("a.path.json"), path_of({key_at({0, 0, 0}), key_at({1, 0, 0})}));
  Json json = Json::parse(read(path("a.path.json")));
  json["path"]["keys"][1]["eas"] = "in";
  write("a.path.json", json.dump());
  EXPECT_TRUE(contains(test::message_of<Error>([&] { load_path(path("a.path.json")); }), "did you mean ease?"));
  json["maquette_path"] = 2;
  write("a.path.json", json.dump());
  EXPECT_TRUE(contains(test::message_of<Error>([&] { load_path(path("a.path.json")); }), "newer version"));
  write("a.path.json", "[");
  EXPECT_TRUE(contains(test::message_of<Error>([&] { load_path(path("a.path.json")); }), "it is no JSON"));
}

}  // namespace
}  // namespace maquette
