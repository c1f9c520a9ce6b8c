//! Scale, rotation, translation: how the model reaches the cameras' world.

use glam::{DMat3, DVec3};

/// `p -> scale * rotation * p + translation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Similarity {
    /// Positive.
    pub scale: f64,
    /// Orthonormal with determinant 1.
    pub rotation: DMat3,
    /// In the target's unit.
    pub translation: DVec3,
}

impl Similarity {
    /// Leaves every point where it is.
    pub const IDENTITY: Self = Self { scale: 1.0, rotation: DMat3::IDENTITY, translation: DVec3::ZERO };

    /// Applies it to a point.
    pub fn apply(&self, point: DVec3) -> DVec3 {
        self.rotation * (point * self.scale) + self.translation
    }
}

impl Default for Similarity {
    fn default() -> Self {
        Self::IDENTITY
    }
}
