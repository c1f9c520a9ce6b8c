// Pass *flakes*: which sample of the images of plants is nearest at each sub-pixel of the view (Max 1996, section 4, with a depth
// buffer in place of layers). Each sample is a parallelogram at its own depth that leans as its normal tells.
// Rust: gpu/renderer/plants/flakes.rs. Before this text: surfaces.wgsl, stipple.wgsl, flake.wgsl, flakes_wide.wgsl or flakes_narrow.wgsl, and the
// number of INVOCATIONS of a workgroup.
// CPU reference: foliage/flake.rs, foliage/place.rs.

// Image and first sample of each workgroup.
@group(1) @binding(3) var<storage, read> jobs: array<vec2u>;
// 1 for each job that pass *hidden* found to be hidden.
@group(1) @binding(4) var<storage, read> is_hidden: array<u32>;

// The steepest surface that a normal is taken for, as a slope.
const STEEPEST = 3.0;

// By how much rounding may miss the places of sub-pixels in pictures up to 16384 pixels wide.
const ROUNDING_PX = 4e-3;

// How far a sub-pixel is from the left side of its pixel, in pixels. In the standard patterns of 1 and 4 SAMPLES each row of sub-pixels
// holds one, in the middle of its height.
fn from_left(sub_pixel: u32) -> f32 {
    if SAMPLES == 1u {
        return 0.5;
    }
    // 0.375, 0.875, 0.125, 0.625.
    return fract(0.375 + 0.5 * f32(sub_pixel) - 0.25 * f32(sub_pixel >> 1u));
}

// The change of the image point of `at` for a change of the point.
fn changed(at: vec3f, px: vec2f, change: vec3f) -> vec2f {
    return (vec2f(frame.focal_x, frame.focal_y) * change.xy - (px - frame.center) * change.z) / at.z;
}

// The middle of the covered sub-pixels from the pixel's centre, in sides of a pixel.
fn middle_of(covered: u32) -> vec2f {
    let x = 3.0 * (f32(countOneBits(covered & 0x8888u)) - f32(countOneBits(covered & 0x1111u)))
        + f32(countOneBits(covered & 0x4444u)) - f32(countOneBits(covered & 0x2222u));
    let y = 3.0 * (f32(countOneBits(covered & 0xf000u)) - f32(countOneBits(covered & 0x000fu)))
        + f32(countOneBits(covered & 0x0f00u)) - f32(countOneBits(covered & 0x00f0u));
    return vec2f(x, y) / (8.0 * f32(countOneBits(covered)));
}

// Whether an image draws in a sub-pixel: it shares them with images from other directions, and with finer and coarser parts.
fn is_drawn(image: FlakeImage, pixel: vec2u, sub_pixel: u32) -> bool {
    return is_open(image.of_direction, pixel, sub_pixel) && is_open(image.of_part, pixel, sub_pixel);
}

fn draw(image: FlakeImage, number: u32) {
    let flake = flake_of(image.first + number);
    let at = point_of(image, flake);
    if !(at.z > 0.0) {
        return;
    }
    let px = vec2f(frame.focal_x, frame.focal_y) * at.xy / at.z + frame.center;
    let last = vec2i(i32(rows.width), i32(rows.first + rows.count)) - 1;
    let beside = f32(rows.reach + 1u);
    let is_near = all(px > vec2f(0.0, f32(rows.first)) - beside) && all(px < vec2f(last) + 1.0 + beside);
    let looks_away = dot(normal_in_view(image, flake), at) > 0.0;
    if !is_near || (looks_away && !flake.is_leaf) {
        return;
    }
    let slope = clamp(flake.normal.xy / max(-flake.normal.z, 1.0 / 64.0), vec2f(-STEEPEST), vec2f(STEEPEST));
    let along = changed(at, px, vec3f(image.right.z, image.down.z, image.forward.z));
    let across = image.delta * (changed(at, px, vec3f(image.right.x, image.down.x, image.forward.x)) + slope.x * along);
    let down = image.delta * (changed(at, px, vec3f(image.right.y, image.down.y, image.forward.y)) + slope.y * along);
    let area = across.x * down.y - across.y * down.x;
    if area == 0.0 {
        return;
    }
    // The depth is that of the middle of the covered sub-pixels: the pixel's centre lies elsewhere on the surface.
    let middle = px - image.delta * dot(slope, middle_of(flake.covered)) * along;
    let reach = 0.5 * (abs(across) + abs(down));
    // What leans most steeply reaches no farther than what does not lean.
    let home = vec2i(floor(px));
    let most = i32(rows.reach);
    let low = max(home - most, vec2i(0, i32(rows.first)));
    let high = min(home + most, last);
    // Rows of sub-pixels.
    let lowest = i32(ceil(f32(SAMPLES) * (middle.y - reach.y - ROUNDING_PX) - 0.5));
    let highest = i32(floor(f32(SAMPLES) * (middle.y + reach.y + ROUNDING_PX) - 0.5));
    let end = min((high.y + 1) * i32(SAMPLES), highest + 1);
    let nearness = bitcast<u32>(1.0 / at.z);
    let of_across = vec2f(down.y, -down.x) / area;
    let of_down = vec2f(-across.y, across.x) / area;
    // One loop over all sub-pixels: where samples of a workgroup need different numbers of rows and columns, loops in loops take longer. A
    // row in which none is within reach takes one turn, too.
    var row = max(low.y * i32(SAMPLES), lowest);
    var column = first_column(row, middle.x - reach.x, low.x);
    while row < end {
        let sub_pixel = u32(row) % SAMPLES;
        let pixel = vec2u(u32(column), u32(row) / SAMPLES);
        let left = from_left(sub_pixel);
        let at_sub_pixel = vec2f(f32(column) + left, (f32(row) + 0.5) / f32(SAMPLES));
        let u = dot(at_sub_pixel - middle, of_across) + 0.5;
        let v = dot(at_sub_pixel - middle, of_down) + 0.5;
        if column <= high.x && u >= 0.0 && u < 1.0 && v >= 0.0 && v < 1.0 {
            let bit = 4u * u32(4.0 * v) + u32(4.0 * u);
            if ((flake.covered >> bit) & 1u) != 0u && is_drawn(image, pixel, sub_pixel) {
                let place = (pixel.y - rows.first) * rows.width + pixel.x;
                keep(place * SAMPLES + sub_pixel, nearness, image.before + number + 1u);
            }
        }
        column += 1;
        if column > high.x || f32(column) + left > middle.x + reach.x + ROUNDING_PX {
            row += 1;
            column = first_column(row, middle.x - reach.x, low.x);
        }
    }
}

// The column of the first sub-pixel of a row of sub-pixels that is right of a place, no less than `least`.
fn first_column(row: i32, right_of: f32, least: i32) -> i32 {
    return max(least, i32(ceil(right_of - ROUNDING_PX - from_left(u32(row) % SAMPLES))));
}

@compute @workgroup_size(INVOCATIONS)
fn flakes(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let job_index = group.y * groups.x + group.x;
    if job_index >= arrayLength(&jobs) {
        return;
    }
    let job = jobs[job_index];
    if is_hidden[job_index] != 0u {
        return;
    }
    let image = images[job.x];
    // Jobs that fill up begin past all samples.
    let end = min(job.y + BLOCK, image.count);
    for (var number = job.y + index; number < end; number += INVOCATIONS) {
        draw(image, number);
    }
}
