//! Views of several layered depth images together, blended as the projective renderer blends photos.
//!
//! Each image is warped into sums of its own. Then the surfaces that the images show at a pixel are put into the order of
//! their depths; those at one depth are one surface, whose colour is the mean of the images by the weights that their
//! cameras have there ([`quadratura_view::weights`]): by the angle between the rays to the view and to the camera, and by
//! the resolution that the camera lacks. What a camera did not see itself, but has filled in, counts only where no camera saw
//! it. No order between the images is needed.
//!
//! Splats that close the gaps of a coarse image reach beyond the outlines of its surfaces. An image whose camera sees past
//! such a point, to something behind it, contradicts the surface there, and takes from its opacity by its own weight.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::layout::{Ldi, ResolutionLevel};
use super::occluders::{CLEARLY_FARTHER, Occluders};
use super::splat::sums::{BLENDED, COLOUR, LEVEL, Slot, SumsCanvas};
use super::warp::{BAND, Plan, WarpOptions, light_of_bytes};
use quadratura_base::error::Result;
use quadratura_base::geometry::Pinhole;
use quadratura_base::task::Task;
use quadratura_view::agreement::AgreementGrid;
use quadratura_view::optics::{Optics, ViewLens};
use quadratura_view::optics::{squared_radius, squared_tangent};
use quadratura_view::srgb::Srgb;
use quadratura_view::weights::BORDER_SHARE;
use quadratura_view::weights::{Claim, angle_at, border_ramp, weights};
use quadratura_view::{Picture, Shot};

/// The penalty, in radians, of what was filled in: whatever a camera saw comes first, because angles are at most pi.
const FILLED_IN: f64 = 1000.0;
/// The share by which inverse depths of different images may differ to be of one surface: those of one image's slot differ by
/// two thirds of it.
const SAME_SURFACE: f32 = 1.5 * LEVEL;
/// The least agreement: a photo that all others contradict still shows what nobody else does.
const LEAST_AGREEMENT: f64 = 1.0 / 255.0;
/// The share of what a camera saw itself above which it is all of it: sums in single precision are not exact.
const SEEN: f32 = 0.9999;
/// The share of a pixel's colour from which on it is inpainted: no camera saw most of it.
const INVENTED: f64 = 0.5;
/// The share of a pixel from which on surfaces hide what is behind them entirely, but for an invisible rest.
const OPAQUE: f64 = 0.995;

/// A layered depth image in a blend.
#[derive(Debug, Clone, Copy)]
pub struct BlendSource<'a> {
    /// The image.
    pub ldi: &'a Ldi,
    /// Natural logarithms of the picture's exposure over that of its colours: R, G, B.
    pub exposure: [f64; 3],
    /// The vignetting and offset of its colours, which are removed.
    pub optics: Optics,
    /// How far other photos confirm its camera's photo; `None` where that does not count.
    pub agreement: Option<&'a AgreementGrid>,
}

/// A view of several layered depth images.
#[derive(Debug, Clone, PartialEq)]
pub struct Blended {
    /// The view.
    pub picture: Picture,
    /// What its pixels show beside their colours, row by row.
    pub surfaces: Vec<BlendedSurface>,
}

/// What a pixel of a blended view shows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BlendedSurface {
    /// Whether most of its colour was filled in and seen by no camera.
    pub invented: bool,
    /// The inverse depth, in the view's camera, of the surface with the largest share; 0 where there is none.
    pub inverse_depth: f32,
}

/// Makes a view of several layered depth images. Of the shot, the camera, the pose, the quality, the blending and whether sides are drawn
/// that the reference cameras do not see count; `lens` darkens it towards its corners. Of the options the spacing counts, and
/// the level.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn warp_blended(
    sources: &[BlendSource],
    shot: &Shot,
    lens: &ViewLens,
    options: &WarpOptions,
    task: &Task,
) -> Result<Blended> {
    let (width, height) = (shot.camera.width, shot.camera.height);
    let plans: Vec<Plan> =
        task.timed("place", || sources.iter().map(|source| Plan::new(source.ldi, shot, options)).collect());
    let light: Vec<_> = sources.iter().map(|source| light_of_bytes(source.exposure)).collect();
    let blender = Blender::new(sources, &plans, shot);
    let count = width as usize * height as usize;
    let (mut rgba, mut surfaces) = (vec![0u8; 4 * count], vec![BlendedSurface::default(); count]);
    let in_band = width as usize * BAND as usize;
    let bands = rgba.par_chunks_mut(4 * in_band).zip(surfaces.par_chunks_mut(in_band)).enumerate();
    bands.try_for_each(|(band, (rgba, surfaces))| {
        task.check_cancelled()?;
        let band = band as u32;
        let (top, rows) = (band * BAND, BAND.min(height - band * BAND));
        let canvases: Vec<_> = task.timed("draw", || {
            let of_source = plans.iter().zip(&light);
            of_source
                .map(|(plan, light)| plan.draw(band, SumsCanvas::<BLENDED>::new(width, rows, light)))
                .collect()
        });
        task.timed("resolve", || blend_band(&blender, lens, &canvases, top, rgba, surfaces));
        Ok(())
    })?;
    Ok(Blended { picture: Picture { width, height, rgba }, surfaces })
}

/// Blends what the images show in a band whose first row is `top`.
fn blend_band(
    blender: &Blender,
    lens: &ViewLens,
    canvases: &[SumsCanvas<BLENDED>],
    top: u32,
    rgba: &mut [u8],
    surfaces: &mut [BlendedSurface],
) {
    let width = blender.shot.camera.width;
    let mut pixels = Vec::new();
    for (i, (out, surface)) in rgba.as_chunks_mut::<4>().0.iter_mut().zip(surfaces).enumerate() {
        let (x, y) = (i as u32 % width, i as u32 / width);
        pixels.clear();
        for (source, canvas) in canvases.iter().enumerate() {
            let [near, far] = canvas.slots(x, y);
            pixels.extend(ImageContribution::new(source, near, 0.0));
            pixels.extend(ImageContribution::new(source, far, near.weight()));
        }
        let at = DVec2::new(f64::from(x) + 0.5, f64::from(top + y) + 0.5);
        let factor = lens.factor(squared_tangent(&blender.shot.camera, at));
        (*out, *surface) = blender.colour(at, factor, &mut pixels);
    }
}

/// What one image shows of one surface at a pixel.
#[derive(Debug, Clone, Copy)]
struct ImageContribution {
    source: usize,
    /// Inverse depth in the picture's camera: the mean of the depth pixels around, which is that of the pixel's centre on a
    /// plane.
    q: f32,
    /// How much larger inverse depth is at the nearest of these: on slanted surfaces it changes from pixel to pixel.
    spread: f32,
    /// Linear light times share, and the share of the pixel that is covered.
    colour: [f32; 4],
    /// The spacing, in pixels.
    spacing: f32,
    /// How much of it the camera saw itself or is paint, 0 to 1.
    own: f32,
    /// How much of it is paint, 0 to 1.
    paint: f32,
}

impl ImageContribution {
    fn new(source: usize, slot: &Slot<BLENDED>, before: f32) -> Option<Self> {
        if slot.weight() <= 0.0 {
            return None;
        }
        let colour = slot.covering(before)[0].to_array();
        let [spacing, own, paint, q] =
            slot.seen[COLOUR].to_array().map(|sum| (sum / slot.weight()).clamp(0.0, f32::MAX));
        Some(Self {
            source,
            q,
            spread: (slot.q() - q).max(0.0),
            colour,
            spacing,
            own: if own > SEEN { 1.0 } else { own },
            paint: paint.min(1.0),
        })
    }
}

/// Lays what one image shows of a surface in two slots, such as a window before its wall, over each other.
fn one_of_each(surface: &[ImageContribution]) -> Vec<ImageContribution> {
    let mut parts: Vec<ImageContribution> = Vec::with_capacity(surface.len());
    for part in surface {
        match parts.iter_mut().find(|other| other.source == part.source) {
            Some(near) => {
                let left = 1.0 - near.colour[3];
                near.colour.iter_mut().zip(part.colour).for_each(|(sum, value)| *sum += left * value);
            }
            None => parts.push(*part),
        }
    }
    parts
}

impl ImageContribution {
    /// Returns what stands for a camera that sees past a point.
    fn past(source: usize) -> Self {
        Self { source, q: 0.0, spread: 0.0, colour: [0.0; 4], spacing: 1.0, own: 1.0, paint: 0.0 }
    }
}

struct Blender<'a> {
    sources: &'a [BlendSource<'a>],
    /// The level of each source that is drawn.
    levels: Vec<&'a ResolutionLevel>,
    shot: &'a Shot,
    /// Where the cameras see outlines.
    occluders: Vec<Occluders>,
    /// The cameras' positions.
    eyes: Vec<DVec3>,
    viewpoint: DVec3,
}

impl<'a> Blender<'a> {
    fn new(sources: &'a [BlendSource], plans: &[Plan<'a>], shot: &'a Shot) -> Self {
        let eyes = sources.iter().map(|source| source.ldi.pose.center_in_world()).collect();
        let levels: Vec<&ResolutionLevel> = plans.iter().map(|plan| plan.level).collect();
        let of_source =
            |(level, source): (&&ResolutionLevel, &BlendSource)| Occluders::new(source.ldi, level);
        let occluders = levels.par_iter().zip(sources).map(of_source).collect();
        Self { sources, levels, occluders, shot, eyes, viewpoint: shot.viewpoint() }
    }

    /// Returns the colour of a pixel at `at` of the parts that the images show there, darkened by a factor, and what it shows.
    fn colour(&self, at: DVec2, factor: f64, parts: &mut [ImageContribution]) -> ([u8; 4], BlendedSurface) {
        parts.sort_by(|a, b| b.q.total_cmp(&a.q).then(a.source.cmp(&b.source)));
        let mut sum = [0.0f64; 5];
        let (mut largest, mut inverse_depth) = (0.0, 0.0);
        let mut rest = &*parts;
        while let Some(first) = rest.first() {
            let level = |part: &ImageContribution| {
                first.q - part.q <= SAME_SURFACE * first.q + first.spread + part.spread
            };
            let (surface, farther) = rest.split_at(rest.partition_point(level));
            rest = farther;
            let colour = self.mixed(at, &one_of_each(surface));
            let left = 1.0 - sum[3];
            sum.iter_mut().zip(colour).for_each(|(sum, value)| *sum += left * value);
            if left * colour[3] > largest {
                (largest, inverse_depth) = (left * colour[3], first.q);
            }
            if sum[3] >= OPAQUE {
                break;
            }
        }
        if sum[3] <= 0.0 {
            return ([0; 4], BlendedSurface::default());
        }
        let srgb = Srgb::tables();
        let [r, g, b] = [0, 1, 2].map(|c| srgb.encoded((factor * sum[c] / sum[3]) as f32));
        let surface = BlendedSurface { invented: sum[4] > INVENTED * sum[3], inverse_depth };
        ([r, g, b, (sum[3] * 255.0).round().min(255.0) as u8], surface)
    }

    /// Returns the mean of the images at one surface, less what other images contradict: linear light times share, the share of
    /// the pixel, and how much of this was filled in.
    fn mixed(&self, at: DVec2, surface: &[ImageContribution]) -> [f64; 5] {
        let point = self.point(at, surface[0].q);
        let mut places: Vec<ProjectedPoint> =
            surface.iter().map(|part| self.place(part.source, &point)).collect();
        let mut penalties: Vec<f64> =
            surface.iter().zip(&places).map(|(part, place)| self.penalty(part, place)).collect();
        let shown = surface.len();
        for source in (0..self.sources.len()).filter(|i| surface.iter().all(|part| part.source != *i)) {
            let place = self.place(source, &point);
            if self.sees_past(source, &place) {
                penalties.push(self.penalty(&ImageContribution::past(source), &place));
                places.push(place);
            }
        }
        let weights = weights(&penalties, &self.shot.blend);
        let mut sum = [0.0f64; 5];
        for ((part, place), weight) in surface.iter().zip(&places).zip(&weights[..shown]) {
            let light = self.sources[part.source].undone(part.colour, place);
            sum.iter_mut().zip(light).for_each(|(sum, value)| *sum += weight * value);
            sum[4] += weight * light[3] * (1.0 - f64::from(part.own));
        }
        sum
    }

    /// Returns the surface point at a pixel.
    fn point(&self, at: DVec2, q: f32) -> VisiblePoint {
        let ray = self.shot.camera.ray_in_camera(at);
        match q > 0.0 {
            true => VisiblePoint::Near(self.shot.pose.world_from_camera(ray / f64::from(q))),
            false => VisiblePoint::Far(self.shot.pose.rotation.transpose() * ray),
        }
    }

    /// Returns where a source's camera has a point.
    fn place(&self, source: usize, point: &VisiblePoint) -> ProjectedPoint {
        let BlendSource { ldi, .. } = self.sources[source];
        let (in_camera, angle) = match *point {
            VisiblePoint::Near(point) => {
                (ldi.pose.camera_from_world(point), angle_at(point, self.viewpoint, self.eyes[source]))
            }
            // The sky is seen under the same angle from everywhere: the nearer camera comes first.
            VisiblePoint::Far(direction) => {
                let apart = self.eyes[source].distance(self.viewpoint);
                (ldi.pose.rotation * direction, PER_UNIT_AT_THE_SKY * apart)
            }
        };
        let camera = &ldi.camera;
        let px = DVec2::new(
            camera.fx * in_camera.x / in_camera.z + camera.cx,
            camera.fy * in_camera.y / in_camera.z + camera.cy,
        );
        let inverse_depth = match (in_camera.z > 0.0, point) {
            (false, _) => None,
            (true, VisiblePoint::Near(_)) => Some(1.0 / in_camera.z),
            (true, VisiblePoint::Far(_)) => Some(0.0),
        };
        ProjectedPoint { px, angle, inverse_depth }
    }

    /// Returns the penalty of what a source shows at a place, in radians, as of a photo that is projected there.
    fn penalty(&self, part: &ImageContribution, place: &ProjectedPoint) -> f64 {
        let octaves = f64::from(part.spacing).log2().max(0.0);
        let border = self.border(part.source, place);
        // Photos do not overrule paint.
        let agreement = match self.sources[part.source].agreement {
            Some(grid) => grid.at(place.px).max(f64::from(part.paint)).max(LEAST_AGREEMENT),
            None => 1.0,
        };
        let beside =
            |inverse_depth| self.occluders[part.source].confidence(place.px.to_array(), inverse_depth);
        let confidence = place.inverse_depth.map_or(1.0, beside).max(f64::from(part.paint));
        let claim = Claim { angle: place.angle, octaves, border, confidence, agreement };
        claim.penalty(&self.shot.blend) + FILLED_IN * (1.0 - f64::from(part.own))
    }

    fn border(&self, source: usize, place: &ProjectedPoint) -> f64 {
        let Pinhole { width, height, .. } = self.sources[source].ldi.camera;
        let (width, height) = (f64::from(width), f64::from(height));
        let inside = place.px.x.min(width - place.px.x).min(place.px.y).min(height - place.px.y);
        // Half a pixel inside at least: what is drawn came from a pixel.
        border_ramp(inside.max(0.5) / (BORDER_SHARE * width.min(height)))
    }

    /// Returns whether a source's camera sees past a point: it shows surfaces there, all of them clearly farther.
    fn sees_past(&self, source: usize, place: &ProjectedPoint) -> bool {
        let Some(inverse_depth) = place.inverse_depth else { return false };
        let level = self.levels[source];
        let reduced = f64::from(level.camera.width) / f64::from(self.sources[source].ldi.camera.width);
        let (x, y) = ((place.px.x * reduced).floor(), (place.px.y * reduced).floor());
        let within = |at: f64, side: u32| at >= 1.0 && at + 2.0 <= f64::from(side);
        if !(within(x, level.camera.width) && within(y, level.camera.height)) {
            return false;
        }
        let (x, y) = (x as u32, y as u32);
        let mut nearest = (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| level.at(x, y)));
        nearest.all(|pixel| {
            !pixel.is_empty()
                && f64::from(level.inverse_depths[pixel.start]) < CLEARLY_FARTHER * inverse_depth
        })
    }
}

/// The angle that a camera's distance from the viewpoint counts as where the sky is seen, in radians per world unit: only the
/// order matters.
const PER_UNIT_AT_THE_SKY: f64 = 1e-3;

/// A surface point that is seen.
#[derive(Debug, Clone, Copy)]
enum VisiblePoint {
    /// In world coordinates.
    Near(DVec3),
    /// Infinitely far away, as a direction in world axes.
    Far(DVec3),
}

/// Where a camera has a point.
#[derive(Debug, Clone, Copy)]
struct ProjectedPoint {
    /// In pixels of its frame.
    px: DVec2,
    /// The angle between the rays to the viewpoint and to the camera, in radians.
    angle: f64,
    /// The inverse depth in the camera; `None` behind it.
    inverse_depth: Option<f64>,
}

impl BlendSource<'_> {
    /// Removes the optics from linear light times share, and share. The light has the picture's exposure already, and the
    /// offset that of the photo.
    fn undone(&self, [r, g, b, share]: [f32; 4], place: &ProjectedPoint) -> [f64; 4] {
        let r2 = squared_radius(&self.ldi.camera, place.px);
        let share = f64::from(share);
        let mut light = [r, g, b].map(f64::from);
        if self.optics.offset == 0.0 || share <= 0.0 {
            light = self.optics.undone(light, r2);
        } else {
            let scale = self.exposure.map(|gain| share * gain.exp());
            let stored = [0, 1, 2].map(|c| light[c] / scale[c]);
            let undone = self.optics.undone(stored, r2);
            light = [0, 1, 2].map(|c| undone[c] * scale[c]);
        }
        let [r, g, b] = light;
        [r, g, b, share]
    }
}
