// Colours are decoded to linear light by the texture unit, before they are filtered.
uniform sampler2D colours;
// How much of a texel the segment covers, and its opacity where it is covered.
uniform sampler2D rims;
in vec2 place;
out vec4 shown;

void main() {
    vec2 rim = texture(rims, place).rg;
    if (rim.r < 0.03) discard;
    // Colours are finer than the device would choose: the photo's grain is part of them, and several samples a pixel smooth the rest.
    // A quarter of a pixel covers it, as in `ldi render`.
    shown = vec4(texture(colours, place, -0.7).rgb, min(1.0, 4.0 * rim.r) * min(1.0, rim.g / rim.r));
}
