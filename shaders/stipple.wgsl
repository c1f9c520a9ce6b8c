// Stippled transparency: in which sub-pixels something is drawn that is drawn in part.
// Rust: gpu/renderer/plants/stipple.rs. CPU reference: foliage/stipple.rs.

// A number of 8 bits that depends on a seed and on a pixel, and is the same each time.
fn scattered(seed: u32, pixel: vec2u) -> u32 {
    var h = seed * 0xc2b2ae35u + pixel.x * 0x9e3779b9u + pixel.y * 0x85ebca6bu;
    h = (h ^ (h >> 16u)) * 0x7feb352du;
    h = (h ^ (h >> 15u)) * 0x846ca68bu;
    return (h ^ (h >> 16u)) >> 24u;
}

// Whether a stipple is open in a sub-pixel. A stipple has where it begins (8 bits), how much of 256 is open (9 bits), and a seed (15 bits):
// stipples of one seed share the sub-pixels, which open in the order 0, 2, 1, 3.
fn is_open(stipple: u32, pixel: vec2u, sub_pixel: u32) -> bool {
    let order = scattered(stipple >> 17u, pixel) + 64u * reverseBits(sub_pixel << 30u);
    return ((order + 256u - (stipple & 0xffu)) & 0xffu) < ((stipple >> 8u) & 0x1ffu);
}
