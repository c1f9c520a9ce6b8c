//! The destination of an export, which never overwrites anything that was changed since its export.

use std::path::{Path, PathBuf};

use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_document::names::file_name_of_photo;
use quadratura_files::inbox::move_to_inbox;
use quadratura_files::stamp::Stamp;
use quadratura_io::exports::WrittenFiles;
use quadratura_io::import_ledger::ImportLedger;
use quadratura_io::stack_store::DESKTOP_FILES;

/// The extension of a folder of layers. It is not the name of an image format, because people and tools would take
/// the folder for a file.
pub const FOLDER: &str = "layers";

/// The destination of an export.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExportDestination {
    /// The file or folder to write; anything that exists there is an unchanged export of this program.
    pub target: PathBuf,
    /// Existing files that the export would have overwritten, but that were changed since.
    pub spared: Vec<PathBuf>,
}

/// Finds a destination for the export of `photo` in `out`: `<photo>.EXTENSION`, or `<photo>-2.EXTENSION` and so on
/// where earlier ones were changed. The extension [`FOLDER`] stands for a folder.
///
/// # Errors
/// Returns [`Error::Io`] when existing files cannot be read.
pub fn find(out: &Path, photo: &str, extension: &str, written: &WrittenFiles) -> Result<ExportDestination> {
    let stem = file_name_of_photo(photo);
    let mut spared = Vec::new();
    for number in 1u32.. {
        let suffix = if number == 1 { String::new() } else { format!("-{number}") };
        let target = out.join(format!("{stem}{suffix}.{extension}"));
        if !target.try_exists().map_err(Error::io(&target, "look at it"))?
            || is_ours(&target, photo, extension == FOLDER, written)?
        {
            return Ok(ExportDestination { target, spared });
        }
        spared.push(target);
    }
    Err(Error::Request(format!("{}: no free name for {photo}", out.display())))
}

/// Moves the folder of `photo` in `out` to the project's inbox where it was painted on and is in the state in which it was imported, so
/// that a new one can take its place.
///
/// # Errors
/// Returns [`Error::Io`].
pub fn put_away(project: &Path, out: &Path, photo: &str, written: &WrittenFiles, task: &Task) -> Result<()> {
    let target = out.join(format!("{}.{FOLDER}", file_name_of_photo(photo)));
    if !target.is_dir() || is_ours(&target, photo, true, written)? {
        return Ok(());
    }
    // A damaged record knows nothing; then the folder is kept where it is.
    let ledger = ImportLedger::read(project).unwrap_or_else(|_| ImportLedger::none(project));
    if ledger.knows(&target, &Stamp::from_path(&target)) {
        let kept = move_to_inbox(&target, &project.join("inbox"))?;
        task.note(format!("{} was painted on and imported; it is now {}", target.display(), kept.display()));
    }
    Ok(())
}

/// Returns true when `target` is an unchanged export of `photo`.
fn is_ours(target: &Path, photo: &str, wants_folder: bool, written: &WrittenFiles) -> Result<bool> {
    if target.is_dir() != wants_folder {
        return Ok(false);
    }
    if !wants_folder {
        return written.contains_unchanged(photo, target);
    }
    all_ours(target, photo, written)
}

/// Returns true when all files in a folder and its subfolders are unchanged exports of `photo`.
fn all_ours(folder: &Path, photo: &str, written: &WrittenFiles) -> Result<bool> {
    for entry in folder.read_dir().map_err(Error::io(folder, "read the folder"))? {
        let entry = entry.map_err(Error::io(folder, "read the folder"))?;
        if DESKTOP_FILES.iter().any(|litter| entry.file_name() == *litter) {
            continue;
        }
        let is_folder = entry.file_type().map_err(Error::io(entry.path(), "look at it"))?.is_dir();
        let ours = if is_folder {
            all_ours(&entry.path(), photo, written)?
        } else {
            written.contains_unchanged(photo, &entry.path())?
        };
        if !ours {
            return Ok(false);
        }
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_free_name_is_taken_as_it_is() {
        let out = tempfile::tempdir().unwrap();
        let place = find(out.path(), "nord/1.jpg", "psd", &WrittenFiles::default()).unwrap();
        assert_eq!(place, ExportDestination { target: out.path().join("nord%2F1.jpg.psd"), spared: vec![] });
    }

    #[test]
    fn files_that_nobody_knows_are_spared_and_the_next_number_is_taken() {
        let out = tempfile::tempdir().unwrap();
        let taken = ["1.jpg.psd", "1.jpg-2.psd"].map(|name| out.path().join(name));
        taken.iter().for_each(|file| std::fs::write(file, "painted").unwrap());
        let place = find(out.path(), "1.jpg", "psd", &WrittenFiles::default()).unwrap();
        assert_eq!(
            place,
            ExportDestination { target: out.path().join("1.jpg-3.psd"), spared: taken.to_vec() }
        );
    }

    #[test]
    fn an_empty_folder_is_ours_and_one_with_a_strange_file_is_not() {
        let out = tempfile::tempdir().unwrap();
        std::fs::create_dir(out.path().join("1.jpg.layers")).unwrap();
        let target = || find(out.path(), "1.jpg", FOLDER, &WrittenFiles::default()).unwrap().target;
        assert_eq!(target(), out.path().join("1.jpg.layers"));
        std::fs::write(out.path().join("1.jpg.layers/.DS_Store"), "").unwrap();
        assert_eq!(target(), out.path().join("1.jpg.layers"), "files that desktops leave are not edits");
        std::fs::write(out.path().join("1.jpg.layers/mine.kra"), "").unwrap();
        assert_eq!(target(), out.path().join("1.jpg-2.layers"));
    }
}
