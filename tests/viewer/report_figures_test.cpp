#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "scenes/image_io.h"
#include "tests/viewer/run_program.h"
#include "viewer/report/charts.h"
#include "viewer/report/content_key.h"
#include "viewer/report/figures.h"
#include "viewer/report/journal.h"
#include "viewer/report/measure.h"
#include "viewer/report/page.h"
#include "viewer/report/page_parts.h"
#include "viewer/report/references.h"
#include "viewer/report/studio.h"
#include "viewer/report/sweep.h"
#include "viewer/report/write_data.h"
#include "viewer/session.h"

namespace maquette::report {
namespace {

Point point(const std::string& camera, const std::string& technique, int step, double ms, double error) {
  Point p;
  p.camera = camera;
  p.technique = technique;
  p.quality = std::to_string(step) + " samples";
  p.scope = Scope::estimator;
  p.step = step;
  p.repeats = 3;
  p.time_ms = {ms, 0.9 * ms, 1.2 * ms};
  p.relative_rmse = Spread{error, 0.9 * error, 1.1 * error};
  p.figures.relative_rmse = error;
  p.figures.flip = 0.5 * error;
  p.figures.notes = {"a note, with a comma"};
  return p;
}

CurvePoint at(double time_ms, double error) { return {time_ms, error, time_ms, time_ms, error, error, "", false, 0}; }

Report two_techniques() {
  Report report;
  report.scene = "a \"scene\" <of> & signs";
  report.cameras = {{"one", ""}, {"two", ""}};
  report.techniques = {{"slow", "s"}, {"quick", "q"}};
  for (const CameraEntry& camera : report.cameras) {
    const double scale = camera.name == "one" ? 1.0 : 4.0;
    for (int step = 0; step < 4; ++step) {
      report.points.push_back(point(camera.name, "slow", step, scale * 10.0 * std::exp2(step), 0.4 / std::exp2(step)));
      report.points.push_back(
          point(camera.name, "quick", step, scale * 5.0 * std::exp2(step), 0.3 / std::exp2(0.5 * step)));
    }
  }
  report.left_out = {{"slow", "glass", "no material transmits"}, {"quick", "glass", "no material transmits"}};
  return report;
}

TEST(ReportFigures, TimeToErrorIsReadLogLog) {
  // Error 1/time: halving it takes twice the time, between the points as well.
  Curve curve{"t", {at(10.0, 0.1), at(100.0, 0.01), at(50.0, 0.5)}};
  EXPECT_NEAR(*time_to_error(curve, 0.05), 20.0, 1e-9);
  EXPECT_NEAR(*time_to_error(curve, 0.02), 50.0, 1e-9);
  EXPECT_EQ(*time_to_error(curve, 0.3), 10.0);
  EXPECT_FALSE(time_to_error(curve, 0.005));
  EXPECT_EQ(best_error(curve), 0.01);
}

TEST(ReportFigures, TheFrontHoldsWhatNothingBeats) {
  const std::vector<FrontPoint> front = pareto_front(
      {{"a", {at(10.0, 0.5), at(20.0, 0.4), at(30.0, 0.1)}}, {"b", {at(15.0, 0.2), at(40.0, 0.1), at(5.0, 0.9)}}});
  ASSERT_EQ(front.size(), 4u);
  EXPECT_EQ(front[0].time_ms, 5.0);
  EXPECT_EQ(front[1].time_ms, 10.0);
  EXPECT_EQ(front[2].technique, "b");
  EXPECT_EQ(front[3].technique, "a");  // 30 ms; 40 ms at the same error is beaten
}

TEST(ReportFigures, NothingIsRankedWithinTheNoiseOfTheReference) {
  std::vector<Curve> curves = {{"a", {at(10.0, 0.5), at(20.0, 0.04), at(30.0, 0.01)}},
                               {"b", {at(15.0, 0.2), at(25.0, 0.03), at(40.0, 0.002)}}};
  EXPECT_EQ(noise_floor(curves), 0.0);
  EXPECT_EQ(pareto_front(curves).size(), 6u);
  for (Curve& curve : curves)
    for (CurvePoint& p : curve.points) p.below_noise = p.error < 0.045;
  const double floor = noise_floor(curves);
  EXPECT_EQ(floor, 0.04);
  EXPECT_FALSE(time_to_error(curves[0], 0.04, floor));
  EXPECT_TRUE(time_to_error(curves[0], 0.05, floor));
  const std::vector<FrontPoint> front = pareto_front(curves);
  ASSERT_EQ(front.size(), 3u);
  EXPECT_EQ(front.back().time_ms, 20.0) << "the fastest of those that the noise hides";
  EXPECT_EQ(best_error_text(curves[1], Metric::relative_rmse, floor), "≈ 4 % or less");
  EXPECT_EQ(best_error_text(curves[1], Metric::relative_rmse, 0.0), "0.2 %");
}

TEST(ReportFigures, MeansAreGeometricOverTheCameras) {
  Report report = two_techniques();
  const std::vector<Curve> curves = mean_curves(report, Scope::estimator, Metric::relative_rmse);
  ASSERT_EQ(curves.size(), 2u);
  ASSERT_EQ(curves[0].points.size(), 4u);
  EXPECT_NEAR(curves[0].points[0].time_ms, 20.0, 1e-9);  // of 10 and 40
  EXPECT_NEAR(curves[0].points[1].error, 0.2, 1e-12);
  EXPECT_TRUE(mean_curves(report, Scope::model, Metric::relative_rmse).empty());
  std::erase_if(report.points, [](const Point& p) { return p.camera == "two" && p.step == 3; });
  EXPECT_EQ(mean_curves(report, Scope::estimator, Metric::flip)[0].points.size(), 3u);  // only what both have
}

TEST(ReportFigures, TheNoiseOfTheReferenceIsNoError) {
  // A picture with an error of 0.1 against a truth of 1; reference halves with noise of 0.2 around the truth.
  std::mt19937 random(7);
  std::normal_distribution<float> noise(0.0f, 0.2f);
  Image picture(200, 100, 3, 1.1f);
  Judge judge;
  for (Image& half : judge.halves) {
    half = Image(200, 100, 3);
    for (float& value : half.data) value = 1.0f + noise(random);
  }
  judge.picture = judge.halves[0];
  for (std::size_t i = 0; i < judge.picture.data.size(); ++i)
    judge.picture.data[i] = 0.5f * (judge.halves[0].data[i] + judge.halves[1].data[i]);
  EXPECT_NEAR(*noise_free_error(picture, judge), 0.1, 0.005);
  EXPECT_NEAR(*compare_images(picture, judge.picture).relative_rmse, std::sqrt(0.01 + 0.02), 0.005);
  const Judge black{Image(4, 4, 3), {Image(4, 4, 3), Image(4, 4, 3)}, {}, {}};
  EXPECT_FALSE(noise_free_error(Image(4, 4, 3, 1.0f), black));
}

TEST(ReportFigures, SpreadsAreMedianAndRange) {
  const Spread spread = spread_of({3.0, 1.0, 2.0});
  EXPECT_EQ(spread.median, 2.0);
  EXPECT_EQ(spread.low, 1.0);
  EXPECT_EQ(spread.high, 3.0);
}

TEST(ReportData, CsvAndJsonHoldEveryPoint) {
  const Report report = two_techniques();
  const std::string csv = report_csv_text(report);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 17);
  EXPECT_EQ(csv.substr(0, 24), "camera,technique,quality");
  const auto json = nlohmann::json::parse(report_json_text(report));
  EXPECT_EQ(json["points"].size(), 16u);
  const auto& all = json["curves"]["estimator"]["all_cameras"]["relative_rmse"];
  EXPECT_NEAR(all["techniques"]["slow"]["time_ms_to_error"]["0.2"].get<double>(), 40.0, 1e-9);
  EXPECT_TRUE(all["techniques"]["quick"]["time_ms_to_error"]["0.01"].is_null());
  EXPECT_EQ(json["curves"]["estimator"]["cameras"]["one"]["flip"]["pareto_front"][0]["technique"], "quick");
}

TEST(ReportJournal, KeepsResultsAndSetsDamageAside) {
  const TemporaryFolder folder;
  const Point p = point("one", "slow", 2, 40.0, 0.1);
  {
    Journal journal(folder.path().string());
    EXPECT_TRUE(journal.note().empty());
    journal.add_point("k", p);
    journal.add_reference("r", {"one", Scope::estimator, "references/r.exr", "reference", 64, 0.01, 3.0});
  }
  const Journal again(folder.path().string());
  const std::optional<Point> found = again.find_point("k");
  ASSERT_TRUE(found);
  EXPECT_EQ(point_json(*found), point_json(p));
  EXPECT_FALSE(again.find_point("other"));
  EXPECT_EQ(again.find_reference("r")->samples, 64);
  std::ofstream(folder.file("progress.json")) << "{\"format\":2,\"points\":{\"k\":";
  const Journal damaged(folder.path().string());
  EXPECT_NE(damaged.note().find("set aside"), std::string::npos);
  EXPECT_FALSE(damaged.find_point("k"));
  EXPECT_EQ(folder.names(), std::vector<std::string>{"progress.json.damaged"});
}

TEST(ReportCharts, ScriptsHoldEveryCurveAndReadableTics) {
  const std::vector<Chart> charts = list_charts(two_techniques());
  ASSERT_EQ(charts.size(), 6u);  // estimator only: both metrics over all cameras and for each
  EXPECT_EQ(charts[0].name, "all-cameras-estimator-relative_rmse");
  const std::string script = gnuplot_script(charts[0], "x.svg");
  for (const char* part : {"\"slow\"", "\"quick\"", "Pareto front", "set logscale xy", "\"20 %%\" 0.2", "\"50\" 50"})
    EXPECT_NE(script.find(part), std::string::npos) << part << "\n" << script;
  EXPECT_NE(technique_color(charts[0].techniques, "slow"), technique_color(charts[0].techniques, "quick"));
}

TEST(ReportCharts, WithoutGnuplotThereIsANote) {
  const TemporaryFolder folder;
  const std::string path = getenv("PATH");
  setenv("PATH", "/nowhere", 1);
  std::string problem;
  const auto svg = draw_chart(list_charts(two_techniques())[0], folder.file("charts"), &problem);
  setenv("PATH", path.c_str(), 1);
  EXPECT_FALSE(svg);
  EXPECT_NE(problem.find("install gnuplot-nox"), std::string::npos) << problem;
}

TEST(ReportPage, HoldsEverythingItself) {
  const Report report = two_techniques();
  PageInput input{
      report, "/nowhere", {{"one-estimator-flip", "<svg><g stroke='rgb(  1,   2,   3)'/></svg>"}}, "no charts"};
  const std::string html = page_html(input);
  for (const char* outside : {"http:", "https:", "<script", "<link", "url("})
    EXPECT_EQ(html.find(outside), std::string::npos) << outside;
  for (std::size_t at = html.find("src=\""); at != std::string::npos; at = html.find("src=\"", at + 1))
    EXPECT_EQ(html.substr(at + 5, 5), "data:");
  EXPECT_NE(html.find("a &quot;scene&quot; &lt;of&gt; &amp; signs"), std::string::npos);
  EXPECT_NE(html.find("What was left out"), std::string::npos);
  EXPECT_NE(html.find("no charts"), std::string::npos);
  const std::size_t explained = html.find("<b>Estimator error</b> against direct light");
  EXPECT_NE(explained, std::string::npos);
  EXPECT_LT(explained, html.find("estimator error")) << "before it is first used";
  // Both slow and quick reach 20 %: 40 ms of slow against quick's 0.3 to 0.212 to 0.15.
  EXPECT_NE(html.find("To an estimator error of"), std::string::npos);
}

TEST(ReportPage, ReflectionsHaveTheirOwnSection) {
  const TemporaryFolder folder;
  Report report = two_techniques();
  EXPECT_EQ(page_html({report, folder.path().string(), {}, {}}).find("reflection error"), std::string::npos);
  Point p = point("one", "quick", 4, 3.0, 0.01);
  p.scope = Scope::reflection;
  p.picture = "none.png";
  report.points.push_back(p);
  for (const char* camera : {"one", "two"}) {
    for (const char* technique : {"quick", "slow"}) {
      Point both = point(camera, technique, 4, std::string(technique) == "slow" ? 12.0 : 3.0, 0.01);
      both.scope = Scope::reflection;
      report.points.push_back(both);
    }
  }
  const std::string html = page_html({report, folder.path().string(), {}, {}});
  EXPECT_NE(html.find("To a reflection error of"), std::string::npos);
  for (const char* part : {"<h3>Reflections</h3>", "given reflection error", "Lower pictures: reflection error"})
    EXPECT_NE(html.find(part), std::string::npos) << part;
  EXPECT_EQ(point_json(point_from_json(point_json(p))), point_json(p));
}

TEST(ReportPage, ChartsFollowTheTheme) {
  const std::string figure = chart_figure("<svg><g color=\"black\" stroke='rgb(  1,   2,   3)'/></svg>", "t");
  const std::string expected =
      "<svg><style>:root{color:#1d2127}@media (prefers-color-scheme:dark){:root{color:#e4e7eb}}</style><g "
      "stroke='currentColor'/></svg>";
  const TemporaryFolder folder;
  std::ofstream(folder.file("f")) << expected;
  EXPECT_NE(figure.find(*data_address(folder.file("f"), "image/svg+xml")), std::string::npos);
}

TEST(ReportPage, DataAddressesAreBase64) {
  const TemporaryFolder folder;
  for (const auto& [text, code] : {std::pair{"M", "TQ=="}, {"Ma", "TWE="}, {"Man", "TWFu"}}) {
    std::ofstream(folder.file("f")) << text;
    EXPECT_EQ(*data_address(folder.file("f"), "text/plain"), std::string("data:text/plain;base64,") + code);
  }
  EXPECT_FALSE(data_address(folder.file("none"), "text/plain"));
}

TEST(ReportSweep, EveryRegisteredTechniqueTakesPart) {
  const SceneFacts facts = compute_facts(build_builtin_scene("cockpit"), -1);
  std::vector<SweptTechnique> swept = swept_techniques(facts, {}, 0);
  std::erase_if(swept, [](const SweptTechnique& t) { return !t.visibility.empty(); });
  std::vector<std::string> names = builtin_registry().names(TechniqueKind::mode);
  for (const std::string& reflector : builtin_registry().names(TechniqueKind::reflector)) names.push_back(reflector);
  ASSERT_EQ(swept.size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(swept[i].name, names[i]);
    EXPECT_FALSE(swept[i].steps.empty());
    const auto info = std::find_if(builtin_registry().techniques.begin(), builtin_registry().techniques.end(),
                                   [&](const Technique& t) { return t.name == names[i]; });
    EXPECT_EQ(swept[i].refused.has_value(), info->own_bake.has_value()) << "a bake of minutes is made before";
  }
}

TEST(ReportSweep, BakesThatAreNamedAreMeasured) {
  const SceneFacts facts = compute_facts(build_builtin_scene("cockpit"), -1);
  int found = 0;
  for (const Technique& info : builtin_registry().techniques) {
    if (!info.own_bake) continue;
    Settings settings;
    settings.set_from_text(info.own_bake->name + ".bake", "folder");
    for (const SweptTechnique& t : swept_techniques(facts, settings, 0)) {
      if (t.name != info.name) continue;
      ++found;
      EXPECT_FALSE(t.refused) << t.name;
      EXPECT_GT(t.steps.size(), 3u) << "its error follows what is kept";
      EXPECT_NE(request_of({}, t, t.steps[0], Scope::model).settings.changed(),
                request_of({}, t, t.steps[1], Scope::model).settings.changed());
    }
  }
  EXPECT_EQ(found, 2);
}

/// Error and time of the kinds of visibility side by side: only where something shadows the sky.
TEST(ReportSweep, ShadowsAreComparedWhereThereAreSome) {
  const auto compared = [](const char* scene, const char* asked) {
    Settings settings;
    settings.set_from_text("shading.visibility", asked);
    std::string names;
    for (const SweptTechnique& t : swept_techniques(compute_facts(build_builtin_scene(scene), -1), settings, 0)) {
      if (t.visibility.empty()) continue;
      names += t.name + " ";
      const FrameRequest whole = request_of({}, t, {.samples = 8, .settings = {}}, Scope::model);
      EXPECT_EQ(whole.mode, "bandwidth");
      EXPECT_EQ("bandwidth-" + whole.settings.get_string("shading.visibility"), t.name);
    }
    return names;
  };
  EXPECT_EQ(compared("cockpit", "auto"), "bandwidth-none bandwidth-baked bandwidth-traced ");
  EXPECT_EQ(compared("cockpit", "traced"), "bandwidth-none bandwidth-baked bandwidth-rays ");
  EXPECT_EQ(compared("cockpit", "none"), "");
  EXPECT_EQ(compared("sphere", "auto"), "");
}

TEST(ReportSweep, WhatCannotDrawSaysWhy) {
  const SceneFacts facts = compute_facts(build_builtin_scene("sphere"), -1);
  for (const SweptTechnique& technique : swept_techniques(facts, {}, 0)) {
    const auto info = std::find_if(builtin_registry().techniques.begin(), builtin_registry().techniques.end(),
                                   [&](const Technique& t) { return t.name == technique.name; });
    const bool baked = info != builtin_registry().techniques.end() && info->own_bake;
    EXPECT_EQ(technique.refused.has_value(), technique.kind == TechniqueKind::reflector || baked) << technique.name;
    if (technique.refused && !baked) {
      EXPECT_NE(technique.refused->find("with --reflector"), std::string::npos);
    }
  }
  Settings settings;
  settings.set_from_text("shading.visibility", "baked");
  for (const SweptTechnique& technique : swept_techniques(facts, settings, 0))
    if (technique.name == "splitsum") {
      EXPECT_TRUE(technique.refused);
    }
}

TEST(ReportSweep, EstimatorScopeIsRestricted) {
  const SweptTechnique uniform{"uniform", "", TechniqueKind::mode, {{}}, {}, "uniform", {}};
  const QualityStep step{.samples = 8, .settings = {{"bandwidth.max_level", 2}}};
  EXPECT_EQ(quality_label(step), "8 samples, bandwidth.max_level 2");
  EXPECT_EQ(quality_label({}), "default");
  const FrameRequest restricted = request_of({}, uniform, step, Scope::estimator);
  EXPECT_EQ(restricted.settings.get_string("shading.visibility"), "none");
  EXPECT_EQ(restricted.mode, "uniform");
  EXPECT_EQ(restricted.samples, 8);
  const FrameRequest whole = request_of({}, uniform, step, Scope::model);
  EXPECT_EQ(whole.settings.get_string("shading.visibility"), "auto");
  EXPECT_EQ(whole.settings.get_int("bandwidth.max_level"), 2);
}

TEST(ReportSweep, ReflectorsAreDrawnByAModeWithoutNoise) {
  const SweptTechnique bezier{"bezier", "", TechniqueKind::reflector, {{}}, {}, reflection_mode(), {}};
  const FrameRequest request = request_of({}, bezier, {}, Scope::reflection);
  EXPECT_EQ(request.mode, reflection_mode());
  EXPECT_EQ(request.reflections, "bezier");
  EXPECT_EQ(request.settings.get_string("shading.visibility"), "auto");
}

TEST(ReportReferences, ReflectorsAreJudgedByRays) {
  const TemporaryFolder folder;
  SceneOptions options;
  options.scene = "builtin:cockpit";
  options.camera = "driver";
  options.width = 64;
  options.height = 36;
  options.settings.set_from_text("shading.visibility", "none");
  Studio studio(options);
  const std::vector<SweptTechnique> swept =
      swept_techniques(compute_facts(studio.overridden_scene(), -1), options.settings, 0);
  const auto technique = [&](const std::string& name) {
    return *std::find_if(swept.begin(), swept.end(), [&](const SweptTechnique& t) { return t.name == name; });
  };
  const SweptCamera driver = swept_cameras(*studio.scene(), options).front();
  const std::optional<Judge> judge =
      obtain_reflection_reference(&studio, folder.path().string(), driver, technique(reflection_reference()));
  ASSERT_TRUE(judge);
  EXPECT_EQ(load_hdr_image(folder.file(judge->entry.file)).data, judge->picture.data);
  const auto error = [&](const std::string& name, const QualityStep& step) {
    const FrameRequest request = request_of(studio.request(driver), technique(name), step, Scope::reflection);
    return judge_measurement(measure_frames(&studio.renderer(), request, request, 1), *judge).relative_rmse->median;
  };
  const SweptTechnique rays = technique(reflection_reference());
  EXPECT_EQ(error(rays.name, rays.steps.back()), 0.0);
  EXPECT_GT(error(rays.name, rays.steps.front()), 0.0);
  const double bezier = error("bezier", technique("bezier").steps.back());
  EXPECT_LT(bezier, error(rays.name, rays.steps.front()));

  SweptCamera away = driver;  // at the seats
  away.view.target = 2.0f * away.view.eye - away.view.target;
  EXPECT_FALSE(obtain_reflection_reference(&studio, folder.path().string(), away, rays));
}

TEST(ReportSweep, AllCamerasOrTheOneAskedFor) {
  const Scene cockpit = build_builtin_scene("cockpit");
  EXPECT_EQ(swept_cameras(cockpit, {}).size(), 4u);
  SceneOptions options;
  options.camera = "door";
  ASSERT_EQ(swept_cameras(cockpit, options).size(), 1u);
  EXPECT_EQ(swept_cameras(cockpit, options)[0].name, "door");
  const Scene seat = build_builtin_scene("seat");
  EXPECT_GE(swept_cameras(seat, {}).size(), 1u);
}

TEST(ReportSweep, KnowsNoTechniqueByItsName) {
  Registry renamed = builtin_registry();
  for (Technique& technique : renamed.techniques) technique.name = "renamed-" + technique.name;
  renamed.default_mode = "renamed-" + renamed.default_mode;
  SceneFacts facts;
  facts.enclosed = true;
  facts.reflector_count = 2;
  const auto own = swept_techniques(facts, {}, 1), other = swept_techniques(facts, {}, 1, renamed);
  ASSERT_GE(own.size(), 8u);
  ASSERT_EQ(own.size(), other.size());
  for (std::size_t i = 0; i < own.size(); ++i) {
    EXPECT_EQ("renamed-" + own[i].name, other[i].name);
    EXPECT_EQ("renamed-" + own[i].mode, other[i].mode) << own[i].name;
    EXPECT_EQ(own[i].refused.has_value(), other[i].refused.has_value()) << own[i].name;
    ASSERT_EQ(own[i].steps.size(), other[i].steps.size()) << own[i].name;
    for (std::size_t k = 0; k < own[i].steps.size(); ++k)
      EXPECT_EQ(quality_label(own[i].steps[k]), quality_label(other[i].steps[k]));
  }
  EXPECT_EQ("renamed-" + reflection_mode(), reflection_mode(renamed));
  EXPECT_EQ("renamed-" + reflection_reference(), reflection_reference(renamed));
}

TEST(ReportKeys, FollowTheContent) {
  Scene scene = build_builtin_scene("sphere");
  const std::string key = scene_key(scene).text();
  EXPECT_EQ(scene_key(build_builtin_scene("sphere")).text(), key);
  scene.materials[0].roughness += 0.01f;
  EXPECT_NE(scene_key(scene).text(), key);
  scene = build_builtin_scene("sphere");
  scene.materials[0].attenuation_distance = 0.5f;
  EXPECT_NE(scene_key(scene).text(), key);
  scene = build_builtin_scene("sphere");
  scene.meshes[0].primitives[0].positions[0].x += 1e-4f;
  EXPECT_NE(scene_key(scene).text(), key);
  FrameRequest a, b;
  b.seed = 1;
  ContentKey ka, kb;
  mix_request(a, &ka);
  mix_request(b, &kb);
  EXPECT_NE(ka.text(), kb.text());
}

}  // namespace
}  // namespace maquette::report
