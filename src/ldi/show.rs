//! What views show instead of colours: the layer of each depth pixel, where its colour is from, its spacing, and why
//! pixels are empty ([`super::holes`]).

use glam::DVec2;

use super::holes::{Hole, HolePixel, holes_of, paint_holes};
use super::layout::{DepthPixelOrigin, Ldi, ResolutionLevel};
use super::set::LdiSet;
use super::spacing::{Factors, exact};
use super::transfer::Transfer;
use super::warp::{WarpOptions, Warped, common_level, warp_set};
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_view::Shot;
use quadratura_view::legend::{DENSITY, DENSITY_OCTAVES, Legend, Origin, colour_at, colour_of_number};

/// The largest number of layers in a legend; deeper ones are rare, and have colours of their own, too.
const MOST_LISTED: u32 = 10;

/// A quantity that a view of a layered depth image shows by colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// Why pixels are empty; the others have their colours.
    Holes,
    /// The layer, 1 the nearest one.
    Layer,
    /// Where the colour is from.
    Provenance,
    /// Depth pixels per pixel of the picture, in octaves around one.
    Density,
}

impl Shown {
    /// Returns the legend for images of up to `layers` layers.
    pub fn legend(self, layers: u32) -> Legend {
        let entries = |title, entries: Vec<(String, [u8; 3])>| Legend::Entries { title, entries };
        match self {
            Self::Holes => {
                let entry = |hole: Hole| (hole.name().to_owned(), hole.colour());
                entries("Empty pixels", Hole::ALL.map(entry).into())
            }
            Self::Layer => {
                let name = |layer: u32| match layer {
                    0 => "layer 1, the nearest".to_owned(),
                    layer => format!("layer {}", layer + 1),
                };
                let layers = 0..layers.clamp(1, MOST_LISTED);
                entries("Layers", layers.map(|layer| (name(layer), colour_of_number(layer))).collect())
            }
            Self::Provenance => {
                let entry = |origin| (name_of(origin).to_owned(), legend_origin(origin).colour());
                entries("Source", DepthPixelOrigin::ALL.map(entry).into())
            }
            Self::Density => Legend::Scale {
                title: "Resolution (depth pixels per pixel)",
                ramp: DENSITY,
                marks: &["1/8", "1", "8"],
            },
        }
    }
}

/// Returns the origin whose colour stands for that of depth pixels, in the legend of all views.
fn legend_origin(origin: DepthPixelOrigin) -> Origin {
    match origin {
        DepthPixelOrigin::Photo => Origin::Photo,
        DepthPixelOrigin::Paint => Origin::Paint,
        DepthPixelOrigin::OtherPhotos => Origin::OtherPhoto,
        DepthPixelOrigin::Invented => Origin::Example,
    }
}

fn name_of(origin: DepthPixelOrigin) -> &'static str {
    match origin {
        // Layered depth images do not tell the two ways of inpainting apart.
        DepthPixelOrigin::Invented => "inpainted",
        origin => legend_origin(origin).name(),
    }
}

/// Makes a view that shows a quantity, of layered depth images that belong together. Options are those of [`warp_set`]; the
/// exposure has no effect on the colours that stand for a quantity.
///
/// # Errors
/// Those of [`warp_set`].
pub fn warp_shown(
    set: &LdiSet,
    shot: &Shot,
    shown: Shown,
    options: &WarpOptions,
    task: &Task,
) -> Result<Warped> {
    let level = options.level.or_else(|| common_level(set, shot));
    let options = &WarpOptions { level, ..*options };
    if shown == Shown::Holes {
        let mut warped = warp_set(set, shot, options, task)?;
        let picture = &warped.picture;
        let pixel = |at: usize| match picture.pixels()[at][3] {
            u8::MAX => HolePixel::Full,
            _ => HolePixel::Empty,
        };
        let found = holes_of(&set.images, shot, options, &pixel, task)?;
        paint_holes(&mut warped.picture, &found);
        return Ok(warped);
    }
    let images = set.images.iter().map(|ldi| coloured(ldi, shot, shown)).collect();
    let options = WarpOptions { exposure: [0.0; 3], ..*options };
    warp_set(&LdiSet { images, ..*set }, shot, &options, task)
}

/// Returns an image whose colours stand for a quantity, opaque and without a gain; in place of holes, its own colours without the gain.
pub fn coloured(ldi: &Ldi, shot: &Shot, shown: Shown) -> Ldi {
    let of_level = |level: &ResolutionLevel| {
        let colours = match shown {
            Shown::Holes => return level.clone(),
            Shown::Layer => colours_of_layers(level),
            Shown::Density => colours_of_density(ldi, level, shot),
            Shown::Provenance => {
                level.splats.iter().map(|splat| legend_origin(splat.origin()).colour()).collect()
            }
        };
        let colours = colours.into_iter().map(|[r, g, b]| [r, g, b, u8::MAX]).collect();
        ResolutionLevel { colours, ..level.clone() }
    };
    Ldi { gain: [0.0; 3], ..ldi.with_levels(ldi.levels.iter().map(of_level).collect()) }
}

fn colours_of_layers(level: &ResolutionLevel) -> Vec<[u8; 3]> {
    let mut colours = Vec::with_capacity(level.len());
    for y in 0..level.camera.height {
        for pixel in level.layered_pixels(y) {
            colours.extend((0..).take(pixel.len()).map(colour_of_number));
        }
    }
    colours
}

/// Returns the colours of the spacing at each depth pixel; those behind the picture's camera have any.
fn colours_of_density(ldi: &Ldi, level: &ResolutionLevel, shot: &Shot) -> Vec<[u8; 3]> {
    let to_shot = |camera| Transfer::new(camera, &ldi.pose, &shot.camera, &shot.pose);
    let transfer = to_shot(&level.camera);
    let Factors::Exact(factors) = Factors::exact(ldi, &to_shot(&ldi.camera), transfer.focal_ratio) else {
        unreachable!("these factors are made by planes")
    };
    let colour = |y: u32, index: usize| {
        let position = DVec2::new(f64::from(level.columns[index]) + 0.5, f64::from(y) + 0.5);
        let omega = transfer.homogeneous(position, f64::from(level.inverse_depths[index])).z;
        let per_omega = (1.0 / omega.max(f64::MIN_POSITIVE)) as f32;
        let spacing = match level.surfaces[index] {
            0 => factors[0] * per_omega,
            surface => exact(factors[usize::from(surface)], per_omega),
        };
        colour_at(DENSITY, 0.5 - 0.5 * spacing.log2() / DENSITY_OCTAVES as f32)
    };
    let mut colours = Vec::with_capacity(level.len());
    for y in 0..level.camera.height {
        colours.extend(level.row(y).map(|index| colour(y, index)));
    }
    colours
}
