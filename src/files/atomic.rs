//! Writes files that appear whole or not at all: a new file in the same folder, fsync, rename, fsync of the
//! folder. After a kill or a power failure either the old or the new content is there.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use tempfile::NamedTempFile;

use quadratura_base::error::{Error, Result};

/// Prefix of the names of unfinished files; [`remove_leftovers`] recognises them by it.
const UNFINISHED: &str = ".quadratura-";

/// A file that is being written. [`AtomicFile::commit`] puts it in place; dropped before that, it vanishes
/// and the old file stays.
#[derive(Debug)]
pub struct AtomicFile {
    file: NamedTempFile,
    target: PathBuf,
}

impl AtomicFile {
    /// Starts a file that will become `target`, whose folder must exist. A symbolic link stays, and what it points to is written.
    ///
    /// # Errors
    /// [`Error::Io`] when the folder does not exist or may not be written to; [`Error::Input`] where a device or a pipe is in the way.
    pub fn create(target: impl Into<PathBuf>) -> Result<Self> {
        let target = followed(target.into());
        refuse_device(&target)?;
        let mut builder = tempfile::Builder::new();
        builder.prefix(UNFINISHED).suffix(".tmp");
        readable_by_others(&mut builder);
        let file = builder.tempfile_in(folder_of(&target)).map_err(|error| not_created(&target, &error))?;
        mark_in_use(file.as_file());
        Ok(Self { file, target })
    }

    /// Returns the file to write to. It is unbuffered and can seek.
    pub fn file(&mut self) -> &mut File {
        self.file.as_file_mut()
    }

    /// Returns the temporary path that the file has until the commit.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// Changes the target to another path in the same folder. Where that is a link into another file system, the commit fails.
    pub fn redirect(&mut self, target: impl Into<PathBuf>) {
        self.target = followed(target.into());
    }

    /// Moves the file to its target and replaces what was there.
    ///
    /// # Errors
    /// [`Error::Io`] when the system refuses, for instance on a full disk; the old file stays.
    pub fn commit(self) -> Result<()> {
        let Self { file, target } = self;
        file.as_file().sync_all().map_err(Error::io(&target, "write it to disk"))?;
        file.persist(&target).map_err(|e| Error::io(&target, "put it in place")(e.error))?;
        sync_folder(folder_of(&target))
    }
}

/// The most links behind each other that are followed, as on Linux: there may be circles.
const MOST_LINKS: usize = 40;

/// Returns the path that a path stands for: where it is a symbolic link, what that points to, which may be missing.
pub fn followed(path: PathBuf) -> PathBuf {
    let next = |path: &PathBuf| fs::read_link(path).ok().map(|link| folder_of(path).join(link));
    std::iter::successors(Some(path), next).take(MOST_LINKS).last().expect("the path itself")
}

/// Refuses a path with something that is neither a file nor a folder.
///
/// # Errors
/// [`Error::Input`].
pub(super) fn refuse_device(path: &Path) -> Result<()> {
    if path.metadata().is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        let found = "this is a device or a pipe, expected a file or a new name";
        return Err(Error::input(path, "", found, "give another name"));
    }
    Ok(())
}

/// Returns whether a path stands for what takes a stream of bytes: a pipe, a terminal or the like, or a name of the system's for a file
/// that is open already, such as `/dev/stdout`.
pub fn is_stream(path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        // Not all of /dev: /dev/shm has files as any folder.
        let names = ["/dev/stdout", "/dev/stderr", "/dev/fd", "/proc"];
        let is_open = || names.iter().any(|name| path.starts_with(name));
        let kind = path.metadata().map(|found| found.file_type());
        kind.is_ok_and(|kind| kind.is_fifo() || kind.is_char_device() || (kind.is_file() && is_open()))
    }
    #[cfg(not(unix))]
    {
        let _ = path;
        false
    }
}

/// Returns the error for a file that could not be started. It names the target, or the folder where that does not exist,
/// and not the temporary file.
fn not_created(target: &Path, error: &std::io::Error) -> Error {
    let folder = folder_of(target);
    let path = if folder.is_dir() { target } else { folder };
    let inner = error.get_ref().and_then(|inner| inner.source()?.downcast_ref::<std::io::Error>());
    let source = match inner.unwrap_or(error).raw_os_error() {
        Some(code) => std::io::Error::from_raw_os_error(code),
        None => error.kind().into(),
    };
    Error::io(path, if folder.is_dir() { "create it" } else { "write to this folder" })(source)
}

/// Writes `bytes` as the whole content of `target`.
///
/// # Errors
/// [`Error::Io`]; the old file stays.
pub fn write_atomically(target: impl AsRef<Path>, bytes: &[u8]) -> Result<()> {
    write_atomically_with(target, |out| out.write_all(bytes))
}

/// Writes `target` through a buffer.
///
/// # Errors
/// [`Error::Io`] with the error of `write` or of the system; the old file stays.
pub fn write_atomically_with(
    target: impl AsRef<Path>,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> std::io::Result<()>,
) -> Result<()> {
    let target = target.as_ref();
    let mut file = AtomicFile::create(target)?;
    let mut out = BufWriter::new(file.file());
    write(&mut out).and_then(|()| out.flush()).map_err(Error::io(target, "write it"))?;
    drop(out);
    file.commit()
}

/// Puts the file `from` at `target` as well, in place of what was there: as a hard link, or as a copy where the file
/// system has none. Whoever does the same at the same time succeeds, too.
///
/// # Errors
/// An error of the system; `target` is as it was.
pub fn link_atomically(from: &Path, target: &Path) -> std::io::Result<()> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(UNFINISHED).suffix(".tmp");
    let linked = builder.make_in(folder_of(target), |beside| super::inbox::link_or_copy(from, beside))?;
    // Renaming one link of a file to another does nothing, so the temporary one is removed when it is dropped.
    let beside = linked.into_temp_path();
    fs::rename(&beside, target)
}

/// Creates `folder`, which must be missing or empty, with what `write` puts into the folder that it is given. That one is
/// beside it and is renamed at the end; on failure it is removed, and `folder` stays as it was.
///
/// # Errors
/// The error of `write`; [`Error::Io`] when the system refuses to create or rename a folder.
pub fn create_folder_with<T>(folder: &Path, write: impl FnOnce(&Path) -> Result<T>) -> Result<T> {
    // An empty folder is not replaced by every system.
    put_folder_with(folder, write, |old, _| fs::remove_dir(old))
}

/// Writes `folder` as [`create_folder_with`] does, in place of what is there, which is removed once the new one is complete.
/// If the program is killed between two renames, the old folder is in the one beside it.
///
/// # Errors
/// As [`create_folder_with`]; the old folder stays.
pub fn replace_folder_with<T>(folder: &Path, write: impl FnOnce(&Path) -> Result<T>) -> Result<T> {
    put_folder_with(folder, write, |old, beside| fs::rename(old, beside.join(OLD)))
}

/// The name of a replaced folder until it is removed.
const OLD: &str = "old";

/// Puts a new folder in place; `make_way` removes what is there, or moves it into the temporary folder that it is given.
fn put_folder_with<T>(
    folder: &Path,
    write: impl FnOnce(&Path) -> Result<T>,
    make_way: impl FnOnce(&Path, &Path) -> std::io::Result<()>,
) -> Result<T> {
    let folder = std::path::absolute(folder).map_err(Error::io(folder, "find the folder"))?;
    let parent = folder_of(&folder);
    fs::create_dir_all(parent).map_err(Error::io(parent, "create the folder"))?;
    let beside = tempfile::Builder::new().prefix(UNFINISHED).tempdir_in(parent);
    let beside = beside.map_err(Error::io(parent, "create a folder in it"))?;
    let new = beside.path().join("new");
    fs::create_dir(&new).map_err(Error::io(&new, "create the folder"))?;
    let written = write(&new)?;
    if folder.exists() {
        make_way(&folder, beside.path()).map_err(Error::io(&folder, "replace the folder"))?;
    }
    if let Err(error) = fs::rename(&new, &folder) {
        // What was moved away comes back; where nothing was, this does nothing.
        let _ = fs::rename(beside.path().join(OLD), &folder);
        return Err(Error::io(&folder, "create the folder")(error));
    }
    Ok(written)
}

/// Flushes `folder` to disk, so that a rename or a new file in it survives a power failure.
///
/// # Errors
/// [`Error::Io`] when the disk refuses.
pub fn sync_folder(folder: impl AsRef<Path>) -> Result<()> {
    // Other systems cannot open a folder as a file; their file systems journal renames.
    if cfg!(unix) {
        let folder = folder.as_ref();
        let open = File::open(folder).map_err(Error::io(folder, "open the folder"))?;
        open.sync_all().map_err(Error::io(folder, "write the folder to disk"))?;
    }
    Ok(())
}

/// Removes the unfinished files that a killed writer left in `folder`. The caller must hold the project's
/// lock, otherwise this may delete files that a running writer still uses.
///
/// # Errors
/// [`Error::Io`] when the folder cannot be read or a leftover cannot be removed.
pub fn remove_leftovers(folder: &Path) -> Result<()> {
    remove_leftovers_if(folder, |_| true)
}

/// Removes the unfinished files in `folder` that were last written at least `age` ago. Unlike
/// [`remove_leftovers`] it is safe in a folder that other programs write to.
///
/// # Errors
/// As [`remove_leftovers`].
pub fn remove_old_leftovers(folder: &Path, age: Duration) -> Result<()> {
    let is_old = |path: &Path| {
        let changed = fs::metadata(path).and_then(|data| data.modified()).ok();
        changed.and_then(|changed| changed.elapsed().ok()).is_some_and(|elapsed| elapsed >= age)
    };
    remove_leftovers_if(folder, is_old)
}

/// The number of letters and digits in a name between [`UNFINISHED`] and its end.
const RANDOM: usize = 6;

/// An unfinished file or folder younger than this may not be marked as in use yet.
const YOUNG: Duration = Duration::from_secs(1);

/// Where the system has no locks that end with a program, a writer that wrote nothing for so long was killed.
const RESTS: Duration = Duration::from_secs(3600);

/// Marks an unfinished file or folder as in use until its handle is closed, also by the end of the program.
pub fn mark_in_use(file: &File) {
    // Elsewhere a lock would keep other handles from writing. Without a mark, only the age counts.
    if cfg!(unix) {
        let _ = file.try_lock();
    }
}

/// Removes the unfinished files and folders in `folder` whose writers were killed. Unlike [`remove_leftovers`] it is
/// safe where other programs write. What cannot be removed stays, because it harms nobody.
pub fn remove_dead_leftovers(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let Some(is_folder) = unfinished(&path).filter(|_| is_dead(&path)) else { continue };
        let _ = if is_folder { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
    }
}

/// Returns whether a path with a name that only this program gives is a folder; `None` for all other names.
fn unfinished(path: &Path) -> Option<bool> {
    let name = path.file_name()?.to_str()?.strip_prefix(UNFINISHED)?;
    let is_folder = path.symlink_metadata().ok()?.is_dir();
    let random = if is_folder { name } else { name.strip_suffix(".tmp")? };
    let ours = random.len() == RANDOM && random.bytes().all(|byte| byte.is_ascii_alphanumeric());
    ours.then_some(is_folder)
}

fn is_dead(path: &Path) -> bool {
    let changed = fs::metadata(path).and_then(|data| data.modified()).ok();
    let age = changed.and_then(|changed| changed.elapsed().ok()).unwrap_or_default();
    if !cfg!(unix) {
        return age >= RESTS;
    }
    age >= YOUNG && File::open(path).is_ok_and(|file| file.try_lock().is_ok())
}

fn remove_leftovers_if(folder: &Path, is_leftover: impl Fn(&Path) -> bool) -> Result<()> {
    for entry in fs::read_dir(folder).map_err(Error::io(folder, "read the folder"))? {
        let path = entry.map_err(Error::io(folder, "read the folder"))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with(UNFINISHED) && name.ends_with(".tmp") && is_leftover(&path) {
            fs::remove_file(&path).map_err(Error::io(&path, "remove it"))?;
        }
    }
    Ok(())
}

/// Returns the folder that contains `path`; `.` for a bare name.
fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Gives the file the permissions of an ordinary file (the umask decides); temporary files are private by
/// default.
fn readable_by_others(builder: &mut tempfile::Builder<'_, '_>) {
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    #[cfg(not(unix))]
    let _ = builder;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names_in(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn the_new_content_replaces_the_old_one_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.json");
        write_atomically(&target, b"old").unwrap();
        write_atomically(&target, b"new").unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"new");
        assert_eq!(names_in(folder.path()), ["a.json"]);
    }

    #[cfg(unix)]
    #[test]
    fn what_a_link_points_to_is_written_and_a_pipe_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("there")).unwrap();
        write_atomically(path("there/a.json"), b"old").unwrap();
        std::os::unix::fs::symlink("there/a.json", path("link")).unwrap();
        write_atomically(path("link"), b"new").unwrap();
        assert!(path("link").symlink_metadata().unwrap().is_symlink());
        assert_eq!(fs::read(path("there/a.json")).unwrap(), b"new");
        // What it points to may be missing, or be a link itself, in a circle even.
        std::os::unix::fs::symlink("link", path("again")).unwrap();
        fs::remove_file(path("there/a.json")).unwrap();
        write_atomically(path("again"), b"made").unwrap();
        assert_eq!(fs::read(path("there/a.json")).unwrap(), b"made");
        assert!(path("link").is_symlink() && path("again").is_symlink());
        std::os::unix::fs::symlink("circle", path("circle")).unwrap();
        assert_eq!(followed(path("circle")), path("circle"));
        // A file that is put in the place of another path, behind a link.
        let mut file = AtomicFile::create(path("there/b.json")).unwrap();
        file.file().write_all(b"moved").unwrap();
        file.redirect(path("link"));
        file.commit().unwrap();
        assert!(path("link").is_symlink() && fs::read(path("there/a.json")).unwrap() == b"moved");
        // A socket is the one of its kind that the standard library makes.
        let _socket = std::os::unix::net::UnixListener::bind(path("socket")).unwrap();
        let refused = write_atomically(path("socket"), b"new").unwrap_err().to_string();
        assert!(refused.contains("socket: this is a device or a pipe"), "{refused}");
        let is_one = |path: &Path| is_stream(path);
        assert!(is_one(Path::new("/dev/null")) && !is_one(&path("socket")) && !is_one(&path("link")));
        // A file in memory is a file.
        if let Ok(in_memory) = NamedTempFile::new_in("/dev/shm") {
            assert!(!is_one(in_memory.path()));
        }
    }

    #[test]
    fn a_writer_that_fails_leaves_the_old_content() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.json");
        write_atomically(&target, b"old").unwrap();
        let full = write_atomically_with(&target, |out| {
            out.write_all(b"half")?;
            Err(std::io::ErrorKind::StorageFull.into())
        });
        assert!(full.unwrap_err().to_string().contains("a.json"));
        assert_eq!(fs::read(&target).unwrap(), b"old");
        assert_eq!(names_in(folder.path()), ["a.json"]);
    }

    #[test]
    fn leftovers_of_a_killed_writer_are_removed_and_other_files_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let killed = AtomicFile::create(folder.path().join("a.json")).unwrap();
        std::mem::forget(killed);
        fs::write(folder.path().join("b.tmp"), "theirs").unwrap();
        remove_old_leftovers(folder.path(), Duration::from_secs(3600)).unwrap();
        assert_eq!(names_in(folder.path()).len(), 2, "another program may still be writing it");
        remove_leftovers(folder.path()).unwrap();
        assert_eq!(names_in(folder.path()), ["b.tmp"]);
    }

    #[cfg(unix)]
    #[test]
    fn what_a_killed_writer_left_is_removed_and_what_a_writer_or_a_user_has_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let old = |name: &str| {
            let path = folder.path().join(name);
            let file = File::open(&path).or_else(|_| File::create(&path)).unwrap();
            file.set_modified(std::time::SystemTime::now() - 2 * YOUNG).unwrap();
        };
        let users = ["a.tmp", ".quadratura-notes.tmp", ".quadratura-abcdef.psd", ".quadratura-old-abc123"];
        users.iter().for_each(|name| old(name));
        old(".quadratura-abc123.tmp");
        fs::create_dir_all(folder.path().join(".quadratura-Xyz789/guides")).unwrap();
        old(".quadratura-Xyz789");
        let writer = AtomicFile::create(folder.path().join("b.psd")).unwrap();
        let written = writer.path().file_name().unwrap().to_str().unwrap().to_owned();
        old(&written);
        remove_dead_leftovers(folder.path());
        let mut expected: Vec<String> = users.iter().map(ToString::to_string).chain([written]).collect();
        expected.sort();
        assert_eq!(names_in(folder.path()), expected);
    }

    #[test]
    fn a_folder_is_replaced_whole_or_not_at_all() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("layers");
        let write = |name: &'static str| {
            move |new: &Path| fs::write(new.join(name), name).map_err(Error::io(new, "write it"))
        };
        create_folder_with(&folder, write("a")).unwrap();
        assert!(create_folder_with(&folder, write("b")).is_err(), "it is not empty");
        assert_eq!(names_in(&folder), ["a"]);
        assert!(replace_folder_with(&folder, |_| Err::<(), _>(Error::Cancelled)).is_err());
        assert_eq!(names_in(&folder), ["a"]);
        replace_folder_with(&folder, write("b")).unwrap();
        assert_eq!(
            (names_in(&folder), names_in(parent.path())),
            (vec!["b".to_owned()], vec!["layers".to_owned()])
        );
    }

    #[test]
    fn a_folder_that_does_not_exist_is_named_in_the_error() {
        let error = write_atomically("/no/such/folder/a.json", b"").unwrap_err();
        assert!(
            error
                .to_string()
                .starts_with("/no/such/folder: could not write to this folder: it does not exist"),
            "{error}"
        );
    }
}
