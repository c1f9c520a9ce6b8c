//! The interface of camera formats, and the table of the formats that are read.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use super::assembly::Assembly;
use super::bundler::Bundler;
use super::colmap::Colmap;
use super::transforms::Transforms;
use quadratura_base::error::Result;
use quadratura_base::task::Task;

/// A format of calibrated cameras: the recognition of its files, and their reader. All code that reads cameras uses
/// [`FORMATS`]; a new format is an implementation of this trait and an entry there.
pub trait CameraFormat: Sync {
    /// Returns a name of its files for messages and help: `transforms.json of nerfstudio`.
    fn accepted(&self) -> &'static str;

    /// Returns the folders, below the one given by the user, in which the format's program puts its files.
    fn folders(&self) -> &'static [&'static str] {
        &[""]
    }

    /// Returns the extensions of its files, in lower case.
    fn extensions(&self) -> &'static [&'static str];

    /// Finds the files of the reconstruction to which `file` belongs. Returns `None` where the file is not of this
    /// format, and an error where it is, but other files of the reconstruction are missing. A file with the usual name
    /// of the format is of this format whatever it contains, so that the reader says what is wrong with it.
    fn of_file(&self, file: &Path) -> Option<Result<ReconstructionFiles>>;

    /// Finds the files of a reconstruction in a folder that contains files with these `names`, sorted.
    fn in_folder(&self, folder: &Path, names: &[String]) -> Option<Result<ReconstructionFiles>>;

    /// Reads the files into `assembly`.
    ///
    /// # Errors
    /// Returns an error when the rest of a file cannot be understood. Problems of single cameras, photos and points go
    /// to the assembly.
    fn read(&self, files: &ReconstructionFiles, assembly: &mut Assembly<'_>, task: &Task) -> Result<()>;
}

/// All formats. Of several in one folder, the first in this table is read.
static FORMATS: &[&dyn CameraFormat] = &[&Colmap, &Transforms, &Bundler];

static PLUGGED_IN: OnceLock<&dyn CameraFormat> = OnceLock::new();

/// Adds a format to the end of the table; the first one of a process counts. A test shows by it that a format needs nothing else.
pub fn plug_in(format: &'static dyn CameraFormat) {
    let _ = PLUGGED_IN.set(format);
}

/// The table, with the format that was plugged in.
pub(super) fn formats() -> impl Iterator<Item = &'static dyn CameraFormat> {
    FORMATS.iter().chain(PLUGGED_IN.get()).copied()
}

/// A format of the table. The order is that of the table: of two formats, the smaller one is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct FormatId(usize);

impl FormatId {
    /// Returns all formats, in their order.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        (0..formats().count()).map(Self)
    }

    /// Returns the format.
    pub(super) fn format(self) -> &'static dyn CameraFormat {
        formats().nth(self.0).expect("numbers are those of the table, which never gets shorter")
    }
}

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
