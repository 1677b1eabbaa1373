#include "render/indirect/indirect_buffers.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace maquette {

namespace {
/// Bakes of a rotating environment are no closer: a cell of the visibility maps, between whose middles visibility is
/// linear.
constexpr float kKeySpacing_rad = 0.2f;
/// Nobody knows where a light goes next that leaps so far from frame to frame.
constexpr float kLeap_rad = 0.5f;
/// While the environment rotates, the worker rests for so many times as many frames as a bake took: frames need the
/// processors more than indirect light needs to be of this very moment.
constexpr int kRest = 1;
/// Frames that a bake is taken to need at most.
constexpr int kSlowest = 16;

float turn_between(const IndirectSky& from, const IndirectSky& to) {
  return std::remainder(to.rotation_rad - from.rotation_rad, 2.0f * std::numbers::pi_v<float>);
}
bool differ_by_turn(const IndirectSky& a, const IndirectSky& b) {
  return a.environment == b.environment && a.scale == b.scale;
}
}  // namespace

bool IndirectBuffers::update(const IndirectJob& job) {
  const bool same_scene = asked_input_ == job.input && asked_visibility_ == job.visibility;
  const bool turns = same_scene && asked_ && differ_by_turn(*asked_, job.sky);
  const float turn_rad = turns ? turn_between(*asked_, job.sky) : 0.0f;
  asked_input_ = job.input;
  asked_visibility_ = job.visibility;
  asked_ = job.sky;
  ++frames_;
  const std::uint32_t before = serial_;
  take_result();
  if (!turns)
    submit_sky(asked_->rotation_rad, IndirectBounces::all);
  else if (turn_rad == 0.0f)
    settle();
  else if (!BakeRunner::busy())
    follow(turn_rad);
  return serial_ != before;
}

void IndirectBuffers::take_result() {
  const std::shared_ptr<const IndirectResult> result = take();
  if (!result) return;
  // A first bake traces rays for seconds: it says nothing about those of a rotating environment.
  if (result->bounces == IndirectBounces::step) latency_ = std::min(frames_, kSlowest);
  if (result->bake.vertices.empty()) return;
  IndirectKey key;
  key.sky = result->sky;
  key.bounces = result->bounces;
  key.input = result->input;
  key.words = Buffer::from("indirect", result->bake.vertices);
  key.view = Texture::make_buffer("indirect", GL_RGBA32UI, key.words);
  key.sides = result->bake.sides;
  key.bias = result->bake.bias;
  key.serial = ++serial_;
  // Light of other surfaces, of another sky or at rest stands alone.
  if (key.bounces == IndirectBounces::all || (ready() && !differ_by_turn(keys_.back().sky, key.sky))) keys_.clear();
  if (keys_.size() > 1) keys_.erase(keys_.begin());
  keys_.push_back(std::move(key));
}

void IndirectBuffers::follow(float turn_rad) {
  const int every = (1 + kRest) * latency_;
  if (frames_ < every) return;
  if (std::abs(turn_rad) > kLeap_rad) {
    submit_sky(asked_->rotation_rad, IndirectBounces::step);
    return;
  }
  // Where the light stands when the bake after this one is done: until then the picture lies between both.
  const float ahead_rad = static_cast<float>(latency_ + every) * turn_rad;
  IndirectSky goal = *asked_;
  goal.rotation_rad += ahead_rad;
  const float left_rad = submitted_ ? turn_between(*submitted_, goal) : ahead_rad;
  if (std::abs(left_rad) < kKeySpacing_rad) return;
  submit_sky(goal.rotation_rad, IndirectBounces::step);
}

void IndirectBuffers::settle() {
  if (submitted_ != asked_ || submitted_bounces_ == IndirectBounces::step)
    submit_sky(asked_->rotation_rad, IndirectBounces::all);
  else if (prepares_ && current() && prepared_ != asked_input_ && !BakeRunner::busy())
    submit_sky(asked_->rotation_rad, IndirectBounces::none);
}

void IndirectBuffers::submit_sky(float rotation_rad, IndirectBounces bounces) {
  submitted_ = asked_;
  submitted_->rotation_rad = rotation_rad;
  submitted_bounces_ = bounces;
  frames_ = 0;
  if (bounces != IndirectBounces::all) prepared_ = asked_input_;
  submit({asked_input_, asked_visibility_, *submitted_, bounces});
}

void IndirectBuffers::wait() {
  if (!asked_) return;
  settle();
  BakeRunner::wait();
}

bool IndirectBuffers::current() const {
  return ready() && keys_.back().bounces == IndirectBounces::all && keys_.back().sky == asked_ &&
         keys_.back().input == asked_input_;
}

float IndirectBuffers::blend() const {
  if (keys_.size() < 2 || !asked_) return 1.0f;
  const float whole = turn_between(keys_[0].sky, keys_[1].sky), part = turn_between(keys_[0].sky, *asked_);
  return whole == 0.0f ? 1.0f : std::clamp(part / whole, 0.0f, 1.0f);
}

std::size_t IndirectBuffers::bytes() const {
  std::size_t sum = 0;
  for (const IndirectKey& key : keys_) sum += key.words.bytes();
  return sum;
}

void IndirectBuffers::clear() {
  cancel();
  keys_.clear();
  asked_input_.reset();
  asked_visibility_.reset();
  asked_.reset();
}

}  // namespace maquette
