#include "viewer/report/conductor.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "render/picture/tonemap.h"
#include "scenes/error.h"
#include "scenes/file_name.h"
#include "scenes/image_io.h"
#include "scenes/percent.h"
#include "viewer/interrupt.h"
#include "viewer/report/measure.h"
#include "viewer/session.h"

namespace maquette::report {

namespace {

/// Share of the budget that references may take.
constexpr double kReferenceShare = 0.4;
/// Share of that for full light transport, which converges more slowly.
constexpr double kFullShare = 0.65;
/// Reserved for charts and page: a share of the budget, and at most this many seconds.
constexpr double kWritingShare = 0.08, kMostWriting_s = 12.0;
/// A relative change of the error below this counts as none.
constexpr double kSameError = 0.005;
constexpr int kIdleSteps = 2;
constexpr std::uint32_t kFirstSeed = 1;

/// A picture for the page: the sky is opaque.
Image shown(const Image& radiance, float exposure_ev, const std::string& tonemap) {
  Image picture = tone_map(radiance, exposure_ev, tonemap);
  for (std::size_t i = 3; picture.channels == 4 && i < picture.data.size(); i += 4) picture.data[i] = 1.0f;
  return picture;
}

}  // namespace

Conductor::Conductor(Studio* studio, Journal* journal, std::string folder, std::function<void(const std::string&)> say)
    : studio_(studio), journal_(journal), folder_(std::move(folder)), say_(std::move(say)) {}

double Conductor::elapsed_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

void Conductor::run(Report* report) {
  const SceneOptions& options = studio_->options();
  cameras_ = swept_cameras(*studio_->scene(), options);
  for (const SweptCamera& camera : cameras_) report->cameras.push_back({camera.name, {}});
  list_techniques(report);
  make_references(report);
  std::vector<Ladder> ladders = make_ladders();
  std::size_t most = 0;
  for (const SweptTechnique& technique : techniques_) most = std::max(most, technique.steps.size());
  for (int step = 0; step < static_cast<int>(most) && !InterruptGuard::asked(); ++step)
    for (Ladder& ladder : ladders)
      if (!ladder.over && !InterruptGuard::asked()) climb(&ladder, step, report);
  report->interrupted = InterruptGuard::asked();
  report->seconds = elapsed_s();
}

void Conductor::list_techniques(Report* report) {
  const SceneOptions& options = studio_->options();
  facts_ = compute_facts(studio_->overridden_scene(), find_variant(*studio_->scene(), options.variant));
  techniques_ = swept_techniques(facts_, options.settings, options.reflectors.size());
  for (const SweptTechnique& technique : techniques_) {
    if (technique.refused) {
      report->left_out.push_back({technique.name, technique.name, *technique.refused});
      continue;
    }
    report->techniques.push_back(
        {technique.name, technique.help,
         technique.kind == TechniqueKind::mode && builtin_registry().find_mode(technique.mode).can.traces_picture});
    for (const LeftOut& left_out : plan_of(technique, Scope::model).left_out)
      report->left_out.push_back({technique.name, left_out.what, left_out.why});
  }
  std::erase_if(techniques_, [](const SweptTechnique& t) { return t.refused.has_value(); });
  for (const LaterName& later : builtin_registry().later_modes)
    report->left_out.push_back({later.name, later.name, later.help + ": not available in this version"});
}

FramePlan Conductor::plan_of(const SweptTechnique& technique, Scope scope) const {
  const FrameRequest request =
      request_of(studio_->request(cameras_.front()), technique, technique.steps.front(), scope);
  ViewInfo view{request.width, request.height, request.msaa, request.reflections};
  view.orthographic = request.camera.is_orthographic();
  if (!request.reflectors.empty()) view.reflectors = static_cast<int>(request.reflectors.size());
  return plan(facts_, request.mode, request.settings, view);
}

void Conductor::make_references(Report* report) {
  const double share = kReferenceShare * studio_->options().budget_s / static_cast<double>(cameras_.size());
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    for (const Scope scope : {Scope::estimator, Scope::model}) {
      if (InterruptGuard::asked()) return;
      const ReferenceOrder order{cameras_[c], scope, share * (scope == Scope::model ? kFullShare : 1.0 - kFullShare)};
      Judge judge = obtain_reference(studio_, journal_, folder_, order);
      say_("reference of " + cameras_[c].name + ", " + scope_name(scope) + ": noise " +
           percent_text(judge.entry.noise));
      report->references.push_back(judge.entry);
      judges_[{cameras_[c].name, scope}] = std::move(judge);
    }
    const Judge& judge = judges_[{cameras_[c].name, Scope::model}];
    std::filesystem::create_directories(folder_ + "/pictures");
    report->cameras[c].reference_picture = "pictures/" + file_name_of(cameras_[c].name) + "-reference.png";
    save_png(folder_ + "/" + report->cameras[c].reference_picture,
             shown(judge.picture, exposure_of_camera(cameras_[c].name), studio_->options().tonemap));
    make_reflection_reference(c, report);
  }
}

void Conductor::make_reflection_reference(std::size_t camera, Report* report) {
  const auto raytraced = std::find_if(techniques_.begin(), techniques_.end(),
                                      [](const SweptTechnique& t) { return t.name == reflection_reference(); });
  if (raytraced == techniques_.end() || InterruptGuard::asked()) return;
  std::optional<Judge> judge;
  std::string why = "no reflector is in view";
  try {
    judge = obtain_reflection_reference(studio_, folder_, cameras_[camera], *raytraced);
  } catch (const Error& error) {
    why = error.what();  // more reflectors than can be drawn at once; the modes are still measured
  }
  if (!judge) {
    report->skipped.push_back("reflections, camera " + cameras_[camera].name + ": " + why);
    return;
  }
  say_("reference of " + cameras_[camera].name + ", " + scope_name(Scope::reflection));
  report->references.push_back(judge->entry);
  judges_[{cameras_[camera].name, Scope::reflection}] = std::move(*judge);
}

float Conductor::exposure_of_camera(const std::string& camera) const {
  const SceneOptions& options = studio_->options();
  const float suited = exposure_of(options, *studio_->environment());
  return options.exposure_ev ? suited : meter_exposure_ev(judges_.at({camera, Scope::model}).picture, suited);
}

std::vector<Conductor::Ladder> Conductor::make_ladders() const {
  std::vector<Ladder> ladders;
  const auto passes = [&](const SweptTechnique& technique, Scope scope) {
    std::string names;
    for (const PlannedPass& pass : plan_of(technique, scope).passes) names += pass.name + " ";
    return names;
  };
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    for (std::size_t t = 0; t < techniques_.size(); ++t) {
      const SweptTechnique& technique = techniques_[t];
      if (technique.kind == TechniqueKind::reflector) {
        if (judges_.contains({cameras_[c].name, Scope::reflection}))
          ladders.push_back({c, t, {Scope::reflection}, 0.0, 0, 0, {}, false});
        continue;
      }
      if (!technique.visibility.empty()) {  // without shadows they all draw the same picture
        ladders.push_back({c, t, {Scope::model}, 0.0, 0, 0, {}, false});
        continue;
      }
      if (builtin_registry().find_mode(technique.mode).own_bake) {  // of all light, which no setting restricts
        ladders.push_back({c, t, {Scope::model}, 0.0, 0, 0, {}, false});
        continue;
      }
      // The plan shows restricted settings that techniques share, but not necessarily the technique's own.
      const bool same = builtin_registry().find_mode(technique.mode).restricted_settings.empty() &&
                        passes(technique, Scope::estimator) == passes(technique, Scope::model);
      if (same)
        ladders.push_back({c, t, {Scope::estimator, Scope::model}, 0.0, 0, 0, {}, false});
      else
        for (const Scope scope : {Scope::estimator, Scope::model})
          ladders.push_back({c, t, {scope}, 0.0, 0, 0, {}, false});
    }
  }
  return ladders;
}

FrameRequest Conductor::request(const Ladder& ladder, const QualityStep& step) const {
  FrameRequest request = studio_->request(cameras_[ladder.camera]);
  request.seed = kFirstSeed;
  // If several scopes judge the same picture, any of them can be used.
  return request_of(std::move(request), techniques_[ladder.technique], step, ladder.scopes.back());
}

std::string Conductor::key_of(const Ladder& ladder, const FrameRequest& request, Scope scope) const {
  const Judge& judge = judges_.at({cameras_[ladder.camera].name, scope});
  ContentKey key = studio_->key();
  mix_request(request, &key);
  key.mix(scope_name(scope)).mix(judge.key).mix(static_cast<double>(judge.entry.samples));
  key.mix(static_cast<double>(studio_->options().repeats)).mix(studio_->device().renderer);
  return key.text();
}

void Conductor::climb(Ladder* ladder, int step, Report* report) {
  const SweptTechnique& technique = techniques_[ladder->technique];
  if (step >= static_cast<int>(technique.steps.size())) {
    ladder->over = true;
    return;
  }
  if (reuse_earlier_points(ladder, step, report)) return;
  const QualityStep& quality = technique.steps[static_cast<std::size_t>(step)];
  const double growth = ladder->last_samples > 0 && quality.samples > 0
                            ? static_cast<double>(quality.samples) / ladder->last_samples
                            : 1.0;
  const double expected_s = 1e-3 * ladder->last_ms * growth * (studio_->options().repeats + 1);
  const double budget_s = studio_->options().budget_s;
  if (elapsed_s() + expected_s + std::min(kMostWriting_s, kWritingShare * budget_s) > budget_s) {
    report->skipped.push_back(technique.name + " from " + quality_label(quality) + " on, camera " +
                              cameras_[ladder->camera].name + ": the budget was spent");
    ladder->over = true;
    return;
  }
  measure(ladder, step, report);
}

bool Conductor::reuse_earlier_points(Ladder* ladder, int step, Report* report) {
  const QualityStep& quality = techniques_[ladder->technique].steps[static_cast<std::size_t>(step)];
  const FrameRequest frame = request(*ladder, quality);
  std::vector<Point> points;
  for (const Scope scope : ladder->scopes) {
    const std::optional<Point> known = journal_->find_point(key_of(*ladder, frame, scope));
    if (!known) return false;
    points.push_back(*known);
  }
  note_progress(ladder, quality, points);
  report->reused += static_cast<int>(points.size());
  for (Point& point : points) report->points.push_back(std::move(point));
  return true;
}

void Conductor::measure(Ladder* ladder, int step, Report* report) {
  const SweptTechnique& technique = techniques_[ladder->technique];
  const QualityStep& quality = technique.steps[static_cast<std::size_t>(step)];
  const FrameRequest frame = request(*ladder, quality);
  const FrameRequest warm = ladder->last_ms < 300.0 ? frame : request(*ladder, technique.steps.front());
  Measurement measurement;
  try {
    studio_->renderer().finish_background_work(frame);
    measurement = measure_frames(&studio_->renderer(), frame, warm, studio_->options().repeats);
    for (const auto& [name, bake] : measurement.stats.status.own_bakes)
      if (!bake.ready) throw Error("mode " + frame.mode, "its bake " + name + " is not there", "see the first message");
  } catch (const Error& error) {
    // Some errors show only when drawing, such as a mirror that no patches fit. The others are still measured.
    report->skipped.push_back(technique.name + ", camera " + cameras_[ladder->camera].name + ": " + error.what());
    ladder->over = true;
    return;
  }
  std::vector<Point> points;
  for (const Scope scope : ladder->scopes) {
    const Judge& judge = judges_.at({cameras_[ladder->camera].name, scope});
    Image flip_map;
    Point point = judge_measurement(measurement, judge, &flip_map);
    point.camera = cameras_[ladder->camera].name;
    point.technique = technique.name;
    point.quality = quality_label(quality);
    point.scope = scope;
    point.samples = quality.samples;
    point.step = step;
    if (scope != Scope::estimator) write_pictures(measurement.pictures.front(), flip_map, judge.picture, &point);
    journal_->add_point(key_of(*ladder, frame, scope), point);
    say_(point.camera + ", " + technique.name + ", " + point.quality + ", " + scope_name(scope) + ": " +
         std::to_string(static_cast<int>(std::lround(point.time_ms.median))) + " ms, " +
         (point.relative_rmse ? percent_text(point.relative_rmse->median) : "no error figure"));
    points.push_back(point);
  }
  note_progress(ladder, quality, points);
  report->measured_now += static_cast<int>(points.size());
  for (Point& point : points) report->points.push_back(std::move(point));
}

/// The ladder ends where the error is below the reference's noise, or no longer falls.
void Conductor::note_progress(Ladder* ladder, const QualityStep& step, const std::vector<Point>& points) {
  ladder->last_ms = points.front().time_ms.median;
  ladder->last_samples = step.samples;
  bool changed = false;
  const auto differs = [](double now, double before) { return std::abs(now - before) > kSameError * before; };
  for (const Point& point : points) {
    const Ladder::Errors errors{point.relative_rmse ? point.relative_rmse->median : 0.0,
                                point.figures.flip.value_or(0.0)};
    const auto last = ladder->last_errors.find(point.scope);
    changed = changed || last == ladder->last_errors.end() || differs(errors.flip, last->second.flip) ||
              (!point.below_noise && differs(errors.relative_rmse, last->second.relative_rmse));
    ladder->last_errors[point.scope] = errors;
  }
  ladder->idle_steps = changed ? 0 : ladder->idle_steps + 1;
  ladder->over = ladder->idle_steps >= kIdleSteps;
}

void Conductor::write_pictures(const Image& radiance, const Image& flip_map, const Image& reference, Point* point) {
  const std::string base = "pictures/" + file_name_of(point->camera) + "-" + file_name_of(point->technique) + "-" +
                           file_name_of(point->quality);
  point->picture = base + ".png";
  point->difference = base + "-flip.png";
  save_png(folder_ + "/" + point->picture,
           shown(radiance, exposure_of_camera(point->camera), studio_->options().tonemap));
  ErrorReport report;
  report.flip_map = flip_map;
  save_png(folder_ + "/" + point->difference, difference_picture(report, radiance, reference));
}

}  // namespace maquette::report
