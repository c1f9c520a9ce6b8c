// Where depth pixels are in the picture, and on which pixels each is drawn.
// Rust: gpu/ldi/dots.rs. Before this text: the constants RUN_BITS, LARGEST, CLOSED_BY_ONE, LEAST, COVERS, COVERS_LEVEL,
// LEAST_SQUARES, LEAST_FACTOR, CLOSED, LONGEST, and SINGLE, true where splats are one pixel. The pass defines `touch`, which is
// called for each pixel of a splat with its weight there.
// CPU reference: ldi/transfer.rs, ldi/spacing.rs, ldi/stretch.rs, ldi/splat/sums.rs.

// A depth pixel in the picture.
struct Dot {
    // False where it is not drawn; the other values have no meaning then.
    drawn: bool,
    // The position in pixels, and the same from the picture's centre.
    at: vec2f,
    from_centre: vec2f,
    // 1 / omega.
    per: f32,
    // Inverse depth in the picture's camera.
    q: f32,
    // The spacing in pixels.
    s: f32,
    // How far the splat reaches along u and v, in pixels, and its weight at its centre.
    reach: vec2f,
    full: f32,
    // True where it is a parallelogram; then the matrix, by columns u and v, that takes an offset in the picture to one between
    // depth pixels.
    is_stretched: bool,
    // True where its depth pixel is magnified so much that splats leave gaps.
    is_cut: bool,
    // How many half sides of a splat of one pixel its surface's slope counts for, and how much its inverse depth changes from pixel
    // to pixel where it is a parallelogram.
    along: f32,
    gradient: vec2f,
    inverse: mat2x2f,
    index: u32,
    surface: u32,
    colour: u32,
}

// Prevents that a product becomes part of a fused multiply-add, which would round differently on some devices and in
// some passes: its bits pass through an integer operation whose result the compiler cannot predict.
fn rounded(product: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(product) ^ view.zero);
}

fn rounded2(product: vec2f) -> vec2f {
    return bitcast<vec2f>(bitcast<vec2u>(product) ^ vec2u(view.zero));
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
        if !SINGLE && dot.drawn {
            shape(&dot);
        }
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
    let surface = surfaces[dot.surface];
    let g = surface.factor;
    let start = starts[(pixel.x >> 16u) * view.runs + (column >> RUN_BITS)].xyz;
    let k = f32(column & ((1u << RUN_BITS) - 1u));
    let h = (start + rounded3(k * view.step)) + rounded3(d * view.depth);
    // Also false where the position is no number.
    if !(h.z > 0.0) || g < 0.0 {
        return dot;
    }
    let per = rounded(1.0 / h.z);
    let from_centre = vec2f(rounded(h.x * per), rounded(h.y * per));
    dot.at = from_centre + view.half;
    dot.q = rounded(d * per);
    dot.s = select(g * (per * sqrt(per)), g * per, dot.surface == 0u);
    dot.drawn = true;
    dot.from_centre = from_centre;
    dot.per = per;
    return dot;
}

// Finds the splat of a depth pixel.
fn shape(dot: ptr<function, Dot>) {
    let s = (*dot).s;
    let per = (*dot).per;
    let from_centre = (*dot).from_centre;
    let surface = surfaces[(*dot).surface];
    // The Jacobian of the map of its plane, by rows.
    let of_u = rounded2((surface.of_u - rounded2(from_centre.x * surface.of_omega)) * per);
    let of_v = rounded2((surface.of_v - rounded2(from_centre.y * surface.of_omega)) * per);
    let squares = rounded(of_u.x * of_u.x) + rounded(of_u.y * of_u.y) + rounded(of_v.x * of_v.x) + rounded(of_v.y * of_v.y);
    if squares > LEAST_SQUARES * rounded(s * s) && squares > CLOSED * CLOSED {
        stretch(dot, vec2f(of_u.x, of_v.x), vec2f(of_u.y, of_v.y));
        (*dot).along = 1.0;
        (*dot).gradient = surface.gradient;
        return;
    }
    let within_one = clamp(s, LEAST, 1.0);
    let shrink = min(s, 1.0) / within_one;
    (*dot).full = shrink * shrink;
    let radius = select(min(s, LARGEST), within_one, s <= CLOSED_BY_ONE);
    (*dot).reach = vec2f(radius);
    (*dot).along = max(radius, 1.0);
    (*dot).is_cut = s > LARGEST;
}

// Makes the splat of a depth pixel the parallelogram of a Jacobian, by columns, that is not zero.
fn stretch(dot: ptr<function, Dot>, x: vec2f, y: vec2f) {
    let xx = dot2(x, x);
    let yy = dot2(y, y);
    let is_x = xx >= yy;
    let long = select(y, x, is_x);
    let squared = select(yy, xx, is_x);
    let share = dot2(x, y) / squared;
    let per_length = inverseSqrt(squared);
    // How far the other column is from the longer one, along (-v, u).
    let determinant = x.x * y.y - y.x * x.y;
    let apart = select(-determinant, determinant, is_x) * per_length;
    let wider = select(1.0, -1.0, apart < 0.0) * clamp(abs(apart), LEAST, LONGEST);
    let shorter = min(LONGEST * per_length, 1.0);
    let column = shorter * long;
    let other = share * column + (wider * per_length) * vec2f(-long.y, long.x);
    let a = select(other, column, is_x);
    let b = select(column, other, is_x);
    (*dot).inverse = (1.0 / (a.x * b.y - b.x * a.y)) * mat2x2f(vec2f(b.y, -a.y), vec2f(-b.x, a.x));
    (*dot).reach = min(abs(a) + abs(b), vec2f(LONGEST));
    (*dot).full = min(abs(apart / wider), 1.0);
    (*dot).is_cut = LONGEST * per_length < 1.0;
    (*dot).is_stretched = true;
}

fn dot2(a: vec2f, b: vec2f) -> f32 {
    return a.x * b.x + a.y * b.y;
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
    let at = dot.at - 0.5;
    if !(is_within(at, dot.reach)) {
        return;
    }
    let low = max(vec2i(floor(at - dot.reach)) + 1, vec2i(0, rows.x));
    let end = min(vec2i(floor(at + dot.reach)) + 1, vec2i(i32(view.size.x), rows.y));
    for (var j = low.y; j < end.y; j++) {
        var of_row = vec2i(low.x, end.x);
        if dot.is_stretched {
            let extent = extent_of(dot, f32(j) - at.y);
            of_row.x = max(of_row.x, i32(floor(at.x + extent.x)) + 1);
            of_row.y = min(of_row.y, i32(floor(at.x + extent.y)) + 1);
        }
        for (var i = of_row.x; i < of_row.y; i++) {
            let weight = weight_of(dot, vec2f(f32(i), f32(j)) - at);
            var here = dot;
            if dot.is_stretched {
                // The inverse depth of its plane; behind the plane's horizon it is not seen.
                let change = rounded2(dot.gradient * (vec2f(f32(i), f32(j)) - at));
                here.q = (dot.q + change.x) + change.y;
            }
            if weight > 0.0 && here.q >= 0.0 {
                touch(index_of(u32(i), u32(j)), weight, here);
            }
        }
    }
}

// Returns from where to where a parallelogram reaches along u in a row that is this far from its centre, in pixels, at most.
fn extent_of(dot: Dot, apart: f32) -> vec2f {
    var extent = vec2f(-dot.reach.x, dot.reach.x);
    for (var row = 0u; row < 2u; row++) {
        let of_u = dot.inverse[0][row];
        if abs(of_u) > LEAST_FACTOR {
            let per = 1.0 / abs(of_u);
            let middle = -dot.inverse[1][row] * apart / of_u;
            extent = vec2f(max(extent.x, middle - per), min(extent.y, middle + per));
        }
    }
    return extent;
}

// Returns the weight of a splat at an offset from its centre, in pixels.
fn weight_of(dot: Dot, offset: vec2f) -> f32 {
    var within = offset / dot.reach;
    if dot.is_stretched {
        within = dot.inverse * offset;
    }
    let tent = max(1.0 - abs(within), vec2f(0.0));
    return dot.full * tent.x * tent.y;
}

// Returns whether a splat at a position, from the first pixel's centre, meets the picture.
fn is_within(at: vec2f, reach: vec2f) -> bool {
    return all(at > -reach) && all(at < vec2f(view.size) - 1.0 + reach);
}
