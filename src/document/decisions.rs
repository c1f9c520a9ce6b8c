//! Decisions about single photos' layers: `decisions` of `project.json`.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use quadratura_base::scene::FaceIndex;
use quadratura_layers::{Faces, LayerConstraints, Options};

/// The longest permitted name of a layer, in bytes; no image editor truncates shorter ones.
pub const LONGEST_NAME: usize = 120;

/// Decisions by the photos' names. They identify faces, so that they apply to every stack that is built later.
/// Decisions to which nothing in a stack corresponds are kept.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Decisions {
    /// The decisions by photo; photos without decisions are absent.
    pub photos: BTreeMap<String, PhotoDecisions>,
}

/// Decisions about one photo's layers.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PhotoDecisions {
    /// Groups of faces to be merged into one layer; see [`LayerConstraints::merge`].
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub merge: Vec<Vec<Faces>>,
    /// Groups of faces to be kept in separate layers; see [`LayerConstraints::split`].
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub split: Vec<Vec<Vec<Faces>>>,
    /// The names of image layers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub names: Vec<LayerNaming>,
    /// Faces that this photo does not texture.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub exclude: Vec<Faces>,
    /// Faces that only this photo textures, as far as it shows them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pin: Vec<Faces>,
    /// Faces whose overlaps with other faces of their object are left to other photos; see
    /// [`LayerConstraints::tolerate`].
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tolerate: Vec<Faces>,
    /// The options of the method that differ for this photo.
    #[serde(skip_serializing_if = "PhotoOptions::is_default")]
    pub options: PhotoOptions,
}

/// The name of an image layer. It applies to the layer that contains most of the listed faces.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayerNaming {
    /// The name.
    pub name: String,
    /// The faces that the layer contained when it was named.
    pub of: Vec<Faces>,
}

/// The options of the method that a photo may override; `None` stands for the project's value.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PhotoOptions {
    /// Overrides [`Options::tolerance`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f32>,
    /// Overrides [`Options::min_support`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_support: Option<u32>,
    /// Overrides [`Options::margin`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub margin: Option<u32>,
    /// Overrides [`Options::min_visible`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_visible: Option<u32>,
    /// Overrides [`Options::min_share`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_share: Option<f32>,
    /// Overrides [`Options::tolerated`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerated: Option<f32>,
}

impl PhotoOptions {
    /// Returns true when nothing is overridden.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the project's options with the overrides applied.
    pub fn applied_to(&self, options: &Options) -> Options {
        Options {
            tolerance: self.tolerance.unwrap_or(options.tolerance),
            min_support: self.min_support.unwrap_or(options.min_support),
            margin: self.margin.unwrap_or(options.margin),
            min_visible: self.min_visible.unwrap_or(options.min_visible),
            min_share: self.min_share.unwrap_or(options.min_share),
            tolerated: self.tolerated.unwrap_or(options.tolerated),
            ..options.clone()
        }
    }
}

impl PhotoDecisions {
    /// Returns true when nothing was decided about the photo and none of its options is overridden.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the merges, splits and pins as the visibility sort takes them.
    pub fn constraints(&self) -> LayerConstraints {
        let Self { merge, split, pin, tolerate, .. } = self.clone();
        LayerConstraints { merge, split, keep: pin, tolerate }
    }

    /// Returns the decisions that affect how a stack is built; the others apply to any stack.
    pub fn of_stack(&self) -> Self {
        let Self { merge, split, tolerate, options, .. } = self.clone();
        Self { merge, split, tolerate, options, ..Self::default() }
    }

    /// Returns true when the face `index` of `object` is excluded from this photo's textures.
    pub fn excludes(&self, object: &str, index: FaceIndex) -> bool {
        self.exclude.iter().any(|faces| faces.holds(object, index))
    }

    /// Returns a sentence about the first contradiction or value out of range, if any.
    fn problem(&self, options: &Options) -> Option<String> {
        let lists = [("exclude", &self.exclude), ("pin", &self.pin), ("tolerate", &self.tolerate)];
        let of_lists = lists
            .into_iter()
            .find_map(|(name, list)| repeated(list).map(|faces| format!("{name} lists {faces} twice")));
        of_lists
            .or_else(|| numbered("merge", &self.merge, |merge| empty(merge)))
            .or_else(|| numbered("split", &self.split, |split| problem_of_split(split)))
            .or_else(|| numbered("names", &self.names, problem_of_name))
            .or_else(|| {
                let both = self.pin.iter().find(|faces| self.exclude.contains(faces))?;
                Some(format!("{both} is pinned and excluded"))
            })
            .or_else(|| Some(format!("options: {}", self.options.applied_to(options).problem()?)))
    }
}

/// Returns the first problem in a list, with the list's name and the item's index.
fn numbered<T>(name: &str, list: &[T], problem: impl Fn(&T) -> Option<String>) -> Option<String> {
    list.iter().enumerate().find_map(|(at, item)| Some(format!("{name}[{at}] {}", problem(item)?)))
}

/// Returns a problem when the list is empty.
fn empty(list: &[Faces]) -> Option<String> {
    list.is_empty().then(|| "names no object; expected one at least".into())
}

/// Returns a problem when a split has an empty group or the same face in two groups.
fn problem_of_split(groups: &[Vec<Faces>]) -> Option<String> {
    if groups.is_empty() || groups.iter().any(Vec::is_empty) {
        return Some("has a group without an object; expected groups of one object at least".into());
    }
    let twice = groups.iter().enumerate().find_map(|(at, group)| {
        let elsewhere = |faces: &&Faces| groups[..at].iter().flatten().any(|other| overlap(faces, other));
        group.iter().find(elsewhere)
    });
    twice.map(|faces| format!("has {faces} in two of its groups"))
}

/// Returns a problem when a layer's name is not a single line of 1 to 120 bytes, or refers to no faces.
fn problem_of_name(name: &LayerNaming) -> Option<String> {
    let LayerNaming { name, of } = name;
    if name.trim().is_empty() || name.len() > LONGEST_NAME || name.chars().any(char::is_control) {
        let expected = format!("expected 1 to {LONGEST_NAME} bytes in one line");
        return Some(format!("is called {name:?}; {expected}"));
    }
    empty(of)
}

/// Returns true when the two have a face in common. An empty list of faces means all faces of the object.
pub fn overlap(a: &Faces, b: &Faces) -> bool {
    let either = a.faces.is_empty() || b.faces.is_empty();
    a.object == b.object && (either || a.faces.iter().any(|face| b.faces.contains(face)))
}

/// Returns the first item that occurs twice.
fn repeated(list: &[Faces]) -> Option<&Faces> {
    let mut seen = BTreeSet::new();
    list.iter().find(|faces| !seen.insert(*faces))
}

impl Decisions {
    /// Returns true when no photo has an entry.
    pub fn is_default(&self) -> bool {
        self.photos.is_empty()
    }

    /// Returns the decisions about one photo.
    pub fn of(&self, photo: &str) -> PhotoDecisions {
        self.photos.get(photo).cloned().unwrap_or_default()
    }

    /// Replaces the decisions about a photo.
    pub fn set(&mut self, photo: &str, decisions: PhotoDecisions) {
        if decisions.is_default() {
            self.photos.remove(photo);
        } else {
            self.photos.insert(photo.to_owned(), decisions);
        }
    }

    /// Returns the one of these photos to which a face is pinned. A pin of the face itself takes precedence over a
    /// pin of its whole object, and an earlier photo over a later one.
    pub fn pinned<'a>(
        &self,
        photos: impl Iterator<Item = &'a str> + Clone,
        object: &str,
        index: FaceIndex,
    ) -> Option<&'a str> {
        let pins = |whole: bool, photo: &str| {
            let Some(decisions) = self.photos.get(photo) else { return false };
            decisions.pin.iter().any(|faces| faces.faces.is_empty() == whole && faces.holds(object, index))
        };
        let of_face = photos.clone().find(|photo| pins(false, photo));
        of_face.or_else(|| photos.clone().find(|photo| pins(true, photo)))
    }

    /// Returns a sentence, with the photo's name, about decisions that are empty, contradict each other, or are out
    /// of range together with the project's `options`.
    pub fn problem(&self, options: &Options) -> Option<String> {
        self.photos
            .iter()
            .find_map(|(photo, decisions)| Some(format!("{photo}: {}", decisions.problem(options)?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> PhotoDecisions {
        serde_json::from_str(text).unwrap()
    }

    fn problem(text: &str) -> String {
        let mut decisions = Decisions::default();
        decisions.set("a.jpg", of(text));
        decisions.problem(&Options::default()).unwrap_or_default()
    }

    const ALL: &str = r#"{"merge":[[{"object":"tower"},{"object":"gate","faces":[2]}]],"split":[[[{"object":"tree"}]]],"names":[{"name":"Front","of":[{"object":"gate"}]}],"exclude":[{"object":"tree"}],"pin":[{"object":"wall"}],"options":{"margin":4}}"#;

    #[test]
    fn decisions_come_back_as_they_were_written_and_those_without_one_leave_no_trace() {
        let mut decisions = Decisions::default();
        decisions.set("a.jpg", of(ALL));
        decisions.set("b.jpg", PhotoDecisions::default());
        let text = serde_json::to_string(&decisions).unwrap();
        assert_eq!(text, format!(r#"{{"a.jpg":{ALL}}}"#));
        assert_eq!(serde_json::from_str::<Decisions>(&text).unwrap(), decisions);
        assert_eq!(decisions.problem(&Options::default()), None);
        decisions.set("a.jpg", PhotoDecisions::default());
        assert!(decisions.is_default());
    }

    #[test]
    fn what_cannot_be_is_told_with_its_photo_and_its_place() {
        assert!(problem(r#"{"merge":[[{"object":"a"}],[]]}"#).starts_with("a.jpg: merge[1] names no object"));
        assert!(problem(r#"{"split":[[[]]]}"#).contains("split[0]"));
        let twice = problem(r#"{"split":[[[{"object":"a"}],[{"object":"a","faces":[1]}]]]}"#);
        assert!(twice.contains("a[1] in two of its groups"), "{twice}");
        assert!(problem(r#"{"names":[{"name":" ","of":[{"object":"a"}]}]}"#).contains("names[0]"));
        assert!(problem(r#"{"names":[{"name":"a\nb","of":[{"object":"a"}]}]}"#).contains("one line"));
        assert!(
            problem(r#"{"pin":[{"object":"a"}],"exclude":[{"object":"a"}]}"#).contains("pinned and excluded")
        );
        assert!(problem(r#"{"exclude":[{"object":"a"},{"object":"a"}]}"#).contains("exclude lists a twice"));
        assert!(problem(r#"{"options":{"tolerance":2}}"#).contains("options: tolerance is 2"));
        assert!(serde_json::from_str::<PhotoDecisions>(r#"{"merges":[]}"#).is_err(), "misspelt");
    }

    #[test]
    fn a_pin_of_the_face_goes_before_one_of_its_object_and_an_earlier_photo_before_a_later_one() {
        let mut decisions = Decisions::default();
        decisions.set("a", of(r#"{"pin":[{"object":"wall"}]}"#));
        decisions.set("b", of(r#"{"pin":[{"object":"wall","faces":[1]},{"object":"tree"}]}"#));
        decisions.set("c", of(r#"{"pin":[{"object":"wall","faces":[1]}]}"#));
        let pinned =
            |object: &str, face: u32| decisions.pinned(["a", "b", "c"].into_iter(), object, FaceIndex(face));
        assert_eq!(
            [pinned("wall", 0), pinned("wall", 1), pinned("tree", 5)],
            [Some("a"), Some("b"), Some("b")]
        );
        assert_eq!(pinned("gate", 0), None);
    }

    #[test]
    fn only_what_changes_a_stack_is_of_the_stack() {
        let stack = of(ALL).of_stack();
        assert!(stack.names.is_empty() && stack.exclude.is_empty() && stack.pin.is_empty());
        // What is pinned keeps its layer, which concerns the stack only where the photo barely shows it.
        let (constraints, all) = (stack.constraints(), of(ALL).constraints());
        assert_eq!((constraints.merge, constraints.split), (all.merge, all.split));
        assert_eq!(stack.options.applied_to(&Options::default()).margin, 4);
    }
}
