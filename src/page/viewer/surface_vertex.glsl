// The corners of surfaces. All fragments of a pass get the same depths as those of the first one.
layout(location = 0) in vec3 corner;
layout(location = 1) in float patch_number;

uniform vec3 right;
uniform vec3 down;
uniform vec3 forward;
uniform vec4 lens;
uniform vec2 view_size;
// The viewpoint as a sum of two single numbers.
uniform vec3 eye_high;
uniform vec3 eye_low;
uniform float near;
// Whether everything is drawn at infinite depth.
uniform bool at_infinity;
uniform highp sampler2D patches;

flat out ivec2 row;
flat out vec2 range;

invariant gl_Position;

void main() {
    vec3 p = (corner - eye_high) - eye_low;
    float z = dot(forward, p);
    float x = 2.0 * (lens.x * dot(right, p) + lens.z * z) / view_size.x - z;
    float y = z - 2.0 * (lens.y * dot(down, p) + lens.w * z) / view_size.y;
    gl_Position = vec4(x, y, at_infinity ? z : z - 2.0 * near, z);
    int number = int(patch_number);
    vec4 of_patch = texelFetch(patches, ivec2(number & 1023, number >> 10), 0);
    row = ivec2(int(of_patch.x) & 127, int(of_patch.x) >> 7);
    range = of_patch.yz;
}
