//! The state of the work on a project, as any machine sees it: what is done, what is worked on and where, what failed and why.

use std::collections::BTreeMap;
use std::path::Path;

use quadratura_base::error::Result;
use quadratura_base::scene::Site;
use quadratura_base::task::Task;
use quadratura_document::{Project, Stack};
use quadratura_files::lease::Holder;
use quadratura_files::lock::ProjectLock;
use quadratura_io::failures::{Failure, failures};
use quadratura_io::photo_lock::works;
use quadratura_io::stack_store::StackStore;

use crate::fill::{FillInputs, FillState};
use crate::survey::{StackState, Survey};

/// The state of the work on one photo.
#[derive(Debug)]
pub struct PhotoStatus {
    /// The photo's name.
    pub photo: String,
    /// Its stack, in a word.
    pub stack: &'static str,
    /// The filling of its stack, in a word.
    pub filling: &'static str,
    /// Who works on it now.
    pub worker: Option<Holder>,
    /// Why it failed last, where it was not made since.
    pub failure: Option<Failure>,
}

impl PhotoStatus {
    /// Returns whether nothing is left to do.
    pub fn is_done(&self) -> bool {
        self.stack == CURRENT && self.filling == FillState::Current.word()
    }
}

/// The state of the work on a project.
#[derive(Debug)]
pub struct ProjectStatus {
    /// The photos, in the site's order.
    pub photos: Vec<PhotoStatus>,
    /// Who makes the estimates that all photos share.
    pub estimates: Option<Holder>,
    /// Who writes what is authored: a window, or a command.
    pub author: Option<Holder>,
}

const CURRENT: &str = "current";

/// Returns the state of the work on the project in `folder`. Nothing is locked or changed.
///
/// # Errors
/// An error when the paint book cannot be read; [`quadratura_base::Error::Cancelled`].
pub fn status(folder: &Path, project: &Project, site: &Site, task: &Task) -> Result<ProjectStatus> {
    let store = StackStore::new(folder);
    let survey = Survey::new(project, site, &store);
    let mut states = Vec::with_capacity(site.photos.len());
    for (photo, done) in site.photos.iter().zip(0..) {
        task.step("check stacks", done, site.photos.len() as u64)?;
        states.push(survey.state(photo)?);
    }
    let stacks: Vec<Option<&Stack>> = states.iter().map(StackState::stack).collect();
    let inputs = FillInputs::new(folder, project, site, &stacks, &project.fill)?;
    let mut workers = BTreeMap::new();
    let mut estimates = None;
    for work in works(folder) {
        match work.photo {
            Some(photo) => drop(workers.insert(photo, work.holder)),
            None => estimates = Some(work.holder),
        }
    }
    let mut failed: BTreeMap<String, Failure> = failures(folder).into_iter().collect();
    let photos = site.photos.iter().zip(&states).map(|(photo, state)| PhotoStatus {
        photo: photo.name.clone(),
        stack: state.word(),
        filling: match state {
            StackState::Current(stack) => FillState::new(stack, &inputs).word(),
            state => state.stack().map_or(FillState::Missing, |_| FillState::Stale).word(),
        },
        worker: workers.remove(&photo.name),
        failure: failed.remove(&photo.name),
    });
    Ok(ProjectStatus { photos: photos.collect(), estimates, author: ProjectLock::holder_of(folder) })
}
