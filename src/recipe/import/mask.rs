//! Layers called `mask`: what is painted in them is no content of the photo.
//!
//! Such layers of one file are one mask of the project, known by the file: importing the file again replaces it. A file
//! without such a layer says nothing of masks.

use std::path::Path;

use super::gather::gathered;
use super::layer::Desk;
use super::report::{FileReport, LayerReport, LayerState};
use super::scaled::unscaled;
use crate::document::export_record::ExportRecord;
use crate::document::masks::{Mask, MaskChange, MaskFrom};
use crate::document::paint::ImportedMask;
use crate::error::Result;
use crate::geometry::{PixelRect, Spans};
use crate::io::layered::EditedLayer;
use crate::io::mask_store::MaskStore;
use crate::io::project::{change_project, read_project};

/// What a file masks.
pub struct MaskShare {
    /// Its place among the report's layers.
    pub report: usize,
    /// In pixels of the photo.
    pub masked: Spans,
}

/// Half of full opacity: more is painted, less is the rim of a soft brush.
const OPAQUE: u16 = 1 << 15;

/// What the layers called `mask` cover, whether they are shown or not; none where there is no such layer.
///
/// # Errors
/// What reading their pixels says.
pub fn mask_of(
    desk: &Desk,
    layers: &[&EditedLayer],
    record: &ExportRecord,
    report: &mut FileReport,
) -> Result<Option<MaskShare>> {
    let Some(first) = layers.first() else { return Ok(None) };
    let photo = PixelRect::of_size(record.photo.width, record.photo.height);
    let mut masked = Spans::default();
    for layer in layers {
        let found = gathered(&[layer])?;
        let (pixels, rect) = match desk.scale == 1.0 {
            true => (found.pixels, desk.in_photo(found.rect)),
            false => unscaled(&found.pixels, found.rect, desk.scale),
        };
        let painted = |x: i32, y: i32| pixels.rgba16((x - rect.x) as u32, (y - rect.y) as u32)[3] >= OPAQUE;
        masked = masked.union(&Spans::of_pixels(rect.intersection(&photo), painted));
    }
    let mut told = LayerReport::new(&first.name, None, LayerState::Mask);
    told.painted = masked.count();
    if masked.count() == photo.area() {
        told.state = LayerState::LeftOut;
        told.notes.push(
            "it covers the whole photo; paint only what is to be masked, the rest is transparent".into(),
        );
        report.layers.push(told);
        return Ok(None);
    }
    report.layers.push(told);
    Ok(Some(MaskShare { report: report.layers.len() - 1, masked }))
}

/// Masks that come home with an import.
#[derive(Debug, Default)]
pub struct MaskDesk {
    arrived: Vec<Arrived>,
}

#[derive(Debug)]
struct Arrived {
    photo: String,
    from: MaskFrom,
    size: [u32; 2],
    masked: Spans,
}

impl MaskDesk {
    /// Some mask is other than it was.
    pub fn changed(&self) -> bool {
        !self.arrived.is_empty()
    }

    /// Takes what a document masks of a photo of this size; returns how many pixels are masked that were not, or no
    /// longer.
    ///
    /// # Errors
    /// [`crate::Error::Io`] and [`crate::Error::Input`] when `project.json` cannot be read.
    pub fn take(
        &mut self,
        project: &Path,
        photo: &str,
        document: &str,
        size: [u32; 2],
        masked: Spans,
    ) -> Result<u64> {
        let from = MaskFrom::Layer(document.to_owned());
        let masks = read_project(project)?.masks;
        let before = match masks.find(photo, &from) {
            // One of another size says nothing of these pixels.
            Some(mask) => MaskStore::new(project).read(&mask.file, size).unwrap_or_default(),
            None => Spans::default(),
        };
        let changed = masked.minus(&before).count() + before.minus(&masked).count();
        self.arrived.retain(|other| other.photo != photo || other.from != from);
        if changed > 0 {
            self.arrived.push(Arrived { photo: photo.to_owned(), from, size, masked });
        }
        Ok(changed)
    }

    /// Writes their files, which nobody names yet.
    ///
    /// # Errors
    /// [`crate::Error::Io`] and [`crate::Error::Input`].
    pub fn prepare(self, project: &Path) -> Result<PreparedMasks> {
        if self.arrived.is_empty() {
            return Ok(PreparedMasks::default());
        }
        let (store, masks) = (MaskStore::new(project), read_project(project)?.masks);
        let mut changes = Vec::new();
        for Arrived { photo, from, size, masked } in self.arrived {
            let before = masks.find(&photo, &from).cloned();
            let after = match masked.is_empty() {
                true => None,
                false => {
                    let file = store.add(&photo, from.stem(), &masked, size)?;
                    Some(Mask { from: from.clone(), file, pixels: masked.count() })
                }
            };
            changes.push(MaskChange { photo, from, before, after });
        }
        Ok(PreparedMasks { changes })
    }
}

/// Masks whose files are there.
#[derive(Debug, Default)]
pub struct PreparedMasks {
    /// What is put in place, and what stands there.
    pub changes: Vec<MaskChange>,
}

impl PreparedMasks {
    /// For whoever takes the import back.
    pub fn imported(&self) -> Vec<ImportedMask> {
        let imported = self.changes.iter().cloned();
        imported.map(|MaskChange { photo, from, before, .. }| ImportedMask { photo, from, before }).collect()
    }

    /// They are the project's from now on.
    ///
    /// # Errors
    /// [`crate::Error::Io`] and [`crate::Error::Input`]; the project's masks are then as they were.
    pub fn commit(&self, project: &Path) -> Result<()> {
        put(project, self.changes.iter().map(|change| (&change.photo, &change.from, &change.after)))
    }
}

/// Puts back what stood in the places of imported masks.
///
/// # Errors
/// [`crate::Error::Io`] and [`crate::Error::Input`] when `project.json` cannot be read or written.
pub fn take_back(project: &Path, imported: &[ImportedMask]) -> Result<()> {
    put(project, imported.iter().map(|mask| (&mask.photo, &mask.from, &mask.before)))
}

/// Puts masks into `project.json` as it is by now, or takes them away there.
fn put<'a>(
    project: &Path,
    masks: impl ExactSizeIterator<Item = (&'a String, &'a MaskFrom, &'a Option<Mask>)>,
) -> Result<()> {
    if masks.len() == 0 {
        return Ok(());
    }
    change_project(project, |authored| {
        let mut authored = authored?;
        masks.for_each(|(photo, from, mask)| authored.masks.set(photo, from, mask.clone()));
        Ok(authored)
    })
}
