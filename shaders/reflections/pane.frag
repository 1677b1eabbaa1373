uniform int u_first_triangle;
uniform int u_reflector;
layout(early_fragment_tests) in;
layout(location = 0) out uvec2 o_pane;
void main() { o_pane = uvec2(uint(u_first_triangle + gl_PrimitiveID + 1), uint(u_reflector + 1)); }
