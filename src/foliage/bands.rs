//! Plants are drawn in bands of rows, which threads share.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::drawer::{Drawer, FragmentCanvas};
use super::mesh::Meshes;
use super::plant::Plant;
use super::view::View;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::task::Task;

/// The largest number of triangles of all instances that is drawn.
pub const MOST_TRIANGLES: u64 = 1_000_000_000_000;

/// The number of rows that are drawn together. It changes no pixel: bands only share work among threads.
const BAND: u32 = 32;

/// The stage that is reported for drawing the rows of a picture.
pub(super) const STAGE: &str = "draw plant";

/// Draws a plant in bands of rows, which begin as `begun` says; returns what `finished` makes of each, from the top, with the
/// number of triangles.
pub(super) fn drawn<C: FragmentCanvas, T: Send>(
    plant: &Plant,
    view: &View,
    begun: &(dyn Fn(PixelRect) -> C + Sync),
    finished: &(dyn Fn(&C) -> Vec<T> + Sync),
    task: &Task,
) -> Result<Vec<(Vec<T>, u64)>> {
    check(plant, view)?;
    let meshes = Meshes::in_full(plant);
    let rect = view.rect();
    let bands = bands(rect, BAND);
    let done = AtomicU64::new(0);
    bands
        .par_iter()
        .map(|band| {
            let mut drawer = Drawer::new(plant, &meshes, view, *band, begun(*band), task);
            drawer.visit(plant.root, &view.view_from_plant)?;
            let band = (finished(&drawer.canvas), drawer.triangles);
            task.step(STAGE, done.fetch_add(1, Ordering::Relaxed) + 1, bands.len() as u64)?;
            Ok(band)
        })
        .collect()
}

/// Returns bands of up to `rows` rows each, from the top, that together are a view's pixels.
pub(super) fn bands(rect: PixelRect, rows: u32) -> Vec<PixelRect> {
    let band = |y: u32| PixelRect { x: 0, y: y as i32, w: rect.w, h: rows.min(rect.h - y) };
    (0..rect.h).step_by(rows as usize).map(band).collect()
}

/// Refuses what cannot be drawn.
pub(super) fn check(plant: &Plant, view: &View) -> Result<()> {
    let counts = plant.whole().counts;
    if counts.triangles > MOST_TRIANGLES {
        return Err(Error::Request(format!(
            "the plant has {} triangles in {} sub-objects, counting every instance, and drawing polygons is limited to \
             {MOST_TRIANGLES}; give a plant with fewer uses",
            counts.triangles, counts.sub_objects
        )));
    }
    if counts.triangles == 0 {
        return Err(Error::Request("the plant has no polygons, so there is nothing to draw".into()));
    }
    if !view.view_from_plant.is_finite() {
        return Err(Error::Request(
            "the camera's pose is not made of finite numbers; correct the camera".into(),
        ));
    }
    Ok(())
}
