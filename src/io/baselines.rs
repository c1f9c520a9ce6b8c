//! Stores the pixels of image layers as they were exported (`exports/pixels/`), named by their content. An
//! import compares with them to find paint, even after the stack was rebuilt or deleted. A layer without
//! paint is a hard link to the stack's own file and takes no space while that stack exists.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use quadratura_base::error::{Error, Result};
use quadratura_document::export_record::Baseline;
use quadratura_files::atomic::{link_atomically, write_atomically};
use quadratura_files::hash::{hash_bytes, hash_file};
use quadratura_layered_files::Raster;
use quadratura_layered_files::png::{read_rgba, write_rgba};

/// The folder `exports/pixels/`.
#[derive(Debug, Clone)]
pub struct Baselines {
    folder: PathBuf,
}

impl Baselines {
    /// Returns the store beside the records in `exports`; the folder need not exist yet.
    pub fn new(exports: &Path) -> Self {
        Self { folder: exports.join("pixels") }
    }

    /// Stores a file whose BLAKE3 is `hash`. Returns its name in the store.
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn store_file(&self, file: &Path, hash: &str) -> Result<String> {
        let name = format!("{hash}.png");
        let target = self.folder.join(&name);
        if !self.has(&name) {
            self.make_folder()?;
            // Two photos may store the same pixels at the same time.
            link_atomically(file, &target).map_err(Error::io(&target, "keep the exported pixels there"))?;
        }
        Ok(name)
    }

    /// Stores `raster` as a PNG. Returns the file's name in the store.
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn store_pixels(&self, raster: &Raster) -> Result<String> {
        let mut bytes = Vec::new();
        write_rgba(&mut bytes, raster, None).map_err(Error::io(&self.folder, "encode pixels for it"))?;
        self.store_bytes(&bytes, "png")
    }

    /// Stores `bytes` in a file with this extension. Returns its name in the store.
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn store_bytes(&self, bytes: &[u8], extension: &str) -> Result<String> {
        let name = format!("{}.{extension}", hash_bytes(bytes));
        if !self.has(&name) {
            self.make_folder()?;
            write_atomically(self.folder.join(&name), bytes)?;
        }
        Ok(name)
    }

    /// Reads the pixels of a layer as they were exported; `None` when they are no longer stored or the file
    /// was changed.
    ///
    /// # Errors
    /// [`Error::Io`] and [`Error::Input`] when the file exists and cannot be read.
    pub fn pixels(&self, baseline: &Baseline) -> Result<Option<Raster>> {
        if !self.has(&baseline.file) {
            return Ok(None);
        }
        read_rgba(&self.folder.join(&baseline.file), baseline.rect.w, baseline.rect.h).map(Some)
    }

    /// Reads the bytes of a stored file; `None` under the same conditions as [`Self::pixels`].
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn bytes(&self, name: &str) -> Result<Option<Vec<u8>>> {
        let file = self.folder.join(name);
        if !self.has(name) {
            return Ok(None);
        }
        fs::read(&file).map(Some).map_err(Error::io(&file, "read it"))
    }

    /// Removes the stored files that are not in `names`.
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn retain(&self, names: &BTreeSet<String>) -> Result<()> {
        if !self.folder.is_dir() {
            return Ok(());
        }
        quadratura_files::atomic::remove_leftovers(&self.folder)?;
        for entry in fs::read_dir(&self.folder).map_err(Error::io(&self.folder, "read the folder"))? {
            let path = entry.map_err(Error::io(&self.folder, "read the folder"))?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if is_name(&name) && !names.contains(&name) {
                fs::remove_file(&path).map_err(Error::io(&path, "remove it"))?;
            }
        }
        Ok(())
    }

    /// Returns whether a file of this name exists and still has the content that it was stored with.
    fn has(&self, name: &str) -> bool {
        let hash = name.split('.').next().unwrap_or_default();
        is_name(name) && hash_file(self.folder.join(name)).is_ok_and(|found| found == hash)
    }

    fn make_folder(&self) -> Result<()> {
        fs::create_dir_all(&self.folder).map_err(Error::io(&self.folder, "create the folder"))
    }
}

/// Returns whether `name` has the form of a stored file: a BLAKE3 hash and an extension.
fn is_name(name: &str) -> bool {
    let hash = name.split('.').next().unwrap_or_default();
    hash.len() == 64 && hash.bytes().all(|b| b.is_ascii_hexdigit()) && name.matches('.').count() == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::PixelRect;
    use quadratura_layered_files::Depth;

    fn baseline(file: String) -> Baseline {
        Baseline { file, rect: PixelRect { x: 5, y: 6, w: 3, h: 2 } }
    }

    #[test]
    fn pixels_outlive_the_stack_that_they_were_linked_from() {
        let folder = tempfile::tempdir().unwrap();
        let kept = Baselines::new(folder.path());
        let raster = Raster::blank(3, 2, Depth::Eight);
        let file = folder.path().join("stack.png");
        write_rgba(fs::File::create(&file).unwrap(), &raster, None).unwrap();
        let linked = baseline(kept.store_file(&file, &hash_file(&file).unwrap()).unwrap());
        assert_eq!(kept.store_pixels(&raster).unwrap(), linked.file, "the same content is there once");
        fs::remove_file(&file).unwrap();
        assert_eq!(kept.pixels(&linked).unwrap(), Some(raster));
    }

    #[test]
    fn a_file_that_was_changed_is_no_baseline_and_the_next_export_replaces_it() {
        let folder = tempfile::tempdir().unwrap();
        let kept = Baselines::new(folder.path());
        let raster = Raster::blank(3, 2, Depth::Sixteen);
        let kept_as = baseline(kept.store_pixels(&raster).unwrap());
        fs::write(folder.path().join("pixels").join(&kept_as.file), "other").unwrap();
        assert_eq!(kept.pixels(&kept_as).unwrap(), None);
        kept.store_pixels(&raster).unwrap();
        assert_eq!(kept.pixels(&kept_as).unwrap(), Some(raster));
    }

    #[test]
    fn photos_with_the_same_pixels_store_them_at_the_same_time() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("stack.png");
        fs::write(&file, "pixels").unwrap();
        let hash = hash_file(&file).unwrap();
        for round in 0..50 {
            let kept = Baselines::new(&folder.path().join(round.to_string()));
            let together = std::sync::Barrier::new(8);
            std::thread::scope(|scope| {
                for _ in 0..8 {
                    scope.spawn(|| {
                        together.wait();
                        kept.store_file(&file, &hash).unwrap();
                    });
                }
            });
            let stored = fs::read_dir(&kept.folder).unwrap().map(|entry| entry.unwrap().file_name());
            assert_eq!(stored.collect::<Vec<_>>(), [format!("{hash}.png").as_str()]);
        }
    }

    #[test]
    fn files_that_no_record_names_are_removed_and_other_files_stay() {
        let folder = tempfile::tempdir().unwrap();
        let kept = Baselines::new(folder.path());
        let names = [b"one", b"two"].map(|bytes| kept.store_bytes(bytes, "icc").unwrap());
        let foreign = folder.path().join("pixels/mine.png");
        fs::write(&foreign, "foreign").unwrap();
        kept.retain(&BTreeSet::from([names[0].clone()])).unwrap();
        assert_eq!(kept.bytes(&names[0]).unwrap().as_deref(), Some(&b"one"[..]));
        assert!(kept.bytes(&names[1]).unwrap().is_none() && foreign.is_file());
    }
}
