#include "render/visibility/visibility_buffers.h"

#include <string>

#include "scenes/error.h"

namespace maquette {

bool VisibilityBuffers::update(const FlatGeometry& geometry, const std::vector<bool>& transmits,
                               const std::vector<Passage>& passages, std::uint32_t geometry_epoch) {
  if (!worker_) worker_ = std::make_unique<VisibilityWorker>();
  if (!asked_ || geometry_epoch != geometry_epoch_ || transmits != transmits_ || passages != passages_) {
    GLint max_texels = 0;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &max_texels);
    if (geometry.positions.size() * 2 * kVisibilityWords > static_cast<std::size_t>(max_texels))
      throw Error("visibility", std::to_string(geometry.positions.size()) + " vertices are more than this driver holds",
                  "set shading.visibility=none");
    VisibilityWorker::Job job;
    job.geometry.positions = geometry.positions;
    job.geometry.normals = geometry.normals;
    job.geometry.indices = geometry.indices;
    job.geometry.items = geometry.items;
    job.transmits = transmits;
    job.passages = passages;
    worker_->submit(std::move(job));
    asked_ = true;
    geometry_epoch_ = geometry_epoch;
    transmits_ = transmits;
    passages_ = passages;
  }
  std::optional<DrawnVisibility> drawn = worker_->take();
  if (!drawn || drawn->bake.vertices.empty()) return false;
  VisibilityBake* bake = &drawn->bake;
  words_ = Buffer::from("visibility", drawn->sides);
  bandwidth_ = Buffer::from("visibility bandwidth", bake->bandwidth);
  word_view_ = Texture::make_buffer("visibility", GL_R32UI, words_);
  bandwidth_view_ = Texture::make_buffer("visibility bandwidth", GL_R32F, bandwidth_);
  transmittance_ = Buffer::from("visibility transmittance", bake->transmittance);
  transmittance_view_ = Texture::make_buffer("visibility transmittance", GL_RG32F, transmittance_);
  bake_ = std::make_shared<const VisibilityBake>(std::move(*bake));
  return true;
}

void VisibilityBuffers::wait() {
  if (worker_) worker_->wait();
}

void VisibilityBuffers::clear() {
  if (worker_) worker_->cancel();
  asked_ = false;
  bake_.reset();
  word_view_ = Texture();
  bandwidth_view_ = Texture();
  words_ = Buffer();
  bandwidth_ = Buffer();
  transmittance_view_ = Texture();
  transmittance_ = Buffer();
}

void VisibilityBuffers::bind() const {
  glBindTextureUnit(25, word_view_.get());
  glBindTextureUnit(30, bandwidth_view_.get());
  glBindTextureUnit(35, transmittance_view_.get());
}

}  // namespace maquette
