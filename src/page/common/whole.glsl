// A triangle over the whole picture, behind everything.
void main() {
    vec2 at = vec2(float((gl_VertexID << 1) & 2), float(gl_VertexID & 2)) * 2.0 - 1.0;
    gl_Position = vec4(at, 1.0, 1.0);
}
