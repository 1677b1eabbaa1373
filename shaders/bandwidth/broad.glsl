/// A lobe is broad up to this bandwidth, cycles/rad: at most a third of a cycle over 8 degrees. The library's leathers, fabrics, matte plastics
/// and rubbers are below it (at most 2.3); satin wood, paints and metals are above.
const float kBroad = 2.5;

/// `surface`: of the G-buffer; `flags`: first word of its material's record 6.
bool is_broad(uvec4 surface, uint flags, bool measured) {
  float roughness = float(surface.z & 255u) * (1.0 / 255.0);
  bool coated = ((surface.z >> 8u) & 255u) != 0u;
  return measured ? unpackHalf2x16(flags).y <= kBroad
                  : bandwidth_ggx(max(roughness * roughness, 1e-3)) <= kBroad && !coated;
}
