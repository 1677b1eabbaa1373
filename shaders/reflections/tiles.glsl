// How pixels are gathered, px: tiles that offered triangles are listed by, and tiles whose rays are taken together.
const int kTile = 4, kFarTile = 8;
int tile_columns(ivec2 size) { return (size.x + kTile - 1) / kTile; }
/// Low bits of a pixel's entry, beside the triangle.
const uint kEffortBits = 7u;
