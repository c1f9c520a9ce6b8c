//! The interface of camera formats.

use std::path::Path;

use super::assembly::Assembly;
use super::reconstruction::ReconstructionFiles;
use quadratura_base::error::Result;
use quadratura_base::task::Task;

/// A format of calibrated cameras: the recognition of its files, and their reader. All code that reads cameras uses
/// the table in `formats`; a new format is an implementation of this trait and an entry there.
pub trait CameraFormat: Sync {
    /// Returns a name of its files for messages and help: `transforms.json of nerfstudio`.
    fn accepted(&self) -> &'static str;

    /// Returns the name of the program, or programs, that write its files.
    fn program(&self) -> &'static str {
        "another program"
    }

    /// Returns what is read of its files, and what is not, for `quadratura formats`.
    fn kept_and_lost(&self) -> [&'static str; 2] {
        ["cameras", ""]
    }

    /// Returns the folders, below the one given by the user, in which the format's program puts its files.
    fn folders(&self) -> &'static [&'static str] {
        &[""]
    }

    /// Returns the extensions of its files, in lower case.
    fn extensions(&self) -> &'static [&'static str];

    /// Returns whether its files may hold several reconstructions with names.
    fn has_chunks(&self) -> bool {
        false
    }

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
