//! Faces that a view leaves out at the user's wish, and the rule by which rays and pictures skip faces.

use std::collections::BTreeSet;
use std::sync::Arc;

use quadratura_base::scene::FaceId;

/// Faces that a view leaves out: it shows what is behind them.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct HiddenFaces(Option<Arc<BTreeSet<FaceId>>>);

impl HiddenFaces {
    /// Returns true when a face is left out.
    pub fn contains(&self, face: FaceId) -> bool {
        self.0.as_ref().is_some_and(|faces| faces.contains(&face))
    }

    /// Returns the faces in ascending order.
    pub fn iter(&self) -> impl Iterator<Item = FaceId> {
        self.0.iter().flat_map(|faces| faces.iter().copied())
    }
}

impl FromIterator<FaceId> for HiddenFaces {
    fn from_iter<I: IntoIterator<Item = FaceId>>(faces: I) -> Self {
        let faces: BTreeSet<FaceId> = faces.into_iter().collect();
        Self((!faces.is_empty()).then(|| Arc::new(faces)))
    }
}

/// No faces.
static NONE: HiddenFaces = HiddenFaces(None);

impl Culling<'_> {
    /// Skips nothing.
    pub fn nothing() -> Culling<'static> {
        Culling { backs: true, hidden: &NONE }
    }
}

/// The faces that a ray or a picture skips.
#[derive(Debug, Clone, Copy)]
pub struct Culling<'a> {
    /// True when back sides of faces (`sides`) are visible like all others.
    pub backs: bool,
    /// The faces that are left out.
    pub hidden: &'a HiddenFaces,
}
