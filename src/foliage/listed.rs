//! What pictures from images of sub-objects have in common: bands of rows, in which what a walk found is drawn, and what that costs.

use std::ops::AddAssign;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3;
use rayon::prelude::*;

use super::bands::{STAGE, bands};
use super::mesh::Meshes;
use super::plant::Plant;
use super::walk::{Drawn, Part};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::light::srgb_from_linear;
use quadratura_base::task::Task;
use quadratura_view::Picture;

/// What a picture from images cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct ImageCost {
    /// The instances that were drawn by images.
    pub images: u64,
    /// The samples that were brought. One near the border of two bands of rows is brought for both.
    pub samples: u64,
    /// The triangles that were projected.
    pub triangles: u64,
}

impl AddAssign for ImageCost {
    fn add_assign(&mut self, other: Self) {
        self.images += other.images;
        self.samples += other.samples;
        self.triangles += other.triangles;
    }
}

/// R, G, B, A of the pixels of a band, and what it cost.
pub(super) type BandPicture = (Vec<u8>, ImageCost);

/// Draws what a walk found in bands of rows, which threads share.
pub(super) fn in_bands(
    rect: PixelRect,
    rows: u32,
    drawn: &[Drawn],
    band: &(dyn Fn(PixelRect) -> Result<BandPicture> + Sync),
    task: &Task,
) -> Result<(Picture, ImageCost)> {
    let bands = bands(rect, rows);
    let done = AtomicU64::new(0);
    let pictures = bands.par_iter().map(|rect| {
        let picture = band(*rect)?;
        task.step(STAGE, done.fetch_add(1, Ordering::Relaxed) + 1, bands.len() as u64)?;
        Ok(picture)
    });
    let pictures: Vec<BandPicture> = pictures.collect::<Result<_>>()?;
    let images = drawn.iter().filter(|drawn| matches!(drawn.part, Part::Image(_))).count() as u64;
    let mut cost = ImageCost { images, ..ImageCost::default() };
    pictures.iter().for_each(|(_, of)| cost += *of);
    let rgba = pictures.into_iter().flat_map(|(rgba, _)| rgba).collect();
    Ok((Picture { width: rect.w, height: rect.h, rgba }, cost))
}

/// Makes the triangles of those sub-objects that are drawn as polygons.
pub(super) fn meshes_of(plant: &Plant, drawn: &[Drawn]) -> Meshes {
    let level = |drawn: &Drawn| match drawn.part {
        Part::Polygons(level) => Some((drawn.object, level)),
        Part::Image(_) => None,
    };
    Meshes::of(plant, drawn.iter().filter_map(level))
}

/// Returns R, G, B, A of a pixel: the mean of light that was summed over the covered ones of its 16 sub-pixels, and their share.
#[inline]
pub(super) fn rgba_of_light(sum: Vec3, covered: u32) -> [u8; 4] {
    let mean = sum / covered.max(1) as f32;
    let byte = |light: f32| (255.0 * srgb_from_linear(f64::from(light).clamp(0.0, 1.0))).round() as u8;
    [byte(mean.x), byte(mean.y), byte(mean.z), ((covered * 255 + 8) / 16) as u8]
}
