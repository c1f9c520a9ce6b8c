// A level of a texture from the one before: the mean of what it covers there, in linear light.
uniform mediump sampler2DArray finer;
uniform float layer;
uniform vec2 size;
out vec4 color;

void main() {
    color = texture(finer, vec3(gl_FragCoord.xy / size, layer));
}
