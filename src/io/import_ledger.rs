//! Records which documents were already imported: `paint/taken.json`, for programs that watch a folder.
//!
//! The record holds the state of each document at its last import. A document that is still in that state is
//! not imported again when the project is opened: an import that was undone stays undone, while a save that
//! no program noticed is imported, whenever it was made.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::paint_store::{PaintStore, UNFINISHED};
use super::project::{below, relative_to};
use quadratura_base::error::{Error, Result};
use quadratura_files::atomic::{remove_leftovers, write_atomically};
use quadratura_files::json::{read_json, to_json};
use quadratura_files::stamp::Stamp;

/// The version that this program writes; it reads no other.
const VERSION: u32 = 1;
/// Limit on the size of the file in bytes; a thousand documents take some hundred KB.
const LARGEST: u64 = 1 << 24;
const REMEDY: &str = "remove the file; the documents in the watched folder are then imported once more";

/// The record of a project in memory. Writers must hold the project's lock.
#[derive(Debug)]
pub struct ImportLedger {
    project: PathBuf,
    list: BTreeMap<String, LedgerEntry>,
}

/// The content of the file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    version: u32,
    documents: BTreeMap<String, LedgerEntry>,
}

/// The state of a document when it was imported.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LedgerEntry {
    /// [`Stamp::token`] of the document.
    stamp: String,
    /// [`Stamp::content`] of the document; it also recognises a copy of a project, whose times differ.
    content: String,
}

impl ImportLedger {
    /// Reads the record of the project in the folder `project`; it is empty where there is none yet.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Input`] when the file is damaged or of another version.
    pub fn read(project: &Path) -> Result<Self> {
        let file = file_of(project);
        let mut taken = Self::none(project);
        if file.exists() {
            let found: File = read_json(&file, LARGEST, REMEDY)?;
            if found.version != VERSION {
                let found_version =
                    format!("version {}, this program reads version {VERSION}", found.version);
                return Err(Error::input(file, "version", found_version, REMEDY));
            }
            taken.list = found.documents;
        }
        Ok(taken)
    }

    /// Returns an empty record.
    pub fn none(project: &Path) -> Self {
        Self { project: project.to_path_buf(), list: BTreeMap::new() }
    }

    /// Returns whether a document is in the state in which it was imported.
    pub fn knows(&self, document: &Path, stamp: &Stamp) -> bool {
        self.list.get(&self.name_of(document)).is_some_and(|taken| {
            taken.stamp == stamp.token(document)
                || stamp.content(document).is_ok_and(|content| content == taken.content)
        })
    }

    /// Returns whether a document was imported before, in whatever state.
    pub fn has(&self, document: &Path) -> bool {
        self.list.contains_key(&self.name_of(document))
    }

    /// Adds a document that was imported in the state `stamp`. If it has changed meanwhile, it is left out,
    /// because its present content was not imported.
    ///
    /// # Errors
    /// [`Error::Io`] when the document can no longer be read; it is then left out, too.
    pub fn take(&mut self, document: &Path, stamp: &Stamp) -> Result<()> {
        let taken = LedgerEntry { stamp: stamp.token(document), content: stamp.content(document)? };
        if Stamp::from_path(document) == *stamp {
            self.list.insert(self.name_of(document), taken);
        }
        Ok(())
    }

    /// Adds documents with the states in which they were imported to the record of the project in the folder
    /// `project`, writes it, and returns it. A damaged record is replaced by a new one.
    ///
    /// # Errors
    /// [`Error::Io`]; the old file then stays.
    pub fn note(project: &Path, documents: &[(PathBuf, Stamp)]) -> Result<Self> {
        remove_leftovers_of_import(project)?;
        let mut taken = Self::read(project).unwrap_or_else(|_| Self::none(project));
        for (document, stamp) in documents {
            // A document that is gone or has changed will be imported by another save.
            let _ = taken.take(document, stamp);
        }
        taken.write()?;
        Ok(taken)
    }

    /// Writes the record, without documents that no longer exist.
    ///
    /// # Errors
    /// [`Error::Io`]; the old file then stays.
    pub fn write(&mut self) -> Result<()> {
        let project = &self.project;
        self.list.retain(|name, _| below(project, name).exists());
        let file = file_of(project);
        let folder = file.parent().unwrap_or(project);
        fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
        write_atomically(&file, &to_json(&File { version: VERSION, documents: self.list.clone() }))
    }

    /// Returns the document's path relative to the project, where there is one.
    fn name_of(&self, document: &Path) -> String {
        relative_to(&self.project, document).unwrap_or_else(|_| document.display().to_string())
    }
}

/// Removes what a killed program left behind. The caller must hold the project's lock.
///
/// # Errors
/// [`Error::Io`].
pub fn remove_leftovers_of_import(project: &Path) -> Result<()> {
    let paint = project.join("paint");
    if !paint.is_dir() {
        return Ok(());
    }
    if paint.join(UNFINISHED).is_file() {
        let store = PaintStore::new(project);
        let book = store.read()?;
        store.commit(&book, &book)?;
    }
    if paint.is_dir() { remove_leftovers(&paint) } else { Ok(()) }
}

fn file_of(project: &Path) -> PathBuf {
    project.join("paint").join("taken.json")
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, SystemTime};

    use super::*;
    use crate::documents::documents;

    fn knows(project: &Path, name: &str) -> bool {
        let document = project.join(name);
        let stamp = documents(project).unwrap().remove(&document).unwrap();
        ImportLedger::read(project).unwrap().knows(&document, &stamp)
    }

    fn set_time(file: &Path, time: SystemTime) {
        fs::File::options().append(true).open(file).unwrap().set_modified(time).unwrap();
    }

    #[test]
    fn a_document_is_known_as_it_was_taken_also_in_a_copy_and_not_when_it_was_saved_again() {
        let folder = tempfile::tempdir().unwrap();
        let (project, file) = (folder.path(), folder.path().join("a.psd"));
        fs::write(&file, "wall").unwrap();
        fs::write(project.join("b.psd"), "wall").unwrap();
        assert!(!knows(project, "a.psd"), "nothing is written yet");
        let mut taken = ImportLedger::read(project).unwrap();
        taken.take(&file, &documents(project).unwrap()[&file]).unwrap();
        taken.write().unwrap();
        assert!(knows(project, "a.psd") && !knows(project, "b.psd"));

        // Older or newer than the list: that says nothing.
        let copied = SystemTime::now() - Duration::from_secs(1000);
        set_time(&file, copied);
        assert!(knows(project, "a.psd"), "a copy has other times");
        fs::write(&file, "door").unwrap();
        set_time(&file, copied);
        assert!(!knows(project, "a.psd"));
    }

    #[test]
    fn documents_that_are_gone_are_forgotten_and_a_damaged_list_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let (project, file) = (folder.path(), folder.path().join("a.psd"));
        fs::write(&file, "wall").unwrap();
        let mut taken = ImportLedger::read(project).unwrap();
        taken.take(&file, &documents(project).unwrap()[&file]).unwrap();
        fs::remove_file(&file).unwrap();
        taken.write().unwrap();
        assert!(ImportLedger::read(project).unwrap().list.is_empty());
        fs::write(file_of(project), r#"{"version": 7, "documents": {}}"#).unwrap();
        let message = ImportLedger::read(project).unwrap_err().to_string();
        assert!(message.contains("taken.json") && message.contains("version 7"), "{message}");
    }
}
