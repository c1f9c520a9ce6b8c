//! What a photo would show if there were no impostors: by surface from other photos, and the surroundings behind all.

use glam::Vec3;

use super::MatteBasis;
use crate::error::Result;
use crate::geometry::PixelRect;
use crate::layers::LayerIndex;
use crate::layers::fill::region::{Region, Regions};
use crate::layers::fill::{Donor, FillContext, FilledTexel, MOST_CONFIDENCE, SurfaceId, predicted_colours};
use crate::layers::matte::{Evidence, Predicted};
use crate::layers::software::owners;
use crate::layers::view::View;
use crate::raster::Image;
use crate::recipe::fill::surroundings::SurroundingsFiller;
use crate::scene::light::linear_of_srgb;
use crate::scene::{ObjectId, PhotoId};
use crate::task::Task;

/// The pixels around the impostors' rectangles that are compared with the prediction, too.
const AROUND_PX: u32 = 8;

/// Returns what a photo shows at impostors and what is expected behind them; `None` where it shows no impostor. The objects
/// are those that the evidence names by index.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn evidence(
    basis: &MatteBasis,
    context: &FillContext,
    photo: PhotoId,
    own: &Donor,
    around: &mut SurroundingsFiller,
    task: &Task,
) -> Result<Option<(Vec<ObjectId>, Evidence)>> {
    let Some((objects, shown)) = shown_impostors(basis, own) else { return Ok(None) };
    let mut behind = task.timed("matte regions", || regions_behind(basis, context, own, &shown));
    let sky = behind.pop_if(|region| region.surface == SurfaceId::SURROUNDINGS);
    let mut predicted = Image::filled(shown.rect(), None);
    let found = task.timed("matte colours", || predicted_colours(context, photo, own, &behind, task))?;
    for (region, colours) in behind.iter().zip(found) {
        for ((x, y), colour) in region.pixels().zip(colours) {
            if let (Some(pixel), Some(colour)) = (predicted.get_mut(x as i32, y as i32), colour) {
                let sure = colour.confidence / MOST_CONFIDENCE;
                *pixel = Some(Predicted { light: Vec3::from_array(colour.light), sure });
            }
        }
    }
    if let (Some(region), Some(stack)) = (sky, &basis.stacks[photo.index()]) {
        let filled = task.timed("matte sky", || around.fill(photo, stack, own.bits, region, task))?;
        if let Some(filled) = filled {
            for ((x, y), texel) in filled.region.pixels().zip(&filled.texels) {
                let pixel = predicted.get_mut(x as i32, y as i32);
                if let Some(pixel) = pixel {
                    *pixel = Some(of_texel(texel));
                }
            }
        }
    }
    let colours = Image::from_fn(shown.rect(), |(x, y)| Vec3::from_array(own.pixel(x as u32, y as u32)));
    Ok(Some((objects, Evidence { colours, predicted, shown })))
}

fn of_texel(texel: &FilledTexel) -> Predicted {
    let light = texel.rgb.map(|value| linear_of_srgb(f64::from(value) / 65535.0) as f32);
    let sure = f32::from(texel.confidence) / 255.0 / MOST_CONFIDENCE;
    Predicted { light: Vec3::from_array(light), sure }
}

/// Returns the impostors of which a photo shows something, and for each pixel of their bounding box and a little around
/// it the index of the one that it shows plus one, else 0.
fn shown_impostors(basis: &MatteBasis, own: &Donor) -> Option<(Vec<ObjectId>, Image<u16>)> {
    let model = &basis.opened.site.model;
    let impostor = |item: u32| {
        let face = own.seen(item).face;
        model.impostor(face).map(|_| model.face(face).object)
    };
    let items = 0..own.view().items.len() as u32;
    let mut objects: Vec<ObjectId> = items.clone().filter_map(impostor).collect();
    objects.sort_unstable();
    objects.dedup();
    let frame = own.camera.rect();
    let bounds = items.filter(|item| impostor(*item).is_some()).map(|item| own.seen(item).bounds);
    let bounds = bounds.reduce(|a, b| a.union(&b))?;
    let rect = bounds.grown(AROUND_PX).intersection(&frame);
    let index = |(x, y): (i32, i32)| {
        let object = own.owner(x as u32, y as u32).and_then(impostor)?;
        objects.binary_search(&object).ok().map(|index| index as u16 + 1)
    };
    let shown = Image::from_fn(rect, |at| index(at).unwrap_or(0));
    shown.pixels().iter().any(|index| *index > 0).then_some((objects, shown))
}

/// Returns the pixels that show impostors by the nearest surface behind them that is none, the surroundings last.
fn regions_behind(basis: &MatteBasis, context: &FillContext, own: &Donor, shown: &Image<u16>) -> Vec<Region> {
    let (model, options) = (&basis.opened.site.model, &basis.opened.project.options);
    let view = View::new(&model.without_impostors(), &own.camera, &own.pose);
    let owners = owners(&view, options.tolerance);
    let (frame, rect): (PixelRect, PixelRect) = (own.camera.rect(), shown.rect());
    let surface = |(x, y): (i32, i32)| match owners[frame.offset(x, y)].checked_sub(1) {
        None => Some(SurfaceId::SURROUNDINGS),
        Some(item) => {
            let item = &view.items[item as usize];
            Some(context.surfaces.id(item.face, item.triangle))
        }
    };
    let surfaces: Vec<Option<SurfaceId>> = rect.pixels().map(surface).collect();
    let hidden: Vec<bool> = shown.pixels().iter().map(|index| *index > 0).collect();
    let mut regions = Regions::default();
    regions.add(LayerIndex(0), rect, &surfaces, &hidden);
    regions.finish()
}
