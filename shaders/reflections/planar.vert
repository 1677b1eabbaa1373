// The scene as a plane mirror shows it: seen from the mirrored eye.
layout(location = 0) in vec3 a_position;
uniform mat4 u_clip_from_world;  // mirrors first
uniform vec4 u_plane;            // towards the eye
out gl_PerVertex {
  vec4 gl_Position;
  float gl_ClipDistance[1];
};
void main() {
  gl_Position = u_clip_from_world * vec4(a_position, 1.0);
  gl_ClipDistance[0] = dot(u_plane, vec4(a_position, 1.0));
}
