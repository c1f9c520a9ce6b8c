//! Propagation of paint from single photos to the others: which photos have paint, which of it is propagated, and
//! where it conflicts.

use std::collections::BTreeMap;
use std::path::Path;

use crate::document::Stack;
use crate::document::stack::PropagationEntry;
use crate::error::Result;
use crate::io::paint_store::PaintStore;
use crate::layers::fill::{FillOptions, Propagation};
use crate::scene::PhotoId;

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
