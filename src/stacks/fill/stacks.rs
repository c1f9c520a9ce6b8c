//! The stacks that are filled, why there is none, and those that are replaced.

use std::path::Path;

use super::request::{FillRequest, FilledPhoto};
use crate::survey::{StackState, Survey};
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::scene::{Photo, Site};
use quadratura_document::{Project, Stack};
use quadratura_io::stack_store::StackStore;

/// Returns the states of all photos' stacks.
pub(super) fn states(project: &Project, site: &Site, store: &StackStore) -> Result<Vec<StackState>> {
    let survey = Survey::new(project, site, store);
    site.photos.iter().map(|photo| survey.state(photo)).collect()
}

/// Returns an up-to-date stack, or the reason why there is none.
pub(super) fn current<'a>(photo: &Photo, state: &'a StackState) -> Result<&'a Stack> {
    match state {
        StackState::Current(stack) => Ok(stack),
        StackState::Stale(_) => {
            Err(Error::missing(("its stack is out of date; run ", Remedy::Build, ", then fill again")))
        }
        StackState::Missing => {
            Err(Error::missing((format!("{} has no stack yet; ", photo.name), Remedy::Build, " builds it")))
        }
        StackState::Broken(error) => Err(Error::Missing(error.message())),
    }
}

/// Removes the stacks that were replaced, unless the request keeps them. They stay until here, because photos that are filled
/// later read layers of those that were filled before.
pub(super) fn without_former(
    folder: &Path,
    request: &FillRequest,
    mut filled: Vec<FilledPhoto>,
) -> Result<Vec<FilledPhoto>> {
    let store = StackStore::new(folder);
    for photo in filled.iter_mut().filter(|_| !request.keep_former) {
        photo.kept.extend(store.clear_former_of(&photo.photo)?);
    }
    Ok(filled)
}
