//! The faces that a photo does not texture, with the reasons.

use std::ops::Deref;
use std::sync::Arc;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use quadratura_base::scene::FaceIndex;

/// A face that this photo does not texture.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Untextured {
    /// The unique name of the object.
    pub object: String,
    /// The face's index within the object.
    pub face: FaceIndex,
    /// The reason.
    pub reason: UntexturedReason,
    /// The nearer face at the first hidden pixel, as `object[index]`; for `hidden` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<String>,
    /// The first hidden pixel for `hidden`, the first visible one for `barely-visible`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<[u32; 2]>,
    /// The numbers of pixels that are visible and covered; for `barely-visible` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub px: Option<[u64; 2]>,
}

/// The faces that a photo does not texture. All copies of a stack share one list, because in a large model it is nearly all of
/// the stack.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct UntexturedFaces(Arc<Vec<Untextured>>);

impl UntexturedFaces {
    /// Adds faces.
    pub fn extend(&mut self, faces: impl IntoIterator<Item = Untextured>) {
        Arc::make_mut(&mut self.0).extend(faces);
    }
}

impl From<Vec<Untextured>> for UntexturedFaces {
    fn from(faces: Vec<Untextured>) -> Self {
        Self(faces.into())
    }
}

impl Deref for UntexturedFaces {
    type Target = [Untextured];

    fn deref(&self) -> &[Untextured] {
        &self.0
    }
}

impl Serialize for UntexturedFaces {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for UntexturedFaces {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Vec::deserialize(deserializer).map(Self::from)
    }
}

impl Untextured {
    /// Returns the reason for messages, such as `hidden by tower[3] at pixel (812, 40)`.
    pub fn in_words(&self) -> String {
        let by = self.by.as_ref().map_or(String::new(), |by| format!(" by {by}"));
        let at = self.at.map_or(String::new(), |[x, y]| format!(" at pixel ({x}, {y})"));
        let px =
            self.px.map_or(String::new(), |[visible, covered]| format!(", {visible} of {covered} pixels"));
        format!("{}{by}{px}{at}", self.reason.word())
    }
}

/// The reason why a photo does not texture a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum UntexturedReason {
    /// The face is in front of the camera, but outside the photo.
    Outside,
    /// The face is behind the camera.
    Behind,
    /// The face covers no pixel centre, or is seen exactly edge-on.
    TooSmall,
    /// Other faces are nearer at all its pixels.
    Hidden,
    /// The face is visible only where the photo is invalid or masked.
    Masked,
    /// The photo shows so little of the face that it is in no image layer.
    BarelyVisible,
    /// The face has no area.
    Degenerate,
    /// The user excluded the face from this photo's textures. Such a face is in the stack, because it occludes
    /// others; so this reason is never in the file, but in lists of reasons.
    Excluded,
}

impl UntexturedReason {
    /// All reasons.
    pub const ALL: [Self; 8] = [
        Self::Outside,
        Self::Behind,
        Self::TooSmall,
        Self::Hidden,
        Self::Masked,
        Self::BarelyVisible,
        Self::Degenerate,
        Self::Excluded,
    ];

    /// Returns the word for tables and messages.
    pub fn word(self) -> &'static str {
        match self {
            Self::Outside => "outside",
            Self::Behind => "behind",
            Self::TooSmall => "too small",
            Self::Hidden => "hidden",
            Self::Masked => "masked",
            Self::BarelyVisible => "barely visible",
            Self::Degenerate => "no area",
            Self::Excluded => "excluded",
        }
    }
}
