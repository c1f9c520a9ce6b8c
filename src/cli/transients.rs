//! The hint of `build` and `update` that photos show something large that other photos do not.

use std::path::Path;

use crate::error::{Remedy, Result};
use crate::recipe::masks::suggest::photos_with_large;
use crate::recipe::open::Opened;
use crate::task::Task;

/// Notes which of these photos, which were just built, show something large that other photos do not.
pub fn note_large(project: &Path, opened: &Opened, built: &[String], memory: u64, task: &Task) -> Result<()> {
    let found = photos_with_large(project, opened, built, memory, task)?;
    if found.is_empty() {
        return Ok(());
    }
    let photos = found.iter().map(|(photo, share)| format!("{photo} ({:.1} % of it)", 100.0 * share));
    let photos = photos.collect::<Vec<_>>().join(", ");
    let text = format!("something large is in one photo only, and shows in views from near it: {photos}; ");
    task.note((text, Remedy::SuggestMasks, " outlines it, so that it can be masked"));
    Ok(())
}
