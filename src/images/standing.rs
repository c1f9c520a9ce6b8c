//! What rises above the model's outlines in a photo: cornices, crosses and statues that no face covers. The photo's stack has them
//! in its surroundings, which are infinitely far away; here they come to the depth of the outline on which they are, so that they
//! move with it when the viewpoint moves. [`quadratura_projection::skirts`] does the same for views of all photos together.

use std::collections::VecDeque;
use std::ops::Range;

use glam::DVec2;
use rayon::prelude::*;

use super::cover::FoundPixel;
use super::figures::UNKNOWN_PLANE;
use super::nearest::{NearestMarked, nearest};
use quadratura_base::geometry::PixelRect;
use quadratura_layers::dome::{BLACK, STRAY};
use quadratura_layers::fill::push_pull::WeightedGrid;
use quadratura_ldi::DepthPixelOrigin;
use quadratura_projection::skirts::{is_far_away, rises_above_outline};
use quadratura_stacks::layer_textures::surroundings::WIDTH;
use quadratura_view::agreement::AgreementGrid;
use quadratura_view::srgb::Srgb;

/// The largest distance from a face, in pixels, at which a pixel is beside it: outlines are rounded to pixels, and pixels mix the face
/// with what is behind it.
const BESIDE_PX: f32 = 2.5;

/// The share of a pixel that nearer surfaces must leave for the photo to show what is behind them: most of it.
const SEEN: f32 = 0.5;

/// The share that they must leave for anything of it to be seen: two steps of a byte.
const LEAST_SEEN: f32 = 2.0 / 255.0;

/// The share of a pixel from which on nothing is before what it shows: bytes of mattes are not exact.
const CLEAR: f32 = 0.98;

/// Where a photo's surroundings are near.
pub struct Standing<'a> {
    /// The frame's width in pixels.
    pub width: usize,
    /// Where the photo is in the frame.
    pub photo: PixelRect,
    /// By position in the photo, as large as it is in the frame: how far other photos, and what is far away in this one, confirm the photo's surroundings.
    pub agreement: &'a AgreementGrid,
    /// Whether what is behind them is inpainted from the surroundings beside them; otherwise it is left out.
    pub filled: bool,
}

impl Standing<'_> {
    /// Moves what rises above outlines to their depth: photo pixels of the surroundings, connected with a face, that are not far
    /// away, and all that are beside a face. `rows` are the depth pixels of the photo, by column, in a column nearest first. Returns the number of depth pixels
    /// that were added behind the moved ones.
    pub fn moved(&self, rows: &mut [Vec<FoundPixel>]) -> u64 {
        let depths = nearest_depths(rows, self.width);
        let is_face: Vec<bool> = depths.iter().map(|depth| *depth > 0.0).collect();
        let nearest = nearest(&is_face, self.width);
        let is_beside = |at: usize| nearest[at].distance_px() <= BESIDE_PX;
        let mut is_near = self.rising(rows, is_beside);
        self.add_rims(rows, &mut is_near, &|at| nearest[at].distance_px());
        let seeds = (0..is_near.len()).filter(|at| is_near[*at] && is_beside(*at)).collect();
        is_near = connected(&is_near, self.width, seeds);
        let seam = if self.filled { self.seam(&is_face, &is_near) } else { vec![false; is_near.len()] };
        let is_guess: Vec<bool> = is_near.iter().zip(&seam).map(|(near, seam)| *near || *seam).collect();
        let colours = if self.filled { self.behind(rows, &is_guess) } else { None };
        let moved = rows.par_iter_mut().enumerate().map(|(y, row)| {
            let mut added = Vec::new();
            let mut before = None;
            let shares = self.shares_seen(row, y);
            for (place, (found, seen)) in row.iter_mut().zip(shares).enumerate() {
                let nearer = before.filter(|(column, _)| *column == found.column).map(|(_, depth)| depth);
                before = Some((found.column, found.inverse_depth));
                let at = y * self.width + usize::from(found.column);
                let is_hidden = seen <= LEAST_SEEN && found.inverse_depth == 0.0;
                if seam[at] && is_hidden && found.origin != DepthPixelOrigin::Paint {
                    if let Some(colours) = &colours {
                        found.colour = colours.at(found.column, y);
                        found.origin = DepthPixelOrigin::Invented;
                    }
                    continue;
                }
                let Some(face) = nearest[at].index().filter(|_| is_near[at] && seen > LEAST_SEEN) else {
                    continue;
                };
                let behind = colours.as_ref().map(|colours| FoundPixel {
                    colour: colours.at(found.column, y),
                    origin: DepthPixelOrigin::Invented,
                    ..*found
                });
                // What hardly shows through something nearer is hidden in the photo: its colour is a guess, and this a better one.
                if seen <= SEEN {
                    *found = behind.unwrap_or(*found);
                    continue;
                }
                added.extend(behind.map(|behind| (place + 1, behind)));
                // Behind what one sees through, it is right behind that.
                let most = nearer.map_or(f32::INFINITY, |nearer: f32| nearer.next_down());
                (found.inverse_depth, found.plane) = (depths[face].min(most), UNKNOWN_PLANE);
            }
            let count = added.len() as u64;
            added.into_iter().rev().for_each(|(place, behind)| row.insert(place, behind));
            count
        });
        moved.sum()
    }

    /// Returns where a face hides surroundings, beside some that are moved to its depth: layers continue past outlines with the colours of
    /// the pixels there, which are those of what stands on the outline, or mixed with the face's.
    fn seam(&self, is_face: &[bool], is_near: &[bool]) -> Vec<bool> {
        let is_open: Vec<bool> = is_face.iter().map(|is_face| !is_face).collect();
        let is_seam = |nearest: NearestMarked| {
            let distance_px = nearest.distance_px();
            distance_px > 0.0 && distance_px <= BESIDE_PX && nearest.index().is_some_and(|at| is_near[at])
        };
        nearest(&is_open, self.width).into_iter().map(is_seam).collect()
    }

    /// Returns where the photo shows surroundings that are not far away, or beside a face.
    fn rising(&self, rows: &[Vec<FoundPixel>], is_beside: impl Fn(usize) -> bool + Sync) -> Vec<bool> {
        let mut rising = vec![false; rows.len() * self.width];
        rising.par_chunks_exact_mut(self.width).zip(rows).enumerate().for_each(|(y, (rising, row))| {
            for (found, _) in row.iter().zip(self.shares_seen(row, y)).filter(|(_, seen)| *seen > SEEN) {
                let x = usize::from(found.column);
                rising[x] =
                    is_beside(y * self.width + x) || rises_above_outline(self.agreement_at(found.column, y));
            }
        });
        rising
    }

    /// Returns for each depth pixel of a row how much of it the photo itself shows, if it is of the surroundings and no paint; 0 for
    /// all others. What the photo shows through the gaps of a see-through surface counts, wherever its colour was taken from.
    fn shares_seen(&self, row: &[FoundPixel], y: usize) -> Vec<f32> {
        let mut left = (None, 1.0);
        let seen = |found: &FoundPixel| {
            if left.0 != Some(found.column) {
                left = (Some(found.column), 1.0);
            }
            let seen = left.1;
            left.1 *= 1.0 - f32::from(found.colour[3]) / 255.0;
            let is_own = self.photo.contains(i32::from(found.column), y as i32)
                && found.inverse_depth == 0.0
                && found.origin != DepthPixelOrigin::Paint;
            if is_own { seen } else { 0.0 }
        };
        row.iter().map(seen).collect()
    }

    /// Adds the rims of what stands on outlines, farther from faces than [`BESIDE_PX`]: surroundings beside a face, as far as photos are
    /// trusted less there ([`WIDTH`]), whose colours stray from those farther out as far as no photo may in the dome ([`STRAY`]), or that show
    /// through something nearer, so that their colours are guesses.
    fn add_rims(
        &self,
        rows: &[Vec<FoundPixel>],
        is_near: &mut [bool],
        distance_px: &(impl Fn(usize) -> f32 + Sync),
    ) {
        let rim = (WIDTH * f64::from(self.photo.w.max(self.photo.h))) as f32;
        // All of it is left out of what it is compared with.
        let in_rim: Vec<bool> = (0..is_near.len()).map(|at| is_near[at] || distance_px(at) <= rim).collect();
        let Some(around) = self.behind(rows, &in_rim) else { return };
        is_near.par_chunks_exact_mut(self.width).zip(rows).enumerate().for_each(|(y, (is_near, row))| {
            for (found, seen) in
                row.iter().zip(self.shares_seen(row, y)).filter(|(_, seen)| *seen > LEAST_SEEN)
            {
                let x = usize::from(found.column);
                let is_other = || seen < CLEAR || around.differs(found.colour, found.column, y);
                is_near[x] |= in_rim[y * self.width + x] && is_other();
            }
        });
    }

    /// Returns the agreement at the centre of a pixel of the frame, 1 outside of the photo.
    fn agreement_at(&self, column: u16, y: usize) -> f64 {
        let corner = DVec2::new(f64::from(self.photo.x), f64::from(self.photo.y));
        let centre = DVec2::new(f64::from(column) + 0.5, y as f64 + 0.5);
        match self.photo.contains(i32::from(column), y as i32) {
            true => self.agreement.at(centre - corner),
            false => 1.0,
        }
    }

    /// Inpaints the surroundings behind pixels that are near from those beside them that are far away; `None` where none is, or
    /// nothing is near.
    fn behind(&self, rows: &[Vec<FoundPixel>], is_near: &[bool]) -> Option<Behind> {
        let near = || (0..is_near.len()).filter(|at| is_near[*at]);
        let (first, last) = (near().next()?, near().next_back()?);
        // The far pixels that are next to near ones decide; a margin holds some of them.
        let margin = self.width / 16 + 8;
        let of_row = |y: usize| &is_near[y * self.width..(y + 1) * self.width];
        let rows_of = first / self.width..last / self.width + 1;
        let left = rows_of.clone().filter_map(|y| of_row(y).iter().position(|near| *near)).min()?;
        let right = rows_of.clone().filter_map(|y| of_row(y).iter().rposition(|near| *near)).max()?;
        let columns = left.saturating_sub(margin)..(right + 1 + margin).min(self.width);
        let rows_of = rows_of.start.saturating_sub(margin)..(rows_of.end + margin).min(rows.len());
        let mut grid = WeightedGrid::new([columns.len(), rows_of.len()]);
        let srgb = Srgb::tables();
        for (grid_row, y) in rows_of.clone().enumerate() {
            for found in
                rows[y].iter().filter(|found| found.inverse_depth == 0.0 && found.colour[3] == u8::MAX)
            {
                let x = usize::from(found.column);
                let is_known = columns.contains(&x)
                    && !is_near[y * self.width + x]
                    && is_far_away(self.agreement_at(found.column, y));
                if is_known {
                    let at = grid_row * columns.len() + (x - columns.start);
                    let [r, g, b, _] = found.colour;
                    (grid.values[at], grid.weights[at]) = ([r, g, b].map(|value| srgb.linear(value)), 1.0);
                }
            }
        }
        Some(Behind { light: grid.filled()?, columns, top: rows_of.start, srgb })
    }
}

/// The inpainted surroundings of a part of the photo, linear light row by row.
struct Behind {
    light: Vec<[f32; 3]>,
    columns: Range<usize>,
    top: usize,
    srgb: Srgb,
}

impl Behind {
    /// Returns whether a colour is none of the surroundings at a pixel.
    fn differs(&self, [r, g, b, _]: [u8; 4], column: u16, y: usize) -> bool {
        let around = self.light[self.index(column, y)];
        let apart =
            |(value, light): (u8, f32)| (self.srgb.linear(value).max(BLACK) / light.max(BLACK)).ln().abs();
        [r, g, b].into_iter().zip(around).map(apart).sum::<f32>() / 3.0 > STRAY
    }

    fn index(&self, column: u16, y: usize) -> usize {
        (y - self.top) * self.columns.len() + usize::from(column) - self.columns.start
    }

    fn at(&self, column: u16, y: usize) -> [u8; 4] {
        let [r, g, b] = self.light[self.index(column, y)].map(|light| self.srgb.encoded(light));
        [r, g, b, u8::MAX]
    }
}

/// Returns the inverse depth of the nearest depth pixel of each pixel; 0 where there is none.
fn nearest_depths(rows: &[Vec<FoundPixel>], width: usize) -> Vec<f32> {
    let mut depths = vec![0.0; rows.len() * width];
    depths.par_chunks_exact_mut(width).zip(rows).for_each(|(depths, row)| {
        for found in row.iter().rev() {
            depths[usize::from(found.column)] = found.inverse_depth;
        }
    });
    depths
}

/// Returns the marked pixels that are connected with some of them, by sides and corners.
fn connected(marked: &[bool], width: usize, mut open: VecDeque<usize>) -> Vec<bool> {
    let height = marked.len() / width.max(1);
    let mut found = vec![false; marked.len()];
    open.iter().for_each(|at| found[*at] = true);
    while let Some(at) = open.pop_front() {
        let (x, y) = (at % width, at / width);
        for v in y.saturating_sub(1)..(y + 2).min(height) {
            for u in x.saturating_sub(1)..(x + 2).min(width) {
                let next = v * width + u;
                if marked[next] && !found[next] {
                    found[next] = true;
                    open.push_back(next);
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::FaceId;
    use quadratura_view::agreement::{ContradictedPixel, PhotoAgreement};

    const SKY: [u8; 4] = [90, 130, 180, 255];
    const STONE: [u8; 4] = [150, 130, 100, 255];

    /// A wall at depth 4 from row 20 on with a statue on it, a bird in the sky, and the sky behind all of them.
    fn rows() -> Vec<Vec<FoundPixel>> {
        let row = |y: usize| {
            let pixel = |column: u16| {
                let is_stone = is_statue(column, y) || is_bird(column, y);
                let colour = if is_stone { STONE } else { SKY };
                let sky = FoundPixel {
                    column,
                    origin: DepthPixelOrigin::Photo,
                    inverse_depth: 0.0,
                    colour,
                    plane: 1,
                };
                let wall = FoundPixel { inverse_depth: 0.25, colour: STONE, plane: 0, ..sky };
                if y >= 20 { wall } else { sky }
            };
            (0..60).map(pixel).collect()
        };
        (0..30).map(row).collect()
    }

    fn standing(agreement: &AgreementGrid, filled: bool) -> Standing<'_> {
        Standing { width: 60, photo: PixelRect::of_size(60, 30), agreement, filled }
    }

    fn is_statue(column: u16, y: usize) -> bool {
        (20..26).contains(&column) && (8..20).contains(&y)
    }

    fn is_bird(column: u16, y: usize) -> bool {
        (50..54).contains(&column) && (3..6).contains(&y)
    }

    /// Everything of stone in the sky is contradicted.
    fn agreement() -> AgreementGrid {
        let stone = |(x, y): (u16, u16)| is_statue(x, usize::from(y)) || is_bird(x, usize::from(y));
        let places = (0..30u16).flat_map(|y| (0..60u16).map(move |x| (x, y))).filter(|place| stone(*place));
        let pixel =
            |(x, y): (u16, u16)| ContradictedPixel { at: [x, y], face: FaceId(u32::MAX), agreement: 3 };
        let contradicted = places.map(pixel).collect();
        PhotoAgreement { size: [60, 30], contradicted, beside: Vec::new() }.whole([60, 30])
    }

    #[test]
    fn a_statue_is_as_deep_as_the_wall_below_it_and_a_bird_stays_in_the_sky() {
        let (before, mut rows) = (rows(), rows());
        let added = standing(&agreement(), true).moved(&mut rows);
        assert_eq!(added, 6 * 10 + 2 * 60);
        for (y, (row, was)) in rows.iter().zip(&before).enumerate() {
            for found in was {
                let pixels: Vec<&FoundPixel> =
                    row.iter().filter(|other| other.column == found.column).collect();
                assert_eq!(pixels[0].colour, found.colour, "the photo is seen as before");
                // Two rows beside the wall come with it, too.
                if is_statue(found.column, y) || (18..20).contains(&y) {
                    assert_eq!((pixels[0].inverse_depth, pixels[0].plane), (0.25, UNKNOWN_PLANE));
                    assert_eq!((pixels[1].inverse_depth, pixels[1].plane), (0.0, 1));
                    assert_eq!(pixels[1].origin, DepthPixelOrigin::Invented);
                    // All of the sky has one colour, which is rounded once.
                    assert!((0..3).all(|c| pixels[1].colour[c].abs_diff(SKY[c]) <= 1));
                } else {
                    assert_eq!(pixels, [found], "column {} of row {y}", found.column);
                }
            }
        }
    }

    #[test]
    fn surroundings_that_a_face_hides_beside_its_outline_are_inpainted_and_paint_is_not() {
        let mut rows = rows();
        // Behind the wall the sky goes on; along the outline with the wall's colour, as layers are continued.
        for (y, row) in rows.iter_mut().enumerate().skip(20) {
            let behind = |wall: &FoundPixel| FoundPixel {
                inverse_depth: 0.0,
                origin: if wall.column < 30 { DepthPixelOrigin::Invented } else { DepthPixelOrigin::Paint },
                colour: if y < 22 { STONE } else { SKY },
                plane: 1,
                ..*wall
            };
            *row = row.iter().flat_map(|wall| [*wall, behind(wall)]).collect();
        }
        standing(&agreement(), true).moved(&mut rows);
        let hidden = |column: u16, y: usize| {
            *rows[y].iter().rfind(|found| found.column == column && found.inverse_depth == 0.0).unwrap()
        };
        for y in [18, 20, 21, 25] {
            let colour = hidden(10, y).colour;
            assert!((0..3).all(|c| colour[c].abs_diff(SKY[c]) <= 1), "{colour:?} in row {y}");
        }
        assert_eq!((hidden(40, 20).colour, hidden(40, 20).origin), (STONE, DepthPixelOrigin::Paint));
        assert_eq!(rows[20][0].inverse_depth, 0.25, "the wall stays");
    }

    #[test]
    fn what_is_behind_a_see_through_pixel_comes_right_behind_it() {
        let mut rows = rows();
        let leaf = |alpha: u8, pixel: &FoundPixel| {
            let [r, g, b, _] = pixel.colour;
            FoundPixel { inverse_depth: 0.5, plane: 2, colour: [r, g, b, alpha], ..*pixel }
        };
        // What is behind may have its colour from anywhere; behind an opaque leaf it is not what the photo shows.
        rows[10][22].origin = DepthPixelOrigin::OtherPhotos;
        let (sparse, dense) = (leaf(90, &rows[10][22]), leaf(200, &rows[10][24]));
        rows[10].insert(24, dense);
        rows[10].insert(22, sparse);
        standing(&agreement(), true).moved(&mut rows);
        let depths = |column: u16| -> Vec<f32> {
            rows[10].iter().filter(|found| found.column == column).map(|found| found.inverse_depth).collect()
        };
        assert_eq!(depths(22), [0.5, 0.5f32.next_down(), 0.0]);
        assert_eq!(depths(24), [0.5, 0.0]);
    }

    #[test]
    fn a_rim_that_differs_from_the_sky_comes_with_the_wall() {
        let is_rim = |x: u16, y: usize| (300..500).contains(&x) && (36..40).contains(&y);
        let row = |y: usize| -> Vec<FoundPixel> {
            let pixel = |column: u16| {
                let stone = is_rim(column, y) || y >= 40;
                let (colour, inverse_depth) =
                    (if stone { STONE } else { SKY }, if y < 40 { 0.0 } else { 0.25 });
                FoundPixel { column, origin: DepthPixelOrigin::Photo, inverse_depth, colour, plane: 0 }
            };
            (0..1000).map(pixel).collect()
        };
        let mut rows: Vec<Vec<FoundPixel>> = (0..60).map(row).collect();
        let agreement = PhotoAgreement { size: [1000, 60], contradicted: Vec::new(), beside: Vec::new() };
        let (agreement, photo) = (agreement.whole([1000, 60]), PixelRect::of_size(1000, 60));
        Standing { width: 1000, photo, agreement: &agreement, filled: true }.moved(&mut rows);
        for (y, row) in rows.iter().enumerate().take(40) {
            for found in row.chunk_by(|a, b| a.column == b.column) {
                // All of the rim, and two rows of the sky.
                let is_near = is_rim(found[0].column, y) || y >= 38;
                assert_eq!(found[0].inverse_depth > 0.0, is_near, "column {} of row {y}", found[0].column);
                let farthest = found[found.len() - 1];
                assert!((0..3).all(|c| farthest.colour[c].abs_diff(SKY[c]) <= 1), "the sky is behind it");
                assert_eq!((found.len(), farthest.inverse_depth), (1 + usize::from(is_near), 0.0));
            }
        }
    }

    #[test]
    fn outside_of_the_photo_everything_is_far_away() {
        let (before, mut rows) = (rows(), rows());
        let photo = PixelRect { x: 0, y: 0, w: 10, h: 30 };
        let added = Standing { photo, ..standing(&agreement(), true) }.moved(&mut rows);
        assert_eq!((added, &rows[..18]), (2 * 10, &before[..18]), "but for what is beside the wall");
        let outside =
            |row: &[FoundPixel]| row.iter().filter(|found| found.column >= 10).cloned().collect::<Vec<_>>();
        assert!(rows.iter().zip(&before).all(|(row, before)| outside(row) == outside(before)));
    }

    #[test]
    fn without_filling_nothing_is_behind_it() {
        let mut rows = rows();
        let added = standing(&agreement(), false).moved(&mut rows);
        assert_eq!(added, 0);
        assert!(rows.iter().all(|row| row.len() == 60));
    }

    #[test]
    fn paint_stays_where_it_was_painted() {
        let mut rows = rows();
        rows.iter_mut().flatten().for_each(|found| found.origin = DepthPixelOrigin::Paint);
        let before = rows.clone();
        standing(&agreement(), true).moved(&mut rows);
        assert_eq!(rows, before);
    }
}
