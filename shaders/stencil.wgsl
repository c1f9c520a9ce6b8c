// Pass stencil: where a fragment is nearer than the farthest by more than the tolerance, the item in the item
// buffer is partly hidden. The published method counts these fragments in the stencil buffer, but only uses
// whether there is any; so the item is marked at once.
// Rust: gpu/stencil.rs.

@group(1) @binding(0) var farthest: texture_depth_2d;
@group(1) @binding(1) var items: texture_2d<u32>;
@group(1) @binding(2) var<storage, read_write> marks: array<atomic<u32>>;

@fragment
fn stencil(fragment: Fragment) {
    let depth = scaled_depth(fragment);
    let pixel = vec2<u32>(fragment.position.xy);
    if depth <= 0.0 || !is_behind(textureLoad(farthest, pixel, 0), depth) {
        return;
    }
    // Another item lies behind this fragment, so the item buffer is not empty here.
    let item = textureLoad(items, pixel, 0).x - 1u;
    if atomicLoad(&marks[item]) == 0u {
        atomicStore(&marks[item], 1u);
    }
}
