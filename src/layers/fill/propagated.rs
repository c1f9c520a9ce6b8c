//! Propagation of paint to other photos: what was painted out of one photo is painted out of all.
//!
//! Propagated paint is derived, like all filling. It never covers paint of the photo itself, which counts
//! more than paint of another photo. Texels where the two differ, and texels where the paint of two other
//! photos differs, are reported.

use std::collections::BTreeMap;

use glam::DVec2;
use rayon::prelude::*;

use super::cells::RegionCells;
use super::painted::PaintSample;
use super::photo::{FillContext, FilledRegion, FilledTexel, in_255ths};
use super::queries::{Asking, Query, centre};
use super::ranked_donors::{OfferedPaint, PaintOffer, paints_differ};
use super::region::Region;
use super::seam::seam;
use super::surfaces::FillSurfaceId;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::PhotoId;
use quadratura_base::task::Task;

/// The paint that was propagated to a photo.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PropagatedPaint {
    /// The texels, in the order of the regions; the origin of all is [`super::FillOrigin::Painted`].
    pub regions: Vec<FilledRegion>,
    /// The statistics, by surface and photo.
    pub offers: Vec<PropagationStatistics>,
}

/// The statistics of the propagation of one photo's paint on one surface to another photo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PropagationStatistics {
    /// The surface.
    pub surface: FillSurfaceId,
    /// The photo that was painted on.
    pub from: PhotoId,
    /// The number of texels that show the surface and received the paint.
    pub texels: u64,
    /// The number of texels that keep the photo's own paint.
    pub own: u64,
    /// The number of texels of `own` whose own paint clearly differs.
    pub conflicts: u64,
    /// The number of texels of `texels` for which a further photo's paint clearly differs.
    pub dissents: u64,
    /// The number of texels that keep the photo's pixels, because the paint is too coarse.
    pub coarse: u64,
}

/// Propagates the paint of `painters` to a photo. `regions` are the pixels in which the photo shows surfaces
/// that may have paint.
///
/// # Errors
/// [`Error::Request`] when the photo itself cannot be read, [`Error::Cancelled`].
pub fn propagate_paint(
    context: &FillContext,
    photo: PhotoId,
    regions: Vec<Region>,
    painters: &[PhotoId],
    task: &Task,
) -> Result<PropagatedPaint> {
    let others: Vec<PhotoId> = painters.iter().copied().filter(|painter| *painter != photo).collect();
    if others.is_empty() || regions.is_empty() {
        return Ok(PropagatedPaint::default());
    }
    let own = context.source.own(photo)?;
    let own =
        own.ok_or_else(|| Error::Request("the photo cannot be read, so no paint is projected to it".into()))?;
    let donors = context.donors(&others)?;
    let asking = Asking { context, photo, own: &own, donors: &donors };
    let regions: Vec<Region> = regions.into_iter().filter(|region| asking.side(region).is_some()).collect();
    let offered = |query: &Query, px: DVec2| query.offered(px);
    let offered = task.timed("spread", || asking.ask(&regions, &offered, task))?;
    let answered: Vec<_> = regions.into_iter().zip(offered).collect();
    let propagated = answered.par_iter().map(|(region, offered)| {
        task.check_cancelled()?;
        Ok(asking.propagated(region, offered))
    });
    let (regions, offers): (Vec<_>, Vec<_>) = propagated.collect::<Result<Vec<_>>>()?.into_iter().unzip();
    Ok(PropagatedPaint { regions: regions.into_iter().flatten().collect(), offers: offers.concat() })
}

/// The decision about paint offered to a texel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fate {
    Taken,
    /// The photo's own paint is kept, and is nearly the same.
    Own,
    /// The photo's own paint is kept, and clearly differs.
    Conflict,
    /// The photo's pixel is kept, because the paint is too coarse.
    TooCoarse,
}

impl Asking<'_> {
    /// Applies the offered paint where the photo has none of its own, adapted at the seam to the photo's
    /// surrounding pixels.
    fn propagated(
        &self,
        region: &Region,
        offered: &[Option<OfferedPaint>],
    ) -> (Option<FilledRegion>, Vec<PropagationStatistics>) {
        let item = self.own.item(region.surface).expect("regions that the photo does not see were left out");
        let pixels = region.pixels();
        let fates: Vec<Option<Fate>> = pixels
            .clone()
            .zip(offered)
            .map(|((x, y), offered)| self.fate(item, x, y, offered.as_ref()?))
            .collect();
        let offers = offers(region.surface, offered, &fates);
        let taken = |at: usize| fates[at] == Some(Fate::Taken);
        let Some(part) = region.part(taken) else { return (None, offers) };
        let cells = RegionCells::around(&part, self.frame());
        // Pixels painted in either photo do not tell how the two photos show the rest.
        let painted = pixels.zip(offered).filter(|(_, offered)| offered.is_some()).map(|(pixel, _)| pixel);
        let painted = cells.touching(painted);
        let differences = self.all_differences(&part, item, &cells, None, &|index| painted[index]);
        let seam = seam(&cells, &differences);
        let texel = |((x, y), offered): ((u32, u32), &PaintOffer)| {
            let seam = seam.as_ref().map_or([0.0; 3], |seam| seam.at(x, y)).map(f32::exp);
            let (given, factor) = (&offered.given, self.factor(centre(x, y)));
            let rgb = self.stored([0, 1, 2].map(|c| given.colour[c] * seam[c] * factor[c]));
            FilledTexel { rgb, confidence: in_255ths(given.confidence), origin: given.origin() }
        };
        let kept = offered.iter().enumerate().filter(|(at, _)| taken(*at));
        let kept = kept.filter_map(|(_, offered)| offered.as_ref()?.fine());
        let texels = part.pixels().zip(kept).map(texel).collect();
        (Some(FilledRegion { region: part, texels }), offers)
    }

    /// Returns the decision about paint offered to a pixel; `None` where the photo's own paint is there and the offer
    /// is too coarse in any case.
    fn fate(&self, item: u32, x: u32, y: u32, offered: &OfferedPaint) -> Option<Fate> {
        let factor = self.factor(centre(x, y));
        let own = self.own.painted(item, x, y);
        let Some(offer) = offered.fine() else {
            return (own == PaintSample::None).then_some(Fate::TooCoarse);
        };
        Some(match own {
            PaintSample::None => Fate::Taken,
            PaintSample::Silence => Fate::Conflict,
            PaintSample::Colour(own) => {
                let own = [0, 1, 2].map(|c| own[c] / factor[c]);
                if paints_differ(own, offer.given.colour) { Fate::Conflict } else { Fate::Own }
            }
        })
    }
}

fn offers(
    surface: FillSurfaceId,
    offered: &[Option<OfferedPaint>],
    fates: &[Option<Fate>],
) -> Vec<PropagationStatistics> {
    let mut by_photo: BTreeMap<PhotoId, PropagationStatistics> = BTreeMap::new();
    for (offered, fate) in offered.iter().zip(fates) {
        let (Some(offered), Some(fate)) = (offered, fate) else { continue };
        let from = offered.from();
        let offer = by_photo.entry(from).or_insert(PropagationStatistics {
            surface,
            from,
            texels: 0,
            own: 0,
            conflicts: 0,
            dissents: 0,
            coarse: 0,
        });
        let dissent = offered.fine().is_some_and(|offer| offer.dissent.is_some());
        offer.texels += u64::from(*fate == Fate::Taken);
        offer.own += u64::from(matches!(fate, Fate::Own | Fate::Conflict));
        offer.conflicts += u64::from(*fate == Fate::Conflict);
        offer.dissents += u64::from(*fate == Fate::Taken && dissent);
        offer.coarse += u64::from(*fate == Fate::TooCoarse);
    }
    by_photo.into_values().collect()
}
