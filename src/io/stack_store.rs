//! The stacks of a project on disk: written as a whole, replaced by one rename, never over a file that was
//! changed by the user.
//!
//! ```text
//! stacks/<photo>/stack.json            names its files as 3fa9c1d20b7e/left.png
//! stacks/<photo>/3fa9c1d20b7e/         one version: the files, and files.json with their hashes
//! stacks/<photo>/+new-…/               a version that is being written
//! inbox/<photo>/                       files that were changed by hand and stood in the way
//! cache/stamps/<photo>.json            modification times of files; saves hashing them
//! ```
//!
//! A version is written and synced under `+new-…`, then named after a hash of its content, and becomes
//! current by the rename of `stack.json`: the one kind of rename that also replaces on every system (a folder
//! that is not empty cannot be replaced by one). Only then is the old version removed, unless a program reads the stacks: unchanged files are
//! deleted, all others go to `inbox/`. After a kill at any moment `stack.json` names complete files, old or
//! new; the next [`StackStore::clean`] removes leftovers. A reader of
//! another program with the old `stack.json` finds its files missing, never mixed with new ones, and reads again.

mod cleaning;

use std::fs;
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::in_use::{self, one_name};
use super::stack_files::{FileState, FileTimes, RECORD, StackFiles, is_version, names_in};
use super::stack_readers::are_read;
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_document::names::{file_name_of_photo, photo_of_file_name};
use quadratura_document::stack::LayerFill;
use quadratura_document::stack::STACK_VERSION;
use quadratura_document::{FilesInUse, ImageLayer, Stack};
use quadratura_files::atomic::{sync_folder, write_atomically};
use quadratura_files::hash::{hash_bytes, hash_file};
use quadratura_files::inbox::copy_to_inbox;
use quadratura_files::json::{read_json, to_json};

const STACK_FILE: &str = "stack.json";
const UNFINISHED: &str = "+new-";
const LARGEST_STACK: u64 = 1 << 30;
/// The remedy for damaged stacks.
const REMEDY: (&str, Remedy, &str) = ("run ", Remedy::Build, " to make it again");
/// Files that desktop environments create in folders; they are no user data.
pub const DESKTOP_FILES: [&str; 3] = [".DS_Store", "Thumbs.db", "desktop.ini"];

/// The stacks of a project on disk. Reading needs no lock; writers hold the lock of the photo ([`StackStore::lock`]).
#[derive(Debug, Clone)]
pub struct StackStore {
    project: PathBuf,
    keeps_former: bool,
}

/// The result of a commit.
#[derive(Debug, Clone, PartialEq)]
pub struct Committed {
    /// The stack as it is on disk, with the paths of its files relative to [`StackStore::folder`].
    pub stack: Stack,
    /// Paths in `inbox/` of files that were changed by the user.
    pub kept: Vec<PathBuf>,
}

impl StackStore {
    /// Returns the store of the project in the folder `project`.
    pub fn new(project: impl Into<PathBuf>) -> Self {
        Self { project: project.into(), keeps_former: false }
    }

    /// Keeps former versions of stacks until [`Self::clear_former`] is called, because a view shows them and
    /// reads their files as needed.
    pub fn keeping_former(self) -> Self {
        Self { keeps_former: true, ..self }
    }

    /// Returns whether former versions stay: for a view of this program, or because another one reads them.
    fn keeps_former(&self) -> bool {
        self.keeps_former || are_read(&self.project)
    }

    /// Returns the folder of a photo's stack; the paths in the stack are relative to it.
    pub fn folder(&self, photo: &str) -> PathBuf {
        self.stacks().join(file_name_of_photo(photo))
    }

    /// Returns the path of the `stack.json` of `photo`.
    pub fn stack_file(&self, photo: &str) -> PathBuf {
        self.folder(photo).join(STACK_FILE)
    }

    /// Reads the current stack of `photo`; `None` if it has none. [`Self::clear_former`] leaves its files alone as long as
    /// the stack, or a copy of it, is in memory.
    ///
    /// # Errors
    /// [`Error::Input`] when `stack.json` is damaged or of another version; [`Error::Io`].
    pub fn current(&self, photo: &str) -> Result<Option<Stack>> {
        let file = self.stack_file(photo);
        let _reading = in_use::reading();
        let mut stack: Stack = match read_json(&file, LARGEST_STACK, REMEDY) {
            Err(Error::Io { source, .. }) if source.kind() == ErrorKind::NotFound => return Ok(None),
            read => read?,
        };
        if stack.version != STACK_VERSION {
            let found = format!("version {}, this program reads version {STACK_VERSION}", stack.version);
            return Err(Error::input(file, "version", found, REMEDY));
        }
        if let Some((place, found)) = stack.flaw() {
            return Err(Error::input(file, place, found, REMEDY));
        }
        stack.in_use = self.in_use(photo, &stack);
        Ok(Some(stack))
    }

    /// Reads the current stack of `photo` if it was built from `inputs` and all its files are as they were
    /// written; `None` means that it has to be built.
    ///
    /// # Errors
    /// [`Error::Io`] when a file exists and cannot be read.
    pub fn up_to_date(&self, photo: &str, inputs: &str) -> Result<Option<Stack>> {
        let Ok(Some(stack)) = self.current(photo) else { return Ok(None) };
        let Some(version) = self.current_version(photo) else { return Ok(None) };
        if stack.inputs != inputs {
            return Ok(None);
        }
        let folder = self.folder(photo).join(version);
        let record = StackFiles::read(&folder).unwrap_or_default();
        let stamps = FileTimes::read(&self.stamps_file(photo));
        if !record.all_intact(&folder, &stamps)? {
            return Ok(None);
        }
        let fresh = FileTimes::new(&record, &folder);
        if fresh != stamps {
            fresh.write(&self.stamps_file(photo));
        }
        Ok(Some(stack))
    }

    /// Returns the photos that have a stack, sorted, including those that no longer belong to the project.
    ///
    /// # Errors
    /// [`Error::Io`] when `stacks/` cannot be read.
    pub fn photos(&self) -> Result<Vec<String>> {
        if !self.stacks().is_dir() {
            return Ok(Vec::new());
        }
        let mut photos: Vec<_> =
            names_in(&self.stacks())?.iter().filter_map(|name| photo_of_file_name(name)).collect();
        photos.retain(|photo| self.folder(photo).join(STACK_FILE).is_file());
        photos.sort();
        Ok(photos)
    }

    /// Starts writing a new version of the stack of `photo`.
    ///
    /// # Errors
    /// [`Error::Io`] when the project is not writable.
    pub fn begin(&self, photo: &str) -> Result<StackWriter> {
        let stack = self.folder(photo);
        fs::create_dir_all(&stack).map_err(Error::io(&stack, "create the folder"))?;
        let mut builder = tempfile::Builder::new();
        builder.prefix(UNFINISHED);
        // Temporary folders are private by default, but this one becomes an ordinary folder.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
        let folder = builder.tempdir_in(&stack).map_err(Error::io(&stack, "create a folder in it"))?;
        Ok(StackWriter { store: self.clone(), photo: photo.to_owned(), folder })
    }

    /// Starts a new version of a current stack with all its files except those of a filling. Returns the
    /// writer, and the stack as [`StackWriter::commit`] takes it: without a filling, its files by their bare
    /// names.
    ///
    /// # Errors
    /// [`Error::Io`] when a file is missing or the project is not writable.
    pub fn begin_from(&self, stack: &Stack) -> Result<(StackWriter, Stack)> {
        let mut bare = stack.clone();
        bare.bytes -= bare.fill.take().map_or(0, |fill| fill.bytes.min(stack.bytes));
        bare.image_layers.iter_mut().for_each(|layer| layer.fill = None);
        let writer = self.begin_with(&mut bare)?;
        Ok((writer, bare))
    }

    /// Replaces the `stack.json` of a current stack, for example with other names of layers; all its files
    /// stay as they are.
    ///
    /// # Errors
    /// [`Error::Io`]; the old stack stays as it was.
    pub fn replace_stack_json(&self, stack: &Stack) -> Result<Committed> {
        let mut bare = stack.clone();
        let writer = self.begin_with(&mut bare)?;
        writer.commit(bare)
    }

    /// Starts a new version with the files of a current stack, and changes `stack` to name them by their bare
    /// names.
    fn begin_with(&self, stack: &mut Stack) -> Result<StackWriter> {
        let writer = self.begin(&stack.photo.name)?;
        let current = self.folder(&stack.photo.name);
        for file in stack.image_layers.iter_mut().flat_map(files_of) {
            let name = file.rsplit('/').next().unwrap_or_default().to_owned();
            link(&current.join(&*file), &writer.folder().join(&name))?;
            *file = name;
        }
        Ok(writer)
    }

    /// Rewrites an error that happened while writing the stack of `photo`, so that it names the stack's own
    /// folder instead of the temporary one, which users do not know.
    pub fn with_final_path(&self, photo: &str, error: Error) -> Error {
        let Error::Io { path, doing, source } = error else { return error };
        let is_new =
            |path: &Path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(UNFINISHED));
        let within = path.parent().is_some_and(is_new);
        let target = self.folder(photo);
        let path = match path.file_name() {
            Some(name) if within => target.join(name),
            Some(_) if is_new(&path) => target,
            _ => path,
        };
        Error::Io { path, doing, source }
    }

    /// Returns an error for a file of a photo's current stack that is missing or cut short; `None` where all
    /// are complete. Files are judged by their sizes and by how a PNG ends, so one that was painted on counts
    /// as complete.
    pub fn damage(&self, photo: &str) -> Option<Error> {
        let folder = self.folder(photo).join(self.current_version(photo)?);
        let record = StackFiles::read(&folder)?;
        record.files.iter().find_map(|(name, written)| {
            let path = folder.join(name);
            let found = match fs::metadata(&path) {
                Err(_) => "the file is missing".to_owned(),
                Ok(data) if data.len() == written.bytes || ends_as_png(&path) => return None,
                Ok(data) => format!("{} bytes of {}: the file is cut short", data.len(), written.bytes),
            };
            Some(Error::input(path, "", found, REMEDY))
        })
    }

    /// Returns the project's folder.
    pub fn project(&self) -> &Path {
        &self.project
    }

    /// Returns a hold on the version of a photo's stack.
    fn in_use(&self, photo: &str, stack: &Stack) -> FilesInUse {
        let version = |layer: &ImageLayer| Some(layer.file.split_once('/')?.0.to_owned());
        let folder = one_name(&self.folder(photo));
        in_use::hold(stack.image_layers.first().and_then(version).map(|version| folder.join(version)))
    }

    fn stacks(&self) -> PathBuf {
        self.project.join("stacks")
    }

    fn inbox(&self, photo: &str) -> PathBuf {
        self.project.join("inbox").join(file_name_of_photo(photo))
    }

    fn stamps_file(&self, photo: &str) -> PathBuf {
        self.project.join("cache/stamps").join(format!("{}.json", file_name_of_photo(photo)))
    }

    /// Returns the version whose record has the hash of the present `stack.json`; `None` when that was
    /// changed by hand.
    fn current_version(&self, photo: &str) -> Option<String> {
        let folder = self.folder(photo);
        let stack = hash_file(folder.join(STACK_FILE)).ok()?;
        let knows = |version: &String| {
            StackFiles::read(&folder.join(version)).is_some_and(|record| record.stack == stack)
        };
        versions_in(&folder).ok()?.into_iter().find(knows)
    }
}

/// A new version of a stack that is being written. Dropped without a commit, it is removed.
#[derive(Debug)]
pub struct StackWriter {
    store: StackStore,
    photo: String,
    folder: TempDir,
}

impl StackWriter {
    /// Returns the folder to write the files to, without sub-folders.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Makes the files in the folder, together with `stack`, the photo's current stack. `stack` names each
    /// file by its bare name. Files of the old version that were changed by the user go to `inbox/`.
    ///
    /// # Errors
    /// [`Error::Io`], for instance on a full disk; the old stack stays as it was.
    pub fn commit(self, mut stack: Stack) -> Result<Committed> {
        let mut record = StackFiles::sync_and_record(self.folder())?;
        let version = record.version(&to_json(&stack));
        let files = stack.image_layers.iter_mut().flat_map(files_of);
        files.for_each(|file| *file = format!("{version}/{file}"));
        stack.in_use = self.store.in_use(&self.photo, &stack);
        let text = to_json(&stack);
        record.stack = hash_bytes(&text);
        write_atomically(self.folder().join(RECORD), &to_json(&record))?;

        let mut kept = self.move_to_version(&version, &record)?;
        kept.extend(self.replace_stack_file(&text)?);
        match self.store.keeps_former() {
            true => self.store.note_former(),
            false => kept.extend(self.store.clear_versions_but(&self.photo, &version, |_| false)?),
        }
        let target = self.stack_folder().join(version);
        FileTimes::new(&record, &target).write(&self.store.stamps_file(&self.photo));
        Ok(Committed { stack, kept })
    }

    fn stack_folder(&self) -> PathBuf {
        self.store.folder(&self.photo)
    }

    /// Renames the folder to the version's name. No reader uses it yet, unless the same version existed
    /// before.
    fn move_to_version(&self, version: &str, record: &StackFiles) -> Result<Vec<PathBuf>> {
        let target = self.stack_folder().join(version);
        sync_folder(self.store.stacks())?;
        let kept = if target.exists() {
            self.repair(&target, record)?
        } else {
            match fs::rename(self.folder(), &target) {
                // Another program has made the same meanwhile.
                Err(_) if target.exists() => self.repair(&target, record)?,
                renamed => {
                    renamed.map_err(Error::io(&target, "put the stack in target"))?;
                    Vec::new()
                }
            }
        };
        sync_folder(self.stack_folder())?;
        Ok(kept)
    }

    /// Replaces the changed or missing files of an existing folder of the same version.
    fn repair(&self, target: &Path, record: &StackFiles) -> Result<Vec<PathBuf>> {
        let stamps = FileTimes::read(&self.store.stamps_file(&self.photo));
        let mut kept = Vec::new();
        for name in record.files.keys().map(String::as_str).chain([RECORD]) {
            let state =
                if name == RECORD { FileState::Missing } else { record.state(target, name, &stamps)? };
            if state == FileState::Changed {
                kept.push(copy_to_inbox(&target.join(name), &self.store.inbox(&self.photo))?);
            }
            if state != FileState::Intact {
                let path = target.join(name);
                fs::rename(self.folder().join(name), &path).map_err(Error::io(&path, "replace it"))?;
            }
        }
        sync_folder(target)?;
        Ok(kept)
    }

    /// Replaces `stack.json` by one rename, which makes the new version current. Returns the path in `inbox/`
    /// of a `stack.json` that was changed by the user.
    fn replace_stack_file(&self, text: &[u8]) -> Result<Option<PathBuf>> {
        let file = self.stack_folder().join(STACK_FILE);
        let changed = file.is_file() && self.store.current_version(&self.photo).is_none();
        let inbox = self.store.inbox(&self.photo);
        let kept = changed.then(|| copy_to_inbox(&file, &inbox)).transpose()?;
        write_atomically(&file, text)?;
        Ok(kept)
    }
}

/// Returns whether the file ends with the last chunk of a PNG, that is, was written completely.
fn ends_as_png(path: &Path) -> bool {
    let end = || {
        let mut file = fs::File::open(path)?;
        file.seek(SeekFrom::End(-8))?;
        let mut end = [0; 4];
        file.read_exact(&mut end)?;
        Ok::<_, std::io::Error>(end)
    };
    end().is_ok_and(|end| end == *b"IEND")
}

/// Yields the names of all files of an image layer.
fn files_of(layer: &mut ImageLayer) -> impl Iterator<Item = &mut String> {
    let ImageLayer { file, needed_file, fill, .. } = layer;
    let of_fill = fill.iter_mut().flat_map(LayerFill::files_mut);
    [file, needed_file].into_iter().chain(of_fill)
}

/// Gives a file a second name, by a hard link where the file system has them, else by a copy.
fn link(file: &Path, name: &Path) -> Result<()> {
    if fs::hard_link(file, name).is_err() {
        fs::copy(file, name).map_err(Error::io(file, "copy it"))?;
    }
    Ok(())
}

fn versions_in(folder: &Path) -> Result<Vec<String>> {
    let mut names = names_in(folder)?;
    names.retain(|name| is_version(name));
    Ok(names)
}
