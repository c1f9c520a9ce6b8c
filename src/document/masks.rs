//! What is masked in the photos: `masks` of `project.json`. The pixels are in files that are never changed, so
//! that a copy of this is all that is needed to undo an edit.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

/// All masks of a project, by photo.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Masks(BTreeMap<String, Vec<Mask>>);

/// One of a photo's masks: what any of them covers is no content of the photo.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mask {
    /// Who made it; a photo has one mask of each maker.
    pub from: MaskFrom,
    /// PNG as large as the photo's pinhole image, black is masked; below the project's `masks/`.
    pub file: String,
    /// Masked pixels.
    pub pixels: u64,
}

/// What an import did to one mask.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MaskChange {
    /// The photo.
    pub photo: String,
    /// Whose mask it is.
    pub from: MaskFrom,
    /// As it was; none where there was nothing.
    pub before: Option<Mask>,
    /// As it is; none where nothing is left.
    pub after: Option<Mask>,
}

/// Who made a mask. The order is that of lists.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MaskFrom {
    /// A file of this name.
    File(String),
    /// What the photo shows of some objects, and what is near it.
    Object(MaskedObject),
    /// A layer called `mask` of an edited file: its export's key, `@`, and its path from the project.
    Layer(String),
    /// Suggestions that were accepted.
    Suggested,
    /// Somebody's hand in the editor.
    Drawn,
}

/// Pixels of objects.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaskedObject {
    /// A name, or the beginning of names with `*` behind.
    pub name: String,
    /// How far around them, in pixels of the photo.
    pub margin: u32,
}

impl MaskFrom {
    /// Two masks of the same maker cannot be: the later one stands for both. A margin makes no other maker.
    fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Object(a), Self::Object(b)) => a.name == b.name,
            (a, b) => a == b,
        }
    }

    /// In a few words.
    pub fn words(&self) -> String {
        match self {
            Self::File(name) => format!("file {name}"),
            Self::Object(MaskedObject { name, margin }) => format!("object {name}, margin {margin}"),
            Self::Layer(document) => {
                format!("layer of {}", document.split_once('@').map_or(document.as_str(), |(_, path)| path))
            }
            Self::Suggested => "suggested".into(),
            Self::Drawn => "drawn".into(),
        }
    }

    /// A short name for a file.
    pub fn stem(&self) -> &str {
        match self {
            Self::File(name) => name.rsplit('/').next().unwrap_or(name),
            Self::Object(MaskedObject { name, .. }) => name,
            Self::Layer(_) => "layer",
            Self::Suggested => "suggested",
            Self::Drawn => "drawn",
        }
    }
}

impl Masks {
    /// Nothing is masked.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The photos with masks, in alphabetical order, whether the project still has them or not.
    pub fn photos(&self) -> impl Iterator<Item = (&str, &[Mask])> {
        self.0.iter().map(|(photo, masks)| (photo.as_str(), masks.as_slice()))
    }

    /// Those of a photo.
    pub fn of(&self, photo: &str) -> &[Mask] {
        self.0.get(photo).map_or(&[], Vec::as_slice)
    }

    /// The one that somebody made of a photo.
    pub fn find(&self, photo: &str, from: &MaskFrom) -> Option<&Mask> {
        self.of(photo).iter().find(|mask| mask.from.is_same(from))
    }

    /// Puts a mask in the place of what the same maker had made of the photo.
    pub fn put(&mut self, photo: &str, mask: Mask) {
        self.remove(photo, &mask.from);
        let masks = self.0.entry(photo.to_owned()).or_default();
        masks.push(mask);
        masks.sort_by(|a, b| a.from.cmp(&b.from));
    }

    /// Takes away what somebody had made of a photo, and says what that was.
    pub fn remove(&mut self, photo: &str, from: &MaskFrom) -> Option<Mask> {
        let masks = self.0.get_mut(photo)?;
        let place = masks.iter().position(|mask| mask.from.is_same(from));
        let removed = place.map(|place| masks.remove(place));
        if masks.is_empty() {
            self.0.remove(photo);
        }
        removed
    }

    /// Takes away all masks of a photo.
    pub fn clear(&mut self, photo: &str) {
        self.0.remove(photo);
    }

    /// Puts a mask in its maker's place, or takes away what is there.
    pub fn set(&mut self, photo: &str, from: &MaskFrom, mask: Option<Mask>) {
        match mask {
            Some(mask) => self.put(photo, mask),
            None => drop(self.remove(photo, from)),
        }
    }

    /// These, with what somebody else made of `known` meanwhile: of masks that are otherwise in `now`, those.
    pub fn with_news(&self, known: &Self, now: &Self) -> Self {
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

    /// The files that are named.
    pub fn files(&self) -> BTreeSet<&str> {
        self.0.values().flatten().map(|mask| mask.file.as_str()).collect()
    }

    /// A file that lies somewhere else, and what is expected.
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

    fn mask(from: MaskFrom, file: &str) -> Mask {
        Mask { from, file: file.into(), pixels: 3 }
    }

    fn tractor(margin: u32) -> MaskFrom {
        MaskFrom::Object(MaskedObject { name: "tractor*".into(), margin })
    }

    #[test]
    fn masks_are_written_readably_and_come_back() {
        let mut masks = Masks::default();
        masks.put("a.jpg", mask(MaskFrom::Suggested, "a.jpg/s-1.png"));
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
        masks.put("a.jpg", mask(MaskFrom::Drawn, "3"));
        assert_eq!(masks.of("a.jpg").len(), 2);
        assert_eq!(masks.find("a.jpg", &tractor(0)).unwrap().file, "2");
        assert_eq!(masks.remove("a.jpg", &tractor(1)).unwrap().file, "2");
        assert_eq!(masks.remove("a.jpg", &tractor(1)), None);
        masks.remove("a.jpg", &MaskFrom::Drawn);
        assert!(masks.is_empty());
    }

    #[test]
    fn what_somebody_else_made_meanwhile_is_taken_and_nothing_else() {
        let layer = |file: &str| mask(MaskFrom::Layer("9@a.psd".into()), file);
        let masks = |list: &[(&str, Mask)]| {
            let mut masks = Masks::default();
            list.iter().for_each(|(photo, mask)| masks.put(photo, mask.clone()));
            masks
        };
        let drawn = |file: &str| mask(MaskFrom::Drawn, file);
        let known = masks(&[("a.jpg", drawn("old")), ("a.jpg", layer("old")), ("c.jpg", layer("gone"))]);
        let mine = masks(&[("a.jpg", drawn("new")), ("a.jpg", layer("old")), ("c.jpg", layer("gone"))]);
        let now = masks(&[("a.jpg", drawn("old")), ("a.jpg", layer("home")), ("b.jpg", layer("first"))]);
        let all = masks(&[("a.jpg", drawn("new")), ("a.jpg", layer("home")), ("b.jpg", layer("first"))]);
        assert_eq!(mine.with_news(&known, &now), all);
        assert_eq!(mine.with_news(&known, &known), mine);
    }

    #[test]
    fn a_file_outside_of_the_folder_of_masks_is_a_problem() {
        for file in ["../a.png", "a/../../b.png", "/a.png", ""] {
            let mut masks = Masks::default();
            masks.put("a.jpg", mask(MaskFrom::Drawn, file));
            assert!(masks.problem().is_some(), "{file}");
        }
    }
}
