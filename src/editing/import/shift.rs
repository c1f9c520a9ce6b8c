//! Detection of a moved layer: the offset between exported and edited pixels, found from the pixels themselves.

use rustc_hash::FxHashMap;

use quadratura_base::geometry::PixelRect;
use quadratura_layered_files::Raster;

/// The number of adjacent pixels that form a pattern; three pixels of a photo rarely occur again elsewhere.
const PATTERN: u32 = 3;
/// The number of patterns that are searched for: enough to outvote chance and paint.
const SOUGHT: usize = 4096;
/// The least number of votes for an offset ...
const LEAST_VOTES: usize = 12;
/// ... and its least share of all votes.
const LEAST_SHARE: f64 = 0.3;

/// Returns the offset of `found` from `base`: a pixel of `base` at (x, y) is at (x + dx, y + dy) in `found`. It is
/// determined from patterns of adjacent pixels that occur once in `base`; `None` where too few of them are found
/// again.
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

/// Returns patterns of opaque pixels with their position; `None` for patterns that occur several times.
fn distinctive(raster: &Raster) -> FxHashMap<Pattern, Option<(u32, u32)>> {
    let all = u64::from(raster.width()) * u64::from(raster.height());
    // Every n-th row contains enough patterns; a prime step is not in phase with a periodic facade.
    let step = if all as usize > 64 * SOUGHT { 7 } else { 1 };
    let mut positions = FxHashMap::default();
    each_pattern(raster, |x, y, pattern| {
        if y % step == 0 && pattern[0] != pattern[1] && pattern[1] != pattern[2] {
            positions.entry(pattern).and_modify(|position| *position = None).or_insert(Some((x, y)));
        }
    });
    positions
}

/// Calls `take` for each run of opaque pixels.
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
    use quadratura_base::scene::Samples;
    use quadratura_base::scene::synthetic::Rng;

    fn noise(width: u32, height: u32, seed: u64) -> Raster {
        let mut rng = Rng::new(seed);
        let mut shade = || rng.between(0.0, 255.0) as u8;
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
