// The weights of photos. CPU reference: view/weights.rs.

const LEAST_ANGLE: f32 = 1e-6;
const OTHER_SIDE: f32 = 1000.0;
const INFINITE: f32 = 3e38;

// atan for 0..1: an odd minimax polynomial with an error of at most 2e-6 (Abramowitz & Stegun 4.4.49, its
// form).
fn atan_of_unit(x: f32) -> f32 {
    let s = x * x;
    let odd = ((((0.0208351 * s - 0.0851330) * s + 0.1801410) * s - 0.3302995) * s + 0.9998660);
    return x * odd;
}

// The angle between two directions of any length, in radians, from sine and cosine.
fn angle_between(a: vec3f, b: vec3f) -> f32 {
    let sine = length(cross(a, b));
    let cosine = dot(a, b);
    let steep = sine > abs(cosine);
    let acute = atan_of_unit(min(sine, abs(cosine)) / max(sine, abs(cosine)));
    let half = select(acute, 1.5707963 - acute, steep);
    return select(half, 3.1415927 - half, cosine < 0.0);
}

// The ramp from 0 at 0 to 1 at 1 and above: 1 - (1 - share)^8.
fn border_ramp(share: f32) -> f32 {
    let left = 1.0 - clamp(share, 0.0, 1.0);
    let square = left * left;
    let fourth = square * square;
    return 1.0 - fourth * fourth;
}

fn raw_weight(q: f32, next: f32) -> f32 {
    if MODE == SMOOTH {
        let w = max(0.0, 1.0 / q - 1.0 / next);
        return w * w;
    }
    if MODE == BEST {
        return 1.0;
    }
    return max(0.0, 1.0 - q / next) / q;
}
