//! See-through surfaces of a photo in its filling: which of its texels the mattes concern.

use std::collections::{BTreeMap, BTreeSet};

use super::hidden::PixelsToFill;
use super::mattes::{SeeThroughPiece, SiteMattes};
use quadratura_base::error::Result;
use quadratura_base::scene::{Model, Photo, PhotoId, PhotoPixels};
use quadratura_io::unmasked::read_unmasked;
use quadratura_layers::fill::see_through::{
    MattePixels, MattedRegion, MattesOfSurface, SeeThroughLayer, SeeThroughPhoto, fill_see_through,
};
use quadratura_layers::fill::{Donor, FillContext, FillSurfaceId, FillSurfaces, PhotoFilling, Region};
use quadratura_layers::matte::Matte;

/// The share of a photo's mixed pixels beyond which it is told that they do not give the photo back.
const REPORTED_SHARE: f64 = 0.01;

/// The mattes of all photos by surface.
pub(super) struct SurfaceMattes<'a> {
    of_surface: BTreeMap<FillSurfaceId, MattesOfSurface<'a>>,
    /// The photos whose mattes could not be found.
    failed: &'a BTreeSet<PhotoId>,
}

impl<'a> SurfaceMattes<'a> {
    /// Sorts a site's mattes by the surface that each is of.
    pub fn new(mattes: &'a SiteMattes, model: &Model, surfaces: &FillSurfaces) -> Self {
        let pieces = SeeThroughPiece::of_model(model, surfaces, &[]);
        let named: BTreeMap<&str, FillSurfaceId> =
            pieces.iter().map(|piece| (&piece.name[..], piece.surface)).collect();
        let mut of_surface: BTreeMap<FillSurfaceId, MattesOfSurface> = BTreeMap::new();
        for (photo, of_photo) in mattes.all() {
            for matte in of_photo {
                if let Some(surface) = named.get(&matte.object[..]) {
                    of_surface.entry(*surface).or_default().insert(photo, matte);
                }
            }
        }
        Self { of_surface, failed: mattes.failed() }
    }

    /// Returns whether nothing is see-through.
    pub fn is_empty(&self) -> bool {
        self.of_surface.is_empty() && self.failed.is_empty()
    }

    /// Returns whether a photo's mattes could not be found. Its filling is not up to date then, whatever it was made from.
    pub fn failed(&self, photo: PhotoId) -> bool {
        self.failed.contains(&photo)
    }
}

/// A photo to be filled, and what is hidden in it.
pub(super) struct SeeThroughFilling<'a> {
    id: PhotoId,
    pixels: PhotoPixels,
    mattes: BTreeMap<FillSurfaceId, &'a Matte>,
    layers: Vec<SeeThroughLayer>,
    /// The hidden texels of see-through surfaces.
    regions: Vec<Region>,
}

impl<'a> SeeThroughFilling<'a> {
    /// Takes the see-through surfaces out of what is hidden in a photo; `None` where it has none of them.
    ///
    /// # Errors
    /// Returns the errors of reading the photo.
    pub fn take(
        mattes: &SurfaceMattes<'a>,
        context: &FillContext,
        photo: &Photo,
        id: PhotoId,
        hidden: &mut PixelsToFill,
    ) -> Result<Option<Self>> {
        let layers = std::mem::take(&mut hidden.see_through);
        if context.options.no_mattes {
            return Ok(None);
        }
        let of = |surface: FillSurfaceId| mattes.of_surface.get(&surface);
        let mut own = BTreeMap::new();
        for surface in layers.iter().flat_map(|layer| &layer.surfaces).flatten() {
            if !own.contains_key(surface) {
                own.extend(of(*surface).and_then(|of| of.get(&id)).map(|matte| (*surface, *matte)));
            }
        }
        let in_layers = |region: &Region| {
            region.spans.iter().all(|span| layers.iter().any(|layer| layer.layer == span.layer))
        };
        let sees_through = |region: &Region| in_layers(region) && of(region.surface).is_some();
        let (regions, solid) = std::mem::take(&mut hidden.regions).into_iter().partition(sees_through);
        hidden.regions = solid;
        if layers.is_empty() {
            return Ok(None);
        }
        Ok(Some(Self { id, pixels: read_unmasked(photo)?, mattes: own, layers, regions }))
    }

    /// Returns the surfaces whose texels cannot be kept from an earlier filling, because they are corrected by mattes.
    pub fn corrected<'r>(&self, regions: impl Iterator<Item = &'r Region>) -> Vec<FillSurfaceId> {
        self.as_photo().mixed_surfaces(regions)
    }

    fn as_photo(&self) -> SeeThroughPhoto<'_> {
        SeeThroughPhoto {
            photo: self.id,
            pixels: &self.pixels,
            mattes: self.mattes.clone(),
            layers: self.layers.clone(),
        }
    }

    /// Lets the mattes take effect on the photo's filling. Returns what was counted, and a message where mixtures do not give
    /// the photo back.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`].
    pub fn lay_over(
        self,
        mattes: &SurfaceMattes,
        context: &FillContext,
        own: &Donor,
        filling: &mut PhotoFilling,
    ) -> Result<(MattePixels, Option<String>)> {
        let photo = self.as_photo();
        let hidden: Vec<MattedRegion> =
            fill_see_through(context, self.id, own, self.regions.clone(), &mattes.of_surface)?;
        let counts = photo.lay_over(filling, hidden);
        let MattePixels { mixed, clipped, .. } = counts;
        let share = clipped as f64 / mixed.max(1) as f64;
        let message = (share > REPORTED_SHARE).then(|| {
            format!(
                "at {clipped} of {mixed} pixels that show a see-through surface mixed with what is behind it, the \
                 layers over each other differ from the photo by more than 3 of 255"
            )
        });
        Ok((counts, message))
    }
}
