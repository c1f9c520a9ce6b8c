// Pass count: the number of fragments per pixel.
// Rust: gpu/count.rs.

@group(1) @binding(0) var<storage, read_write> counts: array<atomic<u32>>;

@fragment
fn count(fragment: Fragment) {
    if scaled_depth(fragment) > 0.0 {
        atomicAdd(&counts[pixel_of(fragment)], 1u);
    }
}
