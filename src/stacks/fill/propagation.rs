//! Propagation of paint from single photos to the others: which photos have paint, which of it is propagated, and
//! where it conflicts.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use serde::Serialize;

use super::FillJob;
use super::projected::PaintProjection;
use quadratura_base::error::Result;
use quadratura_base::scene::{Photo, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::paint::PaintBook;
use quadratura_document::stack::PropagationEntry;
use quadratura_document::{Project, Stack};
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_store::StackStore;
use quadratura_layers::fill::{FillContext, FillOptions, Propagation, PropagationStatistics};

/// A photo with paint.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PaintedPhoto {
    /// The photo's name.
    pub photo: String,
    /// The number of painted pixels.
    pub pixels: u64,
}

/// Returns the photos with paint, by name.
///
/// # Errors
/// Returns an error when the paint book cannot be read.
pub fn painters(project: &Path) -> Result<Vec<PaintedPhoto>> {
    let mut pixels: BTreeMap<String, u64> = BTreeMap::new();
    for entry in PaintStore::new(project).read()?.entries {
        *pixels.entry(entry.photo).or_default() += entry.pixels;
    }
    let painted = pixels.into_iter().filter(|(_, pixels)| *pixels > 0);
    Ok(painted.map(|(photo, pixels)| PaintedPhoto { photo, pixels }).collect())
}

/// Returns a copy of `options` in which the paint of all photos is propagated where `on` is true, and of none
/// otherwise.
pub fn with_all(options: &FillOptions, on: bool) -> FillOptions {
    let propagate = if on { Propagation::all() } else { Propagation::None };
    FillOptions { propagate, ..options.clone() }
}

impl FillJob<'_> {
    /// Returns the other photos whose paint is propagated to this one.
    pub(super) fn painters(&self, context: &FillContext, own: PhotoId) -> Vec<PhotoId> {
        if !self.request.options.propagates_to(&self.site.photo(own).name) {
            return Vec::new();
        }
        let mut painters: Vec<PhotoId> = context.painters.iter().flatten().copied().collect();
        painters.sort_unstable();
        painters.dedup();
        let name = |photo: PhotoId| &self.site.photo(photo).name;
        painters.retain(|photo| *photo != own && self.request.options.propagates(name(*photo)));
        painters
    }
}

/// Paint that is propagated to a photo.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PropagationToPhoto {
    /// The index of the photo in the site.
    pub photo: PhotoId,
    /// The paint, with its conflicts.
    pub paint: PropagationEntry,
}

impl PropagationToPhoto {
    /// Returns the number of texels where other paint clearly differs.
    pub fn disputed(&self) -> u64 {
        self.paint.conflicts + self.paint.dissents
    }
}

/// Converts offers to entries of the document; the triangles of a non-planar face are combined.
pub(super) fn propagation_entries(
    site: &Site,
    context: &FillContext,
    offers: &[PropagationStatistics],
) -> Vec<PropagationEntry> {
    let mut by_face: BTreeMap<(String, &str), PropagationStatistics> = BTreeMap::new();
    for offer in offers {
        let face = site.model.face_name(context.surfaces.get(offer.surface).face);
        let from = context.photos[offer.from.index()].name.as_str();
        let sum = by_face.entry((face, from)).or_insert(PropagationStatistics {
            texels: 0,
            own: 0,
            conflicts: 0,
            dissents: 0,
            coarse: 0,
            ..*offer
        });
        sum.texels += offer.texels;
        sum.own += offer.own;
        sum.conflicts += offer.conflicts;
        sum.dissents += offer.dissents;
        sum.coarse += offer.coarse;
    }
    let entry = |((face, from), offer): ((String, &str), PropagationStatistics)| {
        let PropagationStatistics { texels, own, conflicts, dissents, coarse, .. } = offer;
        PropagationEntry { face, from: from.to_owned(), texels, own, conflicts, dissents, coarse }
    };
    by_face.into_iter().map(entry).collect()
}

/// Paint that is too coarse to replace what a photo shows: there the photo keeps its pixels, and views blend both.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct CoarsePaint {
    /// The photo that keeps its pixels.
    pub photo: String,
    /// The face, as `object[index]`.
    pub face: String,
    /// The photo that was painted on.
    pub from: String,
    /// The number of pixels that the photo keeps.
    pub pixels: u64,
}

impl CoarsePaint {
    /// Returns the coarse paint among what was propagated to photos, the most pixels first; ties stay in their order.
    pub fn among<'a>(propagated: impl IntoIterator<Item = (&'a str, &'a PropagationEntry)>) -> Vec<Self> {
        let is_coarse = |(_, paint): &(&str, &PropagationEntry)| paint.coarse > 0;
        let mut coarse: Vec<Self> = propagated
            .into_iter()
            .filter(is_coarse)
            .map(|(photo, paint)| Self {
                photo: photo.to_owned(),
                face: paint.face.clone(),
                from: paint.from.clone(),
                pixels: paint.coarse,
            })
            .collect();
        coarse.sort_by_key(|paint| std::cmp::Reverse(paint.pixels));
        coarse
    }
}

/// Returns the coarse paint among that in `book` which the fillings do not contain yet, from paint, geometry and stacks
/// alone: no photo is decoded, and faces are taken to be flat, so that numbers of pixels are approximate. Photos without
/// a readable stack are left out.
///
/// # Errors
/// Returns [`quadratura_base::Error::Input`] and [`quadratura_base::Error::Io`] for files of stacks and paint, or
/// [`quadratura_base::Error::Cancelled`].
pub fn coarse_paint(
    folder: &Path,
    project: &Project,
    site: &Site,
    book: &PaintBook,
    task: &Task,
) -> Result<Vec<CoarsePaint>> {
    let store = StackStore::new(folder);
    let stack = |photo: &Photo| store.current(&photo.name).ok().flatten().map(Arc::new);
    let stacks: Vec<Option<Arc<Stack>>> = site.photos.iter().map(stack).collect();
    let counted = PaintProjection::flat(folder, project, site, &stacks).count(book, task)?;
    let named = counted.iter().map(|to| (site.photo(to.photo).name.as_str(), &to.paint));
    Ok(CoarsePaint::among(named))
}

/// Returns the paint that was propagated to each photo when it was filled; `stacks` are in the site's order.
pub fn laid_over(stacks: &[Option<&Stack>]) -> Vec<PropagationToPhoto> {
    let fills = PhotoId::all(stacks.len())
        .zip(stacks)
        .filter_map(|(photo, stack)| Some((photo, stack.as_ref()?.fill.as_ref()?)));
    let laid =
        fills.flat_map(|(photo, fill)| fill.propagated.iter().map(move |paint| (photo, paint.clone())));
    most_disputed_first(laid.map(|(photo, paint)| PropagationToPhoto { photo, paint }).collect())
}

/// Sorts by the number of conflicting texels, then of propagated texels, both descending; ties by photo, face and
/// painter.
pub fn most_disputed_first(mut entries: Vec<PropagationToPhoto>) -> Vec<PropagationToPhoto> {
    entries.sort_by(|a, b| {
        let rank =
            |it: &PropagationToPhoto| (std::cmp::Reverse(it.disputed()), std::cmp::Reverse(it.paint.texels));
        rank(a).cmp(&rank(b)).then_with(|| (a.photo, &a.paint).cmp(&(b.photo, &b.paint)))
    });
    entries
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_photo_that_keeps_most_pixels_comes_first_and_fine_paint_is_not_listed() {
        let entry = |face: &str, coarse| PropagationEntry {
            face: face.into(),
            from: "far.jpg".into(),
            texels: 5,
            own: 0,
            conflicts: 0,
            dissents: 0,
            coarse,
        };
        let (fine, few, many) = (entry("roof[0]", 0), entry("wall[0]", 3), entry("wall[1]", 70));
        let coarse = CoarsePaint::among([("a.jpg", &few), ("a.jpg", &fine), ("b.jpg", &many)]);
        let listed: Vec<_> = coarse.iter().map(|c| (&c.photo[..], &c.face[..], c.pixels)).collect();
        assert_eq!(listed, [("b.jpg", "wall[1]", 70), ("a.jpg", "wall[0]", 3)]);
    }

    #[test]
    fn what_contradicts_most_comes_first() {
        let entry = |photo, face: &str, texels, conflicts, dissents| PropagationToPhoto {
            photo,
            paint: PropagationEntry {
                face: face.into(),
                from: "a.jpg".into(),
                texels,
                own: conflicts,
                conflicts,
                dissents,
                coarse: 0,
            },
        };
        let sorted = most_disputed_first(vec![
            entry(PhotoId(1), "wall[0]", 900, 0, 0),
            entry(PhotoId(2), "wall[1]", 10, 3, 0),
            entry(PhotoId(0), "wall[2]", 10, 2, 9),
            entry(PhotoId(1), "door[0]", 900, 0, 0),
        ]);
        let order: Vec<_> = sorted.iter().map(|it| (it.photo.0, it.paint.face.as_str())).collect();
        assert_eq!(order, [(0, "wall[2]"), (2, "wall[1]"), (1, "door[0]"), (1, "wall[0]")]);
    }
}
