#pragma once

#include "render/gl/objects.h"
#include "render/lights/light_list.h"

namespace maquette {

/// The sampled lights on the GPU: one LightRecord is four texels.
class LightBuffers {
 public:
  explicit LightBuffers(const LightList& list)
      : count_(static_cast<int>(list.lights.size())),
        buffer_(Buffer::from("lights", list.lights)),
        view_(Texture::make_buffer("lights", GL_RGBA32F, buffer_)) {}
  int count() const { return count_; }
  void bind() const { glBindTextureUnit(27, view_.get()); }
  std::size_t bytes() const { return buffer_.bytes(); }

 private:
  int count_ = 0;
  Buffer buffer_;
  Texture view_;
};

}  // namespace maquette
