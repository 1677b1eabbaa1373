// What the second image of a pane may show beside the first (render/reflections/reflector_technique.h).
#ifndef GHOST_REACH
#define GHOST_REACH
uniform vec2 u_ghost;  // m at the ray's origin, m more for each m along it; 0 for what the front mirrors
float ghost_reach(float along_m) { return u_ghost.x + u_ghost.y * along_m; }
/// Of first order are the places on screen that follow from it.
const float kGhostSlack = 1.5;
#endif
