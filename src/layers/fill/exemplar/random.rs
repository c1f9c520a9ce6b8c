//! Pseudorandom numbers that are the same on every machine and for any number of threads.

/// Computes a number from a seed, a position and a step (Steele, Lea and Flood, *Fast Splittable Pseudorandom
/// Number Generators*, 2014: the finalizer of SplitMix).
pub fn number(seed: u64, position: u64, step: u64) -> u64 {
    let mut z = seed
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(position.wrapping_mul(0xd1b5_4a32_d192_ed03))
        .wrapping_add(step.wrapping_mul(0x8cb9_2ba7_2f3d_8dd7));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Maps a number to a whole number from `-reach` to `reach`.
pub fn within(number: u64, reach: i32) -> i32 {
    (number % (2 * reach as u64 + 1)) as i32 - reach
}
