// Pass farthest: the item buffer with the depth test inverted, so that the farthest item wins each pixel; of
// equally far ones, the last in model order.
// Rust: gpu/farthest.rs.

struct Farthest {
    @builtin(frag_depth) depth: f32,
    // 1 + the item's index.
    @location(0) item: u32,
}

@fragment
fn farthest(fragment: Fragment) -> Farthest {
    let depth = scaled_depth(fragment);
    if depth <= 0.0 {
        discard;
    }
    return Farthest(depth, fragment.item + 1u);
}
