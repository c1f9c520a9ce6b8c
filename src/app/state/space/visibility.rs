//! What the 3D view shows of the model: the eyes of objects, and surfaces that no photo covers. It is a view of the
//! model, no decision: it is not saved, and layers do not depend on it.

use std::collections::BTreeSet;

/// How surfaces that no photo covers are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Uncovered {
    /// As plain shaded surfaces.
    #[default]
    Solid,
    /// As outlines, through which one sees what is behind.
    Glass,
    /// Not at all.
    Hidden,
}

/// What the 3D view shows of the model.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ModelVisibility {
    /// The names of objects whose eye is closed.
    pub(super) hidden: BTreeSet<String>,
    /// How surfaces that no photo covers are shown.
    pub uncovered: Uncovered,
}

impl ModelVisibility {
    /// Returns whether an object's eye is open.
    pub fn is_shown(&self, object: &str) -> bool {
        !self.hidden.contains(object)
    }

    /// Returns whether some eye is closed.
    pub fn hides_objects(&self) -> bool {
        !self.hidden.is_empty()
    }
}
