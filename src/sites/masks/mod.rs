//! Masks of a project's photos: edits, and the sources of masks.
//!
//! A mask makes pixels of a photo invalid and has no other effect: occlusion is sorted as before, and the masked
//! pixels of a surface count as hidden. All edits of masks go through [`edited`], whether masks are drawn or
//! suggestions accepted; only a mask that is imported with paint replaces that of the same file by itself
//! (the package `editing`).

pub mod beside;
pub mod list;
mod undistorted;

use std::collections::BTreeSet;
use std::path::Path;

use crate::named::meant;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Spans;
use quadratura_base::scene::{Photo, Site};
use quadratura_document::Masks;
use quadratura_document::masks::{Mask, MaskOrigin, MaskedObject, MaskedTree};
use quadratura_document::paint::PaintBook;
use quadratura_io::mask_store::MaskStore;
use quadratura_layers::fill::options::matches_pattern;

/// An edit of a mask. Photos are given by full names; pixels are those of the photo's pinhole image.
#[derive(Debug, Clone, PartialEq)]
pub enum MaskEdit {
    /// Replaces the mask of this origin; an empty set removes it.
    Put {
        /// The photo's name.
        photo: String,
        /// The origin of the mask.
        from: MaskOrigin,
        /// The masked pixels, in photo pixels.
        masked: Spans,
    },
    /// Adds pixels to the mask of this origin.
    Add {
        /// The photo's name.
        photo: String,
        /// The origin of the mask.
        from: MaskOrigin,
        /// The pixels to mask, in photo pixels.
        masked: Spans,
    },
    /// Records that the mask of this origin cannot be read, where the photo has none of it.
    Unread {
        /// The photo's name.
        photo: String,
        /// The origin of the mask.
        from: MaskOrigin,
    },
    /// Removes pixels from all masks of the photo.
    Uncover {
        /// The photo's name.
        photo: String,
        /// The pixels that are no longer masked, in photo pixels.
        pixels: Spans,
    },
    /// Removes the mask of this origin.
    Remove {
        /// The photo's name.
        photo: String,
        /// The origin of the mask.
        from: MaskOrigin,
    },
    /// Removes all masks of the photo.
    Clear {
        /// The photo's name.
        photo: String,
    },
}

impl MaskEdit {
    /// Returns the photo of the edit.
    fn photo(&self) -> &str {
        match self {
            Self::Put { photo, .. }
            | Self::Add { photo, .. }
            | Self::Unread { photo, .. }
            | Self::Uncover { photo, .. }
            | Self::Remove { photo, .. }
            | Self::Clear { photo } => photo,
        }
    }
}

/// Returns the masks after the edits, applied in order. New files are written to the project's folder and old ones
/// stay, so that undoing needs only the earlier masks. The edits take effect when `project.json` is saved. The
/// caller holds the project's lock.
///
/// # Errors
/// Returns [`Error::Request`] for a photo that the site does not have, or [`Error::Io`] and [`Error::Input`] when
/// files cannot be read or written.
pub fn edited(folder: &Path, masks: &Masks, edits: &[MaskEdit], site: &Site) -> Result<Masks> {
    let store = MaskStore::new(folder);
    let mut editor = MaskEditor { store: &store, masks: masks.clone() };
    for edit in edits {
        match (edit, site.photos.iter().find(|photo| photo.name == edit.photo())) {
            // Masks may outlive their photos and can be removed nevertheless.
            (MaskEdit::Clear { photo }, _) => editor.masks.clear(photo),
            (MaskEdit::Remove { photo, from }, _) => drop(editor.masks.remove(photo, from)),
            (_, None) => return Err(Error::Request(format!("there is no photo {}", edit.photo()))),
            (edit, Some(photo)) => editor.apply(edit, photo)?,
        }
    }
    Ok(editor.masks)
}

/// Sets the photos' mask files to those of the project; those that could not be read are in no file.
pub fn attach(folder: &Path, masks: &Masks, photos: &mut [Photo]) {
    let store = MaskStore::new(folder);
    for photo in photos {
        let read = masks.of(&photo.name).iter().filter(|mask| !mask.is_unread());
        photo.masks = read.map(|mask| store.path(&mask.file)).collect();
    }
}

/// The masks that are removed, by their origins.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ClearedMasks {
    /// All masks.
    All,
    /// Accepted suggestions.
    Suggested,
    /// What was painted: in the editor, or in a layer called `mask` of an edited document.
    Painted,
    /// Mask files.
    Files,
    /// The masks of all objects.
    Objects,
    /// The masks of objects of this name, or of a pattern in which `*` stands for any characters.
    Object(String),
    /// The masks of all trees of the project.
    Trees,
    /// The masks of trees of this name or pattern.
    Tree(String),
}

impl ClearedMasks {
    /// Returns whether masks of this origin are removed.
    fn contains(&self, origin: &MaskOrigin) -> bool {
        match (self, origin) {
            (Self::All, _)
            | (Self::Suggested, MaskOrigin::Suggested)
            | (Self::Painted, MaskOrigin::Drawn | MaskOrigin::Layer(_))
            | (Self::Files, MaskOrigin::File(_))
            | (Self::Objects, MaskOrigin::Object(_))
            | (Self::Trees, MaskOrigin::Tree(_)) => true,
            (Self::Tree(pattern), MaskOrigin::Tree(MaskedTree { name, .. })) => {
                matches_pattern(name, pattern)
            }
            (Self::Object(pattern), MaskOrigin::Object(MaskedObject { name, .. })) => {
                matches_pattern(name, pattern)
            }
            _ => false,
        }
    }

    /// Returns the words for such a mask in messages: `mask`, `suggested mask`, `mask of an object`.
    fn words(&self) -> String {
        match self {
            Self::All => "mask".into(),
            Self::Suggested => "suggested mask".into(),
            Self::Painted => "painted mask".into(),
            Self::Files => "mask from a file".into(),
            Self::Objects => "mask of an object".into(),
            Self::Object(name) => format!("mask of the object {name:?}"),
            Self::Trees => "mask of a tree".into(),
            Self::Tree(name) => format!("mask of the tree {name:?}"),
        }
    }
}

/// Returns the masks without those `of` these origins in the photos of these names, full or abbreviated; in all photos
/// for an empty list. The photos need not be in the site.
///
/// # Errors
/// Returns [`Error::Request`] for names that match no photo with such a mask, all of them together, and where nothing is
/// removed although certain origins were named.
pub fn cleared(masks: &Masks, names: &[String], of: &ClearedMasks) -> Result<Masks> {
    let has_such = |list: &[Mask]| list.iter().any(|mask| of.contains(&mask.from));
    let with: Vec<&str> = masks.photos().filter(|(_, list)| has_such(list)).map(|(photo, _)| photo).collect();
    let mut rest = masks.clone();
    if names.is_empty() {
        if with.is_empty() && *of != ClearedMasks::All {
            return Err(Error::Request(format!("no photo has a {}", of.words())));
        }
        with.into_iter().for_each(|photo| rest.remove_where(photo, |origin| of.contains(origin)));
        return Ok(rest);
    }
    let mut errors = Vec::new();
    for name in names {
        let meant = meant(name, &with);
        if meant.is_empty() {
            errors.push(Error::Request(format!("photo {name} has no {}", of.words())));
        }
        meant.into_iter().for_each(|index| rest.remove_where(with[index], |origin| of.contains(origin)));
    }
    Error::of_all(errors).map_or(Ok(rest), Err)
}

/// The masks while edits are applied.
struct MaskEditor<'a> {
    store: &'a MaskStore,
    masks: Masks,
}

impl MaskEditor<'_> {
    /// Applies one edit to a photo of the site.
    fn apply(&mut self, edit: &MaskEdit, photo: &Photo) -> Result<()> {
        match edit {
            MaskEdit::Put { from, masked, .. } => self.put(photo, from, masked),
            MaskEdit::Add { from, masked, .. } => {
                let before = self.masks.find(&photo.name, from).cloned();
                let before = before.map(|mask| self.pixels(photo, &mask)).transpose()?.unwrap_or_default();
                self.put(photo, from, &before.union(masked))
            }
            MaskEdit::Uncover { pixels, .. } => {
                for mask in self.masks.of(&photo.name).to_vec() {
                    let rest = self.pixels(photo, &mask)?.minus(pixels);
                    if rest.count() < mask.pixels {
                        self.put(photo, &mask.from, &rest)?;
                    }
                }
                Ok(())
            }
            MaskEdit::Unread { from, .. } => {
                if self.masks.find(&photo.name, from).is_none() {
                    self.masks.put(&photo.name, Mask::unread(from.clone()));
                }
                Ok(())
            }
            MaskEdit::Remove { .. } | MaskEdit::Clear { .. } => Ok(()),
        }
    }

    /// Reads the pixels of a mask.
    fn pixels(&self, photo: &Photo, mask: &Mask) -> Result<Spans> {
        if mask.is_unread() {
            return Ok(Spans::default());
        }
        self.store.read(&mask.file, size_of(photo))
    }

    /// Stores a mask's pixels, or removes the mask if they are empty.
    fn put(&mut self, photo: &Photo, from: &MaskOrigin, masked: &Spans) -> Result<()> {
        let pixels = masked.intersection(&whole(photo)).count();
        if pixels == 0 {
            self.masks.remove(&photo.name, from);
            return Ok(());
        }
        let file = self.store.add(&photo.name, from.stem(), masked, size_of(photo))?;
        self.masks.put(&photo.name, Mask { from: from.clone(), file, pixels });
        Ok(())
    }
}

/// Returns the size of a photo in pixels.
fn size_of(photo: &Photo) -> [u32; 2] {
    [photo.camera.width, photo.camera.height]
}

/// Returns all pixels of a photo.
fn whole(photo: &Photo) -> Spans {
    let [width, height] = size_of(photo);
    Spans::from_rows(0..height as i32, |_, out| out.push(0..width as i32))
}

/// Removes mask files to which neither `masks` (the project's, and unsaved ones of a window that ended) nor imports
/// that can be undone refer. It must not be called while edits may still be undone.
///
/// # Errors
/// Returns [`Error::Io`] when a file cannot be removed.
pub fn tidy(folder: &Path, masks: &[Option<&Masks>], paint: &PaintBook) -> Result<()> {
    let replaced = paint.imports.iter().flat_map(|import| &import.masks).filter_map(|m| m.before.as_ref());
    let files =
        masks.iter().flatten().flat_map(|masks| masks.files()).chain(replaced.map(|mask| mask.file.as_str()));
    let named: BTreeSet<String> = files.map(str::to_owned).collect();
    MaskStore::new(folder).tidy(&named)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::PixelRect;
    use quadratura_base::scene::synthetic::closed_form;
    use quadratura_io::unmasked::masked_pixels;

    fn block(x: i32, y: i32, w: u32, h: u32) -> Spans {
        Spans::of_pixels(PixelRect { x, y, w, h }, |_, _| true)
    }

    /// Makes a site of one photo, and returns its masked pixels after each edit.
    struct Bench {
        folder: tempfile::TempDir,
        site: Site,
        masks: Masks,
    }

    impl Bench {
        fn new() -> Self {
            let site = closed_form::two_quads().site();
            Self { folder: tempfile::tempdir().unwrap(), site, masks: Masks::default() }
        }

        fn photo(&self) -> String {
            self.site.photos[0].name.clone()
        }

        fn after(&mut self, edit: MaskEdit) -> u64 {
            self.masks = edited(self.folder.path(), &self.masks, &[edit], &self.site).unwrap();
            let store = MaskStore::new(self.folder.path());
            let masks = self.masks.of(&self.photo()).iter().map(|mask| store.path(&mask.file)).collect();
            masked_pixels(&Photo { masks, ..self.site.photos[0].clone() }).unwrap().count()
        }
    }

    #[test]
    fn masks_are_put_added_uncovered_and_taken_away() {
        let mut bench = Bench::new();
        let (photo, from) = (bench.photo(), MaskOrigin::Drawn);
        let put = |masked| MaskEdit::Put { photo: photo.clone(), from: from.clone(), masked };
        let add = |masked| MaskEdit::Add { photo: photo.clone(), from: from.clone(), masked };
        assert_eq!(bench.after(put(block(2, 3, 4, 5))), 20);
        assert_eq!(bench.after(add(block(4, 3, 4, 5))), 30);
        let suggested = MaskOrigin::Suggested;
        let other =
            MaskEdit::Add { photo: photo.clone(), from: suggested.clone(), masked: block(0, 0, 3, 4) };
        assert_eq!(bench.after(other), 41, "one pixel is masked by both");
        assert_eq!(bench.after(MaskEdit::Uncover { photo: photo.clone(), pixels: block(2, 3, 1, 1) }), 40);
        let before = bench.masks.clone();
        assert_eq!(bench.after(put(block(0, 0, 1, 1))), 11, "the others' mask stays");
        assert_eq!(bench.after(MaskEdit::Remove { photo: photo.clone(), from: suggested }), 1);
        assert_eq!(bench.after(put(Spans::default())), 0);
        assert!(bench.masks.is_empty());
        bench.masks = before;
        assert_eq!(bench.after(MaskEdit::Uncover { photo: photo.clone(), pixels: block(0, 0, 1, 1) }), 39);
        assert_eq!(bench.after(MaskEdit::Clear { photo }), 0);
    }

    #[test]
    fn pixels_outside_of_the_photo_are_none_and_a_stranger_is_refused() {
        let mut bench = Bench::new();
        let photo = bench.photo();
        let outside = MaskEdit::Add { photo, from: MaskOrigin::Drawn, masked: block(-9, -9, 9, 9) };
        assert_eq!(bench.after(outside), 0);
        assert!(bench.masks.is_empty());
        let foreign = MaskEdit::Add { photo: "x".into(), from: MaskOrigin::Drawn, masked: block(0, 0, 1, 1) };
        let message = edited(bench.folder.path(), &bench.masks, &[foreign], &bench.site).unwrap_err();
        assert!(message.to_string().contains("no photo x"), "{message}");
    }

    #[test]
    fn what_no_mask_and_no_import_names_is_cleared_away_when_that_is_asked_for() {
        let mut bench = Bench::new();
        let photo = bench.photo();
        let put =
            |w| MaskEdit::Put { photo: photo.clone(), from: MaskOrigin::Drawn, masked: block(0, 0, w, 1) };
        bench.after(put(3));
        bench.after(put(4));
        let files = |bench: &Bench| {
            let folder = std::fs::read_dir(bench.folder.path().join("masks")).unwrap().next().unwrap();
            std::fs::read_dir(folder.unwrap().path()).unwrap().count()
        };
        assert_eq!(files(&bench), 2, "who undoes it needs the old one");
        let drawn = bench.masks.clone();
        bench.after(put(5));
        let tidied =
            |masks: &[Option<&Masks>]| tidy(bench.folder.path(), masks, &PaintBook::default()).unwrap();
        tidied(&[Some(&bench.masks), Some(&drawn)]);
        assert_eq!(files(&bench), 2, "what a window had not saved when it ended stays");
        tidied(&[Some(&bench.masks), None]);
        assert_eq!(files(&bench), 1);
    }
}
