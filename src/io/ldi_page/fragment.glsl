#version 300 es
precision highp float;
// Colours are decoded to linear light by the texture unit, before they are filtered.
uniform sampler2D colours;
// How much of a texel the segment covers, and its opacity where it is covered.
uniform sampler2D rims;
in vec2 place;
out vec4 shown;

float encoded(float light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1.0 / 2.4) - 0.055;
}

void main() {
  // Finer than the device would choose: the photo's grain is part of it, and several samples a pixel smooth the rest.
  vec2 rim = texture(rims, place, -0.7).rg;
  if (rim.r < 0.03) discard;
  vec3 light = texture(colours, place, -0.7).rgb;
  // A quarter of a pixel covers it, as in `ldi render`.
  float alpha = min(1.0, 4.0 * rim.r) * min(1.0, rim.g / rim.r);
  shown = vec4(encoded(light.r), encoded(light.g), encoded(light.b), alpha);
}
