#include "render/visibility/visibility_buffers.h"

#include <string>

#include "render/gl/bindings.h"
#include "scenes/error.h"

namespace maquette {

namespace {

VisibilityJob make_job(const FlatGeometry& geometry, const std::vector<bool>& transmits,
                       const std::vector<Passage>& passages) {
  VisibilityJob job;
  job.geometry.positions = geometry.positions;
  job.geometry.normals = geometry.normals;
  job.geometry.indices = geometry.indices;
  job.geometry.items = geometry.items;
  job.transmits = transmits;
  job.passages = passages;
  return job;
}

}  // namespace

std::string VisibilityBuffers::key(const FlatGeometry& geometry, const std::vector<bool>& transmits,
                                   const std::vector<Passage>& passages) const {
  return kind().key(make_job(geometry, transmits, passages));
}

bool VisibilityBuffers::update(const FlatGeometry& geometry, const std::vector<bool>& transmits,
                               const std::vector<Passage>& passages, std::uint32_t geometry_epoch) {
  require({geometry_epoch, transmits, passages}, [&] {
    GLint max_texels = 0;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &max_texels);
    if (geometry.positions.size() * 2 * kVisibilityWords > static_cast<std::size_t>(max_texels))
      throw Error("visibility", std::to_string(geometry.positions.size()) + " vertices are more than this driver holds",
                  "set shading.visibility=none");
    return make_job(geometry, transmits, passages);
  });
  const std::shared_ptr<const DrawnVisibility> drawn = take();
  if (!drawn || drawn->bake->vertices.empty()) return false;
  bake_ = drawn->bake;
  words_ = Buffer::from("visibility", drawn->sides);
  bandwidth_ = Buffer::from("visibility bandwidth", bake_->bandwidth);
  word_view_ = Texture::make_buffer("visibility", GL_R32UI, words_);
  bandwidth_view_ = Texture::make_buffer("visibility bandwidth", GL_R32F, bandwidth_);
  transmittance_ = Buffer::from("visibility transmittance", bake_->transmittance);
  transmittance_view_ = Texture::make_buffer("visibility transmittance", GL_RG32F, transmittance_);
  return true;
}

void VisibilityBuffers::clear() {
  cancel();
  bake_.reset();
  word_view_ = Texture();
  bandwidth_view_ = Texture();
  words_ = Buffer();
  bandwidth_ = Buffer();
  transmittance_view_ = Texture();
  transmittance_ = Buffer();
}

void VisibilityBuffers::bind() const {
  glBindTextureUnit(kUnitVisibility, word_view_.get());
  glBindTextureUnit(kUnitVisibilityBandwidth, bandwidth_view_.get());
  glBindTextureUnit(kUnitTransmittance, transmittance_view_.get());
}

}  // namespace maquette
