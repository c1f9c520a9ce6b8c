//! Cracks: pixels between depth pixels of one surface that no splat reaches.
//!
//! Splats are as large as their depth pixels are apart, also where a view stretches a plane in one direction
//! (`crate::stretch`). Where a plane is unknown, the spacing is one length, and depth pixels of a surface that the reference
//! camera sees at a grazing angle are farther apart in one direction; and no splat reaches farther than its limit. The smaller
//! the picture, the coarser the level, so that in a draft a crack is as wide as in a large picture, and takes up more of it.

use rayon::prelude::*;

use quadratura_view::Picture;

/// The widest crack that is closed, in pixels of the picture.
const WIDEST: i32 = 3;
/// The opacity from which on a pixel is a side of a crack, in 255ths: splats overlap there.
const COVERED: u8 = 250;
/// The directions across a crack, to one side of it.
const ACROSS: [[i32; 2]; 4] = [[1, 0], [0, 1], [1, 1], [1, -1]];

/// Closes cracks: a pixel that is not covered, but lies between covered ones, gets their colours as far as it is empty. Where
/// `faces` says that there is no face (0), such as sky between leaves, nothing is closed.
pub fn closed(picture: &Picture, faces: Option<&[u32]>) -> Picture {
    let width = picture.width as usize;
    let mut rgba = picture.rgba.clone();
    let rows = rgba.par_chunks_mut(4 * width.max(1)).enumerate();
    rows.for_each(|(y, row)| {
        for (x, pixel) in row.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            let is_face = faces.is_none_or(|faces| faces[y * width + x] != 0);
            if pixel[3] < COVERED
                && is_face
                && let Some(sides) = narrowest(picture, [x as i32, y as i32], &|_| true)
            {
                *pixel = filled(*pixel, sides);
            }
        }
    });
    Picture { rgba, ..*picture }
}

/// What a pixel of a blended view shows where a face is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shows {
    /// The face, or there is none.
    Face,
    /// What was filled in: no camera saw most of it.
    Filling,
    /// Something behind the face.
    Behind,
    /// Something before the face.
    Before,
}

/// Closes the cracks of a blended view, and also those one pixel wide through which it shows something else than the face: such a
/// pixel gets the colours of the two beside it if these show the same face. One that shows what is behind its face, and has no such
/// sides, gets the mean colour of those around it that show the face: at outlines and corners splats may end half a spacing before their face does.
/// `faces` has the number of each pixel's face, 0 for none.
pub fn closed_blend(picture: &Picture, faces: &[u32], shows: &[Shows]) -> Picture {
    let width = picture.width as usize;
    let mut rgba = picture.rgba.clone();
    rgba.par_chunks_mut(4 * width.max(1)).enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            let at = y * width + x;
            if matches!(shows[at], Shows::Face | Shows::Before) || faces[at] == 0 {
                continue;
            }
            let is_same = |other: usize| shows[other] == Shows::Face && faces[other] == faces[at];
            let is_crack =
                |sides: &[CrackSide; 2]| sides.iter().all(|side| side.away == 1 && is_same(side.at));
            if let Some(sides) = narrowest(picture, [x as i32, y as i32], &is_crack) {
                *pixel = filled([0; 4], sides);
            } else if shows[at] == Shows::Behind {
                *pixel = mean_around(picture, [x, y], is_same).unwrap_or(*pixel);
            }
        }
    });
    closed(&Picture { rgba, ..*picture }, Some(faces))
}

/// Returns the mean of the covered pixels around a pixel that `counts` permits by their indices; `None` where there is none. For
/// these few pixels, stored values stand for light.
fn mean_around(picture: &Picture, [x, y]: [usize; 2], counts: impl Fn(usize) -> bool) -> Option<[u8; 4]> {
    let [width, height] = [picture.width, picture.height].map(|side| side as usize);
    let rows = y.saturating_sub(1)..(y + 2).min(height);
    let around = rows.flat_map(|v| (x.saturating_sub(1)..(x + 2).min(width)).map(move |u| v * width + u));
    let is_side = |at: &usize| *at != y * width + x && picture.pixels()[*at][3] >= COVERED && counts(*at);
    let sides: Vec<[u8; 4]> = around.filter(is_side).map(|at| picture.pixels()[at]).collect();
    let count = sides.len() as u32;
    let mean =
        |c: usize| ((sides.iter().map(|side| u32::from(side[c])).sum::<u32>() + count / 2) / count) as u8;
    (count > 0).then(|| [mean(0), mean(1), mean(2), mean(3)])
}

/// A covered pixel beside a crack.
#[derive(Debug, Clone, Copy)]
struct CrackSide {
    pixel: [u8; 4],
    /// Its index, row by row.
    at: usize,
    /// How far away it is, in pixels.
    away: i32,
}

/// Returns the sides of the narrowest crack in which a pixel is, of those that `is_crack` permits.
fn narrowest(
    picture: &Picture,
    at: [i32; 2],
    is_crack: &impl Fn(&[CrackSide; 2]) -> bool,
) -> Option<[CrackSide; 2]> {
    let width = |[one, other]: &[CrackSide; 2]| one.away + other.away - 1;
    let cracks = ACROSS.into_iter().filter_map(|[dx, dy]| {
        let sides = [side(picture, at, [dx, dy])?, side(picture, at, [-dx, -dy])?];
        (width(&sides) <= WIDEST && is_crack(&sides)).then_some(sides)
    });
    cracks.min_by_key(width)
}

/// Returns the first covered pixel in a direction.
fn side(picture: &Picture, [x, y]: [i32; 2], [dx, dy]: [i32; 2]) -> Option<CrackSide> {
    let (width, height) = (picture.width as i32, picture.height as i32);
    (1..=WIDEST).find_map(|away| {
        let (x, y) = (x + away * dx, y + away * dy);
        let is_inside = (0..width).contains(&x) && (0..height).contains(&y);
        let at = is_inside.then_some((y * width + x) as usize)?;
        let pixel = picture.pixels()[at];
        (pixel[3] >= COVERED).then_some(CrackSide { pixel, at, away })
    })
}

/// Lays a pixel over the colours between two sides. For this thin line, stored values stand for light.
fn filled(pixel: [u8; 4], [one, other]: [CrackSide; 2]) -> [u8; 4] {
    let share = f32::from(pixel[3]) / 255.0;
    let near_one = other.away as f32 / (one.away + other.away) as f32;
    let value = |c: usize| {
        let between = near_one * f32::from(one.pixel[c]) + (1.0 - near_one) * f32::from(other.pixel[c]);
        (share * f32::from(pixel[c]) + (1.0 - share) * between).round() as u8
    };
    [value(0), value(1), value(2), one.pixel[3].min(other.pixel[3])]
}

#[cfg(test)]
mod tests {
    use super::*;

    const EMPTY: [u8; 4] = [0; 4];

    fn grey(byte: u8) -> [u8; 4] {
        [byte, byte, byte, 255]
    }

    /// Returns a picture of rows of equal pixels.
    fn of_rows(rows: &[[u8; 4]]) -> Picture {
        let rgba = rows.iter().flat_map(|pixel| [*pixel; 5]).flatten().collect();
        Picture { width: 5, height: rows.len() as u32, rgba }
    }

    #[test]
    fn cracks_get_the_colours_of_their_sides_and_wider_holes_stay() {
        let crack = of_rows(&[grey(100), EMPTY, EMPTY, EMPTY, grey(200), grey(200)]);
        let expected = of_rows(&[100, 125, 150, 175, 200, 200].map(grey));
        assert_eq!(closed(&crack, None), expected);
        let hole = of_rows(&[grey(100), EMPTY, EMPTY, EMPTY, EMPTY, grey(200)]);
        assert_eq!(closed(&hole, None), hole);
        let rim = of_rows(&[grey(100), grey(100), [100, 100, 100, 90], EMPTY, EMPTY, EMPTY]);
        assert_eq!(closed(&rim, None), rim, "nothing grows over the rim of a surface");
    }

    #[test]
    fn what_is_in_a_crack_stays_as_far_as_it_covers() {
        let crack = of_rows(&[grey(100), [200, 0, 100, 51], grey(100)]);
        assert_eq!(closed(&crack, None), of_rows(&[grey(100), [120, 80, 100, 255], grey(100)]));
    }

    #[test]
    fn what_was_filled_in_or_is_behind_shows_through_no_crack_of_a_face() {
        use Shows::{Behind, Face, Filling};
        // A crack in a seen surface, a strip that nobody saw, and a crack between two faces.
        let rows = [100, 0, 100, 0, 0, 0, 0, 100, 0, 200].map(grey);
        let faces = [1, 1, 1, 1, 1, 1, 1, 1, 1, 2];
        let of_pixels = |of_row: &[u32; 10]| -> Vec<u32> { (0..50).map(|at| of_row[at / 5]).collect() };
        let closed_as = |wrong: Shows| {
            let shows = [Face, wrong, Face, wrong, wrong, wrong, wrong, Face, wrong, Face];
            let shows: Vec<Shows> = (0..50).map(|at| shows[at / 5]).collect();
            assert_eq!(closed_blend(&of_rows(&rows), &[0; 50], &shows), of_rows(&rows), "there is no face");
            closed_blend(&of_rows(&rows), &of_pixels(&faces), &shows)
        };
        assert_eq!(closed_as(Filling), of_rows(&[100, 100, 100, 0, 0, 0, 0, 100, 0, 200].map(grey)));
        // What is behind a face is no part of it: it gets the colours beside it, one pixel far.
        assert_eq!(closed_as(Behind), of_rows(&[100, 100, 100, 100, 0, 0, 100, 100, 100, 200].map(grey)));
    }

    #[test]
    fn nothing_is_closed_where_no_face_is() {
        let crack = of_rows(&[grey(100), EMPTY, grey(100)]);
        let faces: Vec<u32> = (0..15).map(|index| u32::from(index % 5 == 2)).collect();
        let found = closed(&crack, Some(&faces));
        let middle: Vec<u8> = found.pixels()[5..10].iter().map(|pixel| pixel[3]).collect();
        assert_eq!(middle, [0, 0, 255, 0, 0]);
    }
}
