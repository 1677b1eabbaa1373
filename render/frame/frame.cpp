#include "render/frame/frame.h"

#include <algorithm>
#include <cassert>
#include <set>

namespace maquette {

namespace {

constexpr const char* kUnchanged = "nothing that it depends on has changed";

#ifndef NDEBUG
/// What a pass reads was written by one before it, in this frame or, if that was skipped, in an earlier one.
bool reads_are_written(const std::vector<PlannedPass>& planned) {
  std::set<std::string> written, ever;
  for (const PlannedPass& pass : planned) ever.insert(pass.writes.begin(), pass.writes.end());
  for (const PlannedPass& pass : planned) {
    for (const std::string& resource : pass.reads)
      if (ever.contains(resource) && !written.contains(resource)) return false;
    written.insert(pass.writes.begin(), pass.writes.end());
  }
  return true;
}
#endif

}  // namespace

void Frame::begin(bool software) {
  timer_.emplace(software);
  timer_->start();
  skipped_.clear();
}

void Frame::skip(const std::string& name, const std::string& why) { skipped_.push_back({name, why, layer_}); }

void Frame::carry_out(const Pass& pass) {
  timer_->set_layer(pass.layer);
  std::string why = pass.skip ? pass.skip() : std::string();
  const Id id(pass.names.front(), pass.layer);
  const auto known = keys_.find(id);
  std::optional<Key> key;
  if (why.empty() && pass.key) key = pass.key();
  if (key && !pass.always && known != keys_.end() && known->second == *key) why = kUnchanged;
  if (!why.empty()) {
    for (const std::string& name : pass.names) skip(name, why);
    return;
  }
  if (known != keys_.end()) keys_.erase(known);  // should it fail, it has not run
  pass.run();
  if (pass.names.size() == 1) timer_->end(pass.names.front());
  if (key) keys_.emplace(id, *key);
}

void Frame::run(const std::vector<PlannedPass>& planned, const std::vector<Pass>& passes,
                const std::function<void(int)>& enter_layer) {
  assert(reads_are_written(planned));
  std::set<const Pass*> done;
  timer_->begin_run();
  for (const PlannedPass& step : planned) {
    const auto pass = std::find_if(passes.begin(), passes.end(), [&](const Pass& p) {
      return p.layer == step.layer && std::find(p.names.begin(), p.names.end(), step.name) != p.names.end();
    });
    assert(pass != passes.end() && "a planned pass that nothing carries out");
    if (pass == passes.end() || !done.insert(&*pass).second) continue;
    if (step.layer != layer_) enter_layer(step.layer);
    layer_ = step.layer;
    carry_out(*pass);
  }
  layer_ = -1;
}

FrameRecord Frame::finish() {
  FrameRecord record{timer_->finish(), {}};
  for (SkippedPass& pass : skipped_) {
    const bool ran = std::any_of(record.times.begin(), record.times.end(), [&](const PassTime& time) {
      return time.name == pass.name && time.layer == pass.layer;
    });
    if (!ran) record.skipped.push_back(std::move(pass));
  }
  skipped_.clear();
  return record;
}

}  // namespace maquette
