//! The hidden texels of see-through surfaces: from the mattes of other photos.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::{MattedRegion, MattesOfSurface};
use crate::fill::donor::{Donor, Donors};
use crate::fill::photo::in_255ths;
use crate::fill::queries::{Asking, centre};
use crate::fill::ranked_donors::AGREEMENT_ALONE;
use crate::fill::region::Region;
use crate::fill::{FillContext, FillOrigin, FillSurfaceId, FilledRegion, FilledTexel, MOST_CONFIDENCE};
use crate::matte::Matte;
use quadratura_base::error::Result;
use quadratura_base::scene::PhotoId;
use quadratura_base::scene::light::linear_of_srgb;
use quadratura_view::optics::squared_radius;

/// Takes the hidden texels of see-through surfaces from the mattes of other photos, each from the photo that sees it from
/// the most similar direction. `mattes` are those of the surfaces of these regions.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn fill_see_through(
    context: &FillContext,
    photo: PhotoId,
    own: &Donor,
    regions: Vec<Region>,
    mattes: &BTreeMap<FillSurfaceId, MattesOfSurface>,
) -> Result<Vec<MattedRegion>> {
    let mut filled = Vec::with_capacity(regions.len());
    for region in regions {
        let none = MattesOfSurface::new();
        let mattes = mattes.get(&region.surface).unwrap_or(&none);
        let others: Vec<PhotoId> = mattes.keys().copied().filter(|other| *other != photo).collect();
        let donors = donors_of(context.source, &others)?;
        let asking = Asking { context, photo, own, donors: &donors };
        filled.push(asking.see_through(region, mattes));
    }
    Ok(filled)
}

fn donors_of(source: &dyn Donors, photos: &[PhotoId]) -> Result<Vec<(PhotoId, Arc<Donor>)>> {
    let donor = |photo: &PhotoId| Ok(source.donor(*photo)?.map(|donor| (*photo, donor)));
    photos.iter().filter_map(|photo| donor(photo).transpose()).collect()
}

impl Asking<'_> {
    fn see_through(&self, region: Region, mattes: &MattesOfSurface) -> MattedRegion {
        let unknown = FilledTexel { rgb: [0; 3], confidence: 0, origin: FillOrigin::Photo(self.photo) };
        let mut texels = vec![unknown; region.texels()];
        let mut found = vec![0; region.texels()];
        let donors = self.by_direction(&region, mattes);
        for ((texel, matte), (x, y)) in texels.iter_mut().zip(&mut found).zip(region.pixels()) {
            let at = centre(x, y);
            let point = self.met(&region, at);
            let Some((colour, alpha, origin)) = donors.iter().find_map(|donor| donor.at(point)) else {
                continue;
            };
            let factor = self.factor(at);
            let rgb = self.stored([0, 1, 2].map(|c| colour[c] * factor[c]));
            *texel = FilledTexel { rgb, confidence: in_255ths(MOST_CONFIDENCE * AGREEMENT_ALONE), origin };
            *matte = alpha;
        }
        MattedRegion { filled: FilledRegion { region, texels }, mattes: found }
    }

    /// Returns the donors with a matte of the region's surface that see it from the same side, by the angle from the photo's
    /// own direction.
    fn by_direction<'a>(&'a self, region: &Region, mattes: &'a MattesOfSurface) -> Vec<MatteDonor<'a>> {
        let Some(own) = self.own.item(region.surface) else { return Vec::new() };
        let rect = region.rect();
        let middle = DVec2::new(f64::from(rect.x), f64::from(rect.y))
            + DVec2::new(f64::from(rect.w), f64::from(rect.h)) / 2.0;
        let point = self.met(region, middle);
        let from = |donor: &Donor, item: u32| (donor.seen_from(item, point) - point).normalize_or_zero();
        let here = from(self.own, own);
        let donor = |(photo, donor): &'a (PhotoId, Arc<Donor>)| {
            let item = donor.item(region.surface)?;
            let along = from(donor, item).dot(here);
            let matte = *mattes.get(photo)?;
            (along > 0.0).then_some((along, MatteDonor { asking: self, photo: *photo, donor, item, matte }))
        };
        let mut donors: Vec<_> = self.donors.iter().filter_map(donor).collect();
        donors.sort_by(|a, b| b.0.total_cmp(&a.0));
        donors.into_iter().map(|(_, donor)| donor).collect()
    }
}

/// A photo that knows the matte of a surface.
struct MatteDonor<'a> {
    asking: &'a Asking<'a>,
    photo: PhotoId,
    donor: &'a Donor,
    item: u32,
    matte: &'a Matte,
}

impl MatteDonor<'_> {
    /// Returns the colour at a point (linear light in the common exposure), the matte, and where they come from; `None`
    /// where the photo does not show the point, or nobody knows whether it does.
    fn at(&self, point: DVec3) -> Option<([f32; 3], u8, FillOrigin)> {
        let Self { donor, item, .. } = *self;
        let px = donor.camera.image_from_camera(donor.pose_on(item).camera_from_world(point))?;
        let (light, alpha) = sampled(self.matte, px)?;
        let gains = self.asking.context.gains;
        let optics = &gains.optics[self.photo.index()];
        let seen = optics.undone(light, squared_radius(&donor.camera, px));
        let colour = [0, 1, 2].map(|c| (seen[c] * (-gains.of_photo[self.photo.index()][c]).exp()) as f32);
        Some((colour, (alpha * 255.0).round() as u8, FillOrigin::Photo(self.photo)))
    }
}

/// Interpolates a matte and its colour (linear light, weighted by the matte) at a position in photo pixels.
fn sampled(matte: &Matte, px: DVec2) -> Option<([f64; 3], f64)> {
    let low = (px - 0.5).floor();
    let share = px - 0.5 - low;
    let (mut light, mut alpha, mut weight) = ([0.0; 3], 0.0, 0.0);
    let mut nearest = None;
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let at = (low.x as i32 + dx, low.y as i32 + dy);
        let Some((&[r, g, b, a], known)) = matte.texels.get(at.0, at.1).zip(matte.known.get(at.0, at.1))
        else {
            continue;
        };
        if !known.is_known() {
            continue;
        }
        let across = if dx == 1 { share.x } else { 1.0 - share.x };
        let down = if dy == 1 { share.y } else { 1.0 - share.y };
        let here = across * down;
        let linear = [r, g, b].map(|value| linear_of_srgb(f64::from(value) / 255.0));
        let covered = here * f64::from(a) / 255.0;
        (0..3).for_each(|c| light[c] += covered * linear[c]);
        (alpha, weight) = (alpha + covered, weight + here);
        nearest = nearest.filter(|(most, _)| *most >= here).or(Some((here, linear)));
    }
    let (_, nearest) = nearest?;
    let light = if alpha > 1e-6 { light.map(|sum| sum / alpha) } else { nearest };
    (weight > 0.5).then(|| (light, alpha / weight))
}
