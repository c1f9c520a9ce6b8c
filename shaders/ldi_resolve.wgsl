// Pass resolve: the colours of the picture from the sums of its pixels, near over far.
// Rust: gpu/ldi/resolve.rs.

alias Words = array<u32, SUMS>;

// Weight, and the sums of light R, G, B and opacity.
struct Slot {
    weight: f32,
    seen: vec4f,
}

fn words_of(pixel: u32, slot: u32) -> Words {
    let at = slot_at(pixel, slot);
    return Words(sums[at], sums[at + 1u], sums[at + 2u], sums[at + 3u], sums[at + 4u]);
}

fn slot_of(words: Words) -> Slot {
    let light = vec3f(f32(words[2]), f32(words[3]), f32(words[4])) / LIGHT_UNIT;
    return Slot(f32(words[0]) / WEIGHT_UNIT, vec4f(light, f32(words[1]) / WEIGHT_UNIT));
}

// Returns linear light times the share of the pixel that a slot covers, and that share; the slot is opaque from a weight of
// 1 / `per_weight` on, together with what is before it, so that no gap is left where the near surface ends.
fn covering(slot: Slot, per_weight: f32, before: f32) -> vec4f {
    if slot.weight <= 0.0 {
        return vec4f(0.0);
    }
    return slot.seen * (min(per_weight * (before + slot.weight), 1.0) / slot.weight);
}

fn over(front: vec4f, back: vec4f) -> vec4f {
    return front + back * (1.0 - front.a);
}

// Returns what the near slot of a pixel covers. Of several surfaces the nearest one is shown as far as its weights reach, and
// the others where it ends.
fn near_of(pixel: u32) -> vec4f {
    var near = words_of(pixel, NEAR_SLOT);
    if !is_overfull(near[0]) {
        return covering(slot_of(near), PER_OPAQUE, 0.0);
    }
    var front = words_of(pixel, FRONT_SLOT);
    var others: Words;
    for (var i = 0u; i < SUMS; i++) {
        // Those of the front are part of the near slot's, but may be rounded in another way.
        others[i] = max(near[i], front[i]) - front[i];
    }
    return over(covering(slot_of(front), 1.0, 0.0), covering(slot_of(others), PER_OPAQUE, 0.0));
}

fn srgb_from_linear(light: f32) -> f32 {
    let value = clamp(light, 0.0, 1.0);
    return select(1.055 * pow(value, 1.0 / 2.4) - 0.055, value * 12.92, value <= 0.0031308);
}

@compute @workgroup_size(256)
fn resolve(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.x;
    if pixel >= pixel_count() {
        return;
    }
    let before = slot_of(words_of(pixel, NEAR_SLOT)).weight;
    let seen = over(near_of(pixel), covering(slot_of(words_of(pixel, FAR_SLOT)), PER_OPAQUE, before));
    if seen.a <= 0.0 {
        picture[pixel] = 0u;
        return;
    }
    var word = u32(min(seen.a, 1.0) * 255.0 + 0.5) << 24u;
    for (var channel = 0u; channel < 3u; channel++) {
        let value = srgb_from_linear(seen[channel] / seen.a);
        word |= u32(value * 255.0 + 0.5) << (8u * channel);
    }
    picture[pixel] = word;
}
