// The four best photos of a pixel, and their colours, which are looked up when it is known which they are.

const float WHITE_FROM = 0.88, WHITE_CERTAIN = 0.97;
const int BEST = 4;

struct Best {
    float q[BEST];
    uint server[BEST];
    // The position in the photo.
    vec2 px[BEST];
    // Its kind, and 8 bits each of agreement and of what shows the face.
    uvec3 known[BEST];
    float next;
};

Best no_best() {
    Best best;
    for (int i = 0; i < BEST; i++) { best.q[i] = INFINITE; best.server[i] = 0u; }
    best.next = INFINITE;
    return best;
}

// Adds a server; the sort is stable.
void join(inout Best best, float q, uint server, vec2 px, uvec3 known) {
    if (q >= best.next) return;
    if (q >= best.q[BEST - 1]) { best.next = q; return; }
    best.next = best.q[BEST - 1];
    int at = BEST - 1;
    for (int i = BEST - 1; i > 0; i--) {
        if (q >= best.q[i - 1]) break;
        best.q[i] = best.q[i - 1];
        best.server[i] = best.server[i - 1];
        best.px[i] = best.px[i - 1];
        best.known[i] = best.known[i - 1];
        at = i - 1;
    }
    best.q[at] = q;
    best.server[at] = server;
    best.px[at] = px;
    best.known[at] = known;
}

// The k-th best becomes the next one: impostors are blended of three.
void fewer(inout Best best) {
    best.next = min(best.next, best.q[BEST - 1]);
    best.q[BEST - 1] = INFINITE;
}

float share_of(Best best, int i) {
    // Scaled by the least penalty, so that no square overflows.
    return best.q[i] >= INFINITE ? 0.0 : raw_weight(best.q[i] / best.q[0], best.next / best.q[0]);
}

// Removes what the photo's camera adds and takes, and exposes as the view.
vec3 exposed(Camera photo, Look look, vec4 texel, vec2 px) {
    vec2 from_axis = px - look.optics.xy;
    float r2 = dot(from_axis, from_axis);
    vec3 light = texel.rgb;
    if (photo.size.w != 0.0) light = max(light - photo.size.w * texel.a, min(light, vec3(1.5e-4 * texel.a)));
    return light * exp(-(look.optics.z + look.optics.w * r2) * r2) * (look.gain.rgb * lens_here());
}

// What is stored as white, which was at least as bright, stays so.
vec3 kept_white(vec4 texel, vec3 light) {
    float darkest = min(min(texel.r, texel.g), texel.b) / max(texel.a, 1e-3);
    return light + smoothstep(WHITE_FROM, WHITE_CERTAIN, darkest) * max(texel.rgb - light, vec3(0.0));
}

// The movement of a photo's position for a step of the point.
vec2 moved(Camera photo, vec2 px, float z, vec3 by) {
    return (vec2(dot(photo.row_x.xyz, by), dot(photo.row_y.xyz, by)) - px * dot(photo.row_z.xyz, by)) / z;
}

uint byte_of(float value) { return uint(value * 255.0 + 0.5); }
