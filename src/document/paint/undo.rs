//! Undoing imports: the last one, or an earlier one on which no later one depends.

use std::collections::BTreeSet;
use std::fmt;

use super::{PaintBook, PaintImport, PaintedDocument};

/// Why an import cannot be undone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NotUndone {
    /// No import of this number can be undone.
    Unknown(u32),
    /// A later import changed what this one brought.
    Needed {
        /// The number of the import.
        number: u32,
        /// The number of the later one.
        by: u32,
    },
}

impl fmt::Display for NotUndone {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Unknown(number) => {
                write!(
                    f,
                    "there is no import {number} to undo; `import --history` lists those that there are"
                )
            }
            Self::Needed { number, by } => write!(
                f,
                "import {number} cannot be undone alone: import {by} changed the same layers, paint or mask; undo import {by} first"
            ),
        }
    }
}

impl PaintBook {
    /// Undoes the last import; `None` when there is none.
    pub fn take_back(&mut self) -> Option<PaintImport> {
        let last = self.imports.last()?.number;
        self.take_back_one(last).ok()
    }

    /// Undoes an import. The entries that it added are removed, those that it replaced are restored, and the layers of
    /// the edited files are known as they were before.
    ///
    /// # Errors
    /// Returns [`NotUndone`] where there is no such import, or a later one depends on it; the book is then unchanged.
    pub fn take_back_one(&mut self, number: u32) -> Result<PaintImport, NotUndone> {
        let index = self.imports.iter().position(|import| import.number == number);
        let index = index.ok_or(NotUndone::Unknown(number))?;
        let mut later = index + 1..self.imports.len();
        if let Some(by) = later.find(|later| self.depends(*later, index)) {
            return Err(NotUndone::Needed { number, by: self.imports[by].number });
        }
        let layers = self.layers_of(index);
        let import = self.imports.remove(index);
        self.entries.retain(|entry| !import.added.contains(&entry.name()));
        self.entries.extend(import.replaced.iter().cloned());
        for (key, layer) in layers {
            let before =
                import.documents.get(&key).and_then(Option::as_ref).and_then(|of| of.layers.get(&layer));
            let restore = |document: Option<PaintedDocument>| {
                let mut document = document.unwrap_or_default();
                match before {
                    Some(before) => drop(document.layers.insert(layer.clone(), before.clone())),
                    None => drop(document.layers.remove(&layer)),
                }
                (!document.layers.is_empty()).then_some(document)
            };
            if let Some(document) = restore(self.documents.remove(&key)) {
                self.documents.insert(key.clone(), document);
            }
            // Undone themselves, later imports do not bring back what this one had made known.
            for later in &mut self.imports[index..] {
                if let Some(document) = later.documents.get_mut(&key) {
                    *document = restore(document.take());
                }
            }
        }
        for (key, before) in &import.documents {
            let without_layers = |document: &PaintedDocument| document.layers.is_empty();
            if before.is_none() && self.documents.get(key).is_some_and(without_layers) {
                self.documents.remove(key);
            }
        }
        self.tidy();
        Ok(import)
    }

    /// Returns true when the import at `later` changed what the one at `index` brought.
    fn depends(&self, later: usize, index: usize) -> bool {
        let (newer, older) = (&self.imports[later], &self.imports[index]);
        let paint = newer.replaced.iter().any(|entry| older.added.contains(&entry.name()));
        let same_mask = |mask: &super::ImportedMask| {
            older.masks.iter().any(|other| other.photo == mask.photo && other.from == mask.from)
        };
        paint
            || newer.masks.iter().any(same_mask)
            || !self.layers_of(later).is_disjoint(&self.layers_of(index))
    }

    /// Returns the layers of edited files, each with the file's key, whose state the import at `index` changed.
    fn layers_of(&self, index: usize) -> BTreeSet<(String, String)> {
        let mut layers = BTreeSet::new();
        for (key, before) in &self.imports[index].documents {
            let next = self.imports[index + 1..].iter().find_map(|later| later.documents.get(key));
            let after = next.map_or_else(|| self.documents.get(key), Option::as_ref);
            let state = |document: Option<&PaintedDocument>, layer: &str| {
                document.and_then(|document| document.layers.get(layer)).cloned()
            };
            let names = [before.as_ref(), after].into_iter().flatten().flat_map(|of| of.layers.keys());
            let changed = names.filter(|layer| state(before.as_ref(), layer) != state(after, layer));
            layers.extend(changed.map(|layer| (key.clone(), layer.clone())));
        }
        layers
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::paint::{PaintEntry, PaintedLayer};
    use quadratura_base::geometry::PixelRect;
    use quadratura_base::scene::FaceIndex;

    fn entry(layer: &str, import: u32) -> PaintEntry {
        PaintEntry {
            photo: "a.png".into(),
            object: "wall".into(),
            face: Some(FaceIndex(0)),
            triangle: None,
            beyond: false,
            layer: layer.into(),
            document: "k1".into(),
            import,
            view: "v1".into(),
            outline: vec![],
            file: format!("{layer}-{import}"),
            rect: PixelRect::of_size(1, 1),
            pixels: 1,
        }
    }

    /// Imports paint on layers of one file, each of which replaces the layer's paint.
    fn book(imports: &[(u32, &[&str])]) -> PaintBook {
        let mut book = PaintBook::default();
        for (number, layers) in imports {
            let before = book.documents.get("k1").cloned();
            let (mut replaced, mut document) = (vec![], before.clone().unwrap_or_default());
            for layer in *layers {
                replaced.extend(book.entries.iter().filter(|entry| entry.layer == *layer).cloned());
                book.entries.retain(|entry| entry.layer != *layer);
                book.entries.push(entry(layer, *number));
                let shown = format!("{number}");
                document.layers.insert((*layer).into(), PaintedLayer { shown, painted: 1, erased: 0 });
            }
            book.documents.insert("k1".into(), document);
            book.remember(PaintImport {
                number: *number,
                time: 0,
                files: vec![],
                photos: vec![],
                pixels: 0,
                added: layers.iter().map(|layer| entry(layer, *number).name()).collect(),
                replaced,
                documents: BTreeMap::from([("k1".into(), before)]),
                masks: vec![],
                brush: None,
            });
            book.tidy();
        }
        book
    }

    #[test]
    fn an_import_is_undone_out_of_order_as_if_it_had_not_been() {
        let mut undone = book(&[(1, &["t1"]), (2, &["t2", "t3"]), (3, &["t1"])]);
        assert_eq!(undone.take_back_one(2).unwrap().number, 2);
        assert_eq!(undone, book(&[(1, &["t1"]), (3, &["t1"])]));
        assert_eq!(undone.take_back_one(3).unwrap().number, 3);
        assert_eq!(undone, book(&[(1, &["t1"])]), "the layers of import 2 do not come back");
    }

    #[test]
    fn an_import_on_which_a_later_one_depends_is_not_undone() {
        let before = book(&[(1, &["t1"]), (2, &["t2"]), (3, &["t1"])]);
        let mut undone = before.clone();
        assert_eq!(undone.take_back_one(1), Err(NotUndone::Needed { number: 1, by: 3 }));
        assert_eq!(undone.take_back_one(7), Err(NotUndone::Unknown(7)));
        assert_eq!(undone, before);
        undone.take_back_one(3).unwrap();
        undone.take_back_one(1).unwrap();
        assert_eq!(undone, book(&[(2, &["t2"])]));
    }
}
