//! The stacks that a preview shows.

use rayon::prelude::*;

use super::PreviewOptions;
use quadratura_base::error::{Error, Message, Remedy, Result};
use quadratura_base::scene::Site;
use quadratura_base::task::Task;
use quadratura_document::{Project, Stack};
use quadratura_io::stack_store::StackStore;
use quadratura_stacks::survey::{StackState, Survey};

/// The stacks that a preview shows.
#[derive(Debug, Clone)]
pub struct ReadStacks {
    /// The photos' stacks, in the site's order.
    pub stacks: Vec<Option<Stack>>,
    /// Messages about unreadable ones.
    pub problems: Vec<Message>,
}

/// Reads the photos' stacks.
pub fn stacks(
    project: &Project,
    site: &Site,
    store: &StackStore,
    options: &PreviewOptions,
    task: &Task,
) -> Result<ReadStacks> {
    let survey = Survey::new(project, site, store);
    let mut stacks = Vec::with_capacity(site.photos.len());
    let mut missing = Vec::new();
    let mut stale = Vec::new();
    let mut broken = Vec::new();
    let states: Vec<StackState> =
        site.photos.par_iter().map(|photo| survey.state(photo)).collect::<Result<_>>()?;
    for (photo, state) in site.photos.iter().zip(states) {
        stacks.push(match state {
            StackState::Current(stack) => Some(stack),
            StackState::Stale(stack) => {
                stale.push(photo.name.as_str());
                Some(stack)
            }
            StackState::Missing => {
                missing.push(photo.name.as_str());
                None
            }
            StackState::Broken(error) => {
                let photo = format!("{}: its stack is not used: ", photo.name);
                broken.push(Message::from(photo).and(error.message()));
                None
            }
        });
    }
    if stacks.iter().all(Option::is_none) {
        if !broken.is_empty() {
            return Err(Error::Missing(Message::join(broken, "\n")));
        }
        return Err(Error::missing(("no photo has a stack yet; ", Remedy::Build, " builds them")));
    }
    if options.without_stack_notes {
        return Ok(ReadStacks { stacks, problems: broken });
    }
    if !missing.is_empty() {
        let missing = missing.join(", ");
        let found = format!("these photos have no stack and are not used: {missing}; ");
        task.note((found, Remedy::Build, " builds them"));
    }
    if !stale.is_empty() {
        let stale = stale.join(", ");
        let found = format!("the stacks of these photos are out of date: {stale}; ");
        task.note((found, Remedy::Build, " updates them"));
    }
    Ok(ReadStacks { stacks, problems: broken })
}
