//! Pictures of plants whose images are drawn texel by texel (Max, Deussen & Keating 1999): as *flakes*, small pieces of surface at their
//! own depths, or, as published, on planes of depth. The nearest one is kept at each sub-pixel, and what is seen is lit in the end.

use glam::Vec3;

use super::brute::check;
use super::directions::{Directions, Serving};
use super::door::{Door, Doors};
use super::drawer::Drawer;
use super::flake::FlakeBuffer;
use super::images::PlantImages;
use super::lighting::{FlakeCanvas, Lighting, List};
use super::listed::{BandPicture, ImageCost, in_bands, meshes_of};
use super::mesh::Meshes;
use super::place::{Instance, Place};
use super::planes::Planes;
use super::plant::Plant;
use super::shade::Light;
use super::texels::Drawing;
use super::view::View;
use super::walk::{Drawn, Part, WalkOptions, walk};
use crate::error::Result;
use crate::geometry::PixelRect;
use crate::projection::Picture;
use crate::task::Task;

/// The number of rows that are drawn together. It changes no pixel: bands only share work among threads.
const BAND: u32 = 64;

/// An axis whose squared cosine to the viewer is 1/16 or more, 76 degrees, draws in all sub-pixels, and one of 1/128 or less, 85 degrees, in none;
/// between them the share falls. What an axis sees from the side is told by others, too, and drawn from all it covers too much and is
/// too bright: the mean normal of several leaves leans towards the axis (docs/quality.md).
const OPEN_FROM_COS2: f64 = 1.0 / 16.0;
/// The squared cosine from which down an axis draws nothing: it costs as many samples where it draws in a few sub-pixels as where it draws
/// in all.
const CLOSED_FROM_COS2: f64 = 1.0 / 128.0;

/// How texels are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Texels {
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
    pub texels: Texels,
}

impl FlakeOptions {
    /// Previews.
    pub const PREVIEW: Self = Self { walk: WalkOptions::PREVIEW, texels: Texels::Flakes };
    /// Final pictures.
    pub const FINAL: Self = Self { walk: WalkOptions::FINAL, texels: Texels::Flakes };
    /// Previews on planes.
    pub const PREVIEW_PLANES: Self = Self { texels: Texels::Planes { error_px: 1.0 }, ..Self::PREVIEW };
    /// Final pictures on planes.
    pub const FINAL_PLANES: Self = Self { texels: Texels::Planes { error_px: 0.5 }, ..Self::FINAL };
}

/// Draws a plant from its images, texel by texel.
///
/// # Errors
/// Those of [`super::draw`].
pub fn draw_flakes(
    (plant, images): (&Plant, &PlantImages),
    view: &View,
    light: &Light,
    options: &FlakeOptions,
    task: &Task,
) -> Result<(Picture, ImageCost)> {
    check(plant, view)?;
    let drawn = walk(plant, images, view, &options.walk, 0);
    let meshes = meshes_of(plant, &drawn);
    let scene = Scene { plant, images, meshes: &meshes, drawn: &drawn, view, light, options };
    in_bands((view.rect(), BAND), &drawn, &|rect| scene.band(rect, task), task)
}

/// Returns the sums of the linear light of all sub-pixels that flakes of a plant's images cover, in each of some lights, and their number.
///
/// # Errors
/// Those of [`super::draw`].
pub(super) fn light_of_flakes<const N: usize>(
    (plant, images): (&Plant, &PlantImages),
    view: &View,
    lights: [Light; N],
    task: &Task,
) -> Result<([Vec3; N], u32)> {
    let options = &FlakeOptions::PREVIEW;
    let drawn = walk(plant, images, view, &options.walk, 0);
    let meshes = meshes_of(plant, &drawn);
    let scene = Scene { plant, images, meshes: &meshes, drawn: &drawn, view, light: &lights[0], options };
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

/// Returns the screen door of the flakes of an image whose direction has this weight, after directions with the weight `before`.
pub(super) fn door_of(directions: Directions, (before, weight): (f64, f64), path: u64) -> Door {
    match directions {
        Directions::Around => Door::between(before, before + weight, path),
        Directions::Axes => {
            let share = (weight - CLOSED_FROM_COS2) / (OPEN_FROM_COS2 - CLOSED_FROM_COS2);
            Door::open(share.max(0.0), path)
        }
    }
}

/// What all bands of a picture share.
struct Scene<'a> {
    plant: &'a Plant,
    images: &'a PlantImages,
    meshes: &'a Meshes,
    drawn: &'a [Drawn],
    view: &'a View,
    light: &'a Light,
    options: &'a FlakeOptions,
}

impl<'a> Scene<'a> {
    /// Draws a band of rows.
    fn band(&self, rect: PixelRect, task: &Task) -> Result<BandPicture> {
        let (canvas, cost) = self.drawn_into(rect, task)?;
        Ok((self.resolve(&canvas), cost))
    }

    /// Draws what is in a rectangle.
    fn drawn_into(&self, rect: PixelRect, task: &Task) -> Result<(FlakeCanvas<'a>, ImageCost)> {
        let Self { plant, images, view, .. } = self;
        let half_spaces = view.projection.half_spaces(&rect);
        let canvas = FlakeCanvas { buffer: FlakeBuffer::new(rect), drawn: List::default() };
        let mut drawer = Drawer::new((plant, self.meshes), view, (rect, canvas), task);
        let mut cost = ImageCost::default();
        for drawn in self.drawn {
            let Drawn { object, part, view_from_object, door, .. } = drawn;
            let in_view = plant.objects[*object].bounds.ball.mapped(view_from_object);
            if !half_spaces.iter().all(|half_space| half_space.touches(&in_view)) {
                continue;
            }
            task.go_on()?;
            match part {
                Part::Image(copy) => {
                    if let Some(instance) = Instance::of((plant, images), drawn, *copy) {
                        cost.samples += self.image(&instance, &mut drawer.canvas)?;
                    }
                }
                Part::Polygons(level) => drawer.own((*object, *level), view_from_object, door),
            }
        }
        cost.triangles = drawer.triangles;
        Ok((drawer.canvas, cost))
    }

    /// Draws the images of an instance that serve; returns the number of samples.
    fn image(&self, instance: &Instance<'a>, canvas: &mut FlakeCanvas<'a>) -> Result<u64> {
        let projection = &self.view.projection;
        let (mut before, mut drawn) = (0.0, 0);
        for Serving { direction, weight } in instance.serving(projection) {
            let door = match (instance.directions, self.options.texels) {
                // Which axis closes the gaps of another depends on the surface: all are needed.
                (Directions::Axes, Texels::Planes { .. }) => Door::open(1.0, instance.path),
                _ => door_of(instance.directions, (before, weight), instance.path),
            };
            before += weight;
            if door.is_closed() {
                continue;
            }
            let doors = Doors { of_direction: door, of_part: instance.door };
            let place = Place::new(instance, projection, direction);
            let image = &instance.copy.views[direction];
            let index = canvas.drawn.begin_image(image, instance.of_samples(&place, direction))?;
            let planes = match self.options.texels {
                Texels::Flakes => None,
                Texels::Planes { error_px } => Some(Planes::new(instance, &place, (direction, error_px))),
            };
            let drawing = Drawing::new((instance, &place), planes, canvas.buffer.rect);
            let doors = Some(&doors).filter(|doors| !doors.are_wide());
            drawn += drawing.draw((image, index), doors, &mut canvas.buffer);
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
    use super::*;

    #[test]
    fn axes_draw_in_all_sub_pixels_up_to_75_degrees_and_in_none_from_85_on() {
        let door = |degrees: f64| door_of(Directions::Axes, (0.0, degrees.to_radians().cos().powi(2)), 1);
        assert!(door(0.0).is_wide() && door(75.0).is_wide());
        assert!(!door(80.0).is_wide() && !door(80.0).is_closed());
        assert!(door(85.0).is_closed() && door(90.0).is_closed());
        // Of three axes, one has a third of the weight at least.
        assert!(door_of(Directions::Axes, (0.0, 1.0 / 3.0), 1).is_wide());
    }
}
