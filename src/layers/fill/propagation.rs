//! Which paint is seen in other photos: the project's choice, and its exceptions by photo, surface and import.

use std::collections::BTreeSet;
use std::fmt;

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::options::matches_pattern;
use crate::Faces;
use quadratura_base::scene::FaceIndex;

/// The pattern for all photos.
const ALL: &str = "*";

/// The word for [`Propagation::None`] in the project file.
const NONE: &str = "none";

/// The photos whose paint replaces the pixels that other photos show of the same surfaces. In JSON: a list of names
/// or patterns in which `*` stands for any characters; `"none"`; or an empty list, which stands for [`Self::Undecided`], because
/// projects of before the choice have that.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Propagation {
    /// Nobody has chosen yet; the same as [`Self::None`] until somebody does.
    #[default]
    Undecided,
    /// The paint of no photo.
    None,
    /// The paint of the photos that match one of these patterns, of which there is one at least.
    Of(Vec<String>),
}

impl Propagation {
    /// Returns the choice of all photos.
    pub fn all() -> Self {
        Self::Of(vec![ALL.to_owned()])
    }

    /// Returns the patterns of photos; empty for none.
    pub fn patterns(&self) -> &[String] {
        match self {
            Self::Undecided | Self::None => &[],
            Self::Of(patterns) => patterns,
        }
    }

    /// Returns true until somebody has chosen.
    pub fn is_undecided(&self) -> bool {
        *self == Self::Undecided
    }

    /// Returns true when the paint of every photo is chosen.
    pub fn is_all(&self) -> bool {
        self.patterns().iter().any(|pattern| pattern == ALL)
    }
}

/// The choice of these photos; none where there are none.
impl From<Vec<String>> for Propagation {
    fn from(patterns: Vec<String>) -> Self {
        if patterns.is_empty() { Self::None } else { Self::Of(patterns) }
    }
}

impl Serialize for Propagation {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::None => to.serialize_str(NONE),
            Self::Undecided | Self::Of(_) => self.patterns().serialize(to),
        }
    }
}

impl<'de> Deserialize<'de> for Propagation {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct PropagationVisitor;
        impl<'de> Visitor<'de> for PropagationVisitor {
            type Value = Propagation;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a list of photos, such as [{ALL:?}] for all, or {NONE:?}")
            }

            fn visit_str<E: Error>(self, word: &str) -> Result<Propagation, E> {
                match word {
                    NONE => Ok(Propagation::None),
                    _ => Err(E::invalid_value(serde::de::Unexpected::Str(word), &self)),
                }
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Propagation, A::Error> {
                let mut patterns = Vec::new();
                while let Some(pattern) = list.next_element()? {
                    patterns.push(pattern);
                }
                Ok(if patterns.is_empty() { Propagation::Undecided } else { Propagation::Of(patterns) })
            }
        }
        from.deserialize_any(PropagationVisitor)
    }
}

/// The place of paint in a project, which decides where it is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PaintPlace<'a> {
    /// The photo on which it was painted.
    pub photo: &'a str,
    /// The unique name of the object on which it was painted.
    pub object: &'a str,
    /// The index of the face within the object; `None` for the surroundings.
    pub face: Option<FaceIndex>,
    /// The number of the import with which it came.
    pub import: u32,
}

/// Paint that is seen only in the photo on which it was painted: to all other photos it does not exist, so that it
/// neither replaces pixels that they show nor fills areas that they do not show.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OnlyHere {
    /// The photos all of whose paint stays in them.
    #[serde(skip_serializing_if = "BTreeSet::is_empty")]
    pub photos: BTreeSet<String>,
    /// The objects and faces on which paint stays in its photo.
    #[serde(skip_serializing_if = "BTreeSet::is_empty")]
    pub surfaces: BTreeSet<Faces>,
    /// The numbers of the imports whose paint stays in its photo.
    #[serde(skip_serializing_if = "BTreeSet::is_empty")]
    pub imports: BTreeSet<u32>,
}

impl OnlyHere {
    /// Returns true when there are no exceptions.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Returns true when this paint stays in its photo.
    pub fn holds(&self, place: &PaintPlace) -> bool {
        self.photos.contains(place.photo)
            || self.imports.contains(&place.import)
            || self.surfaces.iter().any(|faces| match place.face {
                Some(face) => faces.holds(place.object, face),
                None => faces.object == place.object,
            })
    }
}

/// Returns true when the name of a photo matches one of the patterns.
pub(super) fn is_among(patterns: &[String], photo: &str) -> bool {
    patterns.iter().any(|pattern| matches_pattern(photo, pattern))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::FillOptions;

    fn read(json: &str) -> Result<Propagation, String> {
        serde_json::from_str(json).map_err(|error| error.to_string())
    }

    #[test]
    fn the_choice_reads_as_it_was_written_and_former_projects_are_undecided() {
        assert_eq!(read("[]"), Ok(Propagation::Undecided));
        for choice in [Propagation::None, Propagation::all(), vec!["a.jpg".into(), "b*".into()].into()] {
            assert_eq!(read(&serde_json::to_string(&choice).unwrap()), Ok(choice));
        }
        let former: FillOptions = serde_json::from_str(r#"{"invent": "exemplar"}"#).unwrap();
        assert!(former.propagate.is_undecided());
        assert_eq!(serde_json::to_string(&former).unwrap(), r#"{"invent":"exemplar"}"#);
    }

    #[test]
    fn nonsense_is_refused_and_what_may_be_there_is_named() {
        for wrong in ["\"all\"", "true", "{}", "7"] {
            let message = read(wrong).unwrap_err();
            assert!(message.contains("[\"*\"]") && message.contains("\"none\""), "{wrong}: {message}");
        }
    }

    #[test]
    fn paint_stays_in_its_photo_by_photo_surface_or_import() {
        let paint = PaintPlace { photo: "a.jpg", object: "wall", face: Some(FaceIndex(3)), import: 7 };
        let none = OnlyHere::default();
        assert!(none.is_empty() && !none.holds(&paint));
        let surfaces = |faces| OnlyHere { surfaces: BTreeSet::from([faces]), ..OnlyHere::default() };
        let face = |index| Faces { object: "wall".into(), faces: vec![FaceIndex(index)] };
        let photos = |name: &str| OnlyHere { photos: BTreeSet::from([name.into()]), ..OnlyHere::default() };
        let imports = |number| OnlyHere { imports: BTreeSet::from([number]), ..OnlyHere::default() };
        for (exceptions, stays) in [
            (surfaces(Faces::whole("wall")), true),
            (surfaces(face(3)), true),
            (surfaces(face(4)), false),
            (surfaces(Faces::whole("door")), false),
            (photos("a.jpg"), true),
            (photos("b.jpg"), false),
            (imports(7), true),
            (imports(8), false),
        ] {
            assert_eq!(exceptions.holds(&paint), stays, "{exceptions:?}");
        }
    }
}
