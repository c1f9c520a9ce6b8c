//! The nearest samples in two runs (`shaders/flakes_narrow.wgsl`), for devices that find maxima of words of 32 bits alone.

const SOURCE: &str = include_str!("../../../../shaders/flakes_narrow.wgsl");

/// Returns the WGSL source that is put before the pass *flakes*, for the second run or the first.
pub fn source(second: bool) -> String {
    format!("const SECOND = {second};\n{SOURCE}")
}
