//! The stacks of a project on disk: written whole, replaced by one rename, never over a file that
//! somebody changed.
//!
//! ```text
//! stacks/<photo>/stack.json            names its files as 3fa9c1d20b7e/left.png
//! stacks/<photo>/3fa9c1d20b7e/         one version: the files, and files.json with their hashes
//! stacks/+new-…/                       a version that is being written
//! inbox/<photo>/                       what was changed by hand and stood in the way
//! cache/stamps/<photo>.json            times of files; saves hashing them
//! ```
//!
//! A version is written and synced under `stacks/+new-…`, gets its name, a hash of its content, and
//! becomes current by the rename of `stack.json`: the one rename that also replaces, on every
//! system (a folder that is not empty cannot be replaced by one). Only then is the old version
//! cleared away: files that are as we wrote them are removed, all others go to `inbox/`. After a
//! kill at any moment `stack.json` names whole files, old or new; what is left over here is
//! cleared by the next [`StackStore::clean`]. A reader that had read the old `stack.json` finds its files gone,
//! never mixed with new ones, and reads again.

use std::fs;
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::atomic::{remove_leftovers, sync_folder, write_atomically};
use super::hash::{hash_bytes, hash_file};
use super::inbox::{keep_in_inbox, move_to_inbox};
use super::json::{read_json, to_json};
use super::stack_files::{RECORD, StackFiles, Stamps, State, is_version, names_in};
use crate::document::names::{file_name_of_photo, photo_of_file_name};
use crate::document::stack::LayerFill;
use crate::document::stack::STACK_VERSION;
use crate::document::{ImageLayer, Stack};
use crate::error::{Error, Result};

const STACK_FILE: &str = "stack.json";
const UNFINISHED: &str = "+new-";
const LARGEST_STACK: u64 = 1 << 30;
const REMEDY: &str = "run `quadratura build` to make it again";
/// Files that desktops strew into folders; nobody's work.
pub const LITTER: [&str; 3] = [".DS_Store", "Thumbs.db", "desktop.ini"];

/// The stacks of the project in one folder. Reading needs no lock; whoever writes holds the
/// project's ([`super::lock::ProjectLock`]).
#[derive(Debug, Clone)]
pub struct StackStore {
    project: PathBuf,
    keeps_former: bool,
}

/// What became of a commit.
#[derive(Debug, Clone, PartialEq)]
pub struct Committed {
    /// The stack as it is on disk, its files named relative to [`StackStore::folder`].
    pub stack: Stack,
    /// Where in `inbox/` files are now that somebody had changed.
    pub kept: Vec<PathBuf>,
}

impl StackStore {
    /// The stacks of the project in the folder `project`.
    pub fn new(project: impl Into<PathBuf>) -> Self {
        Self { project: project.into(), keeps_former: false }
    }

    /// Former versions of stacks stay until somebody says [`Self::clear_former`]: a view shows them, and
    /// reads their files as it needs them.
    pub fn keeping_former(self) -> Self {
        Self { keeps_former: true, ..self }
    }

    /// The folder of a photo's stack; the files that the stack names are relative to it.
    pub fn folder(&self, photo: &str) -> PathBuf {
        self.stacks().join(file_name_of_photo(photo))
    }

    /// The current stack of `photo`, if it has one.
    ///
    /// # Errors
    /// [`Error::Input`] when `stack.json` is broken or of another version, [`Error::Io`].
    pub fn current(&self, photo: &str) -> Result<Option<Stack>> {
        let file = self.folder(photo).join(STACK_FILE);
        let stack: Stack = match read_json(&file, LARGEST_STACK, REMEDY) {
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
        Ok(Some(stack))
    }

    /// The current stack of `photo` if it was made of `inputs` and all its files are as they were
    /// written; else it has to be built.
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
        let stamps = Stamps::read(&self.stamps_file(photo));
        if !record.all_intact(&folder, &stamps)? {
            return Ok(None);
        }
        let fresh = Stamps::of(&record, &folder);
        if fresh != stamps {
            fresh.write(&self.stamps_file(photo));
        }
        Ok(Some(stack))
    }

    /// The photos that have a stack, sorted, whether they still belong to the project or not.
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

    /// Starts a new version of the stack of `photo`.
    ///
    /// # Errors
    /// [`Error::Io`] when the project cannot be written to.
    pub fn begin(&self, photo: &str) -> Result<StackWriter> {
        let stacks = self.stacks();
        fs::create_dir_all(&stacks).map_err(Error::io(&stacks, "create the folder"))?;
        let mut builder = tempfile::Builder::new();
        builder.prefix(UNFINISHED);
        // A temporary folder is private by default, but this one becomes an ordinary one.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
        let folder = builder.tempdir_in(&stacks).map_err(Error::io(&stacks, "create a folder in it"))?;
        Ok(StackWriter { store: self.clone(), photo: photo.to_owned(), folder })
    }

    /// Starts a new version of a current stack, with all files that it names but those of a filling, and
    /// the stack as [`StackWriter::commit`] takes it: without a filling, its files by their bare names.
    ///
    /// # Errors
    /// [`Error::Io`] when a file is gone or the project cannot be written to.
    pub fn amend(&self, stack: &Stack) -> Result<(StackWriter, Stack)> {
        let mut bare = stack.clone();
        bare.bytes -= bare.fill.take().map_or(0, |fill| fill.bytes.min(stack.bytes));
        bare.image_layers.iter_mut().for_each(|layer| layer.fill = None);
        let writer = self.begin_with(&mut bare)?;
        Ok((writer, bare))
    }

    /// Makes what a stack says of the current one, such as names, true on disk: all its files stay as they
    /// are.
    ///
    /// # Errors
    /// [`Error::Io`]; the old stack stays as it was.
    pub fn restate(&self, stack: &Stack) -> Result<Committed> {
        let mut bare = stack.clone();
        let writer = self.begin_with(&mut bare)?;
        writer.commit(bare)
    }

    /// Starts a new version with the files that a current stack names, which then names them barely.
    fn begin_with(&self, stack: &mut Stack) -> Result<StackWriter> {
        let (writer, home) = (self.begin(&stack.photo.name)?, self.folder(&stack.photo.name));
        for file in stack.image_layers.iter_mut().flat_map(files_of) {
            let name = file.rsplit('/').next().unwrap_or_default().to_owned();
            link(&home.join(&*file), &writer.folder().join(&name))?;
            *file = name;
        }
        Ok(writer)
    }

    /// What went wrong while the stack of `photo` was written, told of the place where it was to be: nobody knows the
    /// folder in which it is made.
    pub fn at_home(&self, photo: &str, error: Error) -> Error {
        let Error::Io { path, doing, source } = error else { return error };
        let is_new =
            |path: &Path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(UNFINISHED));
        let within = path.parent().is_some_and(is_new);
        let home = self.folder(photo);
        let path = match path.file_name() {
            Some(name) if within => home.join(name),
            Some(_) if is_new(&path) => home,
            _ => path,
        };
        Error::Io { path, doing, source }
    }

    /// What somebody cut or took away of the files of a photo's current stack; none where they are whole. Told by their
    /// sizes, and by how a PNG ends: one that somebody painted on is whole.
    pub fn damage(&self, photo: &str) -> Option<Error> {
        let folder = self.folder(photo).join(self.current_version(photo)?);
        let record = StackFiles::read(&folder)?;
        record.files.iter().find_map(|(name, written)| {
            let path = folder.join(name);
            let found = match fs::metadata(&path) {
                Err(_) => "it is gone".to_owned(),
                Ok(data) if data.len() == written.bytes || ends_as_png(&path) => return None,
                Ok(data) => format!("{} bytes, {} were written: it is cut short", data.len(), written.bytes),
            };
            Some(Error::input(path, "", found, REMEDY))
        })
    }

    /// Clears away what killed builds left over, and former versions where they are not kept. Returns where in `inbox/` files are now that
    /// somebody had changed.
    ///
    /// # Errors
    /// [`Error::Io`] when something cannot be removed.
    pub fn clean(&self) -> Result<Vec<PathBuf>> {
        remove_leftovers(&self.project)?;
        if !self.stacks().is_dir() {
            return Ok(Vec::new());
        }
        for name in names_in(&self.stacks())?.iter().filter(|name| name.starts_with(UNFINISHED)) {
            let path = self.stacks().join(name);
            fs::remove_dir_all(&path).map_err(Error::io(&path, "remove it"))?;
        }
        // Also where a build was killed before the photo had its first stack.
        for folder in names_in(&self.stacks())?.iter().map(|name| self.stacks().join(name)) {
            if folder.is_dir() {
                remove_leftovers(&folder)?;
            }
        }
        if self.keeps_former { Ok(Vec::new()) } else { self.clear_former() }
    }

    /// Clears versions of stacks away that are no longer current; nobody may write a stack meanwhile. Returns where in
    /// `inbox/` files are now that somebody had changed.
    ///
    /// # Errors
    /// [`Error::Io`] when something cannot be removed.
    pub fn clear_former(&self) -> Result<Vec<PathBuf>> {
        let mut kept = Vec::new();
        for photo in self.photos()? {
            if let Some(current) = self.current_version(&photo) {
                kept.extend(self.clear_versions_but(&photo, &current)?);
            }
        }
        Ok(kept)
    }

    /// The project's folder.
    pub fn project(&self) -> &Path {
        &self.project
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

    /// The version whose record knows `stack.json` as it is; `None` when that was changed by hand.
    fn current_version(&self, photo: &str) -> Option<String> {
        let folder = self.folder(photo);
        let stack = hash_file(folder.join(STACK_FILE)).ok()?;
        let knows = |version: &String| {
            StackFiles::read(&folder.join(version)).is_some_and(|record| record.stack == stack)
        };
        versions_in(&folder).ok()?.into_iter().find(knows)
    }

    fn clear_versions_but(&self, photo: &str, current: &str) -> Result<Vec<PathBuf>> {
        let stamps = Stamps::read(&self.stamps_file(photo));
        let mut kept = Vec::new();
        for version in versions_in(&self.folder(photo))?.iter().filter(|version| *version != current) {
            kept.extend(clear(&self.folder(photo).join(version), &self.inbox(photo), &stamps)?);
        }
        Ok(kept)
    }
}

/// A new version of a stack. Dropped without a commit, it vanishes.
#[derive(Debug)]
pub struct StackWriter {
    store: StackStore,
    photo: String,
    folder: TempDir,
}

impl StackWriter {
    /// Where to put the files; no folders in it.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Makes the files in the folder, together with `stack`, the photo's current stack. `stack`
    /// names each by its bare name. What somebody changed in the old version goes to `inbox/`.
    ///
    /// # Errors
    /// [`Error::Io`], for instance on a full disk; the old stack stays as it was.
    pub fn commit(self, mut stack: Stack) -> Result<Committed> {
        let mut record = StackFiles::sync_and_record(self.folder())?;
        let version = record.version(&to_json(&stack));
        let files = stack.image_layers.iter_mut().flat_map(files_of);
        files.for_each(|file| *file = format!("{version}/{file}"));
        let text = to_json(&stack);
        record.stack = hash_bytes(&text);
        write_atomically(self.folder().join(RECORD), &to_json(&record))?;

        let mut kept = self.put_in_place(&version, &record)?;
        kept.extend(self.replace_stack_file(&text)?);
        if !self.store.keeps_former {
            kept.extend(self.store.clear_versions_but(&self.photo, &version)?);
        }
        let place = self.home().join(version);
        Stamps::of(&record, &place).write(&self.store.stamps_file(&self.photo));
        Ok(Committed { stack, kept })
    }

    fn home(&self) -> PathBuf {
        self.store.folder(&self.photo)
    }

    /// Gives the new version its name. Nobody reads it yet, unless the same was there already.
    fn put_in_place(&self, version: &str, record: &StackFiles) -> Result<Vec<PathBuf>> {
        let place = self.home().join(version);
        fs::create_dir_all(self.home()).map_err(Error::io(self.home(), "create the folder"))?;
        sync_folder(self.store.stacks())?;
        let kept = if place.exists() {
            self.mend(&place, record)?
        } else {
            fs::rename(self.folder(), &place).map_err(Error::io(&place, "put the stack in place"))?;
            Vec::new()
        };
        sync_folder(self.home())?;
        Ok(kept)
    }

    /// The same version is there already: puts right, file by file, what was changed or lost.
    fn mend(&self, place: &Path, record: &StackFiles) -> Result<Vec<PathBuf>> {
        let stamps = Stamps::read(&self.store.stamps_file(&self.photo));
        let mut kept = Vec::new();
        for name in record.files.keys().map(String::as_str).chain([RECORD]) {
            let state = if name == RECORD { State::Missing } else { record.state(place, name, &stamps)? };
            if state == State::Changed {
                kept.push(keep_in_inbox(&place.join(name), &self.store.inbox(&self.photo))?);
            }
            if state != State::Intact {
                let target = place.join(name);
                fs::rename(self.folder().join(name), &target).map_err(Error::io(&target, "replace it"))?;
            }
        }
        sync_folder(place)?;
        Ok(kept)
    }

    /// The rename that makes the new version current.
    fn replace_stack_file(&self, text: &[u8]) -> Result<Option<PathBuf>> {
        let file = self.home().join(STACK_FILE);
        let changed = file.is_file() && self.store.current_version(&self.photo).is_none();
        let inbox = self.store.inbox(&self.photo);
        let kept = changed.then(|| keep_in_inbox(&file, &inbox)).transpose()?;
        write_atomically(&file, text)?;
        Ok(kept)
    }
}

/// The last chunk of a PNG: without it, it was not written to its end.
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

/// The names of all files of an image layer.
fn files_of(layer: &mut ImageLayer) -> impl Iterator<Item = &mut String> {
    let ImageLayer { file, needed_file, fill, .. } = layer;
    let of_fill = fill.iter_mut().flat_map(LayerFill::files_mut);
    [file, needed_file].into_iter().chain(of_fill)
}

/// The same file under another name: at no cost where the file system can, else as a copy.
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

/// Removes the folder of a version that is no longer current. Its record goes last, so that a kill
/// never turns a file of ours into one of unknown origin.
fn clear(version: &Path, inbox: &Path, stamps: &Stamps) -> Result<Vec<PathBuf>> {
    let record = StackFiles::read(version).unwrap_or_default();
    let mut kept = Vec::new();
    for name in names_in(version)? {
        let path = version.join(&name);
        if LITTER.contains(&name.as_str()) || record.state(version, &name, stamps)? == State::Intact {
            fs::remove_file(&path).map_err(Error::io(&path, "remove it"))?;
        } else {
            kept.push(move_to_inbox(&path, inbox)?);
        }
    }
    let _ = fs::remove_file(version.join(RECORD));
    match fs::remove_dir(version) {
        // Somebody saved a file there just now: the next `clean` takes it to the inbox.
        Err(error) if error.kind() == ErrorKind::DirectoryNotEmpty => Ok(kept),
        removed => removed.map(|()| kept).map_err(Error::io(version, "remove it")),
    }
}
