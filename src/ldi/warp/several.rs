//! Views of several layered depth images: the faces of a cube, in their order, or a set, summed up without any.

use super::{Exposed, Plan, SplatKind, WarpOptions, Warped, drawn, level_by, spacings_in_view};
use crate::cube::{axis, faces_in_order};
use crate::layout::Ldi;
use crate::set::{Arrangement, LdiSet};
use crate::transfer::Transfer;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_view::Shot;

/// Makes a view of layered depth images that belong together, as [`super::warp`] makes one of a single image.
///
/// The faces of a cube are drawn one after the other in the order of [`crate::cube`], all at one level, so that the depth
/// pixels on both sides of a seam are equally large. The images of a set are summed up, each with its own level and spacing, the
/// farthest camera first: where sums overflow, the nearest camera's colours stay. A set's picture has the exposure of its first
/// image, to which [`WarpOptions::exposure`] refers, whatever the view.
///
/// # Errors
/// [`Error::Request`] for a set that is not summed up, since its images have no common order; [`Error::Cancelled`].
pub fn warp_set(set: &LdiSet, shot: &Shot, options: &WarpOptions, task: &Task) -> Result<Warped> {
    check_splat(set, options.splat)?;
    let images = in_order(set, shot);
    let exposure = exposures(set, options);
    let level = options.level.or_else(|| common_level(set, shot));
    let options = WarpOptions { level, ..*options };
    let exposed = images.iter().map(|&index| {
        let plan = Plan::new(&set.images[index], shot, &options);
        Exposed { plan, exposure: exposure[index] }
    });
    let exposed: Vec<Exposed> = task.timed("place", || exposed.collect());
    drawn(&exposed, shot, options.splat, task)
}

/// Checks that images can be drawn with a splat.
///
/// # Errors
/// [`Error::Request`] for a set that is not summed up.
pub fn check_splat(set: &LdiSet, splat: SplatKind) -> Result<()> {
    if set.arrangement != Arrangement::Set || splat == SplatKind::Sums {
        return Ok(());
    }
    let found = "the images of a set have no common order in which depth pixels could be drawn over each other; draw it with \
                 sums (--splat sums), or give files of single images";
    Err(Error::Request(found.into()))
}

/// Draws all depth pixels of a view on one canvas as high as the picture, for tests of the order; `begin` is called with the
/// index of each image before its depth pixels are drawn.
#[cfg(test)]
pub fn set_drawn_in_order<C: crate::splat::Canvas>(
    set: &LdiSet,
    shot: &Shot,
    options: &WarpOptions,
    canvas: C,
    begin: impl Fn(C, usize) -> C,
) -> C {
    let draw =
        |canvas, index: usize| Plan::new(&set.images[index], shot, options).draw(0, begin(canvas, index));
    in_order(set, shot).into_iter().fold(canvas, draw)
}

/// Returns the indices of the images in the order in which they are drawn.
fn in_order(set: &LdiSet, shot: &Shot) -> Vec<usize> {
    let viewpoint = shot.viewpoint();
    match set.arrangement {
        Arrangement::Cube => {
            let axes: Vec<_> = set.images.iter().map(|image| axis(&image.pose)).collect();
            let centre = set.images.first().map_or(viewpoint, |image| image.pose.center_in_world());
            faces_in_order(&axes, centre, viewpoint)
        }
        Arrangement::Single | Arrangement::Set => {
            let distance = |index: usize| set.images[index].pose.center_in_world().distance(viewpoint);
            let mut order: Vec<usize> = (0..set.images.len()).collect();
            order.sort_by(|&a, &b| distance(b).total_cmp(&distance(a)));
            order
        }
    }
}

/// Returns natural logarithms of the picture's exposure over that of the colours of each image.
fn exposures(set: &LdiSet, options: &WarpOptions) -> Vec<[f64; 3]> {
    let first = set.images.first().map_or([0.0; 3], |image| image.gain);
    let of = |image: &Ldi| [0, 1, 2].map(|c| options.exposure[c] + (first[c] - image.gain[c]));
    set.images.iter().map(of).collect()
}

/// Returns the level of all faces of a cube; `None` where each image has its own.
pub fn common_level(set: &LdiSet, shot: &Shot) -> Option<u8> {
    let levels = set.images.iter().map(|image| image.levels.len()).min()?;
    if set.arrangement != Arrangement::Cube {
        return None;
    }
    let in_view = |image: &Ldi| {
        let transfer = Transfer::new(&image.levels[0].camera, &image.pose, &shot.camera, &shot.pose);
        spacings_in_view(image, &transfer)
    };
    let mut spacings: Vec<(f64, u64)> = set.images.iter().flat_map(in_view).collect();
    Some(level_by(&mut spacings, levels, shot.quality) as u8)
}
