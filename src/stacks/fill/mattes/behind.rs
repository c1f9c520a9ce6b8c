//! What a photo would show if there were nothing that one sees through: by surface from other photos, and the
//! surroundings behind all.

use glam::Vec3;
use rayon::prelude::*;

use super::{MatteBasis, SeeThroughPiece};
use crate::fill::surroundings::SurroundingsFiller;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::Image;
use quadratura_base::scene::PhotoId;
use quadratura_base::scene::light::linear_of_srgb;
use quadratura_base::task::Task;
use quadratura_layers::LayerIndex;
use quadratura_layers::fill::region::{Region, Regions};
use quadratura_layers::fill::{
    Donor, FillContext, FillSurfaceId, FillSurfaces, FilledTexel, MOST_CONFIDENCE, predicted_colours,
};
use quadratura_layers::matte::{CANDIDATES, Evidence, Predicted, SeenPiece};
use quadratura_layers::projected_model::ProjectedModel;
use quadratura_layers::software::owners;

/// The pixels around see-through surfaces whose colours are taken for those of the background, too.
const AROUND_PX: u32 = 8;

/// A photo's sight of see-through surfaces and of what is behind them.
pub struct MatteSight {
    /// The indices of the site's pieces plus one at each pixel of their bounding box and a little around it, as in
    /// [`Evidence`].
    pub candidates: Image<[u16; CANDIDATES]>,
    /// The pieces, in the site's order.
    pub seen: Vec<SeenPiece>,
    /// The model without see-through surfaces, and the item plus one that is nearest at each pixel.
    view: ProjectedModel,
    owners: Vec<u32>,
}

impl MatteSight {
    /// Returns what a photo sees of `pieces`, those of the site's model; `None` where it shows none of them.
    pub fn new(basis: &MatteBasis, own: &Donor, pieces: &[SeeThroughPiece]) -> Option<Self> {
        let (project, site) = (basis.project, basis.site);
        let index_of = |item: u32| {
            let item = own.seen(item);
            let found = pieces.binary_search_by_key(&(item.face, item.triangle), |it| (it.face, it.triangle));
            found.ok().and_then(|index| u16::try_from(index + 1).ok())
        };
        // Where the photo may show each piece.
        let mut bounds = vec![PixelRect::of_size(0, 0); pieces.len()];
        for item in 0..own.view().items.len() as u32 {
            if let Some(index) = index_of(item) {
                bounds[usize::from(index) - 1] = own.seen(item).bounds;
            }
        }
        let all = bounds.iter().filter(|bounds| !bounds.is_empty()).copied().reduce(|a, b| a.union(&b))?;
        let rect = all.grown(AROUND_PX).intersection(&own.camera.rect());
        let view = ProjectedModel::new(&site.model.without_see_through(), &own.camera, &own.pose);
        let owners = owners(&view, project.options.tolerance);
        let seen: Vec<SeenPiece> = pieces.iter().map(|piece| piece.seen(&own.camera, &own.pose)).collect();
        let near: Vec<(u16, PixelRect, &SeenPiece)> = (1..)
            .zip(bounds)
            .zip(&seen)
            .filter(|((_, bounds), _)| !bounds.is_empty())
            .map(|((index, bounds), seen)| (index, bounds.grown(1), seen))
            .collect();
        let frame = own.camera.rect();
        let of_pixel = |at: usize| {
            let at = (rect.x + (at % rect.w as usize) as i32, rect.y + (at / rect.w as usize) as i32);
            let Some(first) = own.owner(at.0 as u32, at.1 as u32).and_then(index_of) else {
                return [0; CANDIDATES];
            };
            let behind = owners[frame.offset(at.0, at.1)].checked_sub(1);
            let plane = behind.map(|item| view.items[item as usize].inverse_depth);
            let limit =
                plane.map_or(f64::INFINITY, |plane| 1.0 / f64::from(plane.at(at.0 as u32, at.1 as u32)));
            candidates(&near, first, at, limit)
        };
        let candidates: Vec<[u16; CANDIDATES]> =
            (0..rect.area() as usize).into_par_iter().map(of_pixel).collect();
        let is_shown = candidates.iter().any(|candidates| candidates[0] != 0);
        is_shown.then(|| Self { candidates: Image::new(rect, candidates), seen, view, owners })
    }

    /// Returns the pixels that show pieces by the nearest surface behind them that is none, the surroundings last.
    fn regions_behind(&self, own: &Donor, surfaces: &FillSurfaces) -> Vec<Region> {
        let (frame, rect) = (own.camera.rect(), self.candidates.rect());
        let surface = |(x, y): (i32, i32)| match self.owners[frame.offset(x, y)].checked_sub(1) {
            None => Some(FillSurfaceId::SURROUNDINGS),
            Some(item) => {
                let item = &self.view.items[item as usize];
                Some(surfaces.id(item.face, item.triangle))
            }
        };
        let behind: Vec<Option<FillSurfaceId>> = rect.pixels().map(surface).collect();
        let hidden: Vec<bool> =
            self.candidates.pixels().iter().map(|candidates| candidates[0] != 0).collect();
        let mut regions = Regions::default();
        regions.add(LayerIndex(0), rect, &behind, &hidden);
        regions.finish()
    }
}

/// Returns the pieces that a ray meets before the depth of what is behind, the nearest first. `first` is the one that the photo
/// shows; `near` has the index of each, and where the photo may show it.
fn candidates(
    near: &[(u16, PixelRect, &SeenPiece)],
    first: u16,
    at: (i32, i32),
    limit: f64,
) -> [u16; CANDIDATES] {
    let mut found = [first, 0, 0];
    let mut depths = [0.0, f64::INFINITY, f64::INFINITY];
    let others = near.iter().filter(|(index, bounds, _)| *index != first && bounds.contains(at.0, at.1));
    for (index, _, seen) in others {
        let Some((_, depth)) = seen.met(at).filter(|(_, depth)| *depth < limit) else { continue };
        if let Some(place) = (1..CANDIDATES).find(|place| depth < depths[*place]) {
            found[place..].rotate_right(1);
            depths[place..].rotate_right(1);
            (found[place], depths[place]) = (*index, depth);
        }
    }
    found
}

/// Returns what a photo shows at see-through surfaces and what is expected behind them.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn evidence(
    basis: &MatteBasis,
    context: &FillContext,
    photo: PhotoId,
    own: &Donor,
    sight: &MatteSight,
    around: &mut SurroundingsFiller,
    task: &Task,
) -> Result<Evidence> {
    let mut behind = sight.regions_behind(own, context.surfaces);
    let sky = behind.pop_if(|region| region.surface == FillSurfaceId::SURROUNDINGS);
    let rect = sight.candidates.rect();
    let mut predicted = Image::filled(rect, None);
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
    let gain = basis.gains.of_photo[photo.index()].map(|gain| gain as f32);
    let (colours, candidates) = (colours(own, rect), sight.candidates.clone());
    Ok(Evidence { colours, predicted, candidates, gain: Vec3::from_array(gain) })
}

/// Returns a photo's colours in a rectangle, in linear light.
pub fn colours(own: &Donor, rect: PixelRect) -> Image<Vec3> {
    Image::from_fn(rect, |(x, y)| Vec3::from_array(own.pixel(x as u32, y as u32)))
}

fn of_texel(texel: &FilledTexel) -> Predicted {
    let light = texel.rgb.map(|value| linear_of_srgb(f64::from(value) / 65535.0) as f32);
    let sure = f32::from(texel.confidence) / 255.0 / MOST_CONFIDENCE;
    Predicted { light: Vec3::from_array(light), sure }
}
