//! The faces that a photo does not texture, with the reasons.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

use serde::{Deserialize, Deserializer, Serialize};

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

/// The faces that a photo does not texture, in runs of faces with the same reason. In a large model they are nearly all of a
/// stack, so all its copies share them.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct UntexturedFaces(Arc<Vec<UntexturedRun>>);

/// Consecutive faces of an object that a photo does not texture for the same reason, which has no particulars unless it is one face.
/// Runs share their names: a photo has thousands of runs of hundreds of objects, and a site hundreds of photos.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
struct UntexturedRun {
    object: Arc<str>,
    /// The first face.
    face: FaceIndex,
    /// The number of faces.
    #[serde(skip_serializing_if = "is_one")]
    faces: u32,
    reason: UntexturedReason,
    #[serde(skip_serializing_if = "Option::is_none")]
    by: Option<Arc<str>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    at: Option<[u32; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    px: Option<Box<[u64; 2]>>,
}

/// A run as it is in a file, with names that are read in place.
#[derive(Deserialize)]
struct WrittenRun<'a> {
    #[serde(borrow)]
    object: Cow<'a, str>,
    face: FaceIndex,
    /// 1 in stacks of before.
    #[serde(default = "one")]
    faces: u32,
    reason: UntexturedReason,
    #[serde(borrow, default)]
    by: Option<Cow<'a, str>>,
    at: Option<[u32; 2]>,
    px: Option<Box<[u64; 2]>>,
}

fn one() -> u32 {
    1
}

fn is_one(count: &u32) -> bool {
    *count == 1
}

impl UntexturedRun {
    fn new(face: Untextured) -> Self {
        let Untextured { object, face, reason, by, at, px } = face;
        let (object, by, px) = (object.into(), by.map(Arc::from), px.map(Box::new));
        Self { object, face, faces: 1, reason, by, at, px }
    }

    /// Returns whether a face continues the run.
    fn continues_with(&self, next: &Untextured) -> bool {
        let is_plain = (&self.by, self.at, &self.px) == (&None, None, &None)
            && (&next.by, next.at, next.px) == (&None, None, None);
        let follows = self.face.0.checked_add(self.faces) == Some(next.face.0);
        follows && is_plain && (&*self.object, self.reason) == (&*next.object, next.reason)
    }

    fn faces(&self) -> impl Iterator<Item = Untextured> + '_ {
        let Self { object, face, faces, reason, by, at, px } = self;
        (face.0..face.0.saturating_add(*faces)).map(|face| Untextured {
            object: object.to_string(),
            face: FaceIndex(face),
            reason: *reason,
            by: by.as_ref().map(|by| by.to_string()),
            at: *at,
            px: px.as_deref().copied(),
        })
    }
}

impl UntexturedFaces {
    /// Adds faces.
    pub fn extend(&mut self, faces: impl IntoIterator<Item = Untextured>) {
        let runs = Arc::make_mut(&mut self.0);
        for face in faces {
            match runs.last_mut().filter(|run| run.continues_with(&face)) {
                Some(run) => run.faces += 1,
                None => runs.push(UntexturedRun::new(face)),
            }
        }
    }

    /// Iterates over the faces.
    pub fn iter(&self) -> impl Iterator<Item = Untextured> + '_ {
        self.0.iter().flat_map(UntexturedRun::faces)
    }

    /// Returns the number of faces.
    pub fn len(&self) -> usize {
        self.0.iter().map(|run| run.faces as usize).sum()
    }

    /// Returns whether the photo textures all faces.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl<'de> Deserialize<'de> for UntexturedFaces {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let written = Vec::<WrittenRun<'de>>::deserialize(deserializer)?;
        let mut known = HashMap::<&str, Arc<str>>::new();
        let runs = written.iter().map(|WrittenRun { object, face, faces, reason, by, at, px }| {
            let mut shared = |name| known.entry(name).or_insert_with(|| Arc::from(name)).clone();
            let (object, by) = (shared(&**object), by.as_deref().map(&mut shared));
            let (face, faces, reason, at, px) = (*face, *faces, *reason, *at, px.clone());
            UntexturedRun { object, face, faces, reason, by, at, px }
        });
        Ok(Self(Arc::new(runs.collect())))
    }
}

impl From<Vec<Untextured>> for UntexturedFaces {
    fn from(faces: Vec<Untextured>) -> Self {
        let mut all = Self::default();
        all.extend(faces);
        all
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

#[cfg(test)]
mod tests {
    use super::*;

    fn face(object: &str, face: u32, reason: UntexturedReason, at: Option<[u32; 2]>) -> Untextured {
        Untextured { object: object.into(), face: FaceIndex(face), reason, by: None, at, px: None }
    }

    #[test]
    fn faces_with_one_reason_are_one_entry_and_come_back_one_by_one() {
        use UntexturedReason::{Behind, Hidden};
        let faces = vec![
            face("house", 0, Behind, None),
            face("house", 1, Behind, None),
            face("house", 3, Behind, None),
            face("house", 4, Hidden, Some([3, 4])),
            face("house", 5, Hidden, Some([3, 4])),
            face("shed", 6, Behind, None),
        ];
        let kept = UntexturedFaces::from(faces.clone());
        let read: UntexturedFaces = serde_json::from_str(&serde_json::to_string(&kept).unwrap()).unwrap();
        assert!(Arc::ptr_eq(&read.0[0].object, &read.0[3].object), "runs share the names of objects");
        assert_eq!((kept.iter().collect::<Vec<_>>(), kept.len()), (faces.clone(), 6));
        let text = serde_json::to_string(&kept).unwrap();
        assert!(text.starts_with(r#"[{"object":"house","face":0,"faces":2,"reason":"behind"},"#), "{text}");
        assert_eq!(serde_json::from_str::<UntexturedFaces>(&text).unwrap(), kept);
        let of_before = serde_json::to_string(&faces).unwrap();
        let read: UntexturedFaces = serde_json::from_str(&of_before).unwrap();
        assert_eq!(read.iter().collect::<Vec<_>>(), faces);
    }
}
