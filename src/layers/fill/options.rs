//! Options of filling, shared by the command line, the project file and the editor.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::propagation::{OnlyHere, PaintPlace, Propagation, is_among};
use quadratura_base::scene::alike::nfc;

/// The method for texels that no photo shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Invent {
    /// By example where the known part is large enough, else by diffusion.
    #[default]
    Exemplar,
    /// By diffusion everywhere.
    Diffusion,
}

/// Options of filling.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FillOptions {
    /// Objects that are not filled: names, or patterns in which `*` stands for any characters. The option refers to objects
    /// and not to image layers, so that it remains valid when a build forms other layers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub without: Vec<String>,
    /// The method for texels that no photo shows.
    pub invent: Invent,
    /// Photos whose paint replaces the pixels that other photos show of the same surfaces.
    #[serde(skip_serializing_if = "Propagation::is_undecided")]
    pub propagate: Propagation,
    /// Paint that is seen only in its photo.
    #[serde(skip_serializing_if = "OnlyHere::is_empty")]
    pub only_here: OnlyHere,
    /// Photos that keep the pixels that they show, whatever was painted on other photos.
    #[serde(skip_serializing_if = "BTreeSet::is_empty")]
    pub protected: BTreeSet<String>,
    /// Whether billboards stay solid rectangles, without mattes.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub no_mattes: bool,
}

impl FillOptions {
    /// Returns true when the object with this name is filled.
    pub fn fills(&self, object: &str) -> bool {
        !self.without.iter().any(|pattern| matches_pattern(object, pattern))
    }

    /// Returns true when paint of the photo with this name replaces pixels that other photos show, as far as it
    /// does not stay in it ([`Self::stays`]).
    pub fn propagates(&self, photo: &str) -> bool {
        is_among(self.propagate.patterns(), photo) && !self.only_here.photos.contains(photo)
    }

    /// Returns true when paint of other photos replaces pixels that the photo with this name shows.
    pub fn propagates_to(&self, photo: &str) -> bool {
        !self.propagate.patterns().is_empty() && !self.protected.contains(photo)
    }

    /// Returns true when paint is seen only in the photo on which it was painted.
    pub fn stays(&self, place: &PaintPlace) -> bool {
        self.only_here.holds(place)
    }

    /// Returns the options on which the filling of the photo with this name depends. Exceptions take effect in the
    /// list of the paint that concerns the photo, and a choice of none has the effect of no choice.
    pub fn of_photo(&self, photo: &str) -> Self {
        let propagate = match self.propagates_to(photo) {
            true => self.propagate.clone(),
            false => Propagation::Undecided,
        };
        Self { propagate, only_here: OnlyHere::default(), protected: BTreeSet::new(), ..self.clone() }
    }

    /// Returns a sentence about the first value that is not valid, if any.
    pub fn problem(&self) -> Option<String> {
        let empty = |name: &&String| name.is_empty();
        let patterns = self.propagate.patterns().iter().find(empty);
        let patterns = patterns.map(|_| "propagate has an empty name; expected names of photos".to_owned());
        let number = self.only_here.imports.contains(&0);
        patterns.or(number.then(|| "only_here has the import 0 in imports; they are numbered from 1".into()))
    }

    /// Returns true when all options have their default values.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Returns true when a name equals the pattern, in which each `*` stands for any characters, or none. Both may be in any Unicode
/// form.
pub fn matches_pattern(name: &str, pattern: &str) -> bool {
    let [name, pattern] = [name, pattern].map(nfc);
    let (name, pattern) = (&*name, &*pattern);
    let Some((beginning, rest)) = pattern.split_once('*') else { return name == pattern };
    let Some(mut left) = name.strip_prefix(beginning) else { return false };
    let (middle, end) = rest.rsplit_once('*').unwrap_or(("", rest));
    for part in middle.split('*') {
        let Some(at) = left.find(part) else { return false };
        left = &left[at + part.len()..];
    }
    left.ends_with(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_stands_for_any_characters_anywhere_in_a_pattern() {
        let names = ["tree_1.billboard", "tree_1.trunk", "billboard", ".billboard", "tree"];
        let matching = |pattern: &str| names.map(|name| u8::from(matches_pattern(name, pattern)));
        assert_eq!(matching("*.billboard"), [1, 0, 0, 1, 0]);
        assert_eq!(matching("tree*"), [1, 1, 0, 0, 1]);
        assert_eq!(matching("tree*board"), [1, 0, 0, 0, 0]);
        assert_eq!(matching("*_*.*"), [1, 1, 0, 0, 0]);
        assert_eq!(matching("*"), [1; 5]);
        assert_eq!(matching("tree"), [0, 0, 0, 0, 1]);
        assert!(!matches_pattern("aba", "ab*ba"), "no character counts twice");
        assert!(
            matches_pattern("ch\u{ea}ne_2", "che\u{302}ne*") && matches_pattern("che\u{302}ne", "ch\u{ea}ne")
        );
    }

    #[test]
    fn an_object_is_left_out_by_its_name_or_by_how_its_name_begins() {
        let options = FillOptions { without: vec!["tractor".into(), "tree_*".into()], ..Default::default() };
        let fills = ["tractor", "tractor.cab", "tree_1", "tree"].map(|name| options.fills(name));
        assert_eq!(fills, [false, true, false, true]);
    }

    #[test]
    fn paint_is_propagated_by_choice_from_and_to_photos_without_exceptions() {
        let undecided = FillOptions::default();
        let none = FillOptions { propagate: Propagation::None, ..FillOptions::default() };
        for options in [&undecided, &none] {
            assert!(!options.propagates("a.jpg") && !options.propagates_to("a.jpg"), "{options:?}");
            assert_eq!(options.of_photo("a.jpg"), undecided, "its filling is the same");
        }
        let all = FillOptions { propagate: Propagation::all(), ..none };
        assert!(all.propagates("a.jpg") && all.propagates_to("a.jpg"));
        let only_here = OnlyHere { photos: BTreeSet::from(["a.jpg".into()]), ..OnlyHere::default() };
        let some = FillOptions { only_here, protected: BTreeSet::from(["b.jpg".into()]), ..all.clone() };
        assert_eq!(["a.jpg", "b.jpg"].map(|photo| some.propagates(photo)), [false, true]);
        assert_eq!(["a.jpg", "b.jpg"].map(|photo| some.propagates_to(photo)), [true, false]);
        assert_eq!((some.of_photo("a.jpg"), some.of_photo("b.jpg")), (all, undecided));
    }
}
