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

    /// These, but with the layers of edited files that `other` has: what came home with paint, or went with it, without
    /// what else was decided meanwhile.
    pub fn with_layers_of(&self, other: &Self) -> Self {
        let is_layer = |mask: &Mask| matches!(mask.from, MaskFrom::Layer(_));
        let mut masks = Self::default();
        let own = self.photos().map(|(photo, of)| (photo, of, false));
        for (photo, of, layers) in own.chain(other.photos().map(|(photo, of)| (photo, of, true))) {
            of.iter().filter(|mask| is_layer(mask) == layers).for_each(|mask| masks.put(photo, mask.clone()));
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
    fn masks_come_home_with_paint_and_what_was_drawn_meanwhile_stays() {
        let layer = |file: &str| mask(MaskFrom::Layer("9@a.psd".into()), file);
        let (mut mine, mut saved) = (Masks::default(), Masks::default());
        mine.put("a.jpg", mask(MaskFrom::Drawn, "new"));
        mine.put("a.jpg", layer("old layer"));
        saved.put("a.jpg", mask(MaskFrom::Drawn, "old"));
        saved.put("b.jpg", layer("new layer"));
        let mut expected = Masks::default();
        expected.put("a.jpg", mask(MaskFrom::Drawn, "new"));
        expected.put("b.jpg", layer("new layer"));
        assert_eq!(mine.with_layers_of(&saved), expected);
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
