// Surface of a material before its textures. Needs gbuffer and material_table.
Surface surface_of_material(int material, vec3 normal) {
  vec4 m1 = material_floats(material, 1), m3 = material_floats(material, 3);
  Surface s;
  s.normal = normal;
  s.base_color = material_floats(material, 0).rgb;
  s.metallic = m1.x;
  s.roughness = m1.y;
  s.clearcoat = m3.x;
  s.material = material;
#if DETAILS
  vec4 m4 = material_floats(material, 4), m5 = material_floats(material, 5), m7 = material_floats(material, 7);
  s.occlusion = 1.0;
  s.coat_normal = normal;
  s.coat_roughness = m3.y;
  s.specular = m3.z;
  s.specular_color = m4.rgb;
  s.sheen_color = m5.rgb;
  s.sheen_roughness = m4.w;
  s.anisotropy = m5.w;
  s.along = tangent_basis(normal).t;
  s.film = m7.x;
  s.film_nm = m7.w;
#endif
  return s;
}

#if DETAILS
layout(binding = kImageDetails, rgba32ui) uniform writeonly uimage2DArray o_details;
void store_details(ivec2 pixel, Surface s) {
  Details details = pack_details(s);
  imageStore(o_details, ivec3(pixel, 0), details.lobes);
  imageStore(o_details, ivec3(pixel, 1), details.shapes);
}
#endif
