//! What is removed of stacks: what killed programs left over, and versions that are no longer current.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::{DESKTOP_FILES, StackStore, UNFINISHED, versions_in};
use crate::in_use::{self, one_name};
use crate::photo_lock::WorkLock;
use crate::stack_files::{FileState, FileTimes, RECORD, StackFiles, names_in};
use crate::stack_readers::{are_read, are_read_by_others};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_document::names::photo_of_file_name;
use quadratura_files::atomic::remove_leftovers;
use quadratura_files::inbox::move_to_inbox;
use quadratura_files::lock::ProjectLock;

impl StackStore {
    /// Waits for the lock of `photo`, and removes what a killed program left over of its stack. Returns the lock, and the paths in
    /// `inbox/` of files that were changed by the user.
    ///
    /// # Errors
    /// [`Error::Io`] when something cannot be removed; [`Error::Cancelled`].
    pub fn lock(&self, photo: &str, task: &Task) -> Result<(WorkLock, Vec<PathBuf>)> {
        let lock = WorkLock::of_photo(&self.project, photo, task)?;
        let kept = self.clean_photo(photo)?;
        Ok((lock, kept))
    }

    /// Removes what killed builds left over, and former versions unless they are kept; not of photos that another program works
    /// on. Returns the paths in `inbox/` of files that were changed by the user.
    ///
    /// # Errors
    /// [`Error::Io`] when something cannot be removed.
    pub fn clean(&self) -> Result<Vec<PathBuf>> {
        let is_own = ProjectLock::holder_of(&self.project).is_some_and(|holder| holder.is_this_process());
        let lock = ProjectLock::take(&self.project);
        if is_own || lock.is_ok() {
            remove_leftovers(&self.project)?;
        }
        drop(lock);
        let mut kept = Vec::new();
        if !self.stacks().is_dir() {
            return Ok(kept);
        }
        // This includes builds that were killed before the photo had its first stack.
        for photo in names_in(&self.stacks())?.iter().filter_map(|name| photo_of_file_name(name)) {
            if let Some(_lock) = WorkLock::try_of_photo(&self.project, &photo) {
                kept.extend(self.clean_photo(&photo)?);
            }
        }
        Ok(kept)
    }

    /// Removes what killed builds left over of a photo's stack, and former versions unless they are kept. The caller has its lock.
    fn clean_photo(&self, photo: &str) -> Result<Vec<PathBuf>> {
        let folder = self.folder(photo);
        if !folder.is_dir() {
            return Ok(Vec::new());
        }
        remove_leftovers(&folder)?;
        for name in names_in(&folder)?.iter().filter(|name| name.starts_with(UNFINISHED)) {
            let path = folder.join(name);
            fs::remove_dir_all(&path).map_err(Error::io(&path, "remove it"))?;
        }
        if self.keeps_former() { Ok(Vec::new()) } else { self.clear_versions_of(photo) }
    }

    /// Removes versions of stacks that are no longer current, but those that stacks in memory name, those of photos that another
    /// program works on, and none while another program reads stacks. Returns the paths in `inbox/` of files that were changed by
    /// the user.
    ///
    /// # Errors
    /// [`Error::Io`] when something cannot be removed.
    pub fn clear_former(&self) -> Result<Vec<PathBuf>> {
        let mut kept = Vec::new();
        if are_read_by_others(&self.project) {
            return Ok(kept);
        }
        for photo in self.photos()? {
            if let Some(_lock) = WorkLock::try_of_photo(&self.project, &photo) {
                kept.extend(self.clear_versions_of(&photo)?);
            }
        }
        Ok(kept)
    }

    /// Does what [`Self::clear_former`] does for one photo.
    ///
    /// # Errors
    /// As [`Self::clear_former`].
    pub fn clear_former_of(&self, photo: &str) -> Result<Vec<PathBuf>> {
        if self.keeps_former() {
            return Ok(Vec::new());
        }
        match WorkLock::try_of_photo(&self.project, photo) {
            Some(_lock) => self.clear_versions_of(photo),
            None => Ok(Vec::new()),
        }
    }

    /// Notes that a version that is no longer current was left for a program that reads it.
    pub(super) fn note_former(&self) {
        let file = self.former_file();
        // Without the note they stay until the next command that is about all photos.
        let _ = file
            .parent()
            .map(fs::create_dir_all)
            .and_then(|made| made.and_then(|()| fs::write(&file, "")).ok());
    }

    /// Removes what was left for programs that read stacks, once none does; this one no longer. Returns the paths in `inbox/` of
    /// files that were changed by the user.
    ///
    /// # Errors
    /// As [`Self::clear_former`].
    pub fn clear_left(&self) -> Result<Vec<PathBuf>> {
        if are_read(&self.project) || fs::remove_file(self.former_file()).is_err() {
            return Ok(Vec::new());
        }
        self.clear_former()
    }

    fn former_file(&self) -> PathBuf {
        self.project.join("cache/former")
    }

    fn clear_versions_of(&self, photo: &str) -> Result<Vec<PathBuf>> {
        let _replacing = in_use::replacing();
        let Some(current) = self.current_version(photo) else { return Ok(Vec::new()) };
        let folder = one_name(&self.folder(photo));
        let is_used = |version: &String| in_use::is_held(&folder.join(version), &[]);
        self.clear_versions_but(photo, &current, is_used)
    }

    pub(super) fn clear_versions_but(
        &self,
        photo: &str,
        current: &str,
        is_used: impl Fn(&String) -> bool,
    ) -> Result<Vec<PathBuf>> {
        let stamps = FileTimes::read(&self.stamps_file(photo));
        let mut kept = Vec::new();
        let former = |version: &&String| *version != current && !is_used(version);
        for version in versions_in(&self.folder(photo))?.iter().filter(former) {
            kept.extend(remove_version(&self.folder(photo).join(version), &self.inbox(photo), &stamps)?);
        }
        Ok(kept)
    }
}

/// Removes the folder of a version that is no longer current. The record goes last, so that after a kill the
/// program's own files are still recognised.
fn remove_version(version: &Path, inbox: &Path, stamps: &FileTimes) -> Result<Vec<PathBuf>> {
    let record = StackFiles::read(version).unwrap_or_default();
    let mut kept = Vec::new();
    for name in names_in(version)? {
        let path = version.join(&name);
        if DESKTOP_FILES.contains(&name.as_str())
            || record.state(version, &name, stamps)? == FileState::Intact
        {
            fs::remove_file(&path).map_err(Error::io(&path, "remove it"))?;
        } else {
            kept.push(move_to_inbox(&path, inbox)?);
        }
    }
    let _ = fs::remove_file(version.join(RECORD));
    match fs::remove_dir(version) {
        // A file was saved there just now: the next `clean` moves it to the inbox.
        Err(error) if error.kind() == ErrorKind::DirectoryNotEmpty => Ok(kept),
        removed => removed.map(|()| kept).map_err(Error::io(version, "remove it")),
    }
}
