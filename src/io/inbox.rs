//! `inbox/`: where files go that somebody changed and that stand in the way of derived ones. What
//! is there is never overwritten and never removed by the program.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use super::hash::hash_file;
use crate::error::{Error, Result};

/// Keeps `file` in the folder `inbox` too, and leaves it where it is. Returns its place there, which
/// is `NAME-2.png` and so on where `NAME.png` is taken; a file with the same content already there
/// is enough.
///
/// # Errors
/// [`Error::Io`]; the file is where it was.
pub fn keep_in_inbox(file: &Path, inbox: &Path) -> Result<PathBuf> {
    fs::create_dir_all(inbox).map_err(Error::io(inbox, "create the folder"))?;
    let hash = hash_file(file)?;
    for place in free_names(file, inbox) {
        match link_or_copy(file, &place) {
            Ok(()) => return Ok(place),
            Err(error) if error.kind() != ErrorKind::AlreadyExists => {
                return Err(Error::io(&place, "keep a file there that was changed by hand")(error));
            }
            Err(_) if place.is_file() && hash_file(&place)? == hash => return Ok(place),
            Err(_) => (),
        }
    }
    unreachable!("the names never end")
}

/// Moves `path`, a file or a folder, into the folder `inbox`.
///
/// # Errors
/// [`Error::Io`]; it is where it was, or in both places.
pub fn move_to_inbox(path: &Path, inbox: &Path) -> Result<PathBuf> {
    if path.is_file() {
        let place = keep_in_inbox(path, inbox)?;
        fs::remove_file(path).map_err(Error::io(path, "remove it, now that it is in the inbox"))?;
        return Ok(place);
    }
    fs::create_dir_all(inbox).map_err(Error::io(inbox, "create the folder"))?;
    let place = free_names(path, inbox).find(|place| !place.exists()).expect("the names never end");
    fs::rename(path, &place).map_err(Error::io(path, "move it to the inbox"))?;
    Ok(place)
}

/// `NAME.png`, `NAME-2.png`, `NAME-3.png` and so on, in `folder`.
fn free_names(file: &Path, folder: &Path) -> impl Iterator<Item = PathBuf> {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let extension = file.extension().map(|e| format!(".{}", e.to_string_lossy())).unwrap_or_default();
    let first = folder.join(file.file_name().unwrap_or_default());
    let folder = folder.to_path_buf();
    std::iter::once(first).chain((2u64..).map(move |n| folder.join(format!("{stem}-{n}{extension}"))))
}

/// A hard link costs nothing and cannot be half done; not every file system has them.
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
        assert_eq!(keep_in_inbox(&file, &inbox).unwrap(), keep_in_inbox(&file, &inbox).unwrap());
        assert_eq!(fs::read_dir(&inbox).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_is_moved_whole() {
        let folder = tempfile::tempdir().unwrap();
        let theirs = folder.path().join("theirs");
        fs::create_dir(&theirs).unwrap();
        fs::write(theirs.join("a.xcf"), "x").unwrap();
        let place = move_to_inbox(&theirs, &folder.path().join("inbox")).unwrap();
        assert_eq!(fs::read_to_string(place.join("a.xcf")).unwrap(), "x");
    }
}
