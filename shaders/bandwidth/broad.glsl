/// A lobe is broad up to this bandwidth, cycles/rad: at most a third of a cycle over 8 degrees. The library's leathers, fabrics, matte plastics
/// and rubbers are below it (at most 2.3); satin wood, paints and metals are above.
const float kBroad = 2.5;

/// `surface`: of the G-buffer; `flags`: first word of its material's record 6.
bool is_broad(uvec4 surface, uint flags, bool measured) {
  float roughness = unpack_roughness(surface.z);
  bool coated = material_floats(int(surface.z >> 16u), 3).x > 0.0;
  return measured ? unpackHalf2x16(flags).y <= kBroad
                  : bandwidth_ggx(max(roughness * roughness, 1e-3)) <= kBroad && !coated;
}
