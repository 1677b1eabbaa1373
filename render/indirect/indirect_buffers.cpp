#include "render/indirect/indirect_buffers.h"

namespace maquette {

bool IndirectBuffers::update(const IndirectJob& job) {
  if (!worker_) worker_ = std::make_unique<IndirectWorker>();
  if (asked_input_ != job.input || asked_visibility_ != job.visibility || asked_ != job.sky) {
    asked_input_ = job.input;
    asked_visibility_ = job.visibility;
    asked_ = job.sky;
    worker_->submit(job);
  }
  std::optional<IndirectWorker::Result> result = worker_->take();
  if (!result || result->bake.vertices.empty()) return false;
  words_ = Buffer::from("indirect", result->bake.vertices);
  view_ = Texture::make_buffer("indirect", GL_RGBA32UI, words_);
  sides_ = result->bake.sides;
  bias_ = result->bake.bias;
  shown_ = result->sky;
  shown_input_ = result->input;
  return true;
}

void IndirectBuffers::wait() {
  if (worker_) worker_->wait();
}

void IndirectBuffers::clear() {
  if (worker_) worker_->cancel();
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
