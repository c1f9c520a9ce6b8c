//! Brute force: every polygon of every instance is drawn, with 16 sub-pixels a pixel. It is the truth that other ways of
//! drawing plants are compared with.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DMat3, Vec3};
use rayon::prelude::*;

use super::drawer::{Canvas, Drawer, Facet};
use super::mesh::Mesh;
use super::plant::Plant;
use super::raster::Fragment;
use super::shade::{Light, Surface, shade};
use super::view::View;
use crate::error::{Error, Result};
use crate::geometry::PixelRect;
use crate::projection::Picture;
use crate::scene::light::srgb_from_linear;
use crate::task::Task;

/// The largest number of triangles of all instances that is drawn.
pub const MOST_TRIANGLES: u64 = 1_000_000_000_000;

/// The number of rows that are drawn together. It changes no pixel: bands only share work among threads.
const BAND: u32 = 32;

/// The stage that is reported for drawing the rows of a picture.
const STAGE: &str = "draw plant";

/// A picture of a plant, and what it cost.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// The picture; alpha is the share of a pixel's sub-pixels that are covered.
    pub picture: Picture,
    /// The triangles that were projected. One near the border of two bands of rows is projected for both.
    pub triangles: u64,
}

/// Draws a plant.
///
/// # Errors
/// [`Error::Request`] for a plant of more than [`MOST_TRIANGLES`] or of none, and for a view that is not made of finite
/// numbers; [`Error::Cancelled`].
pub fn draw(plant: &Plant, view: &View, light: &Light, task: &Task) -> Result<Drawing> {
    let lit = Lit { light: *light, light_from_view: view.light_from_view };
    let drawn = drawn(plant, view, &|rect| Band::new(rect, lit), &Band::resolve, task)?;
    let triangles = drawn.iter().map(|(_, triangles)| triangles).sum();
    let rgba = drawn.into_iter().flat_map(|(rgba, _)| rgba).collect();
    let rect = view.rect();
    Ok(Drawing { picture: Picture { width: rect.w, height: rect.h, rgba }, triangles })
}

/// Finds the pixels of which a plant covers some sub-pixel, row by row, except where something else is nearer: `hiding` holds
/// the nearness of that ([`Projection::image_from_view`]) at the centre of each pixel.
///
/// # Errors
/// Those of [`draw`].
pub fn silhouette(plant: &Plant, view: &View, hiding: &[f32], task: &Task) -> Result<Vec<bool>> {
    let rows = |rect: PixelRect| &hiding[(rect.y as usize * rect.w as usize)..][..rect.area() as usize];
    let lit = Lit { light: Light::day(plant.up), light_from_view: view.light_from_view };
    let behind = |rect| Band::behind(rect, lit, rows(rect));
    let covered = |band: &Band| {
        let subpixels = band.nearness.as_chunks::<16>().0.iter().zip(rows(band.rect));
        subpixels.map(|(found, hiding)| found.iter().any(|found| found > hiding)).collect()
    };
    let drawn = drawn(plant, view, &behind, &covered, task)?;
    Ok(drawn.into_iter().flat_map(|(covered, _)| covered).collect())
}

/// Draws a plant in bands of rows, which begin as `begun` says; returns what `finished` makes of each, from the top, with the
/// number of triangles.
fn drawn<T: Send>(
    plant: &Plant,
    view: &View,
    begun: &(dyn Fn(PixelRect) -> Band + Sync),
    finished: &(dyn Fn(&Band) -> Vec<T> + Sync),
    task: &Task,
) -> Result<Vec<(Vec<T>, u64)>> {
    check(plant, view)?;
    let meshes: Vec<Vec<Mesh>> = plant.objects.par_iter().map(Mesh::of).collect();
    let rect = view.rect();
    let bands: Vec<PixelRect> = (0..rect.h)
        .step_by(BAND as usize)
        .map(|y| PixelRect { x: 0, y: y as i32, w: rect.w, h: BAND.min(rect.h - y) })
        .collect();
    let done = AtomicU64::new(0);
    bands
        .par_iter()
        .map(|band| {
            let mut drawer = Drawer::new((plant, &meshes), view, (*band, begun(*band)), task);
            drawer.visit(plant.root, &view.view_from_plant)?;
            let band = (finished(&drawer.canvas), drawer.triangles);
            task.step(STAGE, done.fetch_add(1, Ordering::Relaxed) + 1, bands.len() as u64)?;
            Ok(band)
        })
        .collect()
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

/// The light on what is drawn.
#[derive(Debug, Clone, Copy)]
struct Lit {
    light: Light,
    light_from_view: DMat3,
}

/// The sub-pixels of a band of rows.
struct Band {
    rect: PixelRect,
    lit: Lit,
    /// 16 a pixel: how near, lower than everything where nothing is.
    nearness: Vec<f32>,
    /// 16 a pixel: linear light.
    light: Vec<Vec3>,
}

impl Band {
    fn new(rect: PixelRect, lit: Lit) -> Self {
        let count = 16 * rect.area() as usize;
        Self { rect, lit, nearness: vec![f32::NEG_INFINITY; count], light: vec![Vec3::ZERO; count] }
    }

    /// Makes a band behind something that is this near at each pixel.
    fn behind(rect: PixelRect, lit: Lit, hiding: &[f32]) -> Self {
        let nearness = hiding.iter().flat_map(|nearness| [*nearness; 16]).collect();
        Self { nearness, ..Self::new(rect, lit) }
    }

    /// Returns R, G, B, A of the pixels: the mean light of the covered sub-pixels, and their share.
    fn resolve(&self) -> Vec<u8> {
        let subpixels = self.nearness.as_chunks::<16>().0.iter().zip(self.light.as_chunks::<16>().0);
        let pixel = |(nearness, light): (&[f32; 16], &[Vec3; 16])| {
            let covered = nearness.iter().filter(|nearness| **nearness > f32::NEG_INFINITY).count();
            // Those that are not covered are black.
            let mean = light.iter().sum::<Vec3>() / covered.max(1) as f32;
            let byte =
                |light: f32| (255.0 * srgb_from_linear(f64::from(light).clamp(0.0, 1.0))).round() as u8;
            [byte(mean.x), byte(mean.y), byte(mean.z), ((covered * 255 + 8) / 16) as u8]
        };
        subpixels.flat_map(pixel).collect()
    }
}

impl Canvas for Band {
    /// Those that are nearer than what is there: of equals the first one stays.
    #[inline]
    fn visible(&self, fragment: &Fragment) -> u16 {
        let first = 16 * self.rect.offset(fragment.x, fragment.y);
        let behind = &self.nearness[first..first + 16];
        let (mut left, mut visible) = (fragment.mask, 0);
        while left != 0 {
            let bit = left.trailing_zeros() as usize;
            left &= left - 1;
            visible |= u16::from(fragment.nearness[bit] > behind[bit]) << bit;
        }
        visible
    }

    #[inline]
    fn put(&mut self, fragment: &Fragment, visible: u16, facet: &Facet) {
        let normal = (self.lit.light_from_view * facet.normal).normalize_or_zero();
        let surface = Surface { normal, reflected: facet.reflected, through: facet.through };
        let light = shade(&surface, &self.lit.light);
        let first = 16 * self.rect.offset(fragment.x, fragment.y);
        let mut left = visible;
        while left != 0 {
            let bit = left.trailing_zeros() as usize;
            left &= left - 1;
            self.nearness[first + bit] = fragment.nearness[bit];
            self.light[first + bit] = light;
        }
    }
}
