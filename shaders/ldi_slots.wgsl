// The slots of a pixel of the picture, in which the sums are.
// Rust: gpu/ldi/slots.rs. Before this text: the constants OVERFULL, SLIGHT, PER_OPAQUE, and WEIGHT_UNIT and LIGHT_UNIT, which
// are a weight and a light of 1 in the sums.
// CPU reference: ldi/splat/sums.rs.

// Planes of `depths`, each a word a pixel, 0 where there is nothing:
// 1 + the bits of the nearest inverse depth of all,
const NEAREST: u32 = 0u;
// 1 + the bits of the nearest inverse depth of what is not level with it, and STRONG where its weight is more than slight,
const FARTHER: u32 = 1u;
// 1 + the surface of the depth pixel of NEAREST,
const NEAREST_SURFACE: u32 = 2u;
// 1 + the surface of that of FARTHER;
const FARTHER_SURFACE: u32 = 3u;
const PLANES: u32 = 4u;
// then one word: the number of depth pixels that are magnified too much.

// The bit of FARTHER that comes before all depths.
const STRONG: u32 = 0x80000000u;

// What is level with the nearest depth pixel; what is level with the next one; and the part of the near slot that is of the
// nearest depth pixel's surface, where that slot holds more than one.
const NEAR_SLOT: u32 = 0u;
const FAR_SLOT: u32 = 1u;
const FRONT_SLOT: u32 = 2u;
const SLOTS: u32 = 3u;
// A slot's sums: of weights, and of weights times opacity, and times opacity and light R, G, B.
const SUMS: u32 = 5u;

// Returns the index in `depths` of a pixel's word in a plane.
fn plane_at(plane: u32, pixel: u32) -> u32 {
    return plane * pixel_count() + pixel;
}

// Returns the index in `sums` of the first one of a slot.
fn slot_at(pixel: u32, slot: u32) -> u32 {
    return (pixel * SLOTS + slot) * SUMS;
}

// Returns whether a near slot of these sums holds more than one surface.
fn is_overfull(weight: u32) -> bool {
    return f32(weight) > OVERFULL * WEIGHT_UNIT;
}

// Returns whether what is behind a near slot of these sums can be seen.
fn is_seen_through(weight: u32, opacity: u32) -> bool {
    return PER_OPAQUE * f32(weight) < WEIGHT_UNIT || opacity < weight;
}
