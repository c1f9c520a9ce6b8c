//! Which species have images, from which the 3D view draws them; they are made once.

use crate::state::running::{JobId, Running};
use quadratura_document::trees::{TreeSpecies, Trees};

/// The species whose images were made, or could not be.
#[derive(Debug, Default)]
pub struct MadeImages {
    species: Vec<TreeSpecies>,
    /// Those for which a job was started: when it is stopped, it does not start again by itself.
    tried: Vec<TreeSpecies>,
    /// The job that makes others.
    pub job: Option<JobId>,
}

impl MadeImages {
    /// Returns the species of trees that stand somewhere and have no images yet; none while a job makes some.
    pub fn missing(&self, trees: &Trees, running: &Running) -> Vec<TreeSpecies> {
        if self.job.is_some_and(|job| running.is_running(job)) {
            return Vec::new();
        }
        let placed = |name: &String| trees.placed.iter().any(|tree| tree.species == *name);
        let missing =
            trees.species.iter().filter(|(name, species)| placed(name) && !self.tried.contains(species));
        missing.map(|(_, species)| species.clone()).collect()
    }

    /// Keeps that a job makes images.
    pub fn begin(&mut self, species: &[TreeSpecies], job: JobId) {
        self.tried.extend_from_slice(species);
        self.job = Some(job);
    }

    /// Keeps that images were made.
    pub fn add(&mut self, species: Vec<TreeSpecies>) {
        self.species.extend(species);
    }

    /// Returns for how many species images were made.
    pub fn count(&self) -> usize {
        self.species.len()
    }

    /// Forgets all, because files may have changed.
    pub fn forget(&mut self) {
        self.species.clear();
        self.tried.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_trees::edit::{TreeChange, placed};

    #[test]
    fn images_are_missing_of_placed_species_until_they_are_made() {
        let (mut images, running) = (MadeImages::default(), Running::default());
        assert!(images.missing(&Trees::default(), &running).is_empty());
        let (trees, _) = placed(&Trees::default(), "oak", None, &TreeChange::default()).unwrap();
        let missing = images.missing(&trees, &running);
        assert_eq!(missing.len(), 1);
        images.tried.clone_from(&missing);
        assert!(
            images.missing(&trees, &running).is_empty() && images.count() == 0,
            "a stopped job is no other one"
        );
        images.add(missing);
        assert_eq!(images.count(), 1);
        let (both, _) = placed(&trees, "maple", None, &TreeChange::default()).unwrap();
        assert_eq!(images.missing(&both, &running).len(), 1);
        images.forget();
        assert_eq!(images.missing(&both, &running).len(), 2);
    }
}
