// What the shaders read of the view, the photos, and the servers of surfaces (tables.js writes it).

// The view: rows of its rotation, focal lengths and principal point in pixels, size in pixels, fx fy.
uniform vec3 right;
uniform vec3 down;
uniform vec3 forward;
uniform vec4 lens;
uniform vec2 view_size;
// How many pixels of the view a pixel of this picture stands for.
uniform float finer;
// The falloff of the view's lens, by the squared tangent of the angle to the axis and by its square, and the largest such tangent.
uniform vec3 falloff;
// The weight of an octave in radians.
uniform float lambda;
// The factors on light in the common exposure, and on the sky.
uniform vec3 of_common;
uniform vec3 of_sky;
// The first candidate of the surroundings, their number, 1 / their scale, and whether there is anything around.
uniform vec4 around_list;
// The light that white in the dome's picture stands for; 0 without a dome.
uniform float dome_white;

uniform highp sampler2D photos;
uniform highp usampler2D servers;
uniform highp sampler2D candidates;

// Where a photo is, which is all that is needed until it is known that it shows something.
struct Camera {
    vec4 row_x;
    vec4 row_y;
    vec4 row_z;
    // The centre relative to the viewpoint, and fx fy.
    vec4 center;
    // Size in pixels, 1 over the width of the border ramp, which is negative where the picture is turned, and the light added everywhere.
    vec4 size;
};

// What is needed of the colours of a photo.
struct Look {
    // The exposure factor, and how far the view has left the photo.
    vec4 gain;
    // Principal point and falloff.
    vec4 optics;
    // One more than its number among the factors to one sky, their share, and how far the fine picture is shown.
    vec4 state;
};

vec4 photo_word(uint photo, int word) {
    return texelFetch(photos, ivec2(word, int(photo)), 0);
}

Camera camera_at(uint photo) {
    return Camera(photo_word(photo, 0), photo_word(photo, 1), photo_word(photo, 2), photo_word(photo, 3), photo_word(photo, 4));
}

Look look_at(uint photo) {
    return Look(photo_word(photo, 5), photo_word(photo, 6), photo_word(photo, 7));
}

uvec4 server_word(uint at) {
    return texelFetch(servers, ivec2(at & 1023u, at >> 10), 0);
}

vec2 candidate_at(uint at) {
    return texelFetch(candidates, ivec2(at & 1023u, at >> 10), 0).xy;
}

// A server: x: photo, flags from bit 16 on, and its number of half planes from bit 24 on; y: place of its labels; z and w: places of its
// tiles, hidden ones and those of layers that one sees through, 0 without. The half planes follow.
const uint BACK = 1u << 16;
const uint PINNED = 2u << 16;

// The ray through a position of the picture, from its upper left corner, with a depth of 1.
vec3 ray_through(vec2 at) {
    return right * ((at.x - lens.z) / lens.x) + down * ((at.y - lens.w) / lens.y) + forward;
}

vec2 position() {
    return vec2(gl_FragCoord.x, view_size.y - gl_FragCoord.y);
}

// The factor by which the view's lens darkens this pixel.
float lens_here() {
    vec2 from_axis = position() - lens.zw;
    float t2 = min(dot(from_axis, from_axis) / (lens.x * lens.y), falloff.z);
    return exp((falloff.x + falloff.y * t2) * t2);
}
