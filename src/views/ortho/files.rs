//! The files of an orthophoto: what a user made or changed is never overwritten.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use quadratura_base::error::Result;
use quadratura_files::hash::hash_file;
use quadratura_files::json::{read_json, to_json};

use super::report::OrthoReport;

/// The endings of the files of an orthophoto.
pub(super) const ENDINGS: [&str; 5] = ["tif", "png", "pdf", "provenance.png", "json"];

/// The most bytes of a file that describes an orthophoto.
const LARGEST: u64 = 1 << 20;

/// The part of `NAME.json` that tells whether the files are as they were written.
#[derive(Debug, Deserialize)]
struct Described {
    hashes: BTreeMap<String, String>,
}

/// What `NAME.json` holds.
#[derive(Debug, Serialize)]
struct Description<'a> {
    /// The version of this file's format.
    version: u32,
    #[serde(flatten)]
    report: &'a OrthoReport,
    /// The hashes of the other files, by which files that were changed are recognised.
    hashes: BTreeMap<String, String>,
}

/// The name without ending that files get, and what was spared for it.
pub(super) struct Stem {
    pub path: PathBuf,
    pub spared: Option<PathBuf>,
}

impl Stem {
    /// Chooses the first of `NAME`, `NAME-2` and so on, of which there is no file but those of an orthophoto that nobody changed, and none
    /// without one of these `endings`, which are to be written.
    pub fn free(folder: &Path, name: &str, endings: &[&str]) -> Self {
        let numbered = (1u32..).map(|number| match number {
            1 => folder.join(name),
            number => folder.join(format!("{name}-{number}")),
        });
        let path = numbered.into_iter().find(|stem| may_be_replaced(stem, endings));
        let path = path.expect("there is a number that no file has");
        let first = folder.join(name);
        Self { spared: (path != first).then_some(first), path }
    }

    /// Returns the path of a file.
    pub fn with(&self, ending: &str) -> PathBuf {
        with(&self.path, ending)
    }

    /// Writes the description of the files.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn describe(&self, report: &OrthoReport) -> Result<()> {
        let mut hashes = BTreeMap::new();
        for ending in ENDINGS.into_iter().filter(|ending| *ending != "json") {
            let path = self.with(ending);
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if report.files.contains(&name) {
                hashes.insert(name, hash_file(&path)?);
            }
        }
        let description = Description { version: 1, report, hashes };
        quadratura_files::atomic::write_atomically(self.with("json"), &to_json(&description))
    }
}

fn with(stem: &Path, ending: &str) -> PathBuf {
    let mut name = stem.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{ending}"));
    stem.with_file_name(name)
}

/// Returns whether there are no files of this name, or only those of an orthophoto as it was written, all with one of these endings.
fn may_be_replaced(stem: &Path, endings: &[&str]) -> bool {
    let is_present = |ending: &&&str| with(stem, ending).symlink_metadata().is_ok();
    let present: Vec<&str> = ENDINGS.iter().filter(is_present).copied().collect();
    if present.is_empty() {
        return true;
    }
    if present.iter().any(|ending| !endings.contains(ending)) {
        return false;
    }
    let present: Vec<PathBuf> = present.into_iter().map(|ending| with(stem, ending)).collect();
    let description = with(stem, "json");
    let Ok(Described { hashes }) = read_json::<Described>(&description, LARGEST, "remove it") else {
        return false;
    };
    let is_unchanged = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        *path == description
            || hashes.get(&*name).is_some_and(|hash| hash_file(path).is_ok_and(|is| is == *hash))
    };
    present.iter().all(is_unchanged)
}
