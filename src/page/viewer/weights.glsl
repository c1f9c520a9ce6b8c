// The weights of photos, as in shaders/weights.wgsl, with the same formulas in the same order.

const float LEAST_ANGLE = 1e-6;
const float OTHER_SIDE = 1000.0;
const float INFINITE = 3e38;

// atan for 0..1: an odd minimax polynomial with an error of at most 2e-6 (Abramowitz & Stegun 4.4.49, its form).
float atan_of_unit(float x) {
    float s = x * x;
    float odd = ((((0.0208351 * s - 0.0851330) * s + 0.1801410) * s - 0.3302995) * s + 0.9998660);
    return x * odd;
}

// The angle between two directions of any length, in radians, from sine and cosine.
float angle_between(vec3 a, vec3 b) {
    float sine = length(cross(a, b));
    float cosine = dot(a, b);
    bool steep = sine > abs(cosine);
    float acute = atan_of_unit(min(sine, abs(cosine)) / max(sine, abs(cosine)));
    float quarter = steep ? 1.5707963 - acute : acute;
    return cosine < 0.0 ? 3.1415927 - quarter : quarter;
}

// The ramp from 0 at 0 to 1 at 1 and above: 1 - (1 - share)^8.
float border_ramp(float share) {
    float rest = 1.0 - clamp(share, 0.0, 1.0);
    float square = rest * rest;
    float fourth = square * square;
    return 1.0 - fourth * fourth;
}

// The weight of a photo of the k best, with the penalty of the next one (smooth: Franke and Little).
float raw_weight(float q, float next) {
    float w = max(0.0, 1.0 / q - 1.0 / next);
    return w * w;
}
