#version 300 es
// One triangle that holds the whole picture.
out vec2 position;

void main() {
  position = vec2(gl_VertexID == 1 ? 2.0 : 0.0, gl_VertexID == 2 ? 2.0 : 0.0);
  gl_Position = vec4(2.0 * position - 1.0, 0.0, 1.0);
}
