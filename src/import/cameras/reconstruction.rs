//! The files of one reconstruction.

use std::path::{Path, PathBuf};

/// The files of one reconstruction; several may be the same.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReconstructionFiles {
    /// The file with lenses and sizes.
    pub cameras: PathBuf,
    /// The file with the photos' poses.
    pub images: PathBuf,
    /// The file with the points.
    pub points: Option<PathBuf>,
    /// Other files that are read.
    pub others: Vec<PathBuf>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

impl ReconstructionFiles {
    /// Creates the value for a format with a single file.
    pub fn one(file: &Path) -> Self {
        let file = file.to_path_buf();
        Self { cameras: file.clone(), images: file, points: None, others: Vec::new(), notes: Vec::new() }
    }

    /// Returns all files, without duplicates.
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
