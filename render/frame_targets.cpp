#include "render/frame_targets.h"

#include <algorithm>
#include <bit>
#include <string>

#include "scenes/error.h"

namespace maquette {

std::vector<unsigned> ordered_tiles(std::vector<unsigned> tiles) {
  constexpr std::size_t kRun = 16;
  std::sort(tiles.begin(), tiles.end());
  const std::size_t half = (tiles.size() + 1) / 2;
  std::vector<unsigned> ordered;
  ordered.reserve(tiles.size());
  const auto append = [&](std::size_t first, std::size_t limit) {
    for (std::size_t i = first; i < std::min(first + kRun, limit); ++i) ordered.push_back(tiles[i]);
  };
  for (std::size_t run = 0; run < half; run += kRun) {
    append(run, half);
    append(half + run, tiles.size());
  }
  return ordered;
}

TileList FrameTargets::make_tile_list() const {
  const auto bands = static_cast<std::size_t>((grid_height() + band_rows - 1) / band_rows);
  TileList list;
  list.tiles = Buffer("tiles", bands * static_cast<std::size_t>(band_tiles()) * sizeof(unsigned));
  list.counts.assign(bands, 0);
  return list;
}

namespace {

void make_item_lists(FrameTargets* t) {
  const auto items = static_cast<std::size_t>(t->item_capacity);
  // The prediction lists its quads there (classify.comp): those of a tile, with several points a pixel one in four.
  const auto tiles = static_cast<std::size_t>((t->grid_width() + FrameTargets::kTile - 1) / FrameTargets::kTile) *
                     static_cast<std::size_t>((t->grid_height() + FrameTargets::kTile - 1) / FrameTargets::kTile);
  const std::size_t quads = t->bandwidth ? tiles * (t->side > 1 ? 4 : 16) : 0;
  for (int k = 0; k < 2; ++k) {
    t->items[k] = Buffer("work items", std::max(items, quads) * 8);
    t->partial[k] = Buffer("partial sums", items * 16);
    t->partial_view[k] = Texture::make_buffer("partial sums", GL_RGBA32F, t->partial[k]);
  }
}

}  // namespace

bool FrameTargets::grow_lists(unsigned wanted) {
  const auto capacity = static_cast<unsigned>(item_capacity), most = static_cast<unsigned>(most_items);
  if (wanted <= capacity || capacity >= most) return false;
  item_capacity = static_cast<int>(std::min(most, std::max(wanted + wanted / 4, 2 * capacity)));
  make_item_lists(this);
  return true;
}

FrameTargets make_frame_targets(int width, int height, int side, bool bandwidth, bool texture_bandwidth) {
  GLint max_size = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &max_size);
  if (width * side > max_size || height * side > max_size)
    throw Error("--size",
                std::to_string(width) + "x" + std::to_string(height) + " with " + std::to_string(side * side) +
                    " samples a pixel exceeds this driver's largest image (" + std::to_string(max_size) + ")",
                "ask for a smaller picture or fewer samples a pixel");
  FrameTargets t;
  t.width = width;
  t.height = height;
  t.side = side;
  t.bandwidth = bandwidth;
  t.texture_bandwidth = texture_bandwidth;
  const int w = t.grid_width(), h = t.grid_height();
  t.triangle = Texture::make_2d("triangle", GL_R32UI, w, h);
  t.depth_buffer = Texture::make_2d("depth buffer", GL_DEPTH_COMPONENT32F, w, h);
  GLuint framebuffer = 0;
  glCreateFramebuffers(1, &framebuffer);
  t.framebuffer = GlName<FramebufferTraits>(framebuffer);
  glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, t.triangle.get(), 0);
  glNamedFramebufferTexture(framebuffer, GL_DEPTH_ATTACHMENT, t.depth_buffer.get(), 0);
  t.surface = Texture::make_2d("surface", GL_RGBA32UI, w, h);
  t.depth = Texture::make_2d("depth", GL_R32F, w, h);
  t.guide = Texture::make_2d("guide", GL_RG32UI, w, h);
  t.marks = Texture::make_2d("marks", GL_RGBA8UI, w, h);
  t.radiance = Texture::make_2d("radiance", GL_RGBA32F, w, h);
  t.picture = Texture::make_2d("picture", GL_RGBA32F, width, height);
  if (texture_bandwidth) t.texture_nu = Texture::make_2d("texture bandwidth", GL_R32F, w, h);
  if (bandwidth) {
    const int qw = (w + 1) / 2, qh = (h + 1) / 2;
    t.energy = Texture::make_2d("energy", GL_RGBA32F, qw, qh);
    t.bend = Texture::make_2d("bend", GL_RGBA32UI, qw, qh);
    t.axes = Texture::make_2d("axes", GL_RGBA16F, qw, qh);
    const int levels = static_cast<int>(std::bit_width(static_cast<unsigned>(std::max(qw, qh))));
    t.pyramid = Texture::make_2d("pyramid", GL_RGBA32F, qw, qh, levels);
    t.weights = Texture::make_2d("upsampling weights", GL_RG32UI, w, h);
    t.open = Texture::make_2d("open to mirrors", GL_R8, w, h);
  }
  // One item a point in uniform, about eight in bandwidth (the sample counts average to the base count). The largest
  // list stays below the 128 MiB that a storage buffer may have.
  const int kBandPoints = bandwidth ? 1 << 19 : 1 << 20;
  t.band_rows = std::clamp(kBandPoints / w / 32 * 32, 32, (h + 31) / 32 * 32);
  const int band_points = w * std::min(t.band_rows, h);
  // The reflected picture is shaded by four rows at least. Frames of mode bandwidth's default counts ask for less than
  // two a point.
  t.item_capacity = std::max({(bandwidth ? 2 : 1) * band_points, 4 * kMostReflectedItems * w, 4096});
  t.most_items = std::max(bandwidth ? 10 * band_points : 0, t.item_capacity);
  const auto bands = static_cast<std::size_t>((h + t.band_rows - 1) / t.band_rows);
  t.tile_counts = Buffer("tile counts", bands * 2 * sizeof(unsigned));
  for (TileList* list : {&t.surface_tiles, &t.sky_tiles, &t.repainted_tiles}) *list = t.make_tile_list();
  if (bandwidth && side > 1) {
    const std::size_t quads = static_cast<std::size_t>(w / 2) * static_cast<std::size_t>(h / 2);
    t.plain_quads.quads = Buffer("plain quads", quads * sizeof(unsigned));
    t.mixed_quads.quads = Buffer("mixed quads", quads * sizeof(unsigned));
    t.quad_counts = Buffer("quad counts", 2 * sizeof(unsigned));
  }
  t.counters = Buffer("counters", 2 * 8 * sizeof(unsigned));
  for (Buffer& points : t.points) points = Buffer("shaded points", static_cast<std::size_t>(band_points) * 16);
  make_item_lists(&t);
  return t;
}

}  // namespace maquette
