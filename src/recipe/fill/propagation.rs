//! Propagation of paint from single photos to the others: which photos have paint, which of it is propagated, and
//! where it conflicts.

use std::collections::BTreeMap;
use std::path::Path;

use crate::document::Stack;
use crate::document::stack::PropagationEntry;
use crate::error::Result;
use crate::io::paint_store::PaintStore;
use crate::layers::fill::FillOptions;
use crate::scene::PhotoId;

/// The pattern for all photos in [`FillOptions::propagate`].
const ALL: &str = "*";

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
    let propagate = if on { vec![ALL.to_owned()] } else { Vec::new() };
    FillOptions { propagate, ..options.clone() }
}

/// Returns the options with the paint of one photo propagated or not; `all` are the photos with paint.
pub fn with_one(options: &FillOptions, photo: &str, on: bool, all: &[PaintedPhoto]) -> FillOptions {
    let names = all.iter().map(|painter| painter.photo.as_str());
    let wanted = |name: &&str| if *name == photo { on } else { options.propagates(name) };
    let wanted: Vec<String> = names.filter(wanted).map(str::to_owned).collect();
    match wanted.len() == all.len() {
        true => with_all(options, true),
        false => FillOptions { propagate: wanted, ..options.clone() },
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

    fn all() -> Vec<PaintedPhoto> {
        ["a.jpg", "b.jpg", "c.jpg"].map(|photo| PaintedPhoto { photo: photo.into(), pixels: 9 }).to_vec()
    }

    #[test]
    fn single_photos_are_taken_out_of_all_and_put_back() {
        let everyone = with_all(&FillOptions::default(), true);
        let some = with_one(&everyone, "b.jpg", false, &all());
        assert_eq!(some.propagate, ["a.jpg", "c.jpg"]);
        assert_eq!(with_one(&some, "b.jpg", true, &all()), everyone);
        let none = with_one(&with_one(&some, "a.jpg", false, &all()), "c.jpg", false, &all());
        assert_eq!(none, with_all(&everyone, false));
        assert!(none.propagate.is_empty());
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
