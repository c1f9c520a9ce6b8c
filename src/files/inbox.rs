//! Keeps user-changed files that stand in the way of derived ones in `inbox/`. The program never overwrites
//! or removes anything there.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use super::hash::hash_file;
use quadratura_base::error::{Error, Result};

/// Keeps a copy of `file` in the folder `inbox` and leaves the original where it is. Returns the copy's path:
/// `NAME-2.png` and so on where `NAME.png` is taken. An existing copy with the same content is reused.
///
/// # Errors
/// [`Error::Io`]; the file is where it was.
pub fn copy_to_inbox(file: &Path, inbox: &Path) -> Result<PathBuf> {
    fs::create_dir_all(inbox).map_err(Error::io(inbox, "create the folder"))?;
    let hash = hash_file(file)?;
    for target in free_names(file, inbox) {
        match link_or_copy(file, &target) {
            Ok(()) => return Ok(target),
            Err(error) if error.kind() != ErrorKind::AlreadyExists => {
                return Err(Error::io(&target, "copy a file that was changed by hand to it")(error));
            }
            Err(_) if target.is_file() && hash_file(&target)? == hash => return Ok(target),
            Err(_) => (),
        }
    }
    unreachable!("the names never end")
}

/// Moves `path`, a file or a folder, into the folder `inbox`. Returns its new path.
///
/// # Errors
/// [`Error::Io`]; the original is then still in place, possibly with a copy in the inbox.
pub fn move_to_inbox(path: &Path, inbox: &Path) -> Result<PathBuf> {
    if path.is_file() {
        let target = copy_to_inbox(path, inbox)?;
        fs::remove_file(path).map_err(Error::io(path, "remove it, now that it is in the inbox"))?;
        return Ok(target);
    }
    fs::create_dir_all(inbox).map_err(Error::io(inbox, "create the folder"))?;
    let target = free_names(path, inbox).find(|target| !target.exists()).expect("the names never end");
    fs::rename(path, &target).map_err(Error::io(path, "move it to the inbox"))?;
    Ok(target)
}

/// Yields `NAME.png`, `NAME-2.png`, `NAME-3.png` and so on, in `folder`.
fn free_names(file: &Path, folder: &Path) -> impl Iterator<Item = PathBuf> {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let extension = file.extension().map(|e| format!(".{}", e.to_string_lossy())).unwrap_or_default();
    let first = folder.join(file.file_name().unwrap_or_default());
    let folder = folder.to_path_buf();
    std::iter::once(first).chain((2u64..).map(move |n| folder.join(format!("{stem}-{n}{extension}"))))
}

/// Links `to` to the file `from`, or copies it where the file system has no hard links. A link takes no space
/// and cannot be left half done.
pub(super) fn link_or_copy(from: &Path, to: &Path) -> io::Result<()> {
    match fs::hard_link(from, to) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => copy_to_new(from, to),
        done => done,
    }
}

fn copy_to_new(from: &Path, to: &Path) -> io::Result<()> {
    let mut target = File::create_new(to)?;
    io::copy(&mut File::open(from)?, &mut target)?;
    target.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_file_of_the_same_name_is_numbered_and_the_first_one_stays() {
        let folder = tempfile::tempdir().unwrap();
        let (file, inbox) = (folder.path().join("left wall.png"), folder.path().join("inbox"));
        for (content, name) in
            [("one", "left wall.png"), ("two", "left wall-2.png"), ("3", "left wall-3.png")]
        {
            fs::write(&file, content).unwrap();
            assert_eq!(move_to_inbox(&file, &inbox).unwrap(), inbox.join(name));
            assert!(!file.exists());
        }
        assert_eq!(fs::read_to_string(inbox.join("left wall.png")).unwrap(), "one");
    }

    #[test]
    fn keeping_the_same_content_twice_makes_one_file() {
        let folder = tempfile::tempdir().unwrap();
        let (file, inbox) = (folder.path().join("a.png"), folder.path().join("inbox"));
        fs::write(&file, "one").unwrap();
        assert_eq!(copy_to_inbox(&file, &inbox).unwrap(), copy_to_inbox(&file, &inbox).unwrap());
        assert_eq!(fs::read_dir(&inbox).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_is_moved_whole() {
        let folder = tempfile::tempdir().unwrap();
        let moved_folder = folder.path().join("layers");
        fs::create_dir(&moved_folder).unwrap();
        fs::write(moved_folder.join("a.xcf"), "x").unwrap();
        let target = move_to_inbox(&moved_folder, &folder.path().join("inbox")).unwrap();
        assert_eq!(fs::read_to_string(target.join("a.xcf")).unwrap(), "x");
    }
}
