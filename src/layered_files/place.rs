//! Limits on positions, sizes and names that every reader enforces.

use quadratura_base::geometry::PixelRect;

/// Maximum side in pixels; no editor makes longer ones: the limit of Photoshop is 300,000, that of GIMP
/// 524,288.
pub const LONGEST_SIDE: u32 = 1 << 20;
/// Maximum distance of a layer's corner from the canvas's in pixels, so that sums of two such numbers and a
/// side fit 32 bits.
pub const LARGEST_OFFSET: i64 = 1 << 24;

/// Returns the rectangle at `(x, y)`; `None` when it is larger or farther away than any editor makes it.
pub fn rect_at(x: i64, y: i64, width: i64, height: i64) -> Option<PixelRect> {
    let longest = i64::from(LONGEST_SIDE);
    let fits = (0..=longest).contains(&width) && (0..=longest).contains(&height);
    let near = x.abs() <= LARGEST_OFFSET && y.abs() <= LARGEST_OFFSET;
    (fits && near).then_some(PixelRect { x: x as i32, y: y as i32, w: width as u32, h: height as u32 })
}

/// Returns whether a canvas may have this size.
pub fn is_canvas(width: u32, height: u32) -> bool {
    (1..=LONGEST_SIDE).contains(&width) && (1..=LONGEST_SIDE).contains(&height)
}

/// Returns what was found in place of a size that a canvas may have, and which sizes these are.
pub fn not_a_canvas(width: u32, height: u32) -> String {
    format!("a canvas of {width} x {height} pixels, expected sides of 1 to {LONGEST_SIDE}")
}

/// Maximum length of a name in characters: editors allow 255, and a damaged file must not produce names of
/// megabytes.
const LONGEST_NAME: usize = 1000;

/// Returns a name without the trailing NULs that C programs and Krita append.
pub fn tidy_name(name: &str) -> String {
    name.trim_end_matches('\0').chars().take(LONGEST_NAME).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_may_lie_outside_but_not_beyond_all_measure() {
        assert_eq!(rect_at(-5, 7, 0, 3), Some(PixelRect { x: -5, y: 7, w: 0, h: 3 }));
        assert_eq!(rect_at(0, 0, -1, 3), None);
        assert_eq!(rect_at(LARGEST_OFFSET + 1, 0, 1, 1), None);
        assert_eq!(rect_at(0, 0, 1 << 21, 1), None);
    }

    #[test]
    fn a_canvas_beyond_the_limit_is_told_with_the_limit() {
        assert!(is_canvas(LONGEST_SIDE, 1) && !is_canvas(LONGEST_SIDE + 1, 1) && !is_canvas(0, 1));
        assert_eq!(
            not_a_canvas(2_000_000, 5),
            "a canvas of 2000000 x 5 pixels, expected sides of 1 to 1048576"
        );
    }

    #[test]
    fn a_name_loses_the_nuls_behind_it_and_what_no_name_needs() {
        assert_eq!(tidy_name("a\0b\0\0"), "a\0b");
        assert_eq!(tidy_name(&"ä".repeat(5000)).chars().count(), LONGEST_NAME);
    }
}
