// Pass mark: marks the items that have a fragment behind the nearest by more than the tolerance.
// Rust: gpu/mark.rs.

@group(1) @binding(0) var nearest: texture_depth_2d;
@group(1) @binding(1) var<storage, read_write> marks: array<atomic<u32>>;

@fragment
fn mark(fragment: Fragment) {
    let depth = scaled_depth(fragment);
    if depth <= 0.0 {
        return;
    }
    let behind = is_behind(depth, textureLoad(nearest, vec2<u32>(fragment.position.xy), 0));
    // The plain read avoids the write for nearly all fragments.
    if behind && atomicLoad(&marks[fragment.item]) == 0u {
        atomicStore(&marks[fragment.item], 1u);
    }
}
