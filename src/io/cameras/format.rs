//! What a format of cameras is, and the table of those that are read.

use std::path::{Path, PathBuf};

use super::assembly::Assembly;
use super::bundler::Bundler;
use super::colmap::Colmap;
use super::transforms::Transforms;
use crate::error::Result;
use crate::task::Task;

/// A format of calibrated cameras: how its files are recognised, and their reader. Whatever reads cameras goes through
/// [`FORMATS`]; to add a format, write one of these and name it there.
pub(super) trait CameraFormat: Sync {
    /// What its files are called, for messages and help: `Bundler's .out file with list.txt beside it`.
    fn accepted(&self) -> &'static str;

    /// Folders below the one that people name in which the format's own program puts its files.
    fn folders(&self) -> &'static [&'static str] {
        &[""]
    }

    /// The files of the reconstruction that `file` belongs to. `None` where it is not of this format; an error where it
    /// is, and others that belong to it are not there.
    fn of_file(&self, file: &Path) -> Option<Result<Files>>;

    /// The same for a folder that holds files of these `names`, sorted.
    fn in_folder(&self, folder: &Path, names: &[String]) -> Option<Result<Files>>;

    /// Reads the files into `assembly`.
    ///
    /// # Errors
    /// What makes the rest of a file impossible to understand; what is wrong with one camera, photo or point goes to
    /// the assembly.
    fn read(&self, files: &Files, assembly: &mut Assembly<'_>, task: &Task) -> Result<()>;
}

/// All formats. Where a folder holds several, the first of these is read.
pub(super) static FORMATS: &[&dyn CameraFormat] = &[
    &Colmap,
    &Transforms,
    &Bundler,
    #[cfg(test)]
    &super::dummy::Dummy,
];

/// The files of one reconstruction; several may be the same.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Files {
    /// The file with lenses and sizes.
    pub cameras: PathBuf,
    /// The file with the photos' poses.
    pub images: PathBuf,
    /// The file with the points.
    pub points: Option<PathBuf>,
    /// Others that are read.
    pub others: Vec<PathBuf>,
    /// What the user should know.
    pub notes: Vec<String>,
}

impl Files {
    /// Of a format that has all in one file.
    pub fn one(file: &Path) -> Self {
        let file = file.to_path_buf();
        Self { cameras: file.clone(), images: file, points: None, others: Vec::new(), notes: Vec::new() }
    }

    /// All of them, each once.
    pub fn all(self) -> Vec<PathBuf> {
        let mut all = vec![self.cameras];
        for file in std::iter::once(self.images).chain(self.points).chain(self.others) {
            if !all.contains(&file) {
                all.push(file);
            }
        }
        all
    }
}
