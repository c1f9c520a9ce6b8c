// Pass nearest: the nearest inverse depth at each pixel of the picture, at first (FAR is false) of all, then, after pass *sums*, of
// what is not level with it, where that is seen.
// Rust: gpu/ldi/nearest.rs.

fn touch(pixel: u32, weight: f32, dot: Dot) {
    if !FAR {
        atomicMax(&depths[plane_at(NEAREST, pixel)], word_of(dot, weight, NEAREST));
        return;
    }
    let near = slot_at(pixel, NEAR_SLOT);
    let is_seen = is_seen_through(atomicLoad(&sums[near]), atomicLoad(&sums[near + 1u]));
    if is_seen && !is_level(dot, NEAREST, pixel) {
        atomicMax(&depths[plane_at(FARTHER, pixel)], word_of(dot, weight, FARTHER));
    }
}

@compute @workgroup_size(256)
fn nearest(@builtin(global_invocation_id) id: vec3u) {
    let dot = dot_of(id.x);
    draw(dot);
    if FAR || !dot.drawn || !dot.is_cut || !is_within(dot.at - 0.5, dot.reach) {
        return;
    }
    // Each is counted with one row.
    let row = u32(clamp(dot.at.y, 0.0, f32(view.size.y - 1u)));
    if row >= view.rows.x && row < view.rows.y {
        atomicAdd(&depths[PLANES * pixel_count()], 1u);
    }
}
