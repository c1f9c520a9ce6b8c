//! The book `paint/trees/trees.json`: the paint of species, and what is needed to undo its imports (see `docs/formats.md`). It is
//! authored; the points are in files beside it.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::paint::IMPORTS_KEPT;

/// The version of the format that this program writes, and the only one that it reads.
pub const TREE_PAINT_VERSION: u32 = 1;

/// All paint of species without its points, and the last imports.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TreePaintBook {
    /// The format's version, [`TREE_PAINT_VERSION`].
    pub version: u32,
    /// The paint by layer of an edited file, in the order of imports.
    pub coats: Vec<TreeCoat>,
    /// The last [`IMPORTS_KEPT`] imports, oldest first.
    pub imports: Vec<TreeImport>,
}

impl Default for TreePaintBook {
    fn default() -> Self {
        Self { version: TREE_PAINT_VERSION, coats: Vec::new(), imports: Vec::new() }
    }
}

/// What was painted in one layer of an edited file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TreeCoat {
    /// The name of the species.
    pub species: String,
    /// The name of the sub-object that was painted; `None` for the whole plant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// The document in which it was painted: the export's key, `@`, and the file's path from the project.
    pub document: String,
    /// The token of the layer.
    pub layer: String,
    /// The number of the import.
    pub import: u32,
    /// The file of the points, below `paint/trees/`.
    pub file: String,
    /// The number of painted texels of the plant.
    pub texels: u64,
    /// Of these, the number of erased ones.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub erased: u64,
    /// The number of painted texels where the plant has nothing.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub beside: u64,
}

/// An import, with what is needed to undo it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TreeImport {
    /// The number, counted from 1.
    pub number: u32,
    /// The time in seconds since 1970, UTC.
    pub time: u64,
    /// The paths of the imported files from the project.
    pub files: Vec<String>,
    /// The species that were painted.
    pub species: BTreeSet<String>,
    /// The number of texels whose paint is new or was changed.
    pub texels: u64,
    /// The coats that it replaced or removed, as they were before.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub replaced: Vec<TreeCoat>,
}

fn is_zero(number: &u64) -> bool {
    *number == 0
}

impl TreePaintBook {
    /// Returns true when there is no paint and no import to undo.
    pub fn is_empty(&self) -> bool {
        self.coats.is_empty() && self.imports.is_empty()
    }

    /// Returns the number of the next import.
    pub fn next_import(&self) -> u32 {
        let coats = self.coats.iter().map(|coat| coat.import);
        coats.chain(self.imports.iter().map(|import| import.number)).max().unwrap_or(0) + 1
    }

    /// Returns all files that are referred to, by coats or by imports that can be undone.
    pub fn files(&self) -> BTreeSet<&str> {
        let replaced = self.imports.iter().flat_map(|import| &import.replaced);
        self.coats.iter().chain(replaced).map(|coat| coat.file.as_str()).collect()
    }

    /// Returns the coats of a species by the sub-object that was painted, in each those of one document together, documents in the
    /// order of their last imports.
    pub fn of_species(&self, species: &str) -> BTreeMap<Option<&str>, Vec<Vec<&TreeCoat>>> {
        let mut parts: BTreeMap<Option<&str>, Vec<Vec<&TreeCoat>>> = BTreeMap::new();
        for coat in self.coats.iter().filter(|coat| coat.species == species) {
            let documents = parts.entry(coat.part.as_deref()).or_default();
            match documents.iter_mut().find(|coats| coats[0].document == coat.document) {
                Some(coats) => coats.push(coat),
                None => documents.push(vec![coat]),
            }
        }
        for documents in parts.values_mut() {
            documents.sort_by_key(|coats| coats.iter().map(|coat| coat.import).max());
        }
        parts
    }

    /// Replaces the coat of a layer of a document, by none where nothing is painted any more; returns the one before. A coat of the
    /// same file stays as it is.
    pub fn set(&mut self, document: &str, layer: &str, coat: Option<TreeCoat>) -> Option<TreeCoat> {
        let index = self.coats.iter().position(|of| of.document == document && of.layer == layer);
        match (index, coat) {
            (Some(index), Some(coat)) if self.coats[index].file == coat.file => None,
            (index, coat) => {
                let before = index.map(|index| self.coats.remove(index));
                self.coats.extend(coat);
                before
            }
        }
    }

    /// Adds an import to the history and drops the oldest one beyond [`IMPORTS_KEPT`].
    pub fn remember(&mut self, import: TreeImport) {
        self.imports.push(import);
        let surplus = self.imports.len().saturating_sub(IMPORTS_KEPT);
        self.imports.drain(..surplus);
    }

    /// Undoes the last import; `None` when there is none. The coats that it added are removed, and those that it replaced restored.
    pub fn take_back(&mut self) -> Option<TreeImport> {
        let import = self.imports.pop()?;
        self.coats.retain(|coat| coat.import != import.number);
        self.coats.extend(import.replaced.iter().cloned());
        self.tidy();
        Some(import)
    }

    /// Sorts the coats by import.
    pub fn tidy(&mut self) {
        self.coats.sort_by(|a, b| (a.import, &a.document, &a.layer).cmp(&(b.import, &b.document, &b.layer)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coat(document: &str, layer: &str, import: u32, file: &str) -> TreeCoat {
        TreeCoat {
            species: "maple".into(),
            part: None,
            document: document.into(),
            layer: layer.into(),
            import,
            file: file.into(),
            texels: 5,
            erased: 0,
            beside: 0,
        }
    }

    fn import(number: u32, replaced: Vec<TreeCoat>) -> TreeImport {
        let (files, species) = (vec!["maple.psd".into()], ["maple".to_owned()].into());
        TreeImport { number, time: 0, files, species, texels: 1, replaced }
    }

    #[test]
    fn an_import_that_is_undone_leaves_the_book_as_it_was() {
        let mut book = TreePaintBook::default();
        for (layer, file) in [("a", "1"), ("b", "2"), ("c", "3")] {
            assert_eq!(book.set("k@maple.psd", layer, Some(coat("k@maple.psd", layer, 1, file))), None);
        }
        book.remember(import(1, Vec::new()));
        let before = book.clone();
        // One layer has other paint, one none any more, and one is as it was.
        let changed = [("a", Some("9")), ("b", None), ("c", Some("3"))];
        let replaced = changed.into_iter().filter_map(|(layer, file)| {
            book.set("k@maple.psd", layer, file.map(|file| coat("k@maple.psd", layer, 2, file)))
        });
        let replaced: Vec<TreeCoat> = replaced.collect();
        assert_eq!(replaced.len(), 2);
        book.remember(import(2, replaced));
        book.tidy();
        assert_eq!((book.coats.len(), book.next_import()), (2, 3));
        assert_eq!(book.files().len(), 4, "those of imports that can be undone are kept");
        assert_eq!(book.take_back().unwrap().number, 2);
        assert_eq!(book, before);
        book.take_back();
        assert!(book.is_empty() && book.take_back().is_none());
    }

    #[test]
    fn coats_of_one_file_are_together_and_files_are_in_the_order_of_their_last_imports() {
        let mut book = TreePaintBook::default();
        for (document, layer, number) in [("x", "a", 1), ("y", "a", 2), ("x", "b", 3)] {
            book.set(document, layer, Some(coat(document, layer, number, "f")));
        }
        let parts = book.of_species("maple");
        let documents: Vec<(&str, usize)> =
            parts[&None].iter().map(|coats| (&coats[0].document[..], coats.len())).collect();
        assert_eq!(documents, [("y", 1), ("x", 2)]);
        assert!(book.of_species("oak").is_empty());
    }
}
