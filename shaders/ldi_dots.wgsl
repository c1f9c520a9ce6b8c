// Where depth pixels are in the picture, and on which pixels each is drawn.
// Rust: gpu/ldi/dots.rs. Before this text: the constants RUN_BITS, LARGEST, CLOSED_BY_ONE, LEAST, COVERS, COVERS_LEVEL, and SINGLE,
// true where splats are one pixel. The pass defines `touch`, which is called for each pixel of a splat with its weight there.
// CPU reference: ldi/transfer.rs, ldi/spacing.rs, ldi/splat/sums.rs.

// A depth pixel in the picture.
struct Dot {
    // False where it is not drawn; the other values have no meaning then.
    drawn: bool,
    // The position in pixels.
    at: vec2f,
    // Inverse depth in the picture's camera.
    q: f32,
    // The spacing in pixels.
    s: f32,
    index: u32,
    surface: u32,
    colour: u32,
}

// Prevents that a product becomes part of a fused multiply-add, which would round differently on some devices and in
// some passes: its bits pass through an integer operation whose result the compiler cannot predict.
fn rounded(product: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(product) ^ view.zero);
}

fn rounded3(product: vec3f) -> vec3f {
    return bitcast<vec3f>(bitcast<vec3u>(product) ^ vec3u(view.zero));
}

// Returns the depth pixel that an invocation draws.
fn dot_of(invocation: u32) -> Dot {
    let index = max(view.within.x, part.x) + invocation;
    let at = index - part.x;
    var dot: Dot;
    if index < view.within.y && at < arrayLength(&pixels) {
        dot = placed(at);
        dot.drawn = dot.drawn && !is_covered(dot, at);
    }
    dot.index = index;
    return dot;
}

// Returns a depth pixel of the part at its place in the picture.
fn placed(at: u32) -> Dot {
    var dot: Dot;
    let pixel = pixels[at];
    let column = pixel.x & 0xffffu;
    let d = bitcast<f32>(pixel.y);
    dot.colour = pixel.z;
    dot.surface = pixel.w;
    let g = surfaces[dot.surface].x;
    let start = starts[(pixel.x >> 16u) * view.runs + (column >> RUN_BITS)].xyz;
    let k = f32(column & ((1u << RUN_BITS) - 1u));
    let h = (start + rounded3(k * view.step)) + rounded3(d * view.depth);
    // Also false where the position is no number.
    if !(h.z > 0.0) || g < 0.0 {
        return dot;
    }
    let per = rounded(1.0 / h.z);
    dot.at = vec2f(rounded(h.x * per), rounded(h.y * per)) + view.half;
    dot.q = rounded(d * per);
    dot.s = select(g * (per * sqrt(per)), g * per, dot.surface == 0u);
    dot.drawn = true;
    return dot;
}

// Returns whether the next nearer depth pixel of its ray covers a depth pixel.
fn is_covered(dot: Dot, at: u32) -> bool {
    // Parts do not end within a ray.
    if SINGLE || at == 0u || pixels[at - 1u].x != pixels[at].x || (pixels[at - 1u].z >> 24u) != 255u {
        return false;
    }
    let nearer = placed(at - 1u);
    let apart = nearer.q - dot.q;
    let level = apart > 0.0 && apart <= rounded(COVERS_LEVEL * nearer.q);
    return nearer.drawn && level && all(abs(dot.at - nearer.at) <= vec2f(COVERS));
}

// Draws a depth pixel. Everything is compared before it becomes an integer, so that what is no number is not drawn. Positions
// are those in the whole picture, so that nothing depends on which rows are drawn together.
fn draw(dot: Dot) {
    if !dot.drawn {
        return;
    }
    let size = vec2f(view.size);
    let rows = vec2i(view.rows);
    if SINGLE {
        let top = f32(rows.x);
        let end = f32(rows.y);
        if dot.at.x >= 0.0 && dot.at.x < size.x && dot.at.y >= top && dot.at.y < end {
            touch(index_of(u32(dot.at.x), u32(dot.at.y)), 1.0, dot);
        }
        return;
    }
    let radius = radius_of(dot);
    let at = dot.at - 0.5;
    if !(is_within(at, radius)) {
        return;
    }
    let low = max(vec2i(floor(at - radius)) + 1, vec2i(0, rows.x));
    let end = min(vec2i(floor(at + radius)) + 1, vec2i(i32(view.size.x), rows.y));
    let full = full_weight(dot);
    let per_radius = 1.0 / radius;
    for (var j = low.y; j < end.y; j++) {
        let of_row = full * (1.0 - abs(f32(j) - at.y) * per_radius);
        for (var i = low.x; i < end.x; i++) {
            let weight = of_row * (1.0 - abs(f32(i) - at.x) * per_radius);
            if weight > 0.0 {
                touch(index_of(u32(i), u32(j)), weight, dot);
            }
        }
    }
}

// Returns the half side of a splat in pixels.
fn radius_of(dot: Dot) -> f32 {
    return select(min(dot.s, LARGEST), clamp(dot.s, LEAST, 1.0), dot.s <= CLOSED_BY_ONE);
}

// Returns the weight of a splat at its centre.
fn full_weight(dot: Dot) -> f32 {
    let shrink = min(dot.s, 1.0) / clamp(dot.s, LEAST, 1.0);
    return shrink * shrink;
}

// Returns whether a splat at a position, from the first pixel's centre, meets the picture.
fn is_within(at: vec2f, radius: f32) -> bool {
    return all(at > vec2f(-radius)) && all(at < vec2f(view.size) - 1.0 + radius);
}
