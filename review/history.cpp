#include "review/history.h"

#include <algorithm>
#include <stdexcept>

namespace maquette {

using Json = nlohmann::json;

namespace {

bool is_camera_move(const Json& patch) {
  return std::all_of(patch.begin(), patch.end(), [](const Json& operation) {
    return operation.at("path").get<std::string>().starts_with("/look/camera");
  });
}

}  // namespace

void History::push(Step step) {
  steps_.resize(done_);
  steps_.push_back(std::move(step));
  if (steps_.size() > kDepth) steps_.pop_front();
  done_ = steps_.size();
}

namespace {

/// Two patches, and a third entry where the step is apart.
Json pair_of(const Json& forward, const Json& backward, bool apart) {
  Json pair = {forward, backward};
  if (apart) pair.push_back(true);
  return pair;
}

}  // namespace

void History::record(const Json& now, bool apart) {
  if (now == document_) return;
  Step step{Json::diff(document_, now), Json::diff(now, document_), apart};
  step.camera = is_camera_move(step.forward) && !apart;
  const bool continues = step.camera && done_ > 0 && done_ == steps_.size() && steps_[done_ - 1].camera;
  if (continues) return amend(now);
  document_ = now;
  emit({{"step", pair_of(step.forward, step.backward, apart)}});
  push(std::move(step));
}

void History::amend(const Json& now) {
  if (now == document_) return;
  if (done_ == 0) {
    steps_.clear();
    document_ = now;
    emit({{"document", now}});
  } else {
    const Json before = document_.patch(steps_[done_ - 1].backward);
    if (now == before) {
      document_ = before;
      steps_.resize(--done_);
      return emit({{"drop", 1}});
    }
    Step step{Json::diff(before, now), Json::diff(now, before), steps_[done_ - 1].apart};
    step.camera = is_camera_move(step.forward) && !step.apart;
    document_ = now;
    emit({{"instead", pair_of(step.forward, step.backward, step.apart)}});
    --done_;
    push(std::move(step));
  }
}

bool History::undo() {
  if (!can_undo()) return false;
  document_ = document_.patch(steps_[--done_].backward);
  emit({{"undo", 1}});
  return true;
}

bool History::redo() {
  if (!can_redo()) return false;
  document_ = document_.patch(steps_[done_++].forward);
  emit({{"redo", 1}});
  return true;
}

void History::follow(const Json& record) {
  const auto step_of = [](const Json& pair) {
    Step step{pair.at(0), pair.at(1), pair.size() > 2};
    step.camera = is_camera_move(step.forward) && !step.apart;
    return step;
  };
  if (record.contains("step")) {
    Step step = step_of(record.at("step"));
    document_ = document_.patch(step.forward);
    push(std::move(step));
  } else if (record.contains("instead")) {
    Step step = step_of(record.at("instead"));
    if (done_ == 0) throw std::runtime_error("a step is missing");
    document_ = document_.patch(steps_[done_ - 1].backward).patch(step.forward);
    --done_;
    push(std::move(step));
  } else if (record.contains("document")) {
    document_ = record.at("document");
    steps_.clear();
    done_ = 0;
  } else if (record.contains("drop")) {
    if (!undo()) throw std::runtime_error("there is nothing to drop");
    steps_.resize(done_);
  } else if (record.contains("undo")) {
    if (!undo()) throw std::runtime_error("there is nothing to undo");
  } else if (record.contains("redo")) {
    if (!redo()) throw std::runtime_error("there is nothing to redo");
  }
}

std::vector<Json> History::records(Json* first_document) const {
  *first_document = document_;
  for (std::size_t i = done_; i-- > 0;) *first_document = first_document->patch(steps_[i].backward);
  std::vector<Json> all;
  for (const Step& step : steps_) all.push_back({{"step", pair_of(step.forward, step.backward, step.apart)}});
  for (std::size_t i = 0; i < redo_count(); ++i) all.push_back({{"undo", 1}});
  return all;
}

}  // namespace maquette
