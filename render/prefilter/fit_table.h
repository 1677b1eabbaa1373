#pragma once

#include <string>
#include <utility>
#include <vector>

#include "render/gl/bindings.h"
#include "render/gl/objects.h"

namespace maquette {

/// The lobes fitted to measured materials, as texels in the order of their slots.
class FitTable {
 public:
  explicit FitTable(std::string label) : label_(std::move(label)) {}
  /// Adds the slots up to `count`: `append(slot, texels)` appends those of one.
  template <typename Append>
  void update(std::size_t count, const Append& append) {
    if (count == slots_) return;
    for (; slots_ < count; ++slots_) append(static_cast<int>(slots_), &texels_);
    buffer_ = Buffer::from(label_, texels_);
    view_ = Texture::make_buffer(label_, GL_RGBA32F, buffer_);
  }
  void bind() const {
    if (view_) glBindTextureUnit(kUnitLobeFits, view_.get());
  }
  std::size_t bytes() const { return buffer_.bytes(); }

 private:
  std::string label_;
  std::vector<glm::vec4> texels_;
  Buffer buffer_;
  Texture view_;
  std::size_t slots_ = 0;
};

}  // namespace maquette
