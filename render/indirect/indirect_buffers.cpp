#include "render/indirect/indirect_buffers.h"

namespace maquette {

namespace {
constexpr int kPause = 2;
}  // namespace

bool IndirectBuffers::update(const IndirectJob& job) {
  if (!worker_) worker_ = std::make_unique<IndirectWorker>();
  const bool same_scene = asked_input_ == job.input && asked_visibility_ == job.visibility;
  const bool turns = same_scene && asked_ != job.sky;
  if (!same_scene || turns) {
    asked_input_ = job.input;
    asked_visibility_ = job.visibility;
    asked_ = job.sky;
    waiting_ = job;
  }
  std::optional<IndirectWorker::Result> result = worker_->take();
  if (result) done_ = Clock::now();
  const bool rested = done_ >= submitted_ && Clock::now() - done_ >= kPause * (done_ - submitted_);
  if (waiting_ && (!turns || rested)) submit(*waiting_);
  if (!result || result->bake.vertices.empty()) return false;
  words_ = Buffer::from("indirect", result->bake.vertices);
  view_ = Texture::make_buffer("indirect", GL_RGBA32UI, words_);
  sides_ = result->bake.sides;
  bias_ = result->bake.bias;
  shown_ = result->sky;
  shown_input_ = result->input;
  return true;
}

void IndirectBuffers::submit(const IndirectJob& job) {
  worker_->submit(job);
  submitted_ = Clock::now();
  waiting_.reset();
}

void IndirectBuffers::wait() {
  if (!worker_) return;
  if (waiting_) submit(*waiting_);
  worker_->wait();
}

void IndirectBuffers::clear() {
  if (worker_) worker_->cancel();
  waiting_.reset();
  asked_input_.reset();
  shown_input_.reset();
  asked_visibility_.reset();
  asked_.reset();
  shown_.reset();
  view_ = Texture();
  words_ = Buffer();
}

void IndirectBuffers::bind() const { glBindTextureUnit(45, view_.get()); }

}  // namespace maquette
