// Pass of single pixels in one run: the largest words of 64 bits, of the inverse depth's bits and the complement of the index.
// Rust: gpu/ldi/wide_pixel.rs.

fn touch(pixel: u32, weight: f32, dot: Dot) {
    if opacity_of(dot.colour) >= 0.5 {
        atomicMax(&depths[pixel], (u64(bitcast<u32>(dot.q)) << 32u) | u64(~dot.index));
    }
}

@compute @workgroup_size(256)
fn find(@builtin(global_invocation_id) id: vec3u) {
    draw(dot_of(id.x));
}
