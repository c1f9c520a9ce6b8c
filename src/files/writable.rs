//! Finds out whether files can be made in a place, before a long computation is begun for them. Nothing is left there.

use std::io::ErrorKind;
use std::path::Path;

use super::atomic::{AtomicFile, followed, refuse_device};
use quadratura_base::error::{Error, Result};

/// The name of the file that is tried; it is removed before it gets this name.
const TRIED: &str = "tried";

/// Checks that files can be made in a folder, which may be missing yet, as may folders above it.
///
/// # Errors
/// [`Error::Input`] where a file is in the way; [`Error::Io`] where the nearest folder that exists may not be written to.
pub fn check_folder(folder: &Path) -> Result<()> {
    let exists = |above: &&Path| above.symlink_metadata().is_ok();
    let nearest = folder.ancestors().filter(|above| *above != Path::new("")).find(exists);
    let nearest = nearest.unwrap_or(Path::new("."));
    if !nearest.is_dir() {
        let found = match nearest == folder {
            true => "this is a file, expected a folder or a new name".to_owned(),
            false => format!("this is a file, so that {} cannot be in it", folder.display()),
        };
        return Err(Error::input(nearest, "", found, "give another place"));
    }
    match AtomicFile::create(nearest.join(TRIED)) {
        Ok(_) => Ok(()),
        // Folders of the system, such as those of processes, take no files, and say that these do not exist.
        Err(Error::Io { source, .. }) if source.kind() == ErrorKind::NotFound => {
            Err(Error::input(nearest, "", "the system makes no files in this folder", "give another place"))
        }
        Err(Error::Io { source, .. }) => Err(Error::io(nearest, "write to this folder")(source)),
        Err(other) => Err(other),
    }
}

/// Checks that a file or folder of a name can be made, or one beside it with a number where there is another of this name.
///
/// # Errors
/// Those of [`check_folder`] for the folder above it.
pub fn check_beside(target: &Path) -> Result<()> {
    check_folder(target.parent().unwrap_or(target))
}

/// Checks that a file can be made or replaced; a symbolic link stands for what it points to.
///
/// # Errors
/// Those of [`check_beside`]; [`Error::Io`] where there is a folder of this name; [`Error::Input`] for a device or a pipe.
pub fn check_file(file: &Path) -> Result<()> {
    if file.is_dir() {
        return Err(Error::io(file, "write it")(ErrorKind::IsADirectory.into()));
    }
    let file = followed(file.to_path_buf());
    refuse_device(&file)?;
    check_beside(&file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn what_can_be_made_is_known_before_it_is_and_nothing_is_left_of_the_check() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("file"), "x").unwrap();
        check_file(&path("file")).unwrap();
        check_file(&path("new/folders/a.ldi")).unwrap();
        check_folder(folder.path()).unwrap();
        check_folder(&path("new/folders")).unwrap();
        check_folder(Path::new("")).unwrap();
        let told = |checked: Result<()>| checked.unwrap_err().to_string();
        let below = told(check_file(&path("file/new/a.ldi")));
        assert!(
            below.contains("file: this is a file") && below.contains("file/new cannot be in it"),
            "{below}"
        );
        let instead = told(check_folder(&path("file")));
        assert!(instead.contains("file: this is a file, expected a folder"), "{instead}");
        let folder_itself = told(check_file(folder.path()));
        assert!(folder_itself.contains("it is a folder, not a file; give a file"), "{folder_itself}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_folder_that_takes_no_files_is_told() {
        let told = check_folder(Path::new("/proc/pictures")).unwrap_err().to_string();
        assert!(told.starts_with("/proc: ") && !told.contains("does not exist"), "{told}");
    }
}
