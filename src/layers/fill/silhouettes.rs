//! The neighbourhood of depth discontinuities in a photo: which pixels lie well inside of what the photo shows of their surface, and
//! which lie clear of the outlines of nearer surfaces.
//!
//! Models are coarse: eaves, dormers and finials that a model lacks overhang what is behind, and a photo shows them where the model has
//! a wall, or a line of trees, behind its outline. Windows and bricks of the one would be continued on the other.

use rayon::prelude::*;

use crate::projected_model::ProjectedModel;

/// The distance in pixels from a depth discontinuity within which a photo is not sampled: models are wrong by
/// a few pixels, and the background at an edge must not be taken for the foreground.
pub(super) const INSIDE_PX: usize = 4;

/// The relative difference of depths that neighbouring pixels may have without a discontinuity, beyond what
/// slopes explain.
const JUMP: f32 = 3e-3;

/// The bit of owners that says that the pixel lies at least [`INSIDE_PX`] inside the area that the
/// photo shows of its surface.
pub(super) const INSIDE: u32 = 1 << 31;

/// The bit of owners that says that the pixel does not lie close behind the outline of a nearer surface.
pub(super) const CLEAR: u32 = 1 << 30;

/// How far what the model lacks overhangs, as a share of the photo's longer side.
const OVERHANG: f64 = 0.004;

/// The same before backdrops, which are behind roofs with all that stands on these.
const OVER_BACKDROPS: f64 = 0.015;

/// Sets [`INSIDE`] at pixels without a depth discontinuity within [`INSIDE_PX`] pixels along rows and
/// columns.
pub(super) fn mark_inside(owners: &mut [u32], view: &ProjectedModel) {
    let (width, height) = (view.width as usize, view.height as usize);
    let unmarked = &*owners;
    let differs = |x: usize, y: usize| {
        let jump_to = |x1: usize, y1: usize| {
            let inside = x1 < width && y1 < height;
            inside && is_jump(view, [unmarked[y * width + x], unmarked[y1 * width + x1]], [x, y], [x1, y1])
        };
        jump_to(x + 1, y)
            || jump_to(x, y + 1)
            || jump_to(x.wrapping_sub(1), y)
            || jump_to(x, y.wrapping_sub(1))
    };
    let mut jumps = vec![0u8; width * height];
    jumps.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        row.iter_mut().enumerate().for_each(|(x, jump)| *jump = differs(x, y).into());
    });
    let wide: Vec<u8> = jumps.par_chunks(width).flat_map_iter(grown_along).collect();
    owners.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        let rows = y.saturating_sub(INSIDE_PX)..(y + INSIDE_PX + 1).min(height);
        for (x, owner) in row.iter_mut().enumerate() {
            if *owner != 0 && rows.clone().all(|y| wide[y * width + x] == 0) {
                *owner |= INSIDE;
            }
        }
    });
}

/// Returns a row in which every mark is extended by [`INSIDE_PX`] to both sides.
fn grown_along(row: &[u8]) -> Vec<u8> {
    let mut grown = vec![0u8; row.len()];
    for (x, _) in row.iter().enumerate().filter(|(_, mark)| **mark != 0) {
        grown[x.saturating_sub(INSIDE_PX)..(x + INSIDE_PX + 1).min(row.len())].fill(1);
    }
    grown
}

/// Returns true when the depth jumps between two neighbouring pixels: neither plane explains the other's
/// depth.
fn is_jump(view: &ProjectedModel, owners: [u32; 2], a: [usize; 2], b: [usize; 2]) -> bool {
    if owners[0] == owners[1] {
        return false;
    }
    if owners.contains(&0) {
        return true;
    }
    let [i, j] = owners.map(|owner| view.items[owner as usize - 1].inverse_depth);
    let off = |p: [usize; 2]| {
        let (x, y) = (p[0] as u32, p[1] as u32);
        let (di, dj) = (i.at(x, y), j.at(x, y));
        let slopes = i.a.abs() + i.b.abs() + j.a.abs() + j.b.abs();
        (di - dj).abs() - slopes - JUMP * di.abs().max(dj.abs())
    };
    off(a).min(off(b)) > 0.0
}

/// Sets [`CLEAR`] at pixels that have no outline of a nearer surface within a distance along their row and column. The items of
/// backdrops have a larger one.
pub(super) fn mark_clear(owners: &mut [u32], view: &ProjectedModel, is_backdrop: &[bool]) {
    let (width, height) = (view.width as usize, view.height as usize);
    let longer = f64::from(view.width.max(view.height));
    let reaches = [OVERHANG, OVER_BACKDROPS].map(|share| (share * longer).round() as u32);
    let reach = |owner: u32| reaches[usize::from(is_backdrop[owner as usize - 1])];
    let bare: Vec<u32> = owners.iter().map(|owner| owner & !INSIDE).collect();
    let is_clear = |line: &[[usize; 2]]| -> Vec<bool> {
        let mut clear = vec![true; line.len()];
        for backwards in [false, true] {
            // The number of pixels since the last outline of something nearer.
            let mut since = u32::MAX;
            for step in 0..line.len() {
                let at = |step: usize| if backwards { line.len() - 1 - step } else { step };
                let owner = |step: usize| bare[line[at(step)][1] * width + line[at(step)][0]];
                if step > 0 {
                    let places = [line[at(step - 1)], line[at(step)]];
                    let pair = [owner(step - 1), owner(step)];
                    // Pixels that are masked or erased hide no outline.
                    let is_outline = !pair.contains(&0) && is_jump(view, pair, places[0], places[1]);
                    since = match is_outline {
                        true if is_farther(view, pair, places) => 0,
                        true => u32::MAX,
                        false => since.saturating_add(1),
                    };
                }
                let own = owner(step);
                clear[at(step)] &= own == 0 || since > reach(own);
            }
        }
        clear
    };
    let rows: Vec<bool> = (0..height)
        .into_par_iter()
        .flat_map_iter(|y| is_clear(&(0..width).map(|x| [x, y]).collect::<Vec<_>>()))
        .collect();
    let columns: Vec<Vec<bool>> = (0..width)
        .into_par_iter()
        .map(|x| is_clear(&(0..height).map(|y| [x, y]).collect::<Vec<_>>()))
        .collect();
    owners.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for (x, owner) in row.iter_mut().enumerate() {
            if *owner != 0 && rows[y * width + x] && columns[x][y] {
                *owner |= CLEAR;
            }
        }
    });
}

/// Returns true when the second of two neighbouring pixels shows something farther than the first.
fn is_farther(view: &ProjectedModel, owners: [u32; 2], places: [[usize; 2]; 2]) -> bool {
    let [near, far] = [0, 1].map(|i| {
        let [x, y] = places[i].map(|at| at as u32);
        view.items[owners[i] as usize - 1].inverse_depth.at(x, y)
    });
    far < near
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::software::owners;
    use quadratura_base::scene::synthetic::closed_form;

    #[test]
    fn what_is_close_behind_an_outline_is_not_clear_and_the_nearer_side_is() {
        let scene = closed_form::two_quads();
        let view = ProjectedModel::new(&scene.model, &scene.camera, &scene.pose);
        let far =
            view.items.iter().position(|item| scene.model.face_name(item.face).starts_with("far")).unwrap();
        let bare = owners(&view, 1e-4);
        let clear_by = |is_backdrop: bool| {
            let mut marked = bare.clone();
            let is_far = |item: usize| is_backdrop && item == far;
            mark_clear(&mut marked, &view, &(0..view.items.len()).map(is_far).collect::<Vec<_>>());
            let (width, height) = (view.width as usize, view.height as usize);
            let (mut unclear, mut farthest) = (0, 0);
            for (at, owner) in bare.iter().enumerate().filter(|(_, owner)| **owner != 0) {
                if marked[at] & CLEAR != 0 {
                    continue;
                }
                assert_eq!(*owner as usize - 1, far, "the nearer surface is whole");
                let (x, y) = (at % width, at / width);
                let is_near = |x: usize, y: usize| bare[y * width + x] != 0 && bare[y * width + x] != *owner;
                let in_row = (0..width).filter(|other| is_near(*other, y)).map(|other| other.abs_diff(x));
                let in_column = (0..height).filter(|other| is_near(x, *other)).map(|other| other.abs_diff(y));
                farthest = farthest.max(in_row.chain(in_column).min().unwrap());
                unclear += 1;
            }
            (unclear, farthest)
        };
        let longer = f64::from(view.width.max(view.height));
        let [(of_wall, wall_px), (of_backdrop, backdrop_px)] = [false, true].map(clear_by);
        assert!(of_wall > 0 && of_backdrop > of_wall, "{of_wall} {of_backdrop}");
        for (farthest, share) in [(wall_px, OVERHANG), (backdrop_px, OVER_BACKDROPS)] {
            assert_eq!(farthest, (share * longer).round() as usize + 1, "of {longer}");
        }
    }
}
