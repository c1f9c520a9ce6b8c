//! Where a layer lies: the offset between what was exported and what came back, told from the pixels themselves.

use rustc_hash::FxHashMap;

use crate::geometry::PixelRect;
use crate::io::layered::Raster;

/// Neighbouring pixels that make a pattern; three of a photo are seldom the same anywhere else.
const PATTERN: u32 = 3;
/// Patterns that are looked for: enough to outvote chance and paint.
const SOUGHT: usize = 4096;
/// An offset needs so many votes at least, and ...
const LEAST_VOTES: usize = 12;
/// ... this share of all that were found somewhere.
const LEAST_SHARE: f64 = 0.3;

/// By how much `found` lies beside where `base` says: a pixel of `base` at (x, y) is at (x + dx, y + dy). Told by
/// patterns of neighbouring pixels that `base` has once; none where too few of them are found again.
pub fn shift(base: &Raster, at: PixelRect, found: &Raster, found_at: PixelRect) -> Option<[i32; 2]> {
    let wanted = distinctive(base);
    let mut votes: FxHashMap<[i32; 2], usize> = FxHashMap::default();
    let mut total = 0;
    each_pattern(found, |x, y, pattern| {
        if let Some(Some((bx, by))) = wanted.get(&pattern) {
            let (old_x, old_y) = (at.x + *bx as i32, at.y + *by as i32);
            *votes.entry([found_at.x + x as i32 - old_x, found_at.y + y as i32 - old_y]).or_default() += 1;
            total += 1;
        }
    });
    let (offset, count) =
        votes.into_iter().max_by_key(|(offset, count)| (*count, std::cmp::Reverse(*offset)))?;
    (count >= LEAST_VOTES && count as f64 >= LEAST_SHARE * total as f64).then_some(offset)
}

type Pattern = [[u16; 4]; PATTERN as usize];

/// Patterns of opaque pixels with their place; `None` where there are several.
fn distinctive(raster: &Raster) -> FxHashMap<Pattern, Option<(u32, u32)>> {
    let all = u64::from(raster.width()) * u64::from(raster.height());
    // Every so manieth row holds enough of them; a prime step meets no rhythm of the facade.
    let step = if all as usize > 64 * SOUGHT { 7 } else { 1 };
    let mut places = FxHashMap::default();
    each_pattern(raster, |x, y, pattern| {
        if y % step == 0 && pattern[0] != pattern[1] && pattern[1] != pattern[2] {
            places.entry(pattern).and_modify(|place| *place = None).or_insert(Some((x, y)));
        }
    });
    places
}

/// Calls `take` for every run of opaque pixels.
fn each_pattern(raster: &Raster, mut take: impl FnMut(u32, u32, Pattern)) {
    for y in 0..raster.height() {
        for x in 0..raster.width().saturating_sub(PATTERN - 1) {
            let pattern: Pattern = std::array::from_fn(|i| raster.rgba16(x + i as u32, y));
            if pattern.iter().all(|pixel| pixel[3] == u16::MAX) {
                take(x, y, pattern);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Samples;
    use crate::scene::synthetic::Dice;

    fn noise(width: u32, height: u32, seed: u64) -> Raster {
        let mut dice = Dice::new(seed);
        let mut shade = || dice.between(0.0, 255.0) as u8;
        let samples = (0..width * height).flat_map(|_| [shade(), shade(), shade(), 255]);
        Raster::new(width, height, Samples::U8(samples.collect()))
    }

    const AT: PixelRect = PixelRect { x: 10, y: 20, w: 40, h: 30 };

    #[test]
    fn a_layer_that_was_moved_cropped_and_painted_on_is_found() {
        let base = noise(40, 30, 5);
        let part = PixelRect { x: 4, y: 3, w: 30, h: 20 };
        let mut found = base.clone().cropped(part);
        (0..200).for_each(|i| found.set_rgba16(i % 30, i / 30, [257, 0, 0, 65535]));
        let found_at = PixelRect { x: 10 + 4 - 7, y: 20 + 3 + 2, w: 30, h: 20 };
        assert_eq!(shift(&base, AT, &found, found_at), Some([-7, 2]));
    }

    #[test]
    fn in_other_pixels_nothing_is_found() {
        assert_eq!(shift(&noise(40, 30, 5), AT, &noise(40, 30, 77), AT), None);
        let plain = Raster::new(40, 30, Samples::U8(vec![255; 4800]));
        assert_eq!(shift(&plain, AT, &plain, AT), None, "it could lie anywhere");
    }
}
