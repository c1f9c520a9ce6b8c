// Pass nearest: the inverse depth of the nearest fragment per pixel, in the depth buffer.
// Rust: gpu/nearest.rs.

@fragment
fn nearest(fragment: Fragment) -> @builtin(frag_depth) f32 {
    let depth = scaled_depth(fragment);
    if depth <= 0.0 {
        discard;
    }
    return depth;
}
