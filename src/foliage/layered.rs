//! Pictures of plants from the images of their sub-objects (Max 1996): what is drawn is found by a walk, images are brought into
//! layered pixels, the rest is drawn into them as polygons, and what is seen is lit in the end.

use glam::{DMat3, DVec2, DVec3, Mat3, Vec3};

use super::bands::check;
use super::drawer::{Drawer, FragmentCanvas};
use super::facet::Facet;
use super::images::PlantImages;
use super::listed::{ImageCost, in_bands, meshes_of, rgba_of_light};
use super::mbuffer::{Layer, LayerSample, LayeredPixels, Slabs};
use super::mesh::Meshes;
use super::place::Instance;
use super::plant::Plant;
use super::raster::Fragment;
use super::reproject::{TargetRows, reproject};
use super::shade::{LightReach, LitSurface, OutdoorLight, Spread, shade_leaves};
use super::view::{Projection, View};
use super::walk::{Drawn, Part, WalkOptions, walk};
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::task::Task;
use quadratura_view::Picture;

/// The number of rows that are drawn together. It changes no pixel: bands only share work among threads.
const BAND: u32 = 64;

/// How plants are drawn from images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayeredOptions {
    /// When images serve.
    pub walk: WalkOptions,
    /// The largest number of surfaces in a pixel.
    pub layers: u8,
    /// What is within this many pixels of depth is one surface. The fewer layers there are, the more has to share one.
    pub epsilon_px: f64,
}

impl LayeredOptions {
    /// Previews.
    pub const PREVIEW: Self = Self { walk: WalkOptions::PREVIEW, layers: 4, epsilon_px: 0.5 };
    /// Final pictures.
    pub const FINAL: Self = Self { walk: WalkOptions::FINAL, layers: 8, epsilon_px: 0.25 };
}

/// Draws a plant from its images.
///
/// # Errors
/// Those of [`super::draw`].
pub fn draw_layered(
    plant: &Plant,
    images: &PlantImages,
    view: &View,
    light: &OutdoorLight,
    options: &LayeredOptions,
    task: &Task,
) -> Result<(Picture, ImageCost)> {
    check(plant, view)?;
    let drawn = walk(plant, images, view, &options.walk, 0);
    let meshes = meshes_of(plant, &drawn);
    let scene = LayeredScene { plant, images, meshes: &meshes, drawn: &drawn, view, light, options };
    in_bands(view.rect(), BAND, &drawn, &|rect| scene.band(rect, task), task)
}

/// What all bands of a picture share.
struct LayeredScene<'a> {
    plant: &'a Plant,
    images: &'a PlantImages,
    meshes: &'a Meshes,
    drawn: &'a [Drawn],
    view: &'a View,
    light: &'a OutdoorLight,
    options: &'a LayeredOptions,
}

impl LayeredScene<'_> {
    /// Draws a band of rows: all instances in their order, so that the bytes do not depend on bands.
    fn band(&self, rect: PixelRect, task: &Task) -> Result<(Vec<u8>, ImageCost)> {
        let Self { plant, images, view, .. } = self;
        let projection = &view.projection;
        let half_spaces = projection.half_spaces(&rect);
        let canvas = LayeredCanvas {
            rect,
            pixels: LayeredPixels::new(rect.area() as usize, self.options.layers),
            projection,
            epsilon_px: self.options.epsilon_px,
        };
        let mut drawer = Drawer::new(plant, self.meshes, view, rect, canvas, task);
        let mut cost = ImageCost::default();
        for drawn in self.drawn {
            let Drawn { object, view_from_object, .. } = drawn;
            let in_view = plant.objects[*object].bounds.ball.mapped(view_from_object);
            if !half_spaces.iter().all(|half_space| half_space.touches(&in_view)) {
                continue;
            }
            task.check_cancelled()?;
            cost.samples += draw_part(&mut drawer, plant, images, drawn, view, self.options.epsilon_px);
        }
        cost.triangles = drawer.triangles;
        Ok((self.resolve(&drawer.canvas), cost))
    }

    /// Returns R, G, B, A of the pixels: the mean light of the covered sub-pixels, and their share.
    fn resolve(&self, canvas: &LayeredCanvas) -> Vec<u8> {
        let view = self.view;
        let pixels = (0..).zip(canvas.rect.pixels());
        let resolved = |(pixel, (x, y)): (usize, (i32, i32))| {
            let point = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let towards = view.projection.towards_viewer(view.projection.view_from_image(point, 1.0));
            let towards = (view.light_from_view * towards).normalize_or_zero();
            resolved(canvas.pixels.layers(pixel), &view.light_from_view.as_mat3(), towards, self.light)
        };
        pixels.flat_map(resolved).collect()
    }
}

/// A canvas of layered pixels, for polygons and for samples of images.
pub(super) trait LayeredRows: FragmentCanvas {
    /// Returns its rows.
    fn rows(&mut self) -> TargetRows<'_>;
}

/// Draws what a walk has found: the samples of an image, where what is within `epsilon_px` pixels of depth is one surface, or polygons.
/// Returns how many samples were drawn.
pub(super) fn draw_part<C: LayeredRows>(
    drawer: &mut Drawer<C>,
    plant: &Plant,
    images: &PlantImages,
    drawn: &Drawn,
    view: &View,
    epsilon_px: f64,
) -> u64 {
    let copy = match drawn.part {
        Part::Image(copy) => copy,
        Part::Polygons(level) => {
            drawer.own(drawn.object, level, &drawn.view_from_object, &drawn.stipple);
            return 0;
        }
    };
    let Some(instance) = Instance::of(plant, images, drawn, copy) else { return 0 };
    reproject(&instance, view, epsilon_px, &mut drawer.canvas.rows())
}

/// Lights the layers of a pixel as far as they are seen, front to back; `towards` is the direction to the viewer.
fn resolved(layers: &[Layer], light_from_view: &Mat3, towards: DVec3, light: &OutdoorLight) -> [u8; 4] {
    // The images of a pixel are seen from directions around that to the viewer; how they are stretched is not known.
    let (right, down) = towards.any_orthonormal_pair();
    let from_image = DMat3::from_cols(right, down, towards);
    let (mut left, mut sum) = (u16::MAX, Vec3::ZERO);
    for layer in layers {
        let seen = layer.mask & left;
        left &= !layer.mask;
        if seen != 0 {
            let normal = (*light_from_view * layer.normal()).as_dvec3().normalize_or_zero();
            let through = layer.is_leaf().then(|| layer.through());
            let surface = LitSurface { normal, reflected: layer.reflected(), through };
            let spread = Spread { length: layer.length(), towards_viewer: towards, from_image };
            let light = shade_leaves(&surface, &spread, light, &LightReach::ALL);
            sum += seen.count_ones() as f32 * light;
        }
    }
    let covered = left.count_zeros();
    rgba_of_light(sum, covered)
}

/// The layered pixels of a band of rows.
struct LayeredCanvas<'a> {
    rect: PixelRect,
    pixels: LayeredPixels,
    projection: &'a Projection,
    epsilon_px: f64,
}

impl FragmentCanvas for LayeredCanvas<'_> {
    #[inline]
    fn visible(&self, fragment: &Fragment) -> u16 {
        fragment.mask
    }

    #[inline]
    fn put(&mut self, fragment: &Fragment, visible: u16, facet: &Facet) {
        if facet.is_back {
            return;
        }
        let depth = self.projection.depth(fragment.middle) as f32;
        let sample = LayerSample::of_facet(visible, depth, facet);
        let epsilon = self.epsilon_px as f32 * pixel_at(self.projection, depth);
        self.pixels.insert(self.rect.offset(fragment.x, fragment.y), &sample, epsilon);
    }
}

impl LayeredRows for LayeredCanvas<'_> {
    fn rows(&mut self) -> TargetRows<'_> {
        TargetRows { rect: self.rect, pixels: &mut self.pixels, slabs: Slabs::ONE, beside_polygons: false }
    }
}

/// Returns the side of a pixel at a depth, in the unit of the view's frame.
#[inline]
fn pixel_at(projection: &Projection, depth: f32) -> f32 {
    match projection {
        Projection::Perspective { camera, .. } => depth / camera.fx.max(camera.fy) as f32,
        Projection::Parallel { scale, .. } => scale.recip() as f32,
    }
}
