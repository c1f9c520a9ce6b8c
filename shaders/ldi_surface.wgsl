// Pass surface: the surface of the depth pixel that pass *nearest* found, at first (FAR is false) of all, then of what is not level
// with it; of equally near ones, the one that was numbered last.
// Rust: gpu/ldi/surface.rs.

fn touch(pixel: u32, weight: f32, dot: Dot) {
    let plane = select(NEAREST, FARTHER, FAR);
    if atomicLoad(&depths[plane_at(plane, pixel)]) == word_of(dot, weight, plane) {
        atomicMax(&depths[plane_at(plane + 2u, pixel)], 1u + dot.surface);
    }
}

@compute @workgroup_size(256)
fn surface_of_nearest(@builtin(global_invocation_id) id: vec3u) {
    draw(dot_of(id.x));
}
