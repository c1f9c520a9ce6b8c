//! Finding the mattes of a photo's see-through objects from what is expected behind them.

use glam::Vec3;

use super::{ClosedForm, Known, Matte, closed_form, foreground};
use crate::error::Result;
use crate::geometry::PixelRect;
use crate::projection::srgb::Srgb;
use crate::raster::Image;
use crate::task::Task;

/// What is expected behind a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// Linear light in the photo's own exposure, full range 1.
    pub light: Vec3,
    /// How sure that is, 0 to 1.
    pub sure: f32,
}

/// What a photo shows at see-through objects, all for one rectangle in photo pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    /// The photo's colours, linear light, full range 1.
    pub colours: Image<Vec3>,
    /// What is expected behind; `None` where nobody knows.
    pub predicted: Image<Option<Predicted>>,
    /// The index of the object that the photo shows there plus one, the foremost one; 0 where it shows no such object.
    pub shown: Image<u16>,
}

/// Options of the search.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FindOptions {
    /// Options of the solution in the band.
    pub closed_form: ClosedForm,
}

/// The distance in sRGB steps (255 are the whole range) from the predicted colours up to which a pixel is as predicted.
const ALIKE: f32 = 10.0;

/// The distance from which on it is something else.
const UNLIKE: f32 = 40.0;

/// The reach in pixels of the box of predicted colours: what was predicted is off by as much.
const REACH: i32 = 2;

/// Finds the mattes of the objects with these names. Objects that the photo does not show get none.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn find_mattes(
    evidence: &Evidence,
    names: &[&str],
    options: &FindOptions,
    task: &Task,
) -> Result<Vec<Matte>> {
    let Evidence { colours, predicted, shown } = evidence;
    let known = Image::from_fn(shown.rect(), |(x, y)| {
        if shown.get(x, y) == Some(&0) {
            return Some(0.0);
        }
        if predicted.get(x, y).is_none_or(Option::is_none) {
            return Some(1.0);
        }
        let off = distance(evidence, (x, y));
        match off {
            off if off <= ALIKE => Some(0.0),
            off if off >= UNLIKE => Some(1.0),
            _ => None,
        }
    });
    let alpha = closed_form(colours, &known, &options.closed_form, task)?;
    let own = foreground(colours, &alpha).front;
    let of_object = |(index, name): (u16, &&str)| matte(name, index, evidence, &alpha, &own);
    Ok((1..).zip(names).filter_map(of_object).collect())
}

fn distance(evidence: &Evidence, (x, y): (i32, i32)) -> f32 {
    let encoded =
        |light: Vec3| Vec3::from_array(light.to_array().map(|c| f32::from(Srgb::tables().encoded(c))));
    let own = encoded(*evidence.colours.get(x, y).expect("within"));
    let mut low = Vec3::INFINITY;
    let mut high = Vec3::NEG_INFINITY;
    for dy in -REACH..=REACH {
        for dx in -REACH..=REACH {
            if let Some(Some(predicted)) = evidence.predicted.get(x + dx, y + dy) {
                let predicted = encoded(predicted.light);
                low = low.min(predicted);
                high = high.max(predicted);
            }
        }
    }
    (own - own.clamp(low, high)).length()
}

/// Returns the matte of one object; `None` where the photo does not show it.
fn matte(
    name: &str,
    index: u16,
    evidence: &Evidence,
    alpha: &Image<f32>,
    own: &Image<Vec3>,
) -> Option<Matte> {
    let Evidence { colours, predicted, shown } = evidence;
    let is_shown = |(x, y): (i32, i32)| shown.get(x, y) == Some(&index);
    let pixel = |(x, y): (i32, i32)| PixelRect { x, y, w: 1, h: 1 };
    let rect = shown.rect().pixels().filter(|at| is_shown(*at)).map(pixel).reduce(|a, b| a.union(&b))?;
    let known = Image::from_fn(rect, |(x, y)| match predicted.get(x, y) {
        _ if !is_shown((x, y)) => Known::NotShown,
        Some(None) | None => Known::Unknown,
        _ => Known::Found,
    });
    let texel = |(x, y): (i32, i32)| {
        let at = shown.rect().offset(x, y);
        let alpha = match known.get(x, y) {
            Some(Known::Found) => in_255ths(alpha.pixels()[at]),
            _ => 255,
        };
        let light = if alpha == 255 { colours.pixels()[at] } else { own.pixels()[at] };
        let [r, g, b] = light.to_array().map(|light| Srgb::tables().encoded(light));
        [r, g, b, alpha]
    };
    let texels = Image::from_fn(rect, texel);
    Some(Matte { object: name.to_owned(), texels, known })
}

/// Returns a matte in 255ths; within 1/32 of its ends it is 0 or 255.
fn in_255ths(alpha: f32) -> u8 {
    match alpha {
        alpha if alpha < 1.0 / 32.0 => 0,
        alpha if alpha > 31.0 / 32.0 => 255,
        alpha => (alpha * 255.0).round() as u8,
    }
}
