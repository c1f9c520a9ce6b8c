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

    /// Returns the first of the files that a format found in a folder, with a note where there are several.
    pub fn first_of(found: &[PathBuf]) -> Option<Self> {
        let mut first = Self::one(found.first()?);
        first.note_instead_of(&found[1..]);
        Some(first)
    }

    /// Notes which files are there, too, and are not read.
    pub fn note_instead_of(&mut self, others: &[PathBuf]) {
        if !others.is_empty() {
            let names: Vec<String> = others.iter().map(|other| other.display().to_string()).collect();
            let (used, others) = (self.images.display(), names.join(" and "));
            self.notes.push(format!("{used}: read instead of {others}; to use that, give the file itself"));
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_several_files_is_read_and_says_which_are_not() {
        let found: Vec<PathBuf> = ["a.sfm", "b.sfm", "c.sfm"].map(PathBuf::from).into();
        let first = ReconstructionFiles::first_of(&found).unwrap();
        assert_eq!(first.images, found[0]);
        assert_eq!(
            first.notes,
            ["a.sfm: read instead of b.sfm and c.sfm; to use that, give the file itself"]
        );
        assert!(ReconstructionFiles::first_of(&found[..1]).unwrap().notes.is_empty());
        assert_eq!(ReconstructionFiles::first_of(&[]), None);
    }
}
