// Passes of single pixels: the nearest depth pixel at each pixel of the picture, of those that are mostly opaque, and of
// equally near ones the first. *find* runs twice: at first (FIRST is false) for the inverse depth, then for the index.
// Rust: gpu/ldi/pixel.rs; gpu/ldi/wide_pixel.rs does it in one run where words of 64 bits can be compared.

// The planes of `depths`: 1 + the bits of the inverse depth; then the complement of the index, of which the largest is the
// first. 0 where there is nothing.
fn touch(pixel: u32, weight: f32, dot: Dot) {
    if opacity_of(dot.colour) < 0.5 {
        return;
    }
    let depth = 1u + bitcast<u32>(dot.q);
    if !FIRST {
        atomicMax(&depths[pixel], depth);
    } else if atomicLoad(&depths[pixel]) == depth {
        atomicMax(&depths[pixel_count() + pixel], ~dot.index);
    }
}

@compute @workgroup_size(256)
fn find(@builtin(global_invocation_id) id: vec3u) {
    draw(dot_of(id.x));
}
