// How far the second image of a pane may be from the first (render/reflections/reflector_technique.h).
#ifndef GHOST_OFFSET
#define GHOST_OFFSET
uniform vec2 u_ghost;  // m at the ray's origin, additional m for each m along it; 0 for the image of the front face
float ghost_offset(float along_m) { return u_ghost.x + u_ghost.y * along_m; }
/// Positions on screen are computed from it to first order only; this factor covers the rest.
const float kGhostSlack = 1.5;
#endif
