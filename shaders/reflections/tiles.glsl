// Sizes of tiles, px: kTile for the lists of offered triangles, kFarTile for bounds of rays.
const int kTile = 4, kFarTile = 8;
int tile_columns(ivec2 size) { return (size.x + kTile - 1) / kTile; }
/// Number of low bits of a pixel's entry that hold the effort; the others hold the triangle.
const uint kEffortBits = 7u;
