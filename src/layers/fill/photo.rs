//! Filling of one photo: colours from other photos, then synthesis, then the seam.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::cells::RegionCells;
use super::donor::{Donor, Donors};
use super::plate::{RectifiedTextures, SurfaceSide, photos_of_plate};
use super::queries::{Asking, Query, centre};
use super::ranked_donors::DonatedColour;
use super::region::Region;
use super::remnant::LastResort;
use super::seam::seam;
use super::see_through::LayerMatte;
use super::surfaces::{FillSurface, FillSurfaceId, FillSurfaces};
use super::{DIFFUSED_CONFIDENCE, FillOptions, FillOrigin, INVENTED_CONFIDENCE};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::PhotoId;
use quadratura_base::task::Task;
use quadratura_projection::relief::Relief;
use quadratura_projection::{Gains, Projector};

/// The data that the filling of all photos of a site shares.
pub struct FillContext<'a> {
    /// The photos, in the site's order.
    pub photos: &'a [Projector],
    /// The surfaces of the model in world coordinates.
    pub surfaces: &'a FillSurfaces,
    /// Per face, the photos that have it in their working set and are not excluded from it, rising.
    pub serving: &'a [Vec<PhotoId>],
    /// Per face, the photos that have paint on it which other photos may see, rising.
    pub painters: &'a [Vec<PhotoId>],
    /// The heights of the true surface over the model's.
    pub relief: &'a Relief,
    /// The exposure of each photo relative to the common exposure, and its optics.
    pub gains: &'a Gains,
    /// The user's options.
    pub options: &'a FillOptions,
    /// The source of the photos' pixels.
    pub source: &'a dyn Donors,
}

impl FillContext<'_> {
    /// Returns these photos as donors; those that cannot be read are left out.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn donors(&self, photos: &[PhotoId]) -> Result<Vec<(PhotoId, Arc<Donor>)>> {
        let donor = |photo: &PhotoId| Ok(self.source.donor(*photo)?.map(|donor| (*photo, donor)));
        photos.iter().filter_map(|photo| donor(photo).transpose()).collect()
    }

    /// Returns the point of the true surface (with relief) over a point of the plane, both in world
    /// coordinates.
    pub fn point_on_relief(&self, surface: &FillSurface, on_plane: DVec3) -> DVec3 {
        let height = self.relief.of(surface.face).map_or(0.0, |relief| relief.height(on_plane));
        on_plane + surface.plane.normal * height
    }

    /// Returns the point of the true surface (with relief) that `eye` sees in the direction of a point of the
    /// plane, all in world coordinates.
    pub fn met(&self, surface: &FillSurface, eye: DVec3, on_plane: DVec3) -> DVec3 {
        let relief = self.relief.of(surface.face);
        relief.map_or(on_plane, |relief| relief.meet(eye, on_plane, surface.plane.normal))
    }
}

/// A filled texel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FilledTexel {
    /// The colour in the photo's own encoding, in the full range of 16 bits.
    pub rgb: [u16; 3],
    /// The confidence in 255ths, 1 at least.
    pub confidence: u8,
    /// The source of the colour.
    pub origin: FillOrigin,
}

/// A filled region.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FilledRegion {
    /// The pixels that were filled.
    pub region: Region,
    /// One texel per pixel, in the order of the region's spans.
    pub texels: Vec<FilledTexel>,
}

/// The filling of a photo.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PhotoFilling {
    /// The filled regions of surfaces, in the order in which they were given.
    pub regions: Vec<FilledRegion>,
    /// The filled part of the surroundings, which no figure of surfaces counts.
    pub surroundings: Option<FilledRegion>,
    /// The mattes of the image layers of see-through surfaces.
    pub mattes: Vec<LayerMatte>,
}

impl PhotoFilling {
    /// Returns the number of texels of surfaces that are this photo's own, the filled one: it shows them through see-through
    /// surfaces.
    pub fn own_texels(&self, photo: PhotoId) -> u64 {
        let texels = self.regions.iter().flat_map(|filled| &filled.texels);
        texels.filter(|texel| texel.origin == FillOrigin::Photo(photo)).count() as u64
    }

    /// Returns the number of filled texels, with those of the surroundings.
    pub fn texels(&self) -> u64 {
        let regions = self.regions.iter().chain(&self.surroundings);
        regions.map(|filled| filled.texels.len() as u64).sum()
    }
}

/// The largest number of donors for one photo; more contribute hardly anything. Fewer are used when photos
/// are too large for memory.
pub const MOST_DONORS: usize = 24;

/// The texels of a filling that are as they were, by surface, in the order of the spans of its region.
pub type KeptTexels = BTreeMap<FillSurfaceId, Vec<FilledTexel>>;

/// Fills the occluded regions of a photo; those of surfaces in `kept` get the texels that are there. Plates that are
/// needed are made and cached for the next photo.
///
/// # Errors
/// [`Error::Request`] when the photo itself cannot be read, [`Error::Cancelled`].
pub fn fill_photo(
    context: &FillContext,
    photo: PhotoId,
    regions: Vec<Region>,
    kept: KeptTexels,
    plates: &mut RectifiedTextures,
    task: &Task,
) -> Result<PhotoFilling> {
    let own = context.source.own(photo)?;
    let own = own.ok_or_else(|| Error::Request("the photo cannot be read, so it cannot be filled".into()))?;
    let is_kept = |region: &Region| kept.contains_key(&region.surface);
    let donors = match regions.iter().all(is_kept) {
        true => Vec::new(),
        false => context.donors(&nearest_donors(context, photo, &regions))?,
    };
    let job = Asking { context, photo, own: &own, donors: &donors };
    let (as_it_was, regions): (Vec<Region>, Vec<Region>) =
        regions.into_iter().filter(|region| job.side(region).is_some()).partition(is_kept);
    let given = |query: &Query, px: DVec2| query.given(px, 0);
    let from_photos = task.timed("from photos", || job.ask(&regions, &given, task))?;
    let lacking = regions.iter().zip(&from_photos).filter(|(_, texels)| texels.iter().any(Option::is_none));
    // A billboard stands for foliage, so an image in its plane would be meaningless.
    let flat = lacking.filter(|(region, _)| !context.surfaces.get(region.surface).billboard);
    let sides: Vec<SurfaceSide> = flat.filter_map(|(region, _)| job.side(region)).collect();
    task.timed("invent", || plates.make(context, sides, task))?;
    let finish = |(region, given): (Region, Vec<Option<DonatedColour>>)| {
        task.check_cancelled()?;
        Ok(job.finish(region, &given, plates))
    };
    let regions: Vec<_> = regions.into_iter().zip(from_photos).collect();
    let mut regions: Vec<FilledRegion> =
        task.timed("seams", || regions.into_par_iter().map(finish).collect::<Result<_>>())?;
    let mut kept = kept;
    let taken = |region: Region| Some(FilledRegion { texels: kept.remove(&region.surface)?, region });
    regions.extend(as_it_was.into_iter().filter_map(taken));
    regions.sort_by_key(|filled| filled.region.surface);
    Ok(PhotoFilling { regions, ..PhotoFilling::default() })
}

/// Returns the photos that have most of the occluded texels' faces in their working sets, rising; photos with
/// paint on these faces are preferred.
pub(super) fn nearest_donors(context: &FillContext, photo: PhotoId, regions: &[Region]) -> Vec<PhotoId> {
    let mut order = donors_by_rank(context, photo, regions);
    order.truncate(most_donors(context));
    order.sort_unstable();
    order
}

/// Returns whether paint decides which photos give colours to a photo, because there are more than are used.
pub fn paint_chooses_donors(context: &FillContext, photo: PhotoId, regions: &[Region]) -> bool {
    donors_by_rank(context, photo, regions).len() > most_donors(context)
}

/// Returns the photos whose pixels may reach these regions of a photo, rising, whichever of the regions are kept from an earlier
/// filling: its donors, those of which its surfaces are synthesised, and the photo itself.
pub fn photos_asked(context: &FillContext, photo: PhotoId, regions: &[Region]) -> Vec<PhotoId> {
    let surfaces: BTreeSet<FillSurfaceId> = regions.iter().map(|region| region.surface).collect();
    let surfaces = surfaces.into_iter().map(|surface| context.surfaces.get(surface));
    let flat: Vec<&FillSurface> = surfaces.filter(|surface| !surface.billboard).collect();
    let mut asked: Vec<PhotoId> =
        flat.into_par_iter().flat_map_iter(|surface| photos_of_plate(context, surface)).collect();
    asked.extend(nearest_donors(context, photo, regions));
    asked.push(photo);
    asked.sort_unstable();
    asked.dedup();
    asked
}

fn most_donors(context: &FillContext) -> usize {
    MOST_DONORS.min(context.source.at_once())
}

/// Returns the photos that may give colours to a photo, best first.
fn donors_by_rank(context: &FillContext, photo: PhotoId, regions: &[Region]) -> Vec<PhotoId> {
    let mut shared = vec![(false, 0usize); context.photos.len()];
    for region in regions {
        let face = context.surfaces.get(region.surface).face;
        for other in &context.serving[face.0 as usize] {
            shared[other.0 as usize].1 += region.texels();
        }
        for painter in &context.painters[face.0 as usize] {
            shared[painter.0 as usize].0 = true;
        }
    }
    shared[photo.index()] = (false, 0);
    let mut order: Vec<usize> = (0..shared.len()).filter(|i| shared[*i].1 > 0).collect();
    order.sort_by_key(|i| (std::cmp::Reverse(shared[*i]), *i));
    order.into_iter().map(PhotoId::new).collect()
}

impl Asking<'_> {
    /// Synthesises the texels that no donor has, and closes the seam.
    fn finish(
        &self,
        region: Region,
        from_photos: &[Option<DonatedColour>],
        plates: &RectifiedTextures,
    ) -> FilledRegion {
        let side = self.side(&region).expect("regions that the photo does not see were left out");
        let item = self.own.item(region.surface).expect("it has a side, so it is seen");
        // A plate that was made for another photo alone must not change anything here: then the order would matter.
        let lacking = from_photos.iter().any(Option::is_none);
        let plate = plates.get(side).filter(|_| lacking).map(Arc::as_ref);
        let cells = RegionCells::around(&region, self.frame());
        let seam = seam(&cells, &self.all_differences(&region, item, &cells, plate, &|_| false));
        let remnant = (plate.is_none() && lacking).then(|| LastResort::new(self.own, item, &region, &cells));
        let mut texels = Vec::with_capacity(region.texels());
        for hidden in &region.spans {
            let y = hidden.span.y;
            for (x, at) in (hidden.span.x0..hidden.span.x1).zip(hidden.first as usize..) {
                let gains = self.factor(centre(x, y));
                let factor = || seam.as_ref().map_or([0.0; 3], |seam| seam.at(x, y)).map(f32::exp);
                let (colour, factor, confidence, origin) = match (from_photos[at], plate, &remnant) {
                    (Some(given), _, _) => (given.colour, factor(), given.confidence, given.origin()),
                    (None, Some(plate), _) => {
                        let point = self.met(&region, centre(x, y));
                        (plate.colour(point), factor(), confidence_of(plate.origin), plate.origin)
                    }
                    (None, None, remnant) => {
                        let colour = remnant.as_ref().expect("made where it is asked for").colour(x, y);
                        let origin = FillOrigin::Diffused;
                        (colour, gains.map(f32::recip), confidence_of(origin), origin)
                    }
                };
                let rgb = self.stored([0, 1, 2].map(|c| colour[c] * factor[c] * gains[c]));
                texels.push(FilledTexel { rgb, confidence: in_255ths(confidence), origin });
            }
        }
        FilledRegion { region, texels }
    }
}

/// Converts a confidence to 255ths; it is 1 at least, because 0 stands for an empty texel.
pub(super) fn in_255ths(confidence: f32) -> u8 {
    (confidence * 255.0).round().clamp(1.0, 255.0) as u8
}

fn confidence_of(invented: FillOrigin) -> f32 {
    if invented == FillOrigin::Exemplar { INVENTED_CONFIDENCE } else { DIFFUSED_CONFIDENCE }
}
