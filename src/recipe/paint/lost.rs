//! Paint that shows nowhere at the moment: told by `build` and `info`, and kept.

use super::PhotoPaint;
use crate::error::Result;
use crate::io::paint_store::PaintStore;
use crate::io::stack_store::StackStore;

/// Paint that has no place in a photo's stack. It is kept, and shows again when its surface comes back.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct LostPaint {
    /// The photo.
    pub photo: String,
    /// `object[index]` of the face that it was painted on.
    pub face: String,
    /// Painted pixels.
    pub pixels: u64,
    /// What is missing.
    pub reason: String,
}

/// What a project has of paint.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize)]
pub struct PaintSurvey {
    /// By photo: name, faces with paint, painted pixels (one that coplanar faces share counts for each).
    pub photos: Vec<(String, usize, u64)>,
    /// What has no place in the stacks of today.
    pub lost: Vec<LostPaint>,
    /// Pictures of paint that are damaged or gone, each with what is lost and what to do.
    pub damaged: Vec<String>,
}

/// Looks at all paint of the project that `store` belongs to, whose photos are called `photos`. Photos without a stack
/// lose nothing yet.
///
/// # Errors
/// When the paint cannot be read.
pub fn survey_paint(store: &StackStore, photos: &[&str]) -> Result<PaintSurvey> {
    let paint = PaintStore::new(store.project());
    let book = paint.read()?;
    let mut names: Vec<&str> = book.entries.iter().map(|entry| entry.photo.as_str()).collect();
    names.dedup();
    let damaged = book.entries.iter().filter_map(|entry| paint.check(entry).err());
    let mut survey =
        PaintSurvey { damaged: damaged.map(|error| error.to_string()).collect(), ..PaintSurvey::default() };
    for name in names {
        let entries = book.of_photo(name);
        let mut faces: Vec<_> = entries.iter().map(|entry| (&entry.object, entry.face)).collect();
        faces.sort();
        faces.dedup();
        survey.photos.push((name.to_owned(), faces.len(), entries.iter().map(|entry| entry.pixels).sum()));
        if !photos.contains(&name) {
            survey.lost.extend(entries.iter().map(|entry| LostPaint {
                photo: name.to_owned(),
                face: entry.face_name(),
                pixels: entry.pixels,
                reason: "the photo is not in the project".into(),
            }));
        // A stack that cannot be read is told elsewhere.
        } else if let Ok(Some(stack)) = store.current(name) {
            survey.lost.extend(PhotoPaint::of(&book, paint.clone(), &stack).lost(&stack)?);
        }
    }
    Ok(survey)
}
