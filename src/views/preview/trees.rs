//! The trees of a preview: they change without anything else being prepared again.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use glam::DVec3;

use super::Preview;
use quadratura_base::error::{Error, Message, Result};
use quadratura_base::scene::up;
use quadratura_base::scene::{Model, Site};
use quadratura_base::task::Task;
use quadratura_document::{Project, Trees};
use quadratura_foliage::PlacedTrees;
use quadratura_trees::light::{LightEstimate, estimated_light, is_needed};
use quadratura_trees::sunlight::SunBlockers;
use quadratura_trees::{KnownPlants, PlantParts, SiteTrees, site_trees_with};

/// What is needed to place other trees.
pub(super) struct PreviewTrees {
    folder: PathBuf,
    /// What is up in the world.
    up: DVec3,
    known: KnownPlants,
    parts: PlantParts,
    model: Arc<Model>,
    /// What of the model keeps the sun away, once there are trees.
    blockers: OnceLock<SunBlockers>,
    /// The estimated light that was shown last.
    estimate: Option<Arc<LightEstimate>>,
    /// What was noted about the trees last.
    noted: Vec<Message>,
}

impl PreviewTrees {
    /// Begins without trees. The project is in `folder`.
    pub fn new(folder: &Path, site: &Site, parts: PlantParts) -> Self {
        let (folder, up) = (folder.to_path_buf(), up(&site.photos));
        let (known, model) = (KnownPlants::default(), site.model.clone());
        let blockers = OnceLock::new();
        Self { folder, up, known, parts, model, blockers, estimate: None, noted: Vec::new() }
    }

    /// Finds what sun reaches the trees that are drawn.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    fn shade(&self, placed: &mut PlacedTrees, task: &Task) -> Result<()> {
        if placed.trees.is_empty() {
            return Ok(());
        }
        let shade = || self.blockers.get_or_init(|| SunBlockers::new(&self.model)).shade(placed, task);
        task.timed("sun on trees", shade)
    }

    /// Makes what is drawn of trees, in the estimated light that is known where no other is given.
    fn placed(&mut self, trees: &Trees, task: &Task) -> Result<(Option<PlacedTrees>, Vec<Message>)> {
        let made = site_trees_with(&self.folder, trees, &mut self.known, self.up, self.parts, task)?;
        let Some(SiteTrees { placed, problems }) = made else { return Ok((None, Vec::new())) };
        let mut placed = Arc::unwrap_or_clone(placed);
        if let Some(estimate) = &self.estimate {
            estimate.shine(&trees.light, &mut placed);
        }
        Ok((Some(placed), problems))
    }
}

impl Preview {
    /// Forgets the plants that were read, because files of them have changed: they are read again with the next trees.
    pub fn forget_plants(&mut self) {
        self.trees.known = KnownPlants::default();
    }

    /// Shows other trees, without those of some names. Their numbers in [`quadratura_projection::Renders::faces`] are those of the
    /// project, hidden ones counted. Where no light is given, they stand in `estimate`, or in the light that was estimated before; what
    /// photos show of them is from there, too.
    /// What is wrong with them is noted when it is new.
    ///
    /// # Errors
    /// As [`quadratura_layers::device::PlantedRenderer::set_trees`]; [`quadratura_base::Error::Cancelled`].
    pub fn set_trees(
        &mut self,
        trees: &Trees,
        hidden: &BTreeSet<String>,
        estimate: Option<Arc<LightEstimate>>,
        task: &Task,
    ) -> Result<()> {
        self.trees.estimate = estimate.or(self.trees.estimate.take());
        let (placed, problems) = self.trees.placed(trees, task)?;
        let mut shown = None;
        if let Some(mut placed) = placed {
            placed.trees.retain(|tree| !hidden.contains(&tree.name));
            self.trees.shade(&mut placed, task)?;
            shown = Some(Arc::new(placed));
        }
        self.renderer.set_trees(shown)?;
        problems
            .iter()
            .filter(|problem| !self.trees.noted.contains(problem))
            .for_each(|it| task.note(it.clone()));
        self.trees.noted = problems;
        Ok(())
    }

    /// Shows the trees of the project for the first time, in the light that is estimated from its photos unless one is given, and
    /// near photos as these show them; what is wrong with them is a problem of the preview. The estimate is in `cache/`, or made now.
    pub(super) fn plant(&mut self, project: &Project, site: &Site, task: &Task) -> Result<()> {
        if self.trees.parts == PlantParts::Nothing {
            return Ok(());
        }
        let trees = &project.trees;
        let (mut placed, mut problems) = self.trees.placed(trees, task)?;
        if let Some(placed) = placed.as_mut().filter(|placed| !placed.trees.is_empty())
            && is_needed(project)
        {
            let made = task
                .timed("light on trees", || estimated_light(&self.trees.folder, project, site, placed, task));
            match made {
                // Light that is given needs no estimate: trees are shown without what photos show of them.
                Err(error)
                    if trees.light.strength.given().is_some() && !matches!(error, Error::Cancelled) =>
                {
                    problems.push(error.message());
                }
                made => {
                    let made = made?;
                    made.shine(&trees.light, placed);
                    self.trees.estimate = Some(Arc::new(made));
                }
            }
        }
        if let Some(placed) = &mut placed {
            self.trees.shade(placed, task)?;
        }
        self.trees.noted.clone_from(&problems);
        // A plant that cannot be drawn leaves the rest of the site to be seen.
        match self.renderer.set_trees(placed.map(Arc::new)) {
            Err(error @ Error::Request(_)) => self.problems.push(error.message()),
            drawn => drawn?,
        }
        self.problems.extend(problems);
        Ok(())
    }
}
