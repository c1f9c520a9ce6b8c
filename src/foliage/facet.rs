//! What a surface is where a polygon is drawn.

use glam::{DVec3, Vec3};

use super::paint::Change;

/// The surface of a fragment in the middle of its covered sub-pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Facet {
    /// The normal in the view's frame, of length 1, or 0 where it has none; of a leaf it looks to the viewer.
    pub normal: DVec3,
    /// True where a surface that is no leaf looks away from the viewer.
    pub is_back: bool,
    /// The share of light that is reflected, in linear light.
    pub reflected: Vec3,
    /// The share that a leaf lets through; `None` for bark.
    pub through: Option<Vec3>,
}

impl Facet {
    /// Returns the surface with paint on it.
    pub fn painted(mut self, change: &Change) -> Self {
        let before = self.reflected;
        self.reflected = change.reflected(before);
        self.through = self.through.map(|through| change.through(through, before, self.reflected));
        self
    }
}
