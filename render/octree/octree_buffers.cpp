#include "render/octree/octree_buffers.h"

#include <algorithm>
#include <cmath>

#include "render/gl/bindings.h"
#include "scenes/error.h"

namespace maquette {

namespace {

Buffer make_words(const std::string& label, std::vector<std::uint32_t> words) {
  if (words.empty()) words.push_back(0u);
  return Buffer::from(label, words);
}

}  // namespace

OctreeBuffers::OctreeBuffers(const Octree& octree) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most);
  if (octree.node_count() > static_cast<std::size_t>(most))
    throw Error("octree",
                std::to_string(octree.node_count()) + " nodes are more than this driver can address (" +
                    std::to_string(most) + ")",
                "lower octree.depth");
  // A tree without nodes is a root without children: every ray passes.
  words_ = make_words("octree words", octree.words);
  planes_ = make_words("octree planes", octree.planes);
  colors_ = make_words("octree colours", octree.colors);
  triangles_ = make_words("octree triangles", octree.triangles);
  word_view_ = Texture::make_buffer("octree words", GL_R32UI, words_);
  plane_view_ = Texture::make_buffer("octree planes", GL_R32UI, planes_);
  color_view_ = Texture::make_buffer("octree colours", GL_R32UI, colors_);
  triangle_view_ = Texture::make_buffer("octree triangles", GL_R32UI, triangles_);
  depth_ = std::max(octree.depth, 1);
  detail_ = std::min(octree.detail, octree.depth);
  grid_ = glm::vec4(octree.corner, std::exp2(static_cast<float>(depth_)) / octree.side_m);
}

void OctreeBuffers::bind() const {
  glBindTextureUnit(kUnitOctree, word_view_.get());
  glBindTextureUnit(kUnitOctreePlanes, plane_view_.get());
  glBindTextureUnit(kUnitOctreeColors, color_view_.get());
}

void OctreeBuffers::bind_triangles() const { glBindTextureUnit(kUnitOctreeTriangles, triangle_view_.get()); }

void OctreeBuffers::set_uniforms(const Program& program) const {
  glProgramUniform4f(program.get(), program.location("u_octree"), grid_.x, grid_.y, grid_.z, grid_.w);
  program.set("u_octree_depth", depth_);
  program.set("u_octree_detail", detail_);
}

}  // namespace maquette
