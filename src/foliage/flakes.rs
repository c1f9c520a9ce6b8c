//! Pictures of plants whose images are drawn texel by texel (Max, Deussen & Keating 1999): as *flakes*, small pieces of surface at their
//! own depths, or, as published, on planes of depth. The nearest one is kept at each sub-pixel, and what is seen is lit in the end.

use glam::Vec3;

use super::bands::check;
use super::directions::{Directions, Serving};
use super::drawer::Drawer;
use super::flake::FlakeBuffer;
use super::images::PlantImages;
use super::lighting::{DrawnParts, FlakeCanvas, Lighting};
use super::listed::{BandPicture, ImageCost, in_bands, meshes_of};
use super::mesh::Meshes;
use super::place::{ImagePlacement, Instance};
use super::planes::DepthPlanes;
use super::plant::Plant;
use super::shade::OutdoorLight;
use super::stipple::{Stipple, Stipples};
use super::texels::TexelDrawer;
use super::view::View;
use super::walk::{Drawn, Part, WalkOptions, walk};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::task::Task;
use quadratura_view::Picture;

/// The number of rows that are drawn together. It changes no pixel: bands only share work among threads.
const BAND: u32 = 64;

/// The squared cosine to the viewer, 1/16 or 76 degrees, from which up an axis draws in all sub-pixels where those of both others are 1/16 or
/// more, too. Images that see a plant from the side cover too much and are too bright: the mean normal of several leaves leans towards their
/// axis (docs/quality.md).
const OPEN_BESIDE_TWO: f64 = 1.0 / 16.0;
/// The same, 1/128 or 85 degrees, beside a single axis along which the viewer looks. That axis misses what is behind the leaves that it sees,
/// so the others are needed as soon as the viewer is a few degrees aside.
const OPEN_BESIDE_ONE: f64 = 1.0 / 128.0;
/// An axis draws nothing from this part of the squared cosine down at which it draws in all sub-pixels: it costs as many samples where it
/// draws in a few as where it draws in all.
const CLOSED_FROM: f64 = 1.0 / 8.0;

/// How texels are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TexelGeometry {
    /// Each as a piece of surface that leans as its normal tells.
    Flakes,
    /// Each on those of the planes across its image's direction that are near it (Max, Deussen & Keating 1999).
    Planes {
        /// The displacement in the view that is allowed, in pixels.
        error_px: f64,
    },
}

/// How plants are drawn texel by texel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlakeOptions {
    /// When images serve.
    pub walk: WalkOptions,
    /// How texels are drawn.
    pub texels: TexelGeometry,
}

impl FlakeOptions {
    /// Previews.
    pub const PREVIEW: Self = Self { walk: WalkOptions::PREVIEW, texels: TexelGeometry::Flakes };
    /// Final pictures.
    pub const FINAL: Self = Self { walk: WalkOptions::FINAL, texels: TexelGeometry::Flakes };
    /// Previews on planes.
    pub const PREVIEW_PLANES: Self =
        Self { texels: TexelGeometry::Planes { error_px: 1.0 }, ..Self::PREVIEW };
    /// Final pictures on planes.
    pub const FINAL_PLANES: Self = Self { texels: TexelGeometry::Planes { error_px: 0.5 }, ..Self::FINAL };
}

/// Draws a plant from its images, texel by texel.
///
/// # Errors
/// Those of [`super::draw`].
pub fn draw_flakes(
    plant: &Plant,
    images: &PlantImages,
    view: &View,
    light: &OutdoorLight,
    options: &FlakeOptions,
    task: &Task,
) -> Result<(Picture, ImageCost)> {
    check(plant, view)?;
    let drawn = walk(plant, images, view, &options.walk, 0);
    let meshes = meshes_of(plant, &drawn);
    let scene = FlakeScene { plant, images, meshes: &meshes, drawn: &drawn, view, light, options };
    in_bands(view.rect(), BAND, &drawn, &|rect| scene.band(rect, task), task)
}

/// Returns the sums of the linear light of all sub-pixels that flakes of a plant's images cover, in each of some lights, and their number.
///
/// # Errors
/// Those of [`super::draw`].
pub(super) fn light_of_flakes<const N: usize>(
    plant: &Plant,
    images: &PlantImages,
    view: &View,
    lights: [OutdoorLight; N],
    task: &Task,
) -> Result<([Vec3; N], u32)> {
    let options = &FlakeOptions::PREVIEW;
    let drawn = walk(plant, images, view, &options.walk, 0);
    let meshes = meshes_of(plant, &drawn);
    let scene =
        FlakeScene { plant, images, meshes: &meshes, drawn: &drawn, view, light: &lights[0], options };
    let (canvas, _) = scene.drawn_into(view.rect(), task)?;
    let mut lighting = Lighting { drawn: &canvas.drawn, view, last: 0 };
    let (mut sums, mut covered) = ([Vec3::ZERO; N], 0);
    for (x, y) in view.rect().pixels() {
        covered += lighting.each_seen((x, y), &canvas.buffer.pixel(x, y), &mut |times, seen| {
            for (sum, light) in sums.iter_mut().zip(&lights) {
                *sum += times as f32 * seen.lit(light);
            }
        });
    }
    Ok((sums, covered))
}

/// Returns the directions whose images are drawn as flakes from a viewpoint that these serve, each with its stippled transparency.
pub(super) fn stipples_of(directions: Directions, serving: &[Serving], path: u64) -> Vec<(usize, Stipple)> {
    let mut before = 0.0;
    let stipples = serving.iter().map(|of| {
        let from = before;
        before += of.weight;
        let stipple = match directions {
            Directions::Around => Stipple::between(from, before, path),
            Directions::Axes => Stipple::open(share_of_axis(of, serving), path),
        };
        (of.direction, stipple)
    });
    stipples.filter(|(_, stipple)| !stipple.is_closed()).collect()
}

/// Returns the share of the sub-pixels, from 0 to 1, that an axis draws in beside the other axes that serve a viewpoint
/// (docs/method.md, "Flakes"). The squared cosine at which it is 1 is the smaller one of both others, within [`OPEN_BESIDE_ONE`] and
/// [`OPEN_BESIDE_TWO`], so the share is a continuous function of the viewpoint.
fn share_of_axis(of: &Serving, serving: &[Serving]) -> f64 {
    let others = serving.iter().filter(|other| other.direction != of.direction).map(|other| other.weight);
    // An axis of weight 0 does not serve.
    let smaller = if serving.len() < 3 { 0.0 } else { others.fold(1.0, f64::min) };
    let open = smaller.clamp(OPEN_BESIDE_ONE, OPEN_BESIDE_TWO);
    ((of.weight / open - CLOSED_FROM) / (1.0 - CLOSED_FROM)).clamp(0.0, 1.0)
}

/// What all bands of a picture share.
struct FlakeScene<'a> {
    plant: &'a Plant,
    images: &'a PlantImages,
    meshes: &'a Meshes,
    drawn: &'a [Drawn],
    view: &'a View,
    light: &'a OutdoorLight,
    options: &'a FlakeOptions,
}

impl<'a> FlakeScene<'a> {
    /// Draws a band of rows.
    fn band(&self, rect: PixelRect, task: &Task) -> Result<BandPicture> {
        let (canvas, cost) = self.drawn_into(rect, task)?;
        Ok((self.resolve(&canvas), cost))
    }

    /// Draws what is in a rectangle.
    fn drawn_into(&self, rect: PixelRect, task: &Task) -> Result<(FlakeCanvas<'a>, ImageCost)> {
        let Self { plant, images, view, .. } = self;
        let half_spaces = view.projection.half_spaces(&rect);
        let canvas = FlakeCanvas { buffer: FlakeBuffer::new(rect), drawn: DrawnParts::default() };
        let mut drawer = Drawer::new(plant, self.meshes, view, rect, canvas, task);
        let mut cost = ImageCost::default();
        for drawn in self.drawn {
            let Drawn { object, part, view_from_object, stipple, .. } = drawn;
            let in_view = plant.objects[*object].bounds.ball.mapped(view_from_object);
            if !half_spaces.iter().all(|half_space| half_space.touches(&in_view)) {
                continue;
            }
            task.check_cancelled()?;
            match part {
                Part::Image(copy) => {
                    if let Some(instance) = Instance::of(plant, images, drawn, *copy) {
                        cost.samples += self.image(&instance, &mut drawer.canvas)?;
                    }
                }
                Part::Polygons(level) => drawer.own(*object, *level, view_from_object, stipple),
            }
        }
        cost.triangles = drawer.triangles;
        Ok((drawer.canvas, cost))
    }

    /// Draws the images of an instance that serve; returns the number of samples.
    fn image(&self, instance: &Instance<'a>, canvas: &mut FlakeCanvas<'a>) -> Result<u64> {
        let projection = &self.view.projection;
        let serving = instance.serving(projection);
        let stipples = match (instance.directions, self.options.texels) {
            // Which axis closes the gaps of another depends on the surface: all are needed.
            (Directions::Axes, TexelGeometry::Planes { .. }) => {
                serving.iter().map(|of| (of.direction, Stipple::open(1.0, instance.path))).collect()
            }
            _ => stipples_of(instance.directions, &serving, instance.path),
        };
        let mut drawn = 0;
        for (direction, stipple) in stipples {
            let stipples = Stipples { of_direction: stipple, of_part: instance.stipple };
            let place = ImagePlacement::new(instance, projection, direction);
            let image = &instance.copy.views[direction];
            let index = canvas.drawn.begin_image(image, instance.of_samples(&place, direction))?;
            let planes = match self.options.texels {
                TexelGeometry::Flakes => None,
                TexelGeometry::Planes { error_px } => {
                    Some(DepthPlanes::new(instance, &place, direction, error_px))
                }
            };
            let drawer = TexelDrawer::new(instance, &place, planes, canvas.buffer.rect);
            let stipples = Some(&stipples).filter(|stipples| !stipples.are_wide());
            drawn += drawer.draw(image, index, stipples, &mut canvas.buffer);
        }
        Ok(drawn)
    }

    /// Returns R, G, B, A of the pixels: the mean light of the covered sub-pixels, and their share.
    fn resolve(&self, canvas: &FlakeCanvas) -> Vec<u8> {
        let FlakeCanvas { buffer, drawn } = canvas;
        let mut lighting = Lighting { drawn, view: self.view, last: 0 };
        let pixels = buffer.rect.pixels();
        pixels.flat_map(|(x, y)| lighting.pixel((x, y), &buffer.pixel(x, y), self.light)).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use glam::DVec3;

    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    fn sin2(degrees: f64) -> f64 {
        degrees.to_radians().sin().powi(2)
    }

    fn shares_towards(viewer: DVec3) -> [f64; 6] {
        let serving = Directions::Axes.serving(viewer);
        let mut shares = [0.0; 6];
        serving.iter().for_each(|of| shares[of.direction] = share_of_axis(of, &serving));
        shares
    }

    /// The shares of the positive axes that a viewpoint at these squared cosines has, in percent.
    fn percent(cos2: [f64; 3]) -> [f64; 3] {
        let shares = shares_towards(DVec3::from_array(cos2.map(f64::sqrt)));
        [0, 2, 4].map(|axis| (100.0 * shares[axis]).round())
    }

    #[test]
    fn beside_one_axis_the_others_open_within_six_degrees_and_beside_two_the_third_within_fifteen() {
        let beside_one = |degrees: f64| percent([1.0 - sin2(degrees), sin2(degrees), 0.0]);
        assert_eq!(beside_one(0.0), [100.0, 0.0, 0.0]);
        assert_eq!(beside_one(1.0), [100.0, 0.0, 0.0]);
        // (128 sin^2 3.5 - 1/8) / (7/8)
        assert_eq!(beside_one(3.5), [100.0, 40.0, 0.0]);
        assert_eq!(beside_one(5.2), [100.0, 100.0, 0.0]);
        let beside_two =
            |degrees: f64| percent([0.5 - 0.5 * sin2(degrees), 0.5 - 0.5 * sin2(degrees), sin2(degrees)]);
        assert_eq!(beside_two(5.0), [100.0, 100.0, 0.0]);
        // (16 sin^2 10 - 1/8) / (7/8)
        assert_eq!(beside_two(10.0), [100.0, 100.0, 41.0]);
        assert_eq!(beside_two(14.5), [100.0, 100.0, 100.0]);
        // As far from both others: both open together.
        assert_eq!(percent([0.98, 0.01, 0.01]), [100.0, 100.0, 100.0]);
        assert_eq!(percent([1.0 / 3.0; 3]), [100.0; 3]);
    }

    #[test]
    fn shares_of_axes_change_without_a_jump_and_leave_no_viewpoint_without_an_open_axis() {
        let mut rng = Rng::new(23);
        let mut any = || DVec3::new(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-1.0, 1.0));
        const STEP: f64 = 1e-3;
        for _ in 0..50 {
            // All the way round, so that every place at which a share could jump on this circle is passed.
            let (across, along) = any().normalize_or(DVec3::Z).any_orthonormal_pair();
            let mut before = shares_towards(across);
            for step in 1..=(TAU / STEP).ceil() as u32 {
                let (sine, cosine) = (STEP * f64::from(step)).sin_cos();
                let towards = cosine * across + sine * along;
                let now = shares_towards(towards);
                // Where the weight of the axis alone changes, a share changes by 26 per radian at most, just before it
                // is 1 (at 5.1 degrees: 128 * 2 sin cos / (7/8)); where the others' weights change, too, by 26 sqrt 2 = 37.
                let most = (0..6).map(|axis| (now[axis] - before[axis]).abs()).fold(0.0, f64::max);
                assert!(most < 40.0 * STEP, "{towards}: {before:?}, {now:?}");
                // The largest weight is 1/3 at least, more than 1/16.
                assert!(now.contains(&1.0), "{towards}: {now:?}");
                before = now;
            }
        }
    }

    #[test]
    fn stipples_belong_to_the_directions_that_serve_and_closed_ones_are_left_out() {
        let beside = |degrees: f64| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let serving = Directions::Axes.serving(DVec3::new(cosine, -sine, 0.0));
            stipples_of(Directions::Axes, &serving, 5)
        };
        assert_eq!(beside(1.0), [(0, Stipple::wide(5))]);
        // +x and -y.
        assert_eq!(beside(5.2), [(0, Stipple::wide(5)), (3, Stipple::wide(5))]);
        let serving = [(7, 0.25), (9, 0.75)].map(|(direction, weight)| Serving { direction, weight });
        let around = stipples_of(Directions::Around, &serving, 5);
        assert_eq!(around, [(7, Stipple::between(0.0, 0.25, 5)), (9, Stipple::between(0.25, 1.0, 5))]);
    }
}
