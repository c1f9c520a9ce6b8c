//! Stores the records of exports, `exports/<document key>.json`. They also answer whether an exported file is
//! still as it was written.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::baselines::Baselines;
use quadratura_base::error::{Error, Result};
use quadratura_document::export_record::{ExportRecord, ExportedFile, RECORD_VERSION};
use quadratura_files::atomic::write_atomically;
use quadratura_files::hash::hash_file;
use quadratura_files::json::{read_json, to_json};

/// The pixels of this many exports of each photo are kept. Each is linked from a stack as long as the stack
/// exists; files that were exported earlier have to be exported again before they can be painted on.
const EXPORTS_WITH_PIXELS: usize = 8;
/// Larger files are not records of this program.
const LARGEST_RECORD: u64 = 1 << 28;
const REMEDY: &str = "move it away; files exported with it are then taken for changed ones";

/// The folder `exports/` with its records.
#[derive(Debug, Clone)]
pub struct ExportStore {
    folder: PathBuf,
}

/// The files that exports wrote, with their photos.
#[derive(Debug, Clone, Default)]
pub struct WrittenFiles {
    /// Pairs of photo name and BLAKE3 of the content, sorted.
    list: Vec<(String, String)>,
}

impl ExportStore {
    /// Returns the store of records in `folder`, which need not exist yet.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into() }
    }

    /// Reads all records, sorted by key. The second list holds an error for each record that cannot be read.
    ///
    /// # Errors
    /// [`Error::Io`] when the folder exists and cannot be read.
    pub fn read_all(&self) -> Result<(Vec<ExportRecord>, Vec<Error>)> {
        let mut records = Vec::new();
        let mut problems = Vec::new();
        for file in self.files()? {
            match read(&file) {
                Ok(record) => records.push(record),
                Err(problem) => problems.push(problem),
            }
        }
        Ok((records, problems))
    }

    /// Writes a record. The files that an earlier record of the same key lists are kept in it.
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn write(&self, mut record: ExportRecord) -> Result<()> {
        fs::create_dir_all(&self.folder).map_err(Error::io(&self.folder, "create the folder"))?;
        let file = self.folder.join(format!("{}.json", record.key));
        if let Ok(before) = read(&file) {
            record.files.extend(before.files);
        }
        write_atomically(&file, &to_json(&record))
    }

    /// Removes stored pixels that no record names and those of all but the newest exports of each photo
    /// (`EXPORTS_WITH_PIXELS`).
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn remove_old_pixels(&self, kept: &Baselines) -> Result<()> {
        let mut by_age: Vec<_> = self.files()?.into_iter().map(|file| (written_at(&file), file)).collect();
        by_age.sort();
        let mut exports: BTreeMap<String, usize> = BTreeMap::new();
        let mut names = BTreeSet::new();
        for (_, file) in by_age.into_iter().rev() {
            // A record that cannot be read may need any of the pixels, so all stay.
            let Ok(record) = read(&file) else { return Ok(()) };
            let count = exports.entry(record.photo.name.clone()).or_default();
            *count += 1;
            if *count <= EXPORTS_WITH_PIXELS {
                names.extend(record.layers.into_iter().map(|layer| layer.baseline.file));
                names.extend(record.profile);
                names.extend(record.tree.into_iter().flat_map(|tree| tree.samples));
            }
        }
        kept.retain(&names)
    }

    fn files(&self) -> Result<Vec<PathBuf>> {
        if !self.folder.is_dir() {
            return Ok(Vec::new());
        }
        let mut files = Vec::new();
        for entry in fs::read_dir(&self.folder).map_err(Error::io(&self.folder, "read the folder"))? {
            let path = entry.map_err(Error::io(&self.folder, "read the folder"))?.path();
            let hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
            if path.extension().is_some_and(|extension| extension == "json") && !hidden {
                files.push(path);
            }
        }
        files.sort();
        Ok(files)
    }
}

/// Returns when a record was last written; `None`, which sorts as the oldest, where the system does not say.
fn written_at(file: &Path) -> Option<SystemTime> {
    fs::metadata(file).and_then(|metadata| metadata.modified()).ok()
}

fn read(file: &Path) -> Result<ExportRecord> {
    let record: ExportRecord = read_json(file, LARGEST_RECORD, REMEDY)?;
    if record.version != RECORD_VERSION {
        let found = format!("version {}, this program reads version {RECORD_VERSION}", record.version);
        return Err(Error::input(file, "version", found, REMEDY));
    }
    Ok(record)
}

impl WrittenFiles {
    /// Collects the content hashes of all files that `records` list, each with the name of its photo.
    pub fn from_records(records: &[ExportRecord]) -> Self {
        let of_record = |record: &ExportRecord| {
            let hashes = record.files.iter().map(|file| file.hash.clone());
            hashes.map(|hash| (record.photo.name.clone(), hash)).collect::<Vec<_>>()
        };
        let mut list: Vec<_> = records.iter().flat_map(of_record).collect();
        list.sort();
        Self { list }
    }

    /// Returns whether the file at `path` is an unchanged export of `photo`.
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be read.
    pub fn contains_unchanged(&self, photo: &str, path: &Path) -> Result<bool> {
        Ok(self.list.binary_search(&(photo.to_owned(), hash_file(path)?)).is_ok())
    }
}

/// Describes the file `name` below `folder` as a record lists it: its name and hash.
///
/// # Errors
/// [`Error::Io`] when it cannot be read.
pub fn exported_file(folder: &Path, name: &str) -> Result<ExportedFile> {
    Ok(ExportedFile { name: name.to_owned(), hash: hash_file(folder.join(name))? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_document::export_record::ExportFormat;
    use quadratura_document::stack::{StackCamera, StackPhoto};

    fn record(key: &str, photo: &str, files: &[(&str, &str)]) -> ExportRecord {
        let file = |&(name, content): &(&str, &str)| ExportedFile {
            name: name.into(),
            hash: quadratura_files::hash::hash_bytes(content.as_bytes()),
        };
        ExportRecord {
            version: RECORD_VERSION,
            key: key.into(),
            format: ExportFormat::Psd,
            photo: StackPhoto { name: photo.into(), width: 2, height: 3 },
            camera: StackCamera { K: [[1.0; 3]; 3], R: [[0.0; 3]; 3], t: [0.5; 3] },
            depth: 8,
            inputs: "i".into(),
            files: files.iter().map(file).collect(),
            evened: None,
            layers: vec![],
            helpers: vec![],
            pieces: vec![],
            surfaces: vec![],
            paint: BTreeSet::new(),
            profile: None,
            tree: None,
        }
    }

    #[test]
    fn a_record_comes_back_and_keeps_the_files_of_the_one_before() {
        let folder = tempfile::tempdir().unwrap();
        let store = ExportStore::new(folder.path().join("exports"));
        store.write(record("k1", "a.png", &[("a.png.psd", "old")])).unwrap();
        store.write(record("k1", "a.png", &[("a.png.psd", "new")])).unwrap();
        let both = record("k1", "a.png", &[("a.png.psd", "old"), ("a.png.psd", "new")]);
        assert_eq!(store.read_all().unwrap().0, [both]);
    }

    #[test]
    fn a_file_is_known_by_its_content_and_its_photo() {
        let folder = tempfile::tempdir().unwrap();
        let written = WrittenFiles::from_records(&[record("k1", "a.png", &[("a.png.psd", "ours")])]);
        let file = folder.path().join("any name");
        fs::write(&file, "ours").unwrap();
        assert!(written.contains_unchanged("a.png", &file).unwrap());
        assert!(!written.contains_unchanged("b.png", &file).unwrap());
        fs::write(&file, "painted").unwrap();
        assert!(!written.contains_unchanged("a.png", &file).unwrap());
    }

    #[test]
    fn a_broken_record_is_said_and_the_others_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let store = ExportStore::new(folder.path());
        store.write(record("k1", "a.png", &[])).unwrap();
        fs::write(folder.path().join("broken.json"), "{").unwrap();
        let (records, problems) = store.read_all().unwrap();
        assert_eq!(records.len(), 1);
        assert!(problems[0].to_string().contains("broken.json"));
    }

    #[test]
    fn a_folder_that_does_not_exist_holds_no_records() {
        let (records, problems) = ExportStore::new("/no/such/folder").read_all().unwrap();
        assert!(records.is_empty() && problems.is_empty());
    }
}
