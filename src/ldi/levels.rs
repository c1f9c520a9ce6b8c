//! Levels of half the resolution: 2 x 2 layered depth pixels become one, so that distant views move fewer pixels.

use glam::DVec3;
use rayon::prelude::*;

use super::layout::{DepthPixel, LdiSurface, ResolutionLevel};
use super::merge::{Merging, SurfaceSample, merge_into};
use quadratura_base::geometry::Pinhole;

/// Levels end where the longer side of the frame is no longer than this, in pixels.
const SMALLEST: u32 = 16;

/// Returns the levels of a layered depth image from its first one on.
pub fn pyramid(first: ResolutionLevel, surfaces: &[LdiSurface]) -> Vec<ResolutionLevel> {
    let mut levels = vec![first];
    let mut pixel_size = 1.0;
    while let Some(last) = levels.last().filter(|last| last.camera.width.max(last.camera.height) > SMALLEST) {
        pixel_size *= 2.0;
        levels.push(halved(last, surfaces, pixel_size));
    }
    levels
}

/// Returns a camera of half the resolution.
pub fn half_camera(camera: &Pinhole) -> Pinhole {
    let Pinhole { width, height, fx, fy, cx, cy } = *camera;
    let [fx, fy, cx, cy] = [fx, fy, cx, cy].map(|value| value / 2.0);
    Pinhole { width: width.div_ceil(2), height: height.div_ceil(2), fx, fy, cx, cy }
}

/// Returns surfaces as they are in a frame whose pixels have `pixel_size` of those of theirs as side.
pub fn surfaces_at(surfaces: &[LdiSurface], pixel_size: f64) -> Vec<LdiSurface> {
    let resized = |surface: &LdiSurface| LdiSurface {
        nu: surface.nu * DVec3::new(pixel_size, pixel_size, 1.0),
        ..surface.clone()
    };
    surfaces.iter().map(resized).collect()
}

/// Returns the level of half the resolution; its pixels have `pixel_size` of those of the frame as side.
fn halved(level: &ResolutionLevel, surfaces: &[LdiSurface], pixel_size: f64) -> ResolutionLevel {
    let camera = half_camera(&level.camera);
    let merging = Merging { layers: usize::from(u8::MAX), ..Merging::default() };
    let row = |y: u32| {
        let mut out: Vec<(u16, DepthPixel)> = Vec::new();
        let mut samples = Vec::new();
        let fine = [2 * y, 2 * y + 1].map(|y| if y < level.camera.height { level.row(y) } else { 0..0 });
        let mut at = fine.clone().map(|range| range.start);
        // The next column of either row, of the coarse level.
        let next = |row: usize, at: usize| (at < fine[row].end).then(|| level.columns[at] / 2);
        while let Some(column) = [next(0, at[0]), next(1, at[1])].into_iter().flatten().min() {
            samples.clear();
            for (row, at) in at.iter_mut().enumerate() {
                while next(row, *at) == Some(column) {
                    let pixel = level.pixel(*at);
                    let (place, hidden) = (*at as u32, level.is_hidden(*at));
                    samples.push(SurfaceSample { pixel, source: 0, place, weight: 1.0, hidden });
                    *at += 1;
                }
            }
            merge_into(&mut samples, surfaces, pixel_size, &merging, |pixel| out.push((column, pixel)));
        }
        out
    };
    let rows: Vec<_> = (0..camera.height).into_par_iter().map(row).collect();
    ResolutionLevel::of_rows(camera, rows)
}
