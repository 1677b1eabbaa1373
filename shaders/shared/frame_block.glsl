// Constants of one frame; std140, the same struct in GLSL and in C++ (render/frame/frame_constants.h asserts the offsets).
// A pixel's ray is forward + ndc_x * right + ndc_y * up (right and up scaled by the field of view), so that the
// parameter along it is the depth along the viewing axis. Parallel rays are forward and start at ndc_x * right + ndc_y * up.
struct FrameConstants {
  mat4 clip_from_world;
  vec4 eye;            // xyz, m; w: 1, or 0 where the rays are parallel
  vec4 forward;        // xyz unit; w: angle of one pixel at the centre, rad; of parallel rays its width, m
  vec4 right;          // xyz
  vec4 up;             // xyz
  vec4 environment;    // cos and sin of the rotation, scale (cd/m2 per stored unit), integral of luminance (stored units * sr)
  ivec4 size;          // shading grid width, height; side of the sample grid in a pixel (1, 2, 4); coarsest level
  ivec4 sampling;      // samples a point, samples a work item, first sample index of the frame, seed
  ivec4 environment_size;  // texels width, height; log2 scale of the packed texels; light sample list length
  ivec4 bandwidth_size;    // nu_L map width, height; number of lights; 0
  ivec4 sky_nodes;     // columns, spans between rows, last row, 1: nodes are the texels' centres (render/environment/packed_sky.h)
  vec4 section;        // xyz unit, w m: points p with dot(xyz, p) > w are not drawn; 0, 0, 0, 1: all are
  vec4 quality;        // x: bandwidth.quality, sharpened with the samples; w: luminance amid suns, stored units
};
