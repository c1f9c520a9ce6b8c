//! Masks of the photos: `masks` of `project.json`. Their pixels are in files that are never modified, so that
//! copies of these entries are enough to undo an edit.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

/// All masks of a project, by photo.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Masks(BTreeMap<String, Vec<Mask>>);

/// One of a photo's masks. Pixels that any of them covers are not used.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mask {
    /// The origin of the mask; a photo has at most one mask of each origin.
    pub from: MaskOrigin,
    /// The file below the project's `masks/`: a PNG as large as the photo's pinhole image, in which black is
    /// masked. Empty for a mask that was found and could not be read: its photo is left out until it can.
    pub file: String,
    /// The number of masked pixels.
    pub pixels: u64,
}

impl Mask {
    /// Returns the entry of a mask that could not be read.
    pub fn unread(from: MaskOrigin) -> Self {
        Self { from, file: String::new(), pixels: 0 }
    }

    /// Returns true where the mask could not be read.
    pub fn is_unread(&self) -> bool {
        self.file.is_empty() && matches!(self.from, MaskOrigin::File(_))
    }
}

/// A change of one mask by an import.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MaskChange {
    /// The photo's name.
    pub photo: String,
    /// The origin of the mask.
    pub from: MaskOrigin,
    /// The mask before the import; `None` where there was none.
    pub before: Option<Mask>,
    /// The mask after the import; `None` where there is none.
    pub after: Option<Mask>,
}

/// The origin of a mask. Lists are sorted in the order of the variants.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MaskOrigin {
    /// A mask file of this name.
    File(String),
    /// The visible pixels of some objects of the model, with a margin.
    Object(MaskedObject),
    /// A layer called `mask` of an edited document: its export's key, `@`, and its path from the project.
    Layer(String),
    /// Accepted suggestions.
    Suggested,
    /// Painting in the editor.
    Drawn,
    /// What the photo shows of the real tree where a tree of the project stands, with a margin.
    Tree(MaskedTree),
}

/// The objects that an object mask covers, and its margin.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaskedObject {
    /// The name of an object, or a pattern of names in which `*` stands for any characters.
    pub name: String,
    /// The margin around the objects, in photo pixels.
    pub margin: u32,
}

/// The tree of the project that a tree mask covers, and its margin.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaskedTree {
    /// The name of the tree.
    pub name: String,
    /// The margin around the tree, in photo pixels.
    pub margin: u32,
    /// A hash of the tree's species, place, size and turn when it was masked; `None` in masks of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub placing: Option<String>,
}

impl MaskOrigin {
    /// Returns true for the same origin, of which a photo has one mask at most. Masks of objects and of trees that differ only
    /// in the margin have the same origin.
    fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Object(a), Self::Object(b)) => a.name == b.name,
            (Self::Tree(a), Self::Tree(b)) => a.name == b.name,
            (a, b) => a == b,
        }
    }

    /// Returns a short description for messages.
    pub fn words(&self) -> String {
        match self {
            Self::File(name) => format!("file {name}"),
            Self::Object(MaskedObject { name, margin }) => format!("object {name}, margin {margin}"),
            Self::Layer(document) => {
                format!("layer of {}", document.split_once('@').map_or(document.as_str(), |(_, path)| path))
            }
            Self::Suggested => "suggested".into(),
            Self::Drawn => "drawn".into(),
            Self::Tree(MaskedTree { name, margin, .. }) => format!("tree {name}, margin {margin}"),
        }
    }

    /// Returns a short name for a file.
    pub fn stem(&self) -> &str {
        match self {
            Self::File(name) => name.rsplit('/').next().unwrap_or(name),
            Self::Object(MaskedObject { name, .. }) => name,
            Self::Layer(_) => "layer",
            Self::Suggested => "suggested",
            Self::Drawn => "drawn",
            Self::Tree(MaskedTree { name, .. }) => name,
        }
    }
}

impl Masks {
    /// Returns true when no photo has a mask.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the photos with masks, in alphabetical order, whether the project still has them or not.
    pub fn photos(&self) -> impl Iterator<Item = (&str, &[Mask])> {
        self.0.iter().map(|(photo, masks)| (photo.as_str(), masks.as_slice()))
    }

    /// Returns the masks of a photo.
    pub fn of(&self, photo: &str) -> &[Mask] {
        self.0.get(photo).map_or(&[], Vec::as_slice)
    }

    /// Returns the mask of a photo that has this origin.
    pub fn find(&self, photo: &str, from: &MaskOrigin) -> Option<&Mask> {
        self.of(photo).iter().find(|mask| mask.from.is_same(from))
    }

    /// Adds a mask, in place of the photo's mask of the same origin.
    pub fn put(&mut self, photo: &str, mask: Mask) {
        self.remove(photo, &mask.from);
        let masks = self.0.entry(photo.to_owned()).or_default();
        masks.push(mask);
        masks.sort_by(|a, b| a.from.cmp(&b.from));
    }

    /// Removes a photo's mask of this origin and returns it.
    pub fn remove(&mut self, photo: &str, from: &MaskOrigin) -> Option<Mask> {
        let masks = self.0.get_mut(photo)?;
        let index = masks.iter().position(|mask| mask.from.is_same(from));
        let removed = index.map(|index| masks.remove(index));
        if masks.is_empty() {
            self.0.remove(photo);
        }
        removed
    }

    /// Removes all masks of a photo.
    pub fn clear(&mut self, photo: &str) {
        self.0.remove(photo);
    }

    /// Removes the masks of a photo whose origins are so.
    pub fn remove_where(&mut self, photo: &str, is_so: impl Fn(&MaskOrigin) -> bool) {
        let Some(masks) = self.0.get_mut(photo) else { return };
        masks.retain(|mask| !is_so(&mask.from));
        if masks.is_empty() {
            self.0.remove(photo);
        }
    }

    /// Gives the masks of a tree the name that the tree has now. Those that a tree of that name has left take no part: they are
    /// replaced where a photo has both.
    pub fn rename_tree(&mut self, before: &str, after: &str) {
        let is_its = |mask: &Mask| matches!(&mask.from, MaskOrigin::Tree(tree) if tree.name == before);
        let of_tree = |(photo, masks): (&str, &[Mask])| {
            let its: Vec<Mask> = masks.iter().filter(|mask| is_its(mask)).cloned().collect();
            (photo.to_owned(), its)
        };
        let found: Vec<(String, Vec<Mask>)> = self.photos().map(of_tree).collect();
        for (photo, mask) in found
            .into_iter()
            .flat_map(|(photo, masks)| masks.into_iter().map(move |mask| (photo.clone(), mask)))
        {
            self.remove(&photo, &mask.from);
            let MaskOrigin::Tree(tree) = mask.from else { continue };
            let from = MaskOrigin::Tree(MaskedTree { name: after.to_owned(), ..tree });
            self.put(&photo, Mask { from, ..mask });
        }
    }

    /// Adds or replaces a photo's mask of this origin, or removes it.
    pub fn set(&mut self, photo: &str, from: &MaskOrigin, mask: Option<Mask>) {
        match mask {
            Some(mask) => self.put(photo, mask),
            None => drop(self.remove(photo, from)),
        }
    }

    /// Returns these masks with external changes merged in: every mask that differs between `known` and `now` is
    /// taken from `now`.
    pub fn merged_with_changes(&self, known: &Self, now: &Self) -> Self {
        let mut masks = self.clone();
        let of_both = [known, now].into_iter().flat_map(Self::photos);
        for (photo, mask) in of_both.flat_map(|(photo, of)| of.iter().map(move |mask| (photo, mask))) {
            let is_now = now.find(photo, &mask.from);
            if known.find(photo, &mask.from) != is_now {
                masks.set(photo, &mask.from, is_now.cloned());
            }
        }
        masks
    }

    /// Returns all files that the masks refer to.
    pub fn files(&self) -> BTreeSet<&str> {
        let read = self.0.values().flatten().filter(|mask| !mask.is_unread());
        read.map(|mask| mask.file.as_str()).collect()
    }

    /// Returns a sentence about a file outside of `masks/`, if any.
    pub fn problem(&self) -> Option<String> {
        let outside = |file: &&str| {
            let parts: Vec<&str> = file.split('/').collect();
            file.contains(['\\', '\0']) || parts.iter().any(|part| matches!(*part, "" | "." | ".."))
        };
        let file = self.files().into_iter().find(outside)?;
        Some(format!("the file {file:?}; expected a path below masks/, with /"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(from: MaskOrigin, file: &str) -> Mask {
        Mask { from, file: file.into(), pixels: 3 }
    }

    fn tractor(margin: u32) -> MaskOrigin {
        MaskOrigin::Object(MaskedObject { name: "tractor*".into(), margin })
    }

    #[test]
    fn masks_are_written_readably_and_come_back() {
        let mut masks = Masks::default();
        masks.put("a.jpg", mask(MaskOrigin::Suggested, "a.jpg/s-1.png"));
        masks.put("a.jpg", mask(tractor(9), "a.jpg/t-1.png"));
        let text = serde_json::to_string(&masks).unwrap();
        assert_eq!(
            text,
            concat!(
                r#"{"a.jpg":[{"from":{"object":{"name":"tractor*","margin":9}},"file":"a.jpg/t-1.png","pixels":3},"#,
                r#"{"from":"suggested","file":"a.jpg/s-1.png","pixels":3}]}"#
            )
        );
        assert_eq!(serde_json::from_str::<Masks>(&text).unwrap(), masks);
    }

    #[test]
    fn a_photo_has_one_mask_of_each_maker_and_another_margin_makes_no_other() {
        let mut masks = Masks::default();
        masks.put("a.jpg", mask(tractor(9), "1"));
        masks.put("a.jpg", mask(tractor(20), "2"));
        masks.put("a.jpg", mask(MaskOrigin::Drawn, "3"));
        assert_eq!(masks.of("a.jpg").len(), 2);
        assert_eq!(masks.find("a.jpg", &tractor(0)).unwrap().file, "2");
        assert_eq!(masks.remove("a.jpg", &tractor(1)).unwrap().file, "2");
        assert_eq!(masks.remove("a.jpg", &tractor(1)), None);
        masks.remove("a.jpg", &MaskOrigin::Drawn);
        assert!(masks.is_empty());
    }

    #[test]
    fn what_somebody_else_made_meanwhile_is_taken_and_nothing_else() {
        let layer = |file: &str| mask(MaskOrigin::Layer("9@a.psd".into()), file);
        let masks = |list: &[(&str, Mask)]| {
            let mut masks = Masks::default();
            list.iter().for_each(|(photo, mask)| masks.put(photo, mask.clone()));
            masks
        };
        let drawn = |file: &str| mask(MaskOrigin::Drawn, file);
        let known = masks(&[("a.jpg", drawn("old")), ("a.jpg", layer("old")), ("c.jpg", layer("gone"))]);
        let mine = masks(&[("a.jpg", drawn("new")), ("a.jpg", layer("old")), ("c.jpg", layer("gone"))]);
        let now = masks(&[("a.jpg", drawn("old")), ("a.jpg", layer("home")), ("b.jpg", layer("first"))]);
        let all = masks(&[("a.jpg", drawn("new")), ("a.jpg", layer("home")), ("b.jpg", layer("first"))]);
        assert_eq!(mine.merged_with_changes(&known, &now), all);
        assert_eq!(mine.merged_with_changes(&known, &known), mine);
    }

    #[test]
    fn the_masks_of_a_tree_follow_its_name() {
        let tree = |name: &str| MaskOrigin::Tree(MaskedTree { name: name.into(), margin: 24, placing: None });
        let mut masks = Masks::default();
        masks.put("a.jpg", mask(tree("maple_1"), "a/1.png"));
        masks.put("a.jpg", mask(tree("maple_2"), "a/2.png"));
        masks.put("b.jpg", mask(tree("maple_1"), "b/1.png"));
        masks.put("b.jpg", mask(MaskOrigin::Drawn, "b/drawn.png"));
        masks.rename_tree("maple_1", "old one");
        let file = |photo: &str, name: &str| masks.find(photo, &tree(name)).map(|mask| mask.file.clone());
        assert_eq!(file("a.jpg", "old one").as_deref(), Some("a/1.png"));
        assert_eq!(file("b.jpg", "old one").as_deref(), Some("b/1.png"));
        assert_eq!(file("a.jpg", "maple_2").as_deref(), Some("a/2.png"));
        assert_eq!((file("a.jpg", "maple_1"), file("b.jpg", "maple_1")), (None, None));
        assert_eq!((masks.of("a.jpg").len(), masks.of("b.jpg").len()), (2, 2));
    }

    #[test]
    fn a_file_outside_of_the_folder_of_masks_is_a_problem() {
        for file in ["../a.png", "a/../../b.png", "/a.png", ""] {
            let mut masks = Masks::default();
            masks.put("a.jpg", mask(MaskOrigin::Drawn, file));
            assert!(masks.problem().is_some(), "{file}");
        }
    }
}
