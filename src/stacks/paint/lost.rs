//! Paint without a place in the present stacks, which `build` and `info` report and which is kept.

use super::PhotoPaint;
use quadratura_base::error::Result;
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_store::StackStore;

/// Paint without a place in a photo's stack. It is kept, and becomes visible again when its surface is back.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct LostPaint {
    /// The photo's name.
    pub photo: String,
    /// The face on which it was painted, as `object[index]`.
    pub face: String,
    /// The number of painted pixels.
    pub pixels: u64,
    /// The reason.
    pub reason: String,
}

/// A survey of a project's paint.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize)]
pub struct PaintSurvey {
    /// For each photo: its name, the number of faces with paint, and the number of painted pixels (those that
    /// coplanar faces share count for each).
    pub photos: Vec<(String, usize, u64)>,
    /// The paint without a place in the present stacks.
    pub lost: Vec<LostPaint>,
    /// Messages about damaged or missing files of paint, each with what is lost and the remedy.
    pub damaged: Vec<String>,
}

/// Surveys all paint of the project that `store` belongs to, whose photos have the names `photos`. Photos without a
/// stack count as having places for all their paint.
///
/// # Errors
/// Returns an error when the paint cannot be read.
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
        // Unreadable stacks are reported elsewhere.
        } else if let Ok(Some(stack)) = store.current(name) {
            survey.lost.extend(PhotoPaint::new(&book, paint.clone(), &stack).lost(&stack)?);
        }
    }
    Ok(survey)
}
