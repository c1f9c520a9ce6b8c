// The nearest sample in two runs: at first (SECOND is false) the largest nearness, then of samples of that nearness the largest
// 1 + sample. Words are where those of 64 bits would be.
// Rust: gpu/renderer/plants/flakes_narrow.rs.

@group(1) @binding(2) var<storage, read_write> kept: array<atomic<u32>>;

// The same sample may be rounded differently in the two runs: by this many units in the last place.
const ROUNDING = 4u;

fn keep(place: u32, nearness: u32, sample: u32) {
    if !SECOND {
        atomicMax(&kept[2u * place + 1u], nearness);
    } else if nearness + ROUNDING >= atomicLoad(&kept[2u * place + 1u]) {
        atomicMax(&kept[2u * place], sample);
    }
}
