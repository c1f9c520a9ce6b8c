// The four best photos of a pixel, and their colours, which are looked up when it is known which they are.

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

// The movement of a photo's position for a step of the point.
vec2 moved(Camera photo, vec2 px, float z, vec3 by) {
    return (vec2(dot(photo.row_x.xyz, by), dot(photo.row_y.xyz, by)) - px * dot(photo.row_z.xyz, by)) / z;
}

uint byte_of(float value) { return uint(value * 255.0 + 0.5); }
