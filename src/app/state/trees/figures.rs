//! What the plants of species cost and how large they are, found once.

use crate::state::running::{JobId, Running};
use quadratura_document::trees::{TreeSpecies, Trees};
use quadratura_trees::list::SpeciesFigures;

/// The figures of a species, or why its plant cannot be read.
pub type Figures = Result<SpeciesFigures, String>;

/// The figures that are known.
#[derive(Debug, Default)]
pub struct KnownFigures {
    known: Vec<(TreeSpecies, Figures)>,
    /// The job that finds others.
    pub job: Option<JobId>,
}

impl KnownFigures {
    /// Returns the figures of a species, where they are known.
    pub fn of(&self, species: &TreeSpecies) -> Option<&Figures> {
        self.known.iter().find(|(known, _)| known == species).map(|(_, figures)| figures)
    }

    /// Adds figures.
    pub fn add(&mut self, found: Vec<(TreeSpecies, Figures)>) {
        self.known.retain(|(known, _)| found.iter().all(|(species, _)| species != known));
        self.known.extend(found);
    }

    /// Returns the species whose figures are to be found; none while a job finds some.
    pub fn missing(&self, trees: &Trees, running: &Running) -> Vec<TreeSpecies> {
        if self.job.is_some_and(|job| running.is_running(job)) {
            return Vec::new();
        }
        trees.species.values().filter(|species| self.of(species).is_none()).cloned().collect()
    }

    /// Forgets all, because files may have changed.
    pub fn forget(&mut self) {
        self.known.clear();
    }
}
