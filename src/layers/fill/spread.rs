//! Paint of one photo on the layers of others: what was taken off a wall in one is taken off in all.
//!
//! It is derived, like all filling, and never lies over paint of the photo's own: what a hand did here counts more
//! than what one did elsewhere. Where the two say different things, or two other photos do, that is told.

use std::collections::BTreeMap;

use glam::DVec2;
use rayon::prelude::*;

use super::asker::{Asker, Asking};
use super::cells::Cells;
use super::givers::{Offered, contradict};
use super::painted::Word;
use super::photo::{FilledRegion, Ground, Texel, in_255ths};
use super::region::Region;
use super::seam::seam;
use super::surfaces::SurfaceId;
use crate::error::{Error, Result};
use crate::projection::PhotoId;
use crate::task::Task;

/// Paint that was laid over what a photo shows.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Spread {
    /// In the order of the regions; all texels are of [`super::Origin::Painted`].
    pub regions: Vec<FilledRegion>,
    /// By surface and photo.
    pub offers: Vec<Offer>,
}

/// What the paint of one photo on a surface says of another photo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Offer {
    /// The surface.
    pub surface: SurfaceId,
    /// Where it was painted.
    pub from: PhotoId,
    /// Texels of the photo that show the surface and have it now.
    pub texels: u64,
    /// Texels with paint of their own, which stays.
    pub own: u64,
    /// Of these, texels whose own paint clearly says something else.
    pub conflicts: u64,
    /// Of `texels`, those where some other photo's paint clearly says something else.
    pub dissents: u64,
}

/// Lays the paint of `painters` over what a photo shows: `regions` are what it shows of surfaces that may have
/// paint.
///
/// # Errors
/// [`Error::Request`] when the photo itself cannot be read, [`Error::Cancelled`].
pub fn spread_paint(
    ground: &Ground,
    photo: PhotoId,
    regions: Vec<Region>,
    painters: &[PhotoId],
    task: &Task,
) -> Result<Spread> {
    let others: Vec<PhotoId> = painters.iter().copied().filter(|painter| *painter != photo).collect();
    if others.is_empty() || regions.is_empty() {
        return Ok(Spread::default());
    }
    let own = ground.source.donor(photo)?;
    let own =
        own.ok_or_else(|| Error::Request("the photo cannot be read, so no paint is projected to it".into()))?;
    let donors = ground.donors(&others)?;
    let asking = Asking { ground, photo, own: &own, donors: &donors };
    let regions: Vec<Region> = regions.into_iter().filter(|region| asking.side(region).is_some()).collect();
    let offered = |asker: &Asker, px: DVec2| asker.offered(px);
    let offered = task.timed("spread", || asking.ask(&regions, &offered, task))?;
    let answered: Vec<_> = regions.into_iter().zip(offered).collect();
    let laid = answered.par_iter().map(|(region, offered)| {
        task.go_on()?;
        Ok(asking.laid(region, offered))
    });
    let (regions, offers): (Vec<_>, Vec<_>) = laid.collect::<Result<Vec<_>>>()?.into_iter().unzip();
    Ok(Spread { regions: regions.into_iter().flatten().collect(), offers: offers.concat() })
}

/// What becomes of the paint that is offered to a texel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fate {
    Taken,
    /// The photo's own paint is as good as the same.
    Own,
    /// The photo's own paint says something else.
    Conflict,
}

impl Asking<'_> {
    /// Takes what may be taken, at the seam like what the photo shows around it.
    fn laid(&self, region: &Region, offered: &[Option<Offered>]) -> (Option<FilledRegion>, Vec<Offer>) {
        let item = self.own.item(region.surface).expect("regions that the photo does not see were left out");
        let places = region.pixels();
        let fates: Vec<Option<Fate>> = places
            .clone()
            .zip(offered)
            .map(|((x, y), offered)| Some(self.fate(item, x, y, offered.as_ref()?)))
            .collect();
        let offers = offers(region.surface, offered, &fates);
        let taken = |at: usize| fates[at] == Some(Fate::Taken);
        let Some(part) = region.part(taken) else { return (None, offers) };
        let cells = Cells::around(&part, self.frame());
        // What is painted in either photo tells nothing of how both show the rest.
        let painted = places.zip(&fates).filter(|(_, fate)| fate.is_some()).map(|(place, _)| place);
        let painted = cells.touching(painted);
        let differences = self.all_differences(&part, item, &cells, None, &|place| painted[place]);
        let seam = seam(&cells, &differences);
        let factor = self.factor();
        let texel = |((x, y), offered): ((u32, u32), &Offered)| {
            let seam = seam.as_ref().map_or([0.0; 3], |seam| seam.at(x, y)).map(f32::exp);
            let given = &offered.given;
            let rgb = self.stored([0, 1, 2].map(|c| given.colour[c] * seam[c] * factor[c]));
            Texel { rgb, confidence: in_255ths(given.confidence), origin: given.origin() }
        };
        let kept = offered.iter().enumerate().filter(|(at, _)| taken(*at));
        let texels = part.pixels().zip(kept.filter_map(|(_, offered)| offered.as_ref())).map(texel).collect();
        (Some(FilledRegion { region: part, texels }), offers)
    }

    fn fate(&self, item: u32, x: u32, y: u32, offered: &Offered) -> Fate {
        let factor = self.factor();
        match self.own.painted(item, x, y) {
            Word::None => Fate::Taken,
            Word::Silence => Fate::Conflict,
            Word::Colour(own) => {
                let own = [0, 1, 2].map(|c| own[c] / factor[c]);
                if contradict(own, offered.given.colour) { Fate::Conflict } else { Fate::Own }
            }
        }
    }
}

fn offers(surface: SurfaceId, offered: &[Option<Offered>], fates: &[Option<Fate>]) -> Vec<Offer> {
    let mut by_photo: BTreeMap<PhotoId, Offer> = BTreeMap::new();
    for (offered, fate) in offered.iter().zip(fates) {
        let (Some(offered), Some(fate)) = (offered, fate) else { continue };
        let from = offered.given.photo;
        let offer = by_photo.entry(from).or_insert(Offer {
            surface,
            from,
            texels: 0,
            own: 0,
            conflicts: 0,
            dissents: 0,
        });
        offer.texels += u64::from(*fate == Fate::Taken);
        offer.own += u64::from(*fate != Fate::Taken);
        offer.conflicts += u64::from(*fate == Fate::Conflict);
        offer.dissents += u64::from(*fate == Fate::Taken && offered.dissent.is_some());
    }
    by_photo.into_values().collect()
}
