//! The export of one photo to a layered file.

use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Serialize;

use super::compose::StackContent;
use super::folder;
use super::place::put_away;
use super::trees::{GuidedTrees, STAGE_TREES};
use super::written::{DocumentPlace, WrittenDocument};
use super::{ExportOptions, STAGE_READ, STAGE_WRITE};
use quadratura_base::error::{Error, Remedy, Result};
use quadratura_base::scene::{FaceIndex, Photo};
use quadratura_base::task::Task;
use quadratura_document::export_record::{
    ExportFormat, ExportRecord, ExportedFile, KEY_DIGITS, RECORD_VERSION,
};
use quadratura_document::paint::PaintBook;
use quadratura_document::{ImageLayer, Stack};
use quadratura_files::hash::hash_bytes;
use quadratura_files::json::to_json;
use quadratura_import::photo::read_photo;
use quadratura_io::baselines::Baselines;
use quadratura_io::exports::{ExportStore, WrittenFiles};
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_store::StackStore;
use quadratura_layered_files::Raster;
use quadratura_layered_files::folder::NewFolder;
use quadratura_stacks::layer_names::rename;
use quadratura_stacks::layer_table::LayerFigures;
use quadratura_stacks::paint::PhotoPaint;

/// The report of one photo's export.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExportReport {
    /// The name of the photo.
    pub photo: String,
    /// The file or folder that was written.
    pub path: PathBuf,
    /// Files that were not overwritten, because they were changed since their export.
    pub spared: Vec<PathBuf>,
    /// The key that identifies the document.
    pub key: String,
    /// The number of image layers.
    pub layers: usize,
    /// The number of groups, one per order.
    pub groups: usize,
    /// The size in bytes of the file, or of all files in the folder.
    pub bytes: u64,
    /// By how much edges of see-through layers are darker in image editors than in views, at most; 1 is white. `None` where that is not
    /// known: in formats that are mixed in linear light, and without such layers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub darker: Option<f64>,
    /// Problems of its layers, with remedies.
    pub problems: Vec<String>,
}

/// The stores and options that all photos of an export share.
pub struct Exporter<'a> {
    pub project: &'a Path,
    pub stacks: StackStore,
    pub records: ExportStore,
    pub kept: Baselines,
    pub paint: PaintStore,
    pub book: PaintBook,
    pub written: WrittenFiles,
    pub trees: Option<GuidedTrees<'a>>,
    pub out: &'a Path,
    pub options: &'a ExportOptions,
}

impl Exporter<'_> {
    /// Exports one photo.
    ///
    /// # Errors
    /// Returns [`Error::Request`] when the photo has no stack, [`Error::Input`] when the stack or the photo cannot
    /// be read, or [`Error::Io`] when something cannot be written. No incomplete file remains.
    pub fn export(&self, photo: &Photo, task: &Task) -> Result<ExportReport> {
        let mut stack = self.stacks.current(&photo.name)?.ok_or_else(|| no_stack(photo))?;
        if let Some(decisions) = &self.options.decisions {
            rename(&mut stack, &decisions.of(&photo.name).names);
        }
        let pixels = task.timed(STAGE_READ, || read_reference(photo, &stack))?;
        let icc = pixels.icc.clone();
        let evened = self.options.evened.get(&photo.name).copied();
        let mut raster = Raster::of_photo(pixels);
        if let Some(factors) = evened {
            raster.multiply_light(factors);
        }
        let folder = self.stacks.folder(&photo.name);
        let mut content = StackContent::new(&stack, folder, Arc::new(raster), icc, task);
        content.evened = evened;
        content.guides = self.options.guides;
        let trees = self.trees.as_ref();
        let guide =
            |trees: &GuidedTrees| task.timed(STAGE_TREES, || trees.guide(photo, content.depth(), task));
        content.trees = trees.map(guide).transpose()?.flatten();
        content.selected = self.options.selected.as_deref().or_else(|| largest(&stack));
        content.paint = PhotoPaint::new(&self.book, self.paint.clone(), &stack);
        content.margin = self.options.layer_margin();
        let key = self.key(&content);
        let job = ExportJob { exporter: self, content: &content, photo_file: &photo.file, key };
        let WrittenDocument { path, spared, bytes } = task.timed(STAGE_WRITE, || job.write())?;
        let darker = match self.options.format {
            ExportFormat::Psd | ExportFormat::Ora => {
                task.timed("see-through layers", || content.encoded_difference())?
            }
            _ => None,
        };
        for file in &spared {
            let (old, new) = (file.display(), path.display());
            task.note(format!("{old} was changed since it was exported and is kept; this export is {new}"));
        }
        let photo = photo.name.clone();
        let layers = stack.image_layers.len();
        let groups = content.orders().len();
        let problems = content.paint.damaged().to_vec();
        Ok(ExportReport { photo, path, spared, key: job.key, layers, groups, bytes, darker, problems })
    }

    /// Returns the document's key: the same stack with the same paint and guide of trees, exported with the same options, has the same
    /// key. (`stack.json` and the paint book name their files by the hash of their content, so they represent the
    /// pixels, too.)
    fn key(&self, content: &StackContent) -> String {
        let options = (self.options.format, self.options.margin, self.options.guides);
        let painted: BTreeSet<&str> = content.paint.files().collect();
        let evened = content.evened.map_or(Vec::new(), |factors| to_json(&factors));
        let trees = content.trees.as_ref().map_or(Vec::new(), |trees| to_json(&trees.hash()));
        let parts = [to_json(content.stack), to_json(&options), to_json(&painted), evened, trees];
        let mut hash = hash_bytes(&parts.concat());
        hash.truncate(KEY_DIGITS);
        hash
    }
}

/// Makes the error for a photo without a stack.
fn no_stack(photo: &Photo) -> Error {
    Error::missing((format!("photo {} has no stack yet; run ", photo.name), Remedy::Build, " first"))
}

/// Reads the photo that the layers were cut from.
fn read_reference(photo: &Photo, stack: &Stack) -> Result<quadratura_base::scene::PhotoPixels> {
    read_photo(&photo.file, stack.photo.width, stack.photo.height)
}

/// A document that is being written to a file.
struct ExportJob<'a> {
    exporter: &'a Exporter<'a>,
    content: &'a StackContent<'a>,
    photo_file: &'a Path,
    key: String,
}

impl ExportJob<'_> {
    fn write(&self) -> Result<WrittenDocument> {
        let document = self.content.document(&self.key);
        let Exporter { out, options, written, .. } = self.exporter;
        let name = &self.content.stack.photo.name;
        let place = DocumentPlace { out, name, written, format: options.format };
        if options.for_scene {
            put_away(self.exporter.project, out, name, written, self.content.task)?;
        }
        let fill = |new: &mut NewFolder| match options.for_scene {
            true => folder::fill_for_scene(new, self.content, &document),
            false => folder::fill(new, self.content, &document, self.photo_file),
        };
        place.write(&document, &fill, &|files| self.record(files))
    }

    /// Writes the record of the export.
    fn record(&self, files: Vec<ExportedFile>) -> Result<()> {
        let stack = self.content.stack;
        let kept = &self.exporter.kept;
        let layers = self.content.exported_layers(kept)?;
        let profile = self.content.profile().map(|profile| kept.store_bytes(&profile, "icc")).transpose()?;
        let named = |object: &str, face: FaceIndex, piece: u32| {
            let elements = layers.iter().flat_map(|layer| &layer.elements);
            elements.filter(|e| e.object == object).any(|e| e.pieces.contains(&(face, piece)))
        };
        let pieces = stack.pieces.iter().filter(|p| named(&p.object, p.face, p.piece)).cloned().collect();
        let surfaces = stack.surfaces.clone();
        self.exporter.records.write(ExportRecord {
            version: RECORD_VERSION,
            key: self.key.clone(),
            format: self.exporter.options.format,
            photo: stack.photo.clone(),
            camera: stack.camera.clone(),
            depth: self.content.depth().bits(),
            inputs: stack.inputs.clone(),
            files: files.into_iter().collect(),
            helpers: self.content.helpers()?,
            evened: self.content.evened,
            pieces,
            surfaces,
            paint: self.content.paint.files().map(str::to_owned).collect(),
            profile,
            tree: None,
            layers,
        })
    }
}

/// Returns the token of the layer of which the photo shows most: an editor opens the file on it where no layer was
/// chosen, as on a group or a guide nothing can be painted. None in a stack without layers.
fn largest(stack: &Stack) -> Option<&str> {
    let shown = |layer: &&ImageLayer| {
        let figures = LayerFigures::from_layer(layer);
        (figures.used.saturating_sub(figures.hidden), Reverse(layer.order))
    };
    stack.image_layers.iter().max_by_key(shown).map(|layer| layer.id.as_str())
}
