// Pass fill: every fragment writes its entry, from the end of its pixel's entries to their beginning.
// Afterwards every element of `places` is the offset at which the pixel's entries begin.
// Rust: gpu/fill.rs.

@group(1) @binding(0) var nearest: texture_depth_2d;
@group(1) @binding(1) var<storage, read_write> places: array<atomic<u32>>;
@group(1) @binding(2) var<storage, read_write> entries: array<u32>;

@fragment
fn fill(fragment: Fragment) {
    let depth = scaled_depth(fragment);
    if depth <= 0.0 {
        return;
    }
    let hidden = is_behind(depth, textureLoad(nearest, vec2<u32>(fragment.position.xy), 0));
    let place = atomicSub(&places[pixel_of(fragment)], 1u) - 1u;
    entries[place - frame.first_entry] = fragment.item | select(VISIBLE, 0u, hidden);
}
