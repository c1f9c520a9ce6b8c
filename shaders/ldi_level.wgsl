// Which slot of a pixel a depth pixel belongs to, for passes over depth pixels.
// Rust: gpu/ldi/level.rs. Before this text: the constants LEVEL, APART and APART_PIXELS.
// CPU reference: ldi/splat/sums.rs.

// Returns whether a depth pixel is of the surface of NEAREST or FARTHER, lies on it or meets it; none is, where there is none.
fn is_level(dot: Dot, plane: u32, pixel: u32) -> bool {
    let word = atomicLoad(&depths[plane_at(plane, pixel)]);
    let other = bitcast<f32>(max(word & ~STRONG, 1u) - 1u);
    let surface = max(atomicLoad(&depths[plane_at(plane + 2u, pixel)]), 1u) - 1u;
    var tolerance = LEVEL * other;
    if surface != dot.surface && surface != 0u && dot.surface != 0u {
        let slope = max(surfaces[surface].slope, surfaces[dot.surface].slope);
        tolerance = min(tolerance, APART * other + APART_PIXELS * dot.along * slope);
    }
    return word != 0u && abs(dot.q - other) <= tolerance;
}

// Returns what a depth pixel writes to NEAREST or FARTHER.
fn word_of(dot: Dot, weight: f32, plane: u32) -> u32 {
    // Inverse depths are not negative, and bits of such numbers are in their order. The rim of a splat does not hide what is
    // behind it.
    let strong = select(0u, STRONG, plane == FARTHER && weight > SLIGHT * dot.full);
    return (1u + bitcast<u32>(dot.q)) | strong;
}
