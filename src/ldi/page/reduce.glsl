#version 300 es
precision highp float;
// What was drawn, decoded to linear light by the texture unit; and how far from the middle of a pixel it is looked up.
uniform sampler2D drawn;
uniform vec2 apart;
in vec2 position;
out vec4 shown;

#include encoded
void main() {
  vec3 light = vec3(0.0);
  for (int i = 0; i < 4; i++) {
    vec2 corner = vec2(i % 2, i / 2) * 2.0 - 1.0;
    light += 0.25 * texture(drawn, position + corner * apart).rgb;
  }
  shown = vec4(encoded(light), 1.0);
}
