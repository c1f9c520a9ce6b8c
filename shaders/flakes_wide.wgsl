// The nearest sample in one run: the largest words of 64 bits, of the nearness and 1 + the sample.
// Rust: gpu/renderer/plants/flakes_wide.rs.

@group(1) @binding(2) var<storage, read_write> kept: array<atomic<u64>>;

fn keep(place: u32, nearness: u32, sample: u32) {
    atomicMax(&kept[place], (u64(nearness) << 32u) | u64(sample));
}
