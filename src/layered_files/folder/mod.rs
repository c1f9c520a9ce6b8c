//! Writes a folder of PNG files, which every image editor can open.

pub mod read;

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use tempfile::TempDir;

use crate::document::{LayeredDocument, PixelLayer};
use crate::format::LayeredFormat;
use crate::png::write_rgba;
use quadratura_base::error::{Error, Result};
use quadratura_document::export_record::ExportFormat;
use quadratura_files::atomic::{mark_in_use, sync_folder};

/// The entry in the table of formats.
pub const FORMAT: LayeredFormat = LayeredFormat {
    format: ExportFormat::Folder,
    title: "Folder of PNG",
    name: "folder",
    about: "A folder of PNG files with stack.json",
    file: None,
};

/// The sub-folder of guides.
const GUIDES: &str = "guides";

/// The file name of the guide of trees.
pub const TREE_GUIDE_FILE: &str = "guides/trees.png";

/// Returns the file name of an order's guide.
pub fn guide_file(order: u32) -> String {
    format!("{GUIDES}/order-{order:02}.png")
}

/// Returns the order of a guide by the name of its file, without folder and extension.
fn order_of_guide(stem: &str) -> Option<u32> {
    stem.strip_prefix("order-")?.parse().ok()
}

/// A folder that is being written. [`NewFolder::commit`] puts it in place; dropped before that, it vanishes.
#[derive(Debug)]
pub struct NewFolder {
    folder: TempDir,
    target: PathBuf,
    /// Paths below `folder`, with `/`.
    files: Vec<String>,
    /// The mark that the folder is being written; systems that open no folders have none.
    _in_use: Option<File>,
}

impl NewFolder {
    /// Starts a folder that will become `target`.
    ///
    /// # Errors
    /// [`Error::Io`] when the parent folder does not exist or is not writable.
    pub fn create(target: impl Into<PathBuf>) -> Result<Self> {
        let target = target.into();
        let mut builder = tempfile::Builder::new();
        builder.prefix(".quadratura-");
        // Temporary folders are private by default, but this one becomes an ordinary folder.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
        let folder = builder.tempdir_in(parent_of(&target)).map_err(Error::io(&target, "create it"))?;
        let in_use = File::open(folder.path()).ok();
        if let Some(folder) = &in_use {
            mark_in_use(folder);
        }
        Ok(Self { folder, target, files: Vec::new(), _in_use: in_use })
    }

    /// Changes the target to another path in the same folder.
    pub fn redirect(&mut self, target: impl Into<PathBuf>) {
        self.target = target.into();
    }

    /// Returns the temporary path that the folder has until the commit.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Returns the files added so far, relative to [`NewFolder::path`], with `/`.
    pub fn files(&self) -> &[String] {
        &self.files
    }

    /// Adds a file with these bytes. `name` may contain sub-folders, with `/`.
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn add(&mut self, name: &str, bytes: &[u8]) -> Result<()> {
        self.add_with(name, |out| out.write_all(bytes))
    }

    /// Adds a copy of a file.
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn copy(&mut self, name: &str, from: &Path) -> Result<()> {
        let mut file = File::open(from).map_err(Error::io(from, "open it"))?;
        self.add_with(name, |out| std::io::copy(&mut file, out).map(drop))
    }

    /// Adds the layers of a document for which `name_of` returns a name, as PNG files.
    ///
    /// # Errors
    /// [`Error::Io`], and the errors of the layers' sources.
    pub fn add_layers<'a>(
        &mut self,
        document: &LayeredDocument<'a>,
        name_of: impl Fn(&PixelLayer<'a>) -> Option<String>,
    ) -> Result<()> {
        let named = document.layers().filter_map(|layer| Some((name_of(layer)?, layer)));
        let named: Vec<_> = named.collect();
        named.par_iter().try_for_each(|(name, layer)| {
            let pixels = document.pixels_of(layer)?;
            write_file(&self.path().join(name), |out| write_rgba(out, &pixels, document.icc.as_deref()))
        })?;
        self.files.extend(named.into_iter().map(|(name, _)| name));
        Ok(())
    }

    fn add_with(
        &mut self,
        name: &str,
        write: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
    ) -> Result<()> {
        write_file(&self.path().join(name), write)?;
        self.files.push(name.to_owned());
        Ok(())
    }

    /// Moves the folder to its target and replaces what was there. A folder cannot be replaced by one rename:
    /// a kill between the two leaves the old one beside the target, under `.quadratura-old-`.
    ///
    /// # Errors
    /// [`Error::Io`] when the system refuses; the old folder stays, at worst under that name.
    pub fn commit(self) -> Result<()> {
        let Self { folder, target, .. } = self;
        sync_folder(folder.path())?;
        let old = tempfile::Builder::new().prefix(".quadratura-old-").tempdir_in(parent_of(&target));
        let old = old.map_err(Error::io(&target, "create a folder beside it"))?;
        if target.exists() {
            fs::rename(&target, old.path().join("old")).map_err(Error::io(&target, "move it away"))?;
        }
        if let Err(error) = fs::rename(folder.path(), &target) {
            if fs::rename(old.path().join("old"), &target).is_err() {
                let _kept = old.keep();
            }
            return Err(Error::io(&target, "put it in place")(error));
        }
        sync_folder(parent_of(&target))
    }
}

/// Writes and syncs a file, and creates its folder if needed.
fn write_file(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>) -> Result<()> {
    let write_and_sync = || {
        fs::create_dir_all(parent_of(path))?;
        let mut out = BufWriter::with_capacity(1 << 18, File::create(path)?);
        write(&mut out)?;
        out.flush()?;
        out.get_ref().sync_all()
    };
    write_and_sync().map_err(Error::io(path, "write it"))
}

/// Returns the folder that contains `path`; `.` for a bare name.
fn parent_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_folder_replaces_the_old_one_whole() {
        let parent = tempfile::tempdir().unwrap();
        let target = parent.path().join("photo");
        for (name, content) in [("old.png", "old"), ("needed/new.png", "new")] {
            let mut folder = NewFolder::create(&target).unwrap();
            folder.add(name, content.as_bytes()).unwrap();
            assert_eq!(folder.files(), [name]);
            folder.commit().unwrap();
            assert_eq!(fs::read_to_string(target.join(name)).unwrap(), content);
        }
        assert!(!target.join("old.png").exists());
        assert_eq!(fs::read_dir(parent.path()).unwrap().count(), 1, "nothing else is left");
    }

    #[test]
    fn an_exported_folder_without_its_description_says_what_is_missing() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(super::super::KEY_FILE), "key").unwrap();
        let message = read::read(folder.path()).unwrap_err().to_string();
        assert!(
            message.contains("stack.json: it is missing, and every exported folder has one"),
            "{message}"
        );
        assert!(message.contains("; restore stack.json from the export"), "{message}");
    }

    #[test]
    fn a_folder_that_is_given_up_leaves_nothing() {
        let parent = tempfile::tempdir().unwrap();
        NewFolder::create(parent.path().join("photo")).unwrap().add("a", b"a").unwrap();
        assert_eq!(fs::read_dir(parent.path()).unwrap().count(), 0);
    }
}
