//! Brute force: every polygon of every instance is drawn, with 16 sub-pixels a pixel. It is the truth that other ways of
//! drawing plants are compared with.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::clip::clipped;
use super::mesh::Mesh;
use super::pixels::Pixels;
use super::plant::{Plant, Use};
use super::primitive::{Corner, Material};
use super::raster::{Fragment, ImageCorner, Target, rasterise, share_in_pixel};
use super::shade::{Light, Surface, shade};
use super::view::{HalfSpace, Projection, View, normal_map};
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
    let resolved = |band: &Band| band.resolve();
    let drawn = drawn((plant, view, light), &|rect| Band::new(rect), &resolved, task)?;
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
    let light = Light::day(plant.up);
    let behind = |rect| Band::behind(rect, rows(rect));
    let covered = |band: &Band| {
        let subpixels = band.nearness.as_chunks::<16>().0.iter().zip(rows(band.rect));
        subpixels.map(|(found, hiding)| found.iter().any(|found| found > hiding)).collect()
    };
    let drawn = drawn((plant, view, &light), &behind, &covered, task)?;
    Ok(drawn.into_iter().flat_map(|(covered, _)| covered).collect())
}

/// Draws a plant in bands of rows, which begin as `begun` says; returns what `finished` makes of each, from the top, with the
/// number of triangles.
fn drawn<T: Send>(
    (plant, view, light): (&Plant, &View, &Light),
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
            let mut drawer = Drawer::new(plant, &meshes, (view, light), begun(*band), task);
            drawer.visit(plant.root, &view.view_from_plant)?;
            let band = (finished(&drawer.band), drawer.triangles);
            task.step(STAGE, done.fetch_add(1, Ordering::Relaxed) + 1, bands.len() as u64)?;
            Ok(band)
        })
        .collect()
}

/// Refuses what cannot be drawn.
fn check(plant: &Plant, view: &View) -> Result<()> {
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

/// The sub-pixels of a band of rows.
struct Band {
    rect: PixelRect,
    /// 16 a pixel: how near, lower than everything where nothing is.
    nearness: Vec<f32>,
    /// 16 a pixel: linear light.
    light: Vec<Vec3>,
}

impl Band {
    fn new(rect: PixelRect) -> Self {
        let count = 16 * rect.area() as usize;
        Self { rect, nearness: vec![f32::NEG_INFINITY; count], light: vec![Vec3::ZERO; count] }
    }

    /// Makes a band behind something that is this near at each pixel.
    fn behind(rect: PixelRect, hiding: &[f32]) -> Self {
        let nearness = hiding.iter().flat_map(|nearness| [*nearness; 16]).collect();
        Self { nearness, ..Self::new(rect) }
    }

    /// Returns the sub-pixels of a fragment that are nearer than what is there. Of equals the first one stays.
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

    fn put(&mut self, fragment: &Fragment, visible: u16, light: Vec3) {
        let first = 16 * self.rect.offset(fragment.x, fragment.y);
        let mut left = visible;
        while left != 0 {
            let bit = left.trailing_zeros() as usize;
            left &= left - 1;
            self.nearness[first + bit] = fragment.nearness[bit];
            self.light[first + bit] = light;
        }
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

/// A corner of the present instance, in the view's frame and, where it has one, in the image.
#[derive(Clone, Copy)]
struct Projected {
    position: DVec3,
    image: Option<ImageCorner>,
}

/// Draws one band.
struct Drawer<'a> {
    plant: &'a Plant,
    meshes: &'a [Vec<Mesh>],
    view: &'a View,
    light: &'a Light,
    half_spaces: Vec<HalfSpace>,
    target: Target,
    band: Band,
    corners: Vec<Projected>,
    triangles: u64,
    task: &'a Task,
}

impl<'a> Drawer<'a> {
    fn new(
        plant: &'a Plant,
        meshes: &'a [Vec<Mesh>],
        (view, light): (&'a View, &'a Light),
        band: Band,
        task: &'a Task,
    ) -> Self {
        Self {
            plant,
            meshes,
            view,
            light,
            half_spaces: view.projection.half_spaces(&band.rect),
            target: Target { bounds: band.rect, perspective: view.projection.is_perspective() },
            band,
            corners: Vec::new(),
            triangles: 0,
            task,
        }
    }

    /// Draws an instance with all that it uses, in the order of the plant, unless its ball is out of view.
    fn visit(&mut self, object: usize, view_from_object: &DAffine3) -> Result<()> {
        let (plant, meshes) = (self.plant, self.meshes);
        let of = &plant.objects[object];
        let ball = of.bounds.ball.mapped(view_from_object);
        if of.counts.triangles == 0 || !self.half_spaces.iter().all(|half_space| half_space.touches(&ball)) {
            return Ok(());
        }
        self.task.go_on()?;
        for mesh in &meshes[object] {
            self.mesh(mesh, view_from_object);
        }
        for Use { child, parent_from_child } in &of.uses {
            self.visit(*child, &(*view_from_object * *parent_from_child))?;
        }
        Ok(())
    }

    fn mesh(&mut self, mesh: &Mesh, view_from_object: &DAffine3) {
        let projection = &self.view.projection;
        self.corners.clear();
        self.corners.extend(mesh.corners.iter().map(|corner| {
            let position = view_from_object.transform_point3(corner.position);
            Projected { position, image: image_corner(projection, position) }
        }));
        self.triangles += mesh.triangles.len() as u64;
        let painter = Painter {
            projection,
            light: self.light,
            material: &mesh.material,
            view_from_normal: normal_map(&view_from_object.matrix3),
            light_from_view: self.view.light_from_view,
        };
        // Written out: closures over arrays stay calls in builds that do not optimise across functions.
        for &[a, b, c] in &mesh.triangles {
            let (a, b, c) = (a as usize, b as usize, c as usize);
            let (p, q, r) = (self.corners[a], self.corners[b], self.corners[c]);
            let of_mesh = [&mesh.corners[a], &mesh.corners[b], &mesh.corners[c]];
            let of = (of_mesh, [p.position, q.position, r.position]);
            match (p.image, q.image, r.image) {
                (Some(p), Some(q), Some(r)) => {
                    painter.paint(&mut self.band, &self.target, [p, q, r], &|w| w, of);
                }
                _ => self.clipped(&painter, of),
            }
        }
    }

    /// Draws what is left of a triangle that reaches out of what can be projected.
    fn clipped(&mut self, painter: &Painter, of: ([&Corner; 3], [DVec3; 3])) {
        let left = clipped(of.1, &self.half_spaces);
        let image = |position| {
            let (px, nearness) = self.view.projection.image_from_view(position);
            ImageCorner::new(px, nearness)
        };
        for i in 2..left.len() {
            let fan = [left[0], left[i - 1], left[i]];
            let weights = DMat3::from_cols(fan[0].weights, fan[1].weights, fan[2].weights);
            if let [Some(a), Some(b), Some(c)] = fan.map(|corner| image(corner.position)) {
                painter.paint(&mut self.band, &self.target, [a, b, c], &|w| weights * w, of);
            }
        }
    }
}

/// Returns a point in the image; `None` where it has to be clipped.
#[inline]
fn image_corner(projection: &Projection, position: DVec3) -> Option<ImageCorner> {
    let (px, nearness) = projection.image_from_view(position);
    ImageCorner::new(px, nearness).filter(|_| projection.is_ahead(position))
}

/// What colours the triangles of an instance's mesh.
struct Painter<'a> {
    projection: &'a Projection,
    light: &'a Light,
    material: &'a Material,
    view_from_normal: DMat3,
    light_from_view: DMat3,
}

impl Painter<'_> {
    /// Draws a triangle; `weights` gives those of `of` (corners, and their positions in the view's frame) from those of
    /// `corners`.
    #[inline]
    fn paint(
        &self,
        band: &mut Band,
        target: &Target,
        corners: [ImageCorner; 3],
        weights: &dyn Fn(DVec3) -> DVec3,
        of: ([&Corner; 3], [DVec3; 3]),
    ) {
        let texture = |w: DVec3| -> DVec2 {
            let w = weights(w);
            w.x * of.0[0].texture + w.y * of.0[1].texture + w.z * of.0[2].texture
        };
        let Material { picture, cutout, wrap, .. } = self.material;
        let keeps = picture
            .as_ref()
            .zip(*cutout)
            .map(|(pixels, cutout)| move |w: DVec3| pixels.alpha(texture(w), *wrap) >= cutout);
        let keeps = keeps.as_ref().map(|keeps| keeps as &dyn Fn(DVec3) -> bool);
        rasterise(target, corners, keeps, |fragment| {
            let visible = band.visible(fragment);
            if visible == 0 {
                return;
            }
            let of_picture = picture.as_ref().map_or(Vec3::ONE, |pixels| {
                let share = share_in_pixel(target.perspective, &corners, fragment.middle);
                let area = share * area_in_picture(pixels, [DVec3::X, DVec3::Y, DVec3::Z].map(texture));
                pixels.light(texture(fragment.weights), *wrap, area)
            });
            band.put(fragment, visible, self.colour(weights(fragment.weights), of_picture, of));
        });
    }

    /// Returns the light of a triangle's point, whose picture has the light `of_picture` there.
    fn colour(&self, w: DVec3, of_picture: Vec3, (of, at): ([&Corner; 3], [DVec3; 3])) -> Vec3 {
        let mean = |value: [DVec3; 3]| w.x * value[0] + w.y * value[1] + w.z * value[2];
        let mut normal = (self.view_from_normal * mean(of.map(|corner| corner.normal))).normalize_or_zero();
        if self.material.leaf && normal.dot(self.projection.towards_viewer(mean(at))) < 0.0 {
            normal = -normal;
        }
        let Material { reflected, through, leaf, .. } = self.material;
        let reflected = of_picture * Vec3::from_array(*reflected);
        let normal = (self.light_from_view * normal).normalize_or_zero();
        let through = leaf.then_some(Vec3::from_array(*through));
        shade(&Surface { normal, reflected, through }, self.light)
    }
}

/// Returns the area of a triangle in a picture, in its pixels.
fn area_in_picture(pixels: &Pixels, [a, b, c]: [DVec2; 3]) -> f64 {
    let [width, height] = pixels.size();
    0.5 * (b - a).perp_dot(c - a).abs() * (width * height) as f64
}
