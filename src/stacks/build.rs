//! The command `build`: sorts every photo, cuts it into image layers and writes its stack.

use std::path::PathBuf;

use rayon::prelude::*;

use crate::assemble::{add_surroundings, assemble};
use crate::faces_to_keep::FacesToKeep;
use crate::inputs::Inputs;
use crate::layer_names::rename;
use crate::turns::Turns;
use crate::untextured;
use quadratura_base::error::Result;
use quadratura_base::scene::impostor::Facing;
use quadratura_base::scene::{Photo, PhotoPixels, Site};
use quadratura_base::task::Task;
use quadratura_document::stack::Stack;
use quadratura_document::{Decisions, PhotoDecisions};
use quadratura_io::failures::{forget_failure, note_failure};
use quadratura_io::layer_png::{LayerSpans, write_layer, write_mask};
use quadratura_io::paint_store::PaintStore;
use quadratura_io::stack_store::{StackStore, StackWriter};
use quadratura_io::unmasked::read_unmasked;
use quadratura_layers::content::Content;
use quadratura_layers::surroundings::Surroundings;
use quadratura_layers::{Options, Rasteriser, Sorted, sort_photo};
use quadratura_sites::budget::default_memory;
use quadratura_sites::named::photos_named;
use quadratura_sites::side_by_side::ParallelPhotos;

/// Options of [`build`].
#[derive(Debug, Clone, PartialEq)]
pub struct BuildOptions {
    /// The options of the method.
    pub layers: Options,
    /// Decisions about single photos' layers.
    pub decisions: Decisions,
    /// The names of the photos to build; empty for all.
    pub photos: Vec<String>,
    /// The memory budget in bytes for photos processed at the same time.
    pub memory: u64,
    /// The largest number of photos processed at the same time.
    pub threads: usize,
    /// Whether photos with an up-to-date stack are built again.
    pub force: bool,
}

/// All photos, a quarter of the available memory, one photo per core at a time, and only what is out of date.
impl Default for BuildOptions {
    fn default() -> Self {
        Self {
            layers: Options::default(),
            decisions: Decisions::default(),
            photos: Vec::new(),
            memory: default_memory(),
            threads: rayon::current_num_threads(),
            force: false,
        }
    }
}

/// The result for one photo.
#[derive(Debug)]
pub struct Built {
    /// The photo's name.
    pub photo: String,
    /// The stack, or the reason why there is none (an older one may still exist).
    pub stack: Result<Stack>,
    /// Whether the stack was up to date, so that nothing was written.
    pub up_to_date: bool,
    /// Files that were edited by hand; they were moved to these paths in `inbox/`.
    pub kept: Vec<PathBuf>,
}

/// Builds the stacks of a site's photos, several at a time. An error in one photo is in its [`Built`] and does not
/// stop the others. Results are in the site's order.
///
/// # Errors
/// Returns [`quadratura_base::Error::Request`] for a photo name that the site does not have, the errors of reading the paint
/// book, or [`quadratura_base::Error::Cancelled`].
pub fn build(
    site: &Site,
    store: &StackStore,
    rasteriser: &dyn Rasteriser,
    options: &BuildOptions,
    task: &Task,
) -> Result<Vec<Built>> {
    build_or_check(site, store, rasteriser, options, None, task)
}

/// [`build`] within a turn of an update, which stops photos one by one and commits no stack that has become obsolete.
///
/// # Errors
/// As [`build`].
pub(super) fn build_in_turn(
    site: &Site,
    store: &StackStore,
    rasteriser: &dyn Rasteriser,
    options: &BuildOptions,
    turns: &Turns,
    task: &Task,
) -> Result<Vec<Built>> {
    build_or_check(site, store, rasteriser, options, Some(turns), task)
}

fn build_or_check(
    site: &Site,
    store: &StackStore,
    rasteriser: &dyn Rasteriser,
    options: &BuildOptions,
    turns: Option<&Turns>,
    task: &Task,
) -> Result<Vec<Built>> {
    let photos = photos_named(site, &options.photos)?;
    let inputs = Inputs::new(&site.model, &options.layers, &options.decisions);
    let paint = PaintStore::new(store.project()).read()?;
    let to_keep = FacesToKeep::new(&options.decisions, &paint);
    let job = BuildJob { site, store, rasteriser, options, inputs, to_keep, turns };
    let at_a_time = ParallelPhotos { threads: options.threads, memory: options.memory, stage: STAGE };
    let work = |photo: &&Photo| job.photo(photo, &task.with_subject(&photo.name));
    at_a_time.run(&photos, |photo| bytes_for(photo), work, task)
}

/// The name of the stage that builds photo after photo.
pub const STAGE: &str = "build layers";

/// Returns the peak memory for one photo in bytes: pixels, fragment lists and runs, layers being written. A second
/// photo at the same time took 28 bytes per pixel more on a site of mean depth 1.8; the lists are longer where more
/// surfaces lie behind each other.
fn bytes_for(photo: &Photo) -> u64 {
    u64::from(photo.camera.width) * u64::from(photo.camera.height) * 48
}

/// The inputs that all photos of a build share.
struct BuildJob<'a> {
    site: &'a Site,
    store: &'a StackStore,
    rasteriser: &'a dyn Rasteriser,
    options: &'a BuildOptions,
    inputs: Inputs<'a>,
    to_keep: FacesToKeep<'a>,
    /// The turns of the update that this belongs to.
    turns: Option<&'a Turns<'a>>,
}

impl BuildJob<'_> {
    /// Builds one photo and moves any error into the result.
    fn photo(&self, photo: &Photo, task: &Task) -> Built {
        let built = |stack, up_to_date, kept| Built { photo: photo.name.clone(), stack, up_to_date, kept };
        let task = &self.turns.map_or_else(|| task.clone(), |turns| turns.task_of(&photo.name, task));
        match self.try_photo(photo, task) {
            Ok((stack, up_to_date, kept)) => built(Ok(stack), up_to_date, kept),
            Err(error) => {
                let error = self.store.with_final_path(&photo.name, error);
                note_failure(self.store.project(), &photo.name, &error);
                built(Err(error), false, Vec::new())
            }
        }
    }

    /// Returns an up-to-date stack with its layers renamed as decided; nothing else of it is made again.
    fn with_names(&self, mut stack: Stack, task: &Task) -> Result<(Stack, Vec<PathBuf>)> {
        note_unsatisfied(&stack, task);
        let decided = self.options.decisions.of(&stack.photo.name);
        if !give_names(&mut stack, &decided, task) {
            return Ok((stack, Vec::new()));
        }
        let committed = self.store.replace_stack_json(&stack)?;
        Ok((committed.stack, committed.kept))
    }

    /// Builds one photo unless its stack is up to date. Returns the stack, whether it was up to date, and the files
    /// moved to the inbox.
    fn try_photo(&self, photo: &Photo, task: &Task) -> Result<(Stack, bool, Vec<PathBuf>)> {
        task.check_cancelled()?;
        let inputs = self.inputs.hash(photo)?;
        // Who has waited for another program finds what that has made.
        let (lock, mut kept) = self.store.lock(&photo.name, task)?;
        if !self.options.force
            && let Some(stack) = self.store.up_to_date(&photo.name, &inputs)?
            && self.to_keep.agrees(&stack)
        {
            let (stack, more) = self.with_names(stack, task)?;
            kept.extend(more);
            return Ok((stack, true, kept));
        }
        let decided = self.options.decisions.of(&photo.name);
        let model = &self.site.model.facing(&Facing::of_pose(&photo.pose));
        let options = &decided.options.applied_to(&self.options.layers);
        let camera = &photo.camera;
        let constraints = self.to_keep.constraints(&photo.name);
        let sorted = sort_photo(model, camera, &photo.pose, self.rasteriser, options, &constraints, task)?;
        let assembled = || assemble(model, photo, &sorted, options, &constraints, &inputs);
        let mut stack = task.timed("assemble", assembled);
        note_unsatisfied(&stack, task);
        let pixels = task.timed("decode", || read_unmasked(photo))?;
        let rest = || Surroundings::find(&sorted, camera.rect(), &pixels, options, &constraints);
        let surroundings = task.timed("surroundings", rest);
        let contents: Vec<&Content> = sorted.contents.iter().chain(surroundings.contents()).collect();
        if pixels.has_alpha() {
            count_valid(&mut stack, &sorted, &pixels);
            stack.leftovers = valid_leftovers(&sorted, &pixels);
            stack.untextured.extend(untextured::of_mask(model, &sorted, &pixels));
        }
        add_surroundings(&mut stack, photo, &surroundings);
        give_names(&mut stack, &decided, task);
        let writer = self.store.begin(&photo.name)?;
        stack.bytes = task.timed("write", || write_files(&writer, &stack, &contents, &pixels, task))?;
        drop(pixels);
        let _held = self.turns.map(|turns| turns.check_stack(photo, &inputs, task)).transpose()?;
        lock.check()?;
        let committed = task.timed("commit", || writer.commit(stack))?;
        forget_failure(self.store.project(), &photo.name);
        kept.extend(committed.kept);
        Ok((committed.stack, false, kept))
    }
}

/// Reports the decisions that could not be satisfied.
fn note_unsatisfied(stack: &Stack, task: &Task) {
    stack.unsatisfied.iter().for_each(|unsatisfied| task.note(unsatisfied));
}

/// Renames the layers as decided and reports names for which no layer was found. Returns true when a name changed.
fn give_names(stack: &mut Stack, decided: &PhotoDecisions, task: &Task) -> bool {
    let renamed = rename(stack, &decided.names);
    renamed.unmatched.iter().for_each(|name| task.note(name));
    renamed.changed
}

/// Writes each image layer and its needed area; returns the size of the files in bytes.
fn write_files(
    writer: &StackWriter,
    stack: &Stack,
    contents: &[&Content],
    pixels: &PhotoPixels,
    task: &Task,
) -> Result<u64> {
    let layers: Vec<_> = stack.image_layers.iter().zip(contents).collect();
    layers
        .par_iter()
        .map(|(layer, content)| {
            task.check_cancelled()?;
            let layer_file = writer.folder().join(&layer.file);
            let needed_file = writer.folder().join(&layer.needed_file);
            let beside = content.beside([pixels.width, pixels.height]);
            let spans = LayerSpans { visible: &content.visible, beside: &beside };
            Ok(write_layer(&layer_file, pixels, layer.rect, spans)?
                + write_mask(&needed_file, layer.rect, &content.needed)?)
        })
        .sum()
}

/// Counts visible texels again without those where the photo is invalid.
fn count_valid(stack: &mut Stack, sorted: &Sorted, pixels: &PhotoPixels) {
    for (layer, content) in stack.image_layers.iter_mut().zip(&sorted.contents) {
        let valid = content.visible.iter().flat_map(|s| (s.x0..s.x1).filter(|&x| pixels.is_valid(x, s.y)));
        layer.texels_visible = valid.count() as u64;
    }
}

/// Returns the pixels of leftovers at which the photo is valid, as in [`Stack::leftovers`].
fn valid_leftovers(sorted: &Sorted, pixels: &PhotoPixels) -> Vec<[u32; 3]> {
    let mut valid: Vec<[u32; 3]> = Vec::new();
    for span in &sorted.leftovers.spans {
        for x in (span.x0..span.x1).filter(|&x| pixels.is_valid(x, span.y)) {
            match valid.last_mut() {
                Some([y, _, end]) if *y == span.y && *end == x => *end += 1,
                _ => valid.push([span.y, x, x + 1]),
            }
        }
    }
    valid
}
