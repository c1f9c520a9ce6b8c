//! Layers called `mask`: the pixels painted in them are masked.
//!
//! All such layers of one file are one mask of the project, whose origin is the file: importing the file again
//! replaces it. A file without such a layer does not change masks.

use std::path::Path;

use super::gather::gathered;
use super::layer::DocumentContext;
use super::report::{FileReport, LayerImportReport, LayerState};
use super::scaled::unscaled;
use quadratura_base::error::Result;
use quadratura_base::geometry::{PixelRect, Spans};
use quadratura_document::Masks;
use quadratura_document::export_record::ExportRecord;
use quadratura_document::masks::{Mask, MaskChange, MaskOrigin};
use quadratura_document::paint::ImportedMask;
use quadratura_io::mask_store::MaskStore;
use quadratura_io::project::change_project;
use quadratura_layered_files::EditedLayer;

/// The mask in a file.
pub struct FileMask {
    /// The index among the report's layers.
    pub report: usize,
    /// The masked pixels of the photo.
    pub masked: Spans,
}

/// Half opacity: above it a pixel is masked, below it is the soft edge of a brush.
const OPAQUE: u16 = 1 << 15;

/// Returns the pixels that layers called `mask` cover, visible or not; `None` where there is no such layer.
///
/// # Errors
/// Returns the errors of reading their pixels.
pub fn mask_of(
    context: &DocumentContext,
    layers: &[&EditedLayer],
    record: &ExportRecord,
    report: &mut FileReport,
) -> Result<Option<FileMask>> {
    let Some(first) = layers.first() else { return Ok(None) };
    let photo = PixelRect::of_size(record.photo.width, record.photo.height);
    let mut masked = Spans::default();
    for layer in layers {
        let found = gathered(&[layer])?;
        let (pixels, rect) = match context.scale == 1.0 {
            true => (found.pixels, context.in_photo(found.rect)),
            false => unscaled(&found.pixels, found.rect, context.scale),
        };
        let painted = |x: i32, y: i32| pixels.rgba16((x - rect.x) as u32, (y - rect.y) as u32)[3] >= OPAQUE;
        masked = masked.union(&Spans::of_pixels(rect.intersection(&photo), painted));
    }
    let mut layer_report = LayerImportReport::new(&first.name, None, LayerState::Mask);
    layer_report.painted = masked.count();
    if masked.count() == photo.area() {
        layer_report.state = LayerState::LeftOut;
        layer_report.notes.push(
            "it covers the whole photo; paint only the area to be masked and leave the rest \
             transparent"
                .into(),
        );
        report.layers.push(layer_report);
        return Ok(None);
    }
    report.layers.push(layer_report);
    Ok(Some(FileMask { report: report.layers.len() - 1, masked }))
}

/// The masks of an import in progress.
#[derive(Debug, Default)]
pub struct MaskSession {
    /// The project's masks before it.
    masks: Masks,
    arrived: Vec<Arrived>,
}

/// A mask that differs from the project's.
#[derive(Debug)]
struct Arrived {
    photo: String,
    from: MaskOrigin,
    size: [u32; 2],
    masked: Spans,
}

impl MaskSession {
    /// Begins with the project's masks.
    pub fn new(masks: Masks) -> Self {
        Self { masks, arrived: Vec::new() }
    }

    /// Returns true when a mask changes.
    pub fn changed(&self) -> bool {
        !self.arrived.is_empty()
    }

    /// Adds the mask that a document contains for a photo of this size. Returns the number of pixels whose masking
    /// changes.
    pub fn take(
        &mut self,
        project: &Path,
        photo: &str,
        document: &str,
        size: [u32; 2],
        masked: Spans,
    ) -> u64 {
        let from = MaskOrigin::Layer(document.to_owned());
        let before = match self.masks.find(photo, &from) {
            // A mask of another size has no meaning for these pixels.
            Some(mask) => MaskStore::new(project).read(&mask.file, size).unwrap_or_default(),
            None => Spans::default(),
        };
        let changed = masked.minus(&before).count() + before.minus(&masked).count();
        self.arrived.retain(|other| other.photo != photo || other.from != from);
        if changed > 0 {
            self.arrived.push(Arrived { photo: photo.to_owned(), from, size, masked });
        }
        changed
    }

    /// Writes the masks' files, to which nothing refers yet.
    ///
    /// # Errors
    /// Returns [`quadratura_base::Error::Io`] and [`quadratura_base::Error::Input`].
    pub fn prepare(self, project: &Path) -> Result<PreparedMasks> {
        if self.arrived.is_empty() {
            return Ok(PreparedMasks::default());
        }
        let store = MaskStore::new(project);
        let mut changes = Vec::new();
        for Arrived { photo, from, size, masked } in self.arrived {
            let before = self.masks.find(&photo, &from).cloned();
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

/// Masks whose files are written.
#[derive(Debug, Default)]
pub struct PreparedMasks {
    /// The changes to be made in `project.json`.
    pub changes: Vec<MaskChange>,
}

impl PreparedMasks {
    /// Returns the masks for the record of the import, so that it can be undone.
    pub fn imported(&self) -> Vec<ImportedMask> {
        let imported = self.changes.iter().cloned();
        imported.map(|MaskChange { photo, from, before, .. }| ImportedMask { photo, from, before }).collect()
    }

    /// Stores the masks in `project.json`.
    ///
    /// # Errors
    /// Returns [`quadratura_base::Error::Io`] and [`quadratura_base::Error::Input`]; the project's masks are then unchanged.
    pub fn commit(&self, project: &Path) -> Result<()> {
        put(project, self.changes.iter().map(|change| (&change.photo, &change.from, &change.after)))
    }
}

/// Restores the masks that imported ones had replaced.
///
/// # Errors
/// Returns [`quadratura_base::Error::Io`] and [`quadratura_base::Error::Input`] when `project.json` cannot be read or written.
pub fn take_back(project: &Path, imported: &[ImportedMask]) -> Result<()> {
    put(project, imported.iter().map(|mask| (&mask.photo, &mask.from, &mask.before)))
}

/// Sets or removes masks in `project.json` as it is at this time.
fn put<'a>(
    project: &Path,
    masks: impl ExactSizeIterator<Item = (&'a String, &'a MaskOrigin, &'a Option<Mask>)>,
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
