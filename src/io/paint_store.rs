//! The paint of a project on disk: authored, readable, and replaced as a whole.
//!
//! ```text
//! paint/paint.json                                all entries of paint, and the last ten imports
//! paint/<photo>/left wall-3-9c1f….png             what was painted on face 3 of "left wall"
//! paint/<photo>/left wall-3.beyond-77ab….png      what was painted past its outline
//! ```
//!
//! A file of paint is never changed: its name holds a hash of its content. An import writes and syncs new
//! files and then replaces `paint.json` by one rename. Only after that are files removed that the old
//! `paint.json` named and the new one does not. After a kill at any moment the old paint is there, or the new
//! one, complete; leftovers are listed in `unfinished.txt` and removed by the next import. So are the files of
//! former books that this program still has in memory, because a view may read them. No other picture
//! is ever removed.

use std::collections::BTreeSet;
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::in_use::{self, one_name};
use super::project::below;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::Samples;
use quadratura_document::names::file_name_of_photo;
use quadratura_document::paint::{PAINT_VERSION, PaintBook, PaintEntry, PaintPatch};
use quadratura_files::atomic::{remove_leftovers, write_atomically, write_atomically_with};
use quadratura_files::hash::{hash_bytes, hash_file};
use quadratura_files::json::{read_json, to_json};
use quadratura_layered_files::Raster;
use quadratura_layered_files::png::{read_rgba_as_stored, write_rgba};

const BOOK: &str = "paint.json";
/// Name of the file that lists the files of an unfinished import, one per line, as the book would name them.
pub(super) const UNFINISHED: &str = "unfinished.txt";
/// Limit on the size of the book in bytes; ten thousand entries with a history of as many take some tens of
/// MB.
const LARGEST_BOOK: u64 = 1 << 30;
const REMEDY: &str = "put the file back as the program wrote it (the pictures beside it hold the paint)";
/// How often the book is read while another program replaces it.
const TRIES: usize = 5;
/// Number of hexadecimal digits of the hash in a file's name.
const DIGITS: usize = 12;
/// Maximum length of the object's name in a file's name in bytes, so that the whole stays below the 255 of
/// file systems.
const LONGEST_READABLE: usize = 120;

/// The store of a project's paint. Writers must hold the project's lock.
#[derive(Debug, Clone)]
pub struct PaintStore {
    folder: PathBuf,
}

impl PaintStore {
    /// Returns the store of the project in the folder `project`.
    pub fn new(project: &Path) -> Self {
        Self { folder: project.join("paint") }
    }

    /// Returns the path of the book of paint.
    pub fn book_file(&self) -> PathBuf {
        self.folder.join(BOOK)
    }

    /// Returns when the book was last written; `None` where there is no paint. Views of the paint reload it
    /// when this changes.
    pub fn changed(&self) -> Option<SystemTime> {
        std::fs::metadata(self.book_file()).and_then(|metadata| metadata.modified()).ok()
    }

    /// Reads the book of paint; it is empty where there is no paint yet. The files that it names stay on disk as long as
    /// the book, or a copy of it, is in memory.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Input`] when the book is damaged or of another version, or when it is missing
    /// although pictures of paint are there.
    pub fn read(&self) -> Result<PaintBook> {
        let _reading = in_use::reading();
        let mut tries = TRIES;
        loop {
            let before = self.changed();
            let read = self.read_now();
            tries -= 1;
            // Another program may have replaced the book between two looks at the folder.
            if read.is_ok() || tries == 0 || self.changed() == before {
                return read.map(|book| self.held(book));
            }
        }
    }

    fn read_now(&self) -> Result<PaintBook> {
        let file = self.folder.join(BOOK);
        if !file.exists() {
            // A writer announces a picture before it writes it, so the list is read after the folder.
            let mut lost = self.pictures()?;
            let unfinished = self.unfinished()?;
            lost.retain(|picture| !unfinished.contains(picture));
            return match lost.first() {
                None => Ok(PaintBook::default()),
                Some(first) => {
                    let found = format!(
                        "it is missing, but {} pictures of paint are there: {first}, ...",
                        lost.len()
                    );
                    let remedy = "restore it from a copy of the project; to start without that paint, move the \
                                  folder away";
                    Err(Error::input(file, "the file", found, remedy))
                }
            };
        }
        let book: PaintBook = read_json(&file, LARGEST_BOOK, REMEDY)?;
        if book.version != PAINT_VERSION {
            let found = format!("version {}, this program reads version {PAINT_VERSION}", book.version);
            return Err(Error::input(file, "version", found, "use the program that wrote it"));
        }
        Ok(book)
    }

    /// Returns a book that is on disk with a hold on its files. A writer holds the book that it returns before another
    /// writer can replace it.
    pub fn held(&self, mut book: PaintBook) -> PaintBook {
        let folder = self.held_folder();
        book.in_use = in_use::hold(book.files().into_iter().map(|file| folder.join(file)));
        book
    }

    /// Returns the folder as holds name it; it may not exist yet.
    fn held_folder(&self) -> PathBuf {
        one_name(self.folder.parent().unwrap_or(Path::new(""))).join("paint")
    }

    /// Reads the pixels of an entry.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn patch(&self, entry: &PaintEntry) -> Result<PaintPatch> {
        let file = self.folder.join(&entry.file);
        if !file.is_file() {
            return Err(self.damaged(entry, "is missing"));
        }
        let raster = read_rgba_as_stored(&file, entry.rect.w, entry.rect.h);
        Ok(patch_of(
            &raster.map_err(|found| self.damaged(entry, &format!("is damaged: {found}")))?,
            entry.rect,
        ))
    }

    /// Checks that the picture of an entry can be used: it is as the program wrote it (its name holds its
    /// hash), or it was changed since and can be read.
    ///
    /// # Errors
    /// [`Error::Input`] that says which paint is lost and how to restore it.
    pub fn check(&self, entry: &PaintEntry) -> Result<()> {
        let file = self.folder.join(&entry.file);
        if !file.is_file() {
            return Err(self.damaged(entry, "is missing"));
        }
        if is_ours(&file)? { Ok(()) } else { self.patch(entry).map(drop) }
    }

    /// Builds the error for an entry whose picture has the problem `what`. Nothing is damaged where another program has
    /// replaced the paint since the entry was read.
    fn damaged(&self, entry: &PaintEntry, what: &str) -> Error {
        let pixels = entry.pixels;
        let face = entry.face_name();
        let photo = &entry.photo;
        let names_it = |now: &PaintBook| now.files().contains(entry.file.as_str());
        if self.read_now().is_ok_and(|now| !names_it(&now)) {
            return Error::Request(format!(
                "the paint on {face} of photo {photo} was replaced while it was being read; nothing is lost: try again"
            ));
        }
        let found = format!("the picture of {pixels} px of paint on {face} of photo {photo} {what}");
        let restore = "restore it from a copy of the project";
        if entry.is_of_brush() {
            let found = format!("{found}; it is of a brush stroke");
            return Error::input(self.folder.join(&entry.file), "", found, restore);
        }
        let (_, source) = entry.document.split_once('@').unwrap_or(("", &entry.document));
        let source = below(self.folder.parent().unwrap_or(Path::new("")), source);
        let remedy = match source.exists() {
            true => format!("{restore}, or import {} again, which it came from", source.display()),
            false => format!("{restore} ({}, which it came from, no longer exists)", source.display()),
        };
        Error::input(self.folder.join(&entry.file), "", found, remedy)
    }

    /// Stores the pixels of an entry and sets the entry's file name, rectangle and count. The paint becomes
    /// part of the project when a book that names the entry is committed.
    ///
    /// # Errors
    /// [`Error::Io`], for instance on a full disk.
    pub fn add(&self, entry: &mut PaintEntry, patch: &PaintPatch) -> Result<()> {
        entry.rect = patch.rect();
        entry.pixels = patch.count();
        let mut bytes = Vec::new();
        let encoded = write_rgba(&mut bytes, &raster_of(patch), None);
        let photo = self.folder.join(file_name_of_photo(&entry.photo));
        encoded.map_err(Error::io(&photo, "encode paint for it"))?;
        entry.file = file_of(entry, &hash_bytes(&bytes)[..DIGITS]);
        let target = self.folder.join(&entry.file);
        if target.is_file() && hash_file(&target)? == hash_bytes(&bytes) {
            return Ok(());
        }
        fs::create_dir_all(&photo).map_err(Error::io(&photo, "create the folder"))?;
        self.announce(&entry.file)?;
        write_atomically_with(target, |out| std::io::Write::write_all(out, &bytes))
    }

    /// Makes `book` the project's book by one rename and removes the files that it no longer names. `before` is the
    /// book as it is on disk, which a writer has read and holds under the project's lock.
    ///
    /// # Errors
    /// [`Error::Io`]; when the rename failed, the old book still holds, with all its files.
    pub fn commit(&self, book: &PaintBook, before: &PaintBook) -> Result<()> {
        let file = self.folder.join(BOOK);
        let _replacing = in_use::replacing();
        let mut superseded = self.unfinished()?;
        superseded.extend(before.files().into_iter().map(str::to_owned));
        // After a kill behind the rename this list still says what is to be removed.
        let named = book.files();
        superseded
            .iter()
            .filter(|name| !named.contains(name.as_str()))
            .try_for_each(|name| self.announce(name))?;
        if book.is_empty() {
            remove_if_there(&file)?;
        } else {
            fs::create_dir_all(&self.folder).map_err(Error::io(&self.folder, "create the folder"))?;
            write_atomically(&file, &to_json(book))?;
        }
        superseded.retain(|name| !named.contains(name.as_str()));
        let folder = self.held_folder();
        // The writer's own books do not count.
        let own = [&book.in_use, &before.in_use];
        let is_used = |name: &String| in_use::is_held(&folder.join(name), &own);
        let (used, unused): (BTreeSet<String>, _) = superseded.into_iter().partition(is_used);
        self.clear(&unused, &used)
    }

    /// Records, before a file is written, that it is not part of the project yet.
    fn announce(&self, name: &str) -> Result<()> {
        let file = self.folder.join(UNFINISHED);
        let mut list = fs::File::options()
            .create(true)
            .append(true)
            .open(&file)
            .map_err(Error::io(&file, "open it for writing"))?;
        list.write_all(format!("{name}\n").as_bytes()).map_err(Error::io(&file, "write it"))
    }

    /// Returns the files that were announced and not committed.
    fn unfinished(&self) -> Result<BTreeSet<String>> {
        let file = self.folder.join(UNFINISHED);
        match fs::read_to_string(&file) {
            Ok(text) => Ok(text.lines().map(str::to_owned).collect()),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(BTreeSet::new()),
            Err(error) => Err(Error::io(&file, "read it")(error)),
        }
    }

    /// Returns the pictures of paint on disk, by their names as a book has them.
    fn pictures(&self) -> Result<Vec<String>> {
        let mut found = Vec::new();
        if !self.folder.is_dir() {
            return Ok(found);
        }
        for photo in entries_of(&self.folder)?.iter().filter(|path| path.is_dir()) {
            for file in entries_of(photo)? {
                let below = file.strip_prefix(&self.folder).unwrap_or(&file);
                let name = below.to_string_lossy().replace('\\', "/");
                if is_ours(&file)? {
                    found.push(name);
                }
            }
        }
        Ok(found)
    }

    /// Removes those of the `superseded` files that this program wrote, and then empty folders. Those that are `used` are
    /// left to the next import.
    fn clear(&self, superseded: &BTreeSet<String>, used: &BTreeSet<String>) -> Result<()> {
        if !self.folder.is_dir() {
            return Ok(());
        }
        for name in superseded {
            let file = self.folder.join(name);
            if is_ours(&file)? {
                remove_if_there(&file)?;
            }
        }
        let list = self.folder.join(UNFINISHED);
        match used.is_empty() {
            true => remove_if_there(&list)?,
            false => {
                let names: String = used.iter().map(|name| format!("{name}\n")).collect();
                write_atomically(&list, names.as_bytes())?;
            }
        }
        remove_leftovers(&self.folder)?;
        for photo in entries_of(&self.folder)?.iter().filter(|path| path.is_dir()) {
            remove_leftovers(photo)?;
            remove_if_empty(photo)?;
        }
        remove_if_empty(&self.folder)
    }
}

/// Returns the name `<photo>/<object>-<face>.t<triangle>.beyond-<hash>.png` of an entry's file, without `-<face>`
/// for the surroundings.
fn file_of(entry: &PaintEntry, hash: &str) -> String {
    let replaced = |c: char| if c.is_control() || "/\\:*?\"<>|".contains(c) { '_' } else { c };
    let mut object: String = entry.object.chars().map(replaced).collect();
    while object.len() > LONGEST_READABLE {
        object.pop();
    }
    let triangle = entry.triangle.map_or(String::new(), |t| format!(".t{t}"));
    let beyond = if entry.beyond { ".beyond" } else { "" };
    let face = entry.face.map_or(String::new(), |face| format!("-{face}"));
    format!("{}/{object}{face}{triangle}{beyond}-{hash}.png", file_name_of_photo(&entry.photo))
}

/// Returns whether this program wrote the file unchanged: its name holds the hash of its content.
fn is_ours(file: &Path) -> Result<bool> {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let Some((_, hash)) = name.strip_suffix(".png").and_then(|stem| stem.rsplit_once('-')) else {
        return Ok(false);
    };
    Ok(hash.len() == DIGITS && file.is_file() && hash_file(file)?.starts_with(hash))
}

fn entries_of(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).map_err(Error::io(folder, "read the folder"))?;
    let paths = entries.map(|entry| Ok(entry.map_err(Error::io(folder, "read the folder"))?.path()));
    let mut paths = paths.collect::<Result<Vec<_>>>()?;
    paths.sort();
    Ok(paths)
}

fn remove_if_there(file: &Path) -> Result<()> {
    match fs::remove_file(file) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(Error::io(file, "remove it")(error)),
        _ => Ok(()),
    }
}

fn remove_if_empty(folder: &Path) -> Result<()> {
    if entries_of(folder)?.is_empty() {
        fs::remove_dir(folder).map_err(Error::io(folder, "remove the empty folder"))?;
    }
    Ok(())
}

fn patch_of(raster: &Raster, rect: PixelRect) -> PaintPatch {
    let mut patch = PaintPatch::new(rect);
    for y in 0..rect.h {
        for x in 0..rect.w {
            let colour = raster.rgba16(x, y);
            if colour != [0; 4] {
                patch.put(rect.x + x as i32, rect.y + y as i32, colour);
            }
        }
    }
    patch
}

fn raster_of(patch: &PaintPatch) -> Raster {
    let rect = patch.rect();
    let samples = patch.pixels().pixels().iter().flat_map(|pixel| pixel.unwrap_or_default());
    let samples = match patch.fits_8_bits() {
        true => Samples::U8(samples.map(|sample| (sample / 257) as u8).collect()),
        false => Samples::U16(samples.collect()),
    };
    Raster::new(rect.w, rect.h, samples)
}

#[cfg(test)]
mod tests;
