//! The hints of `build` and `update` about what is large and in one photo only.

use std::path::Path;

use quadratura_base::error::{Remedy, Result};
use quadratura_base::scene::Site;
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_stacks::masks::suggest::{LargeFindings, photos_with_large};

/// Notes which of these photos, which have stacks that are up to date, show something large that other photos do not, and over which
/// of them other light lies.
pub fn note_large(
    folder: &Path,
    project: &Project,
    site: &Site,
    photos: &[String],
    memory: u64,
    task: &Task,
) -> Result<()> {
    let LargeFindings { things, light } = photos_with_large(folder, project, site, photos, memory, task)?;
    let listed = |found: &[(String, f64)]| {
        let photos = found.iter().map(|(photo, share)| format!("{photo} ({:.1} % of it)", 100.0 * share));
        photos.collect::<Vec<_>>().join(", ")
    };
    if !things.is_empty() {
        let photos = listed(&things);
        let text =
            format!("something large is in one photo only, and shows in views from near it: {photos}; ");
        task.note((text, Remedy::SuggestMasks, " outlines it, so that it can be masked"));
    }
    if !light.is_empty() {
        task.note(format!(
            "haze, glare or a shadow lies over surfaces in one photo only: {}; there is nothing to mask, and where three others \
             contradict it the photo counts less in views; `quadratura colour --offset on` estimates even haze and removes it, and \
             `quadratura decide --exclude` keeps the photo away from faces that others show better",
            listed(&light)
        ));
    }
    Ok(())
}
