//! The way from a new project to its first painted layer, and how far it is gone.

use super::session::Session;

/// A step of the way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FirstStep {
    /// Building the layers.
    Build,
    /// Filling what the photos do not show.
    Fill,
    /// Opening a photo's layers in the image editor.
    Edit,
    /// Painting and saving there, which imports the paint.
    Save,
}

impl FirstStep {
    /// All steps, in order.
    pub const ALL: [Self; 4] = [Self::Build, Self::Fill, Self::Edit, Self::Save];
}

impl Session {
    /// Returns whether a step was done, in this run or an earlier one; `is_painted`: the project has paint.
    pub fn is_done(&self, step: FirstStep, is_painted: bool) -> bool {
        let built = || self.photos.iter().filter_map(|photo| photo.stack.as_ref());
        match step {
            FirstStep::Build => built().next().is_some(),
            FirstStep::Fill => {
                built().any(|stack| stack.image_layers.iter().any(|layer| layer.fill.is_some()))
            }
            FirstStep::Edit => is_painted || self.editing_folder().is_some(),
            FirstStep::Save => is_painted,
        }
    }

    /// Returns the first step that was not done; `None` where a layer is painted.
    pub fn next_first_step(&self, is_painted: bool) -> Option<FirstStep> {
        FirstStep::ALL.into_iter().find(|step| !self.is_done(*step, is_painted))
    }
}
