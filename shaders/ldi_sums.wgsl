// Pass sums: the sums of the slots, at first (FAR is false) of what is level with the nearest depth pixel, then of what is level with
// the next, and, where the near slot holds more than one surface, of the nearest one's alone. Sums are of integers, so they are
// the same in whatever order depth pixels come.
// Rust: gpu/ldi/sums.rs.

// A light beyond this is cut off, so that sums have room for many.
const BRIGHTEST: f32 = 64.0;

// Returns a number in 0..1 that has nothing to do with a depth pixel and a pixel, and is the same each time.
fn scattered(index: u32, pixel: u32) -> f32 {
    var h = index * 0x9e3779b9u + pixel * 0x85ebca6bu;
    h = (h ^ (h >> 16u)) * 0x7feb352du;
    h = (h ^ (h >> 15u)) * 0x846ca68bu;
    return f32((h ^ (h >> 16u)) >> 8u) * 0x1p-24;
}

fn light_of(dot: Dot, channel: u32) -> f32 {
    let byte = (dot.colour >> (8u * channel)) & 0xffu;
    return min(bitcast<f32>(exposed[256u * channel + byte]), BRIGHTEST);
}

fn add(pixel: u32, slot: u32, weight: f32, dot: Dot) {
    // Rounded up or down by chance: sums of many weights below 1, of what is far away, are right, where each alone would be 0.
    let dither = scattered(dot.index, view.rows.x * view.size.x + pixel);
    let opacity = opacity_of(dot.colour);
    let at = slot_at(pixel, slot);
    atomicAdd(&sums[at], u32(rounded(weight * WEIGHT_UNIT) + dither));
    atomicAdd(&sums[at + 1u], u32(rounded(weight * opacity * WEIGHT_UNIT) + dither));
    for (var channel = 0u; channel < 3u; channel++) {
        let light = weight * opacity * light_of(dot, channel);
        atomicAdd(&sums[at + 2u + channel], u32(rounded(light * LIGHT_UNIT) + dither));
    }
}

fn touch(pixel: u32, weight: f32, dot: Dot) {
    let level = is_level(dot, NEAREST, pixel);
    if !FAR {
        if level {
            add(pixel, NEAR_SLOT, weight, dot);
        }
        return;
    }
    if level {
        if is_overfull(atomicLoad(&sums[slot_at(pixel, NEAR_SLOT)]))
            && atomicLoad(&depths[plane_at(NEAREST_SURFACE, pixel)]) == 1u + dot.surface {
            add(pixel, FRONT_SLOT, weight, dot);
        }
        return;
    }
    // There is a depth only where what is behind is seen.
    if is_level(dot, FARTHER, pixel) {
        add(pixel, FAR_SLOT, weight, dot);
    }
}

@compute @workgroup_size(256)
fn sums_of_slots(@builtin(global_invocation_id) id: vec3u) {
    draw(dot_of(id.x));
}
