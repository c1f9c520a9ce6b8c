//! Seeds of the orders in which sub-pixels open.

/// Returns a number whose bits all depend on all bits of another (Steele, Lea & Flood 2014, the finaliser of *SplitMix*).
pub(super) fn mixed(of: u64) -> u64 {
    let mut bits = of.wrapping_add(0x9E37_79B9_7F4A_7C15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    bits ^ (bits >> 31)
}
