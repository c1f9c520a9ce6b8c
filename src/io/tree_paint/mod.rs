//! The paint of a project's species on disk: authored, and replaced as a whole.
//!
//! ```text
//! paint/trees/trees.json               what was painted in which file, and the last ten imports
//! paint/trees/maple-9c1f….coat         the points of one painted layer
//! ```
//!
//! A file of points is never changed: its name holds a hash of its content. An import writes and syncs new files and then replaces
//! `trees.json` by one rename; only after that are files removed that the old one named and the new one does not.

mod points;

use std::fs;
use std::path::{Path, PathBuf};

use self::points::{REMEDY, coat_bytes, parse_coat};
use quadratura_base::error::{Error, Result};
use quadratura_document::names::file_name_of_photo;
use quadratura_document::tree_paint::{TREE_PAINT_VERSION, TreePaintBook};
use quadratura_files::atomic::{remove_leftovers, write_atomically};
use quadratura_files::hash::{hash_bytes, hash_file};
use quadratura_files::json::{read_json, to_json};
use quadratura_foliage::PaintedSlab;

const BOOK: &str = "trees.json";
/// The extension of files of points.
const COAT: &str = "coat";
/// Larger books are not of this program.
const LARGEST_BOOK: u64 = 1 << 28;
/// The number of hexadecimal digits of the hash in a file's name.
const DIGITS: usize = 12;
/// The longest readable part of a file's name in bytes.
const LONGEST_READABLE: usize = 120;
/// What to do about a damaged book.
const BOOK_REMEDY: &str =
    "restore it from a copy of the project; to start without that paint, move the folder away";

/// The store of the paint of a project's species. Writers hold the project's lock.
#[derive(Debug, Clone)]
pub struct TreePaintStore {
    folder: PathBuf,
}

impl TreePaintStore {
    /// Returns the store of the project in the folder `project`.
    pub fn new(project: &Path) -> Self {
        Self { folder: project.join("paint").join("trees") }
    }

    /// Reads the book; it is empty where there is no paint yet.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Input`] when the book is damaged or of another version, or when it is missing although files of points
    /// are there.
    pub fn read(&self) -> Result<TreePaintBook> {
        let file = self.folder.join(BOOK);
        if !file.exists() {
            let coats = self.coats()?;
            return match coats.first() {
                None => Ok(TreePaintBook::default()),
                Some(first) => {
                    let found =
                        format!("it is missing, but {} files of paint are there: {first}, ...", coats.len());
                    Err(Error::input(file, "the file", found, BOOK_REMEDY))
                }
            };
        }
        let book: TreePaintBook = read_json(&file, LARGEST_BOOK, BOOK_REMEDY)?;
        if book.version != TREE_PAINT_VERSION {
            let found = format!("version {}, this program reads version {TREE_PAINT_VERSION}", book.version);
            return Err(Error::input(file, "version", found, "use the program that wrote it"));
        }
        Ok(book)
    }

    /// Reads the points of a coat by the name of its file.
    ///
    /// # Errors
    /// [`Error::Input`] when the file is missing or damaged; [`Error::Io`].
    pub fn coat(&self, name: &str) -> Result<PaintedSlab> {
        let file = self.folder.join(name);
        if !file.is_file() {
            let found = "the file is missing, and with it the paint of one layer; expected the file that trees.json names";
            return Err(Error::input(file, "", found, REMEDY));
        }
        let bytes = fs::read(&file).map_err(Error::io(&file, "read it"))?;
        parse_coat(&file, &bytes)
    }

    /// Stores the points of a coat of a species; returns the name of the file. They become part of the project when a book that names
    /// the file is committed.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn add(&self, species: &str, coat: &PaintedSlab) -> Result<String> {
        let bytes = coat_bytes(coat);
        let name = name_of(species, &bytes);
        let target = self.folder.join(&name);
        if target.is_file() && hash_file(&target)? == hash_bytes(&bytes) {
            return Ok(name);
        }
        fs::create_dir_all(&self.folder).map_err(Error::io(&self.folder, "create the folder"))?;
        let book = self.folder.join(BOOK);
        // Points without a book would be taken for those of a lost one.
        if !book.exists() {
            write_atomically(&book, &to_json(&TreePaintBook::default()))?;
        }
        write_atomically(&target, &bytes)?;
        Ok(name)
    }

    /// Returns the name of the file that [`Self::add`] would write.
    pub fn name_of(species: &str, coat: &PaintedSlab) -> String {
        name_of(species, &coat_bytes(coat))
    }

    /// Makes `book` the project's book by one rename, and removes files that `before` named and it does not.
    ///
    /// # Errors
    /// [`Error::Io`]; when the rename failed, the old book still holds, with all its files.
    pub fn commit(&self, book: &TreePaintBook, before: &TreePaintBook) -> Result<()> {
        fs::create_dir_all(&self.folder).map_err(Error::io(&self.folder, "create the folder"))?;
        let file = self.folder.join(BOOK);
        write_atomically(&file, &to_json(book))?;
        let named = book.files();
        for name in before.files().into_iter().filter(|name| !named.contains(name)) {
            let old = self.folder.join(name);
            if old.is_file() && is_ours(&old)? {
                fs::remove_file(&old).map_err(Error::io(&old, "remove it"))?;
            }
        }
        remove_leftovers(&self.folder)?;
        if book.is_empty() && self.coats()?.is_empty() {
            fs::remove_file(&file).map_err(Error::io(&file, "remove it"))?;
            // Files of others stay, and the folder with them.
            let _ = fs::remove_dir(&self.folder);
            let _ = self.folder.parent().map(fs::remove_dir);
        }
        Ok(())
    }

    /// Lists the files of points, sorted.
    fn coats(&self) -> Result<Vec<String>> {
        if !self.folder.is_dir() {
            return Ok(Vec::new());
        }
        let mut names = Vec::new();
        for entry in fs::read_dir(&self.folder).map_err(Error::io(&self.folder, "read the folder"))? {
            let path = entry.map_err(Error::io(&self.folder, "read the folder"))?.path();
            if path.extension().is_some_and(|extension| extension == COAT) {
                names.extend(path.file_name().map(|name| name.to_string_lossy().into_owned()));
            }
        }
        names.sort();
        Ok(names)
    }
}

fn name_of(species: &str, bytes: &[u8]) -> String {
    let mut readable = file_name_of_photo(species);
    while readable.len() > LONGEST_READABLE {
        readable.pop();
    }
    format!("{readable}-{}.{COAT}", &hash_bytes(bytes)[..DIGITS])
}

/// Returns whether this program wrote the file unchanged: its name holds the hash of its content.
fn is_ours(file: &Path) -> Result<bool> {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let Some((_, hash)) = stem.rsplit_once('-') else { return Ok(false) };
    Ok(hash.len() == DIGITS && hash_file(file)?.starts_with(hash))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use quadratura_document::tree_paint::TreeCoat;
    use quadratura_foliage::{Change, PaintPoint};

    fn coat(x: f32) -> PaintedSlab {
        let change = Change { colour: Vec3::X, alpha: 1.0 };
        let points = vec![PaintPoint { at: Vec3::new(x, 0.0, 0.0), change, leaf: true }];
        let (corner, beside) = ([0.0; 2], Vec::new());
        PaintedSlab { direction: 0, slab: 1, delta: 0.5, corner, far: 1.0, points, beside }
    }

    fn named(file: &str) -> TreePaintBook {
        let coat = TreeCoat {
            species: "map/le".into(),
            part: None,
            document: "k@a".into(),
            layer: "t".into(),
            import: 1,
            file: file.into(),
            texels: 1,
            erased: 0,
            beside: 0,
        };
        TreePaintBook { coats: vec![coat], ..TreePaintBook::default() }
    }

    #[test]
    fn a_replaced_coat_is_removed_after_the_book_and_nothing_is_left_without_paint() {
        let project = tempfile::tempdir().unwrap();
        let store = TreePaintStore::new(project.path());
        let (one, two) = (store.add("map/le", &coat(1.0)).unwrap(), store.add("map/le", &coat(2.0)).unwrap());
        assert!(one != two && one.starts_with("map%2Fle-"), "{one}");
        let (first, second) = (named(&one), named(&two));
        store.commit(&first, &TreePaintBook::default()).unwrap();
        assert_eq!((store.read().unwrap(), store.coat(&one).unwrap()), (first.clone(), coat(1.0)));
        store.commit(&second, &first).unwrap();
        let said = store.coat(&one).unwrap_err().to_string();
        assert!(said.contains(&one) && said.contains("missing"), "{said}");
        store.commit(&TreePaintBook::default(), &second).unwrap();
        assert!(store.read().unwrap().is_empty() && !project.path().join("paint").exists());
    }

    #[test]
    fn a_lost_or_damaged_book_is_told_with_its_file_and_no_paint_is_removed() {
        let project = tempfile::tempdir().unwrap();
        let store = TreePaintStore::new(project.path());
        let name = store.add("maple", &coat(1.0)).unwrap();
        assert!(store.read().unwrap().is_empty(), "an import that was stopped is no damage");
        let book = project.path().join("paint/trees/trees.json");
        for damage in ["{", "{\"version\": 9, \"coats\": [], \"imports\": []}"] {
            fs::write(&book, damage).unwrap();
            let said = store.read().unwrap_err().to_string();
            assert!(said.contains("trees.json"), "{said}");
        }
        fs::remove_file(&book).unwrap();
        let said = store.read().unwrap_err().to_string();
        assert!(said.contains("1 files of paint") && said.contains(&name) && said.contains("copy"), "{said}");
        assert!(project.path().join("paint/trees").join(&name).is_file());
    }
}
