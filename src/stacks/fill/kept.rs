//! What a filling may keep when paint has changed: the texels of all surfaces that the change does not concern are
//! taken from the present files, and the result is what a complete filling would write.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use super::inputs::PaintAround;
use super::paint::SitePaint;
use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::{PhotoId, Site};
use quadratura_document::stack::{FillBasis, FilledPaint, ImageLayer, LayerFill, SurfaceName, origins};
use quadratura_document::{Project, Stack};
use quadratura_io::layer_reader::{read_grey, read_layer_16};
use quadratura_layers::LayerIndex;
use quadratura_layers::fill::near::surfaces_near;
use quadratura_layers::fill::{
    FillContext, FillOrigin, FillSurfaceId, FillSurfaces, FilledTexel, KeptTexels, Region,
    paint_chooses_donors,
};
use quadratura_projection::Projector;

/// The paint that changed between two fillings.
pub(super) struct PaintChange<'a> {
    /// The entries that only one of the two has.
    pub entries: Vec<&'a FilledPaint>,
    /// Whether other surfaces of some photo have paint than before.
    other_surfaces: bool,
}

impl<'a> PaintChange<'a> {
    /// Compares the paint that two fillings are made from.
    pub fn between(before: &'a [FilledPaint], now: &'a [FilledPaint]) -> Self {
        let gone = before.iter().filter(|entry| !now.contains(entry));
        let entries = gone.chain(now.iter().filter(|entry| !before.contains(entry))).collect();
        let painted = [before, now].map(painted_surfaces);
        Self { entries, other_surfaces: painted[0] != painted[1] }
    }

    /// Returns the changed rectangles of each photo, by its name.
    fn rects(&self) -> BTreeMap<&'a str, BTreeSet<[i64; 4]>> {
        let mut rects: BTreeMap<&str, BTreeSet<[i64; 4]>> = BTreeMap::new();
        for entry in &self.entries {
            rects.entry(entry.photo.as_str()).or_default().insert(entry.rect.into());
        }
        rects
    }
}

/// Returns the surfaces of each photo with paint that other photos see.
fn painted_surfaces(paint: &[FilledPaint]) -> BTreeSet<(&str, &SurfaceName)> {
    paint
        .iter()
        .filter(|entry| !entry.only_here)
        .flat_map(|entry| entry.surfaces.iter().map(|surface| (entry.photo.as_str(), surface)))
        .collect()
}

/// Finds out what fillings may keep. What several photos share is computed once.
pub(super) struct FillReuse<'a> {
    project: &'a Project,
    site: &'a Site,
    surfaces: &'a FillSurfaces,
    paint: &'a SitePaint<'a>,
    basis: FillBasis,
    /// The paint on the surroundings, as the filling of each photo depends on it.
    around: &'a PaintAround,
    /// The surfaces near changed pixels, by photo and rectangles.
    near: RefCell<BTreeMap<NearKey, Arc<BTreeSet<FillSurfaceId>>>>,
}

/// A photo's name, and rectangles of it.
type NearKey = (String, BTreeSet<[i64; 4]>);

impl<'a> FillReuse<'a> {
    /// Makes the reuse for fillings that are made from `common` and the present paint.
    pub fn new(
        project: &'a Project,
        site: &'a Site,
        surfaces: &'a FillSurfaces,
        paint: &'a SitePaint<'a>,
        common: String,
        around: &'a PaintAround,
    ) -> Self {
        let basis = FillBasis { common, paint: paint.placed(), ..FillBasis::default() };
        Self { project, site, surfaces, paint, basis, around, near: RefCell::default() }
    }

    /// Returns what a new filling of a stack is made from.
    pub fn basis(&self, stack: &Stack) -> FillBasis {
        FillBasis { around: self.around.of_stack(stack), ..self.basis.clone() }
    }

    /// Returns the texels of the surroundings in a photo's filling in `folder` where a complete filling would make
    /// them again as they are, else `None`.
    ///
    /// # Errors
    /// As [`Self::kept`].
    pub fn kept_surroundings(
        &self,
        stack: &Stack,
        folder: &Path,
        region: &Region,
    ) -> Result<Option<Vec<FilledTexel>>> {
        let basis = stack.fill.as_ref().and_then(|fill| fill.basis.as_ref());
        let is_same = |basis: &FillBasis| {
            basis.common == self.basis.common && basis.around == self.around.of_stack(stack)
        };
        if !basis.is_some_and(is_same) || self.paint.is_damaged() {
            return Ok(None);
        }
        Ok(self.texels(stack, folder, &[region])?.remove(&region.surface))
    }

    /// Returns whether a stack's filling was made from the same stacks and options, whatever the paint.
    pub fn differs_in_paint_alone(&self, stack: &Stack) -> bool {
        let basis = stack.fill.as_ref().and_then(|fill| fill.basis.as_ref());
        basis.is_some_and(|basis| basis.common == self.basis.common)
    }

    /// Returns the texels of a photo's filling in `folder` that a complete filling would make again as they are.
    /// Nothing is kept of a filling that was not made from the same stacks and options.
    ///
    /// # Errors
    /// Returns [`quadratura_base::Error::Input`] and [`quadratura_base::Error::Io`] for the files of the filling.
    pub fn kept(
        &self,
        context: &FillContext,
        photo: PhotoId,
        stack: &Stack,
        folder: &Path,
        regions: &[Region],
    ) -> Result<KeptTexels> {
        let Some(basis) = stack.fill.as_ref().and_then(|fill| fill.basis.as_ref()) else {
            return Ok(KeptTexels::new());
        };
        let change = PaintChange::between(&basis.paint, &self.basis.paint);
        let other_donors = change.other_surfaces && paint_chooses_donors(context, photo, regions);
        if basis.common != self.basis.common || other_donors || self.paint.is_damaged() {
            return Ok(KeptTexels::new());
        }
        let concerned = self.concerned(&change);
        let is_own = change.entries.iter().any(|entry| entry.photo == stack.photo.name);
        let untouched: Vec<&Region> =
            regions.iter().filter(|region| !concerned.contains(&region.surface)).collect();
        let mut kept = self.texels(stack, folder, &untouched)?;
        if is_own {
            // Where nothing else is known, such texels come from any pixels of the photo nearby.
            kept.retain(|_, texels| texels.iter().all(|texel| texel.origin != FillOrigin::Diffused));
        }
        Ok(kept)
    }

    /// Returns the surfaces whose filling changed paint may concern.
    fn concerned(&self, change: &PaintChange) -> BTreeSet<FillSurfaceId> {
        let mut concerned = BTreeSet::new();
        for name in change.entries.iter().flat_map(|entry| &entry.surfaces) {
            // Which photos are asked for a surface depends on who has paint on its face.
            concerned.extend(self.paint.id(name).into_iter().flat_map(|id| self.surfaces.of_same_face(id)));
        }
        for (photo, rects) in change.rects() {
            concerned.extend(self.near(photo, rects).iter());
        }
        concerned
    }

    fn near(&self, photo: &str, rects: BTreeSet<[i64; 4]>) -> Arc<BTreeSet<FillSurfaceId>> {
        let key = (photo.to_owned(), rects);
        if let Some(near) = self.near.borrow().get(&key) {
            return near.clone();
        }
        let (site, tolerance) = (self.site, self.project.options.tolerance);
        let found = site.photo_named(photo).map(|id| {
            let photo = site.photo(id);
            let projector = Projector { name: photo.name.clone(), camera: photo.camera, pose: photo.pose };
            let rects: Vec<PixelRect> = key.1.iter().map(|rect| PixelRect::from(*rect)).collect();
            surfaces_near(&projector, &rects, &site.model, self.surfaces, tolerance)
        });
        let near = Arc::new(found.unwrap_or_default());
        self.near.borrow_mut().insert(key, near.clone());
        near
    }

    /// Reads the texels of regions from the files of the present filling. Regions that are not filled are left out.
    fn texels(&self, stack: &Stack, folder: &Path, regions: &[&Region]) -> Result<KeptTexels> {
        let wanted: BTreeSet<LayerIndex> =
            regions.iter().flat_map(|region| region.spans.iter().map(|span| span.layer)).collect();
        let names = stack.fill.iter().flat_map(|fill| &fill.origins);
        let origins: Vec<Option<FillOrigin>> = names.map(|name| self.origin(name)).collect();
        let read = |layer: LayerIndex| {
            let layer_of_stack = stack.layer(layer);
            let fill = layer_of_stack.fill.as_ref();
            Ok((layer, fill.map(|fill| FilledLayer::read(layer_of_stack, fill, folder)).transpose()?))
        };
        let layers: BTreeMap<LayerIndex, Option<FilledLayer>> =
            wanted.into_par_iter().map(read).collect::<Result<_>>()?;
        let texels = |region: &&Region| {
            let mut texels = Vec::with_capacity(region.texels());
            for hidden in &region.spans {
                let layer = layers[&hidden.layer].as_ref()?;
                for x in hidden.span.x0..hidden.span.x1 {
                    texels.push(layer.texel(x, hidden.span.y, &origins)?);
                }
            }
            Some((region.surface, texels))
        };
        Ok(regions.par_iter().filter_map(texels).collect())
    }

    /// Returns the source of texels with this name; `None` where it is not known.
    fn origin(&self, name: &str) -> Option<FillOrigin> {
        let photo = |name: &str| self.site.photo_named(name);
        match name {
            origins::EXEMPLAR => Some(FillOrigin::Exemplar),
            origins::DIFFUSED => Some(FillOrigin::Diffused),
            origins::NONE | origins::PAINTED => None,
            name => match origins::painter(name) {
                Some(painter) => photo(painter).map(FillOrigin::Painted),
                None => photo(name).map(FillOrigin::Photo),
            },
        }
    }
}

/// The filling of an image layer within its needed rectangle.
struct FilledLayer {
    rect: PixelRect,
    colours: Vec<u16>,
    confidence: Vec<u16>,
    provenance: Vec<u16>,
}

impl FilledLayer {
    fn read(layer: &ImageLayer, fill: &LayerFill, folder: &Path) -> Result<Self> {
        let rect = layer.needed_rect.intersection(&layer.rect);
        Ok(Self {
            rect,
            colours: read_layer_16(&folder.join(&fill.filled_file), layer.rect, rect)?,
            confidence: read_grey(&folder.join(&fill.confidence_file), layer.rect, rect)?,
            provenance: read_grey(&folder.join(&fill.provenance_file), layer.rect, rect)?,
        })
    }

    /// Returns a texel; `None` where it is not filled, or its source is not known.
    fn texel(&self, x: u32, y: u32, origins: &[Option<FillOrigin>]) -> Option<FilledTexel> {
        let at = self.rect.index(x as i32, y as i32)?;
        let origin = (*origins.get(usize::from(self.provenance[at]))?)?;
        let rgb = [0, 1, 2].map(|c| self.colours[4 * at + c]);
        let confidence = u8::try_from(self.confidence[at]).ok().filter(|confidence| *confidence > 0)?;
        Some(FilledTexel { rgb, confidence, origin })
    }
}
