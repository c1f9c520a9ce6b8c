//! `build`: every photo sorted, cut into image layers and written as a stack.

use std::path::PathBuf;

use rayon::prelude::*;

use super::assemble::assemble;
use super::inputs::Inputs;
use super::layer_names::rename;
use super::named::photos_named;
use super::side_by_side::SideBySide;
use super::untextured;
use crate::document::stack::Stack;
use crate::document::{Decisions, PhotoDecisions};
use crate::error::Result;
use crate::io::layer_png::{LayerSpans, write_layer, write_mask};
use crate::io::photo::read_shown;
use crate::io::stack_store::{StackStore, StackWriter};
use crate::layers::{Options, Rasteriser, Sorted, sort_photo};
use crate::scene::{Photo, PhotoPixels, Site};
use crate::task::Task;

/// What `build` is asked to do.
#[derive(Debug, Clone, PartialEq)]
pub struct BuildOptions {
    /// The method.
    pub layers: Options,
    /// What was decided about single photos' layers.
    pub decisions: Decisions,
    /// Only these photos; empty for all.
    pub photos: Vec<String>,
    /// Bytes that photos worked on at the same time may take together.
    pub memory: u64,
    /// Photos worked on at the same time at most.
    pub threads: usize,
    /// Also photos whose stack is up to date.
    pub force: bool,
}

/// What became of one photo.
#[derive(Debug)]
pub struct Built {
    /// Its name.
    pub photo: String,
    /// Its stack, or why there is none (an older one may still be there).
    pub stack: Result<Stack>,
    /// Nothing had changed, nothing was written.
    pub up_to_date: bool,
    /// Files somebody had changed by hand, as they are now in `inbox/`.
    pub kept: Vec<PathBuf>,
}

/// Builds the stacks of a site's photos, several at a time. A fault in one photo is in its
/// [`Built`]; the others go on. Results come in the site's order.
///
/// # Errors
/// [`crate::Error::Request`] for a photo name that the site does not have, [`crate::Error::Cancelled`].
pub fn build(
    site: &Site,
    store: &StackStore,
    rasteriser: &dyn Rasteriser,
    options: &BuildOptions,
    task: &Task,
) -> Result<Vec<Built>> {
    let photos = photos_named(site, &options.photos)?;
    let inputs = Inputs::new(&site.model, &options.layers, &options.decisions);
    let job = Job { site, store, rasteriser, options, inputs };
    let at_a_time = SideBySide { threads: options.threads, memory: options.memory, stage: "photos" };
    let work = |photo: &&Photo| job.photo(photo, &task.of(&photo.name));
    at_a_time.run(&photos, |photo| bytes_for(photo), work, task)
}

/// What one photo takes at its peak: pixels, fragment lists and runs, layers being written.
/// A second photo at a time took 28 bytes a pixel more on a site of mean depth 1.8; lists are
/// longer where more surfaces lie behind each other.
fn bytes_for(photo: &Photo) -> u64 {
    u64::from(photo.camera.width) * u64::from(photo.camera.height) * 48
}

struct Job<'a> {
    site: &'a Site,
    store: &'a StackStore,
    rasteriser: &'a dyn Rasteriser,
    options: &'a BuildOptions,
    inputs: Inputs<'a>,
}

impl Job<'_> {
    fn photo(&self, photo: &Photo, task: &Task) -> Built {
        let built = |stack, up_to_date, kept| Built { photo: photo.name.clone(), stack, up_to_date, kept };
        match self.try_photo(photo, task) {
            Ok((stack, up_to_date, kept)) => built(Ok(stack), up_to_date, kept),
            Err(error) => built(Err(self.store.at_home(&photo.name, error)), false, Vec::new()),
        }
    }

    /// A stack that is up to date, with its layers named as was decided: nothing else of it is made again.
    fn with_names(&self, mut stack: Stack, task: &Task) -> Result<(Stack, Vec<PathBuf>)> {
        note_unmet(&stack, task);
        let decided = self.options.decisions.of(&stack.photo.name);
        if !give_names(&mut stack, &decided, task) {
            return Ok((stack, Vec::new()));
        }
        let committed = self.store.restate(&stack)?;
        Ok((committed.stack, committed.kept))
    }

    fn try_photo(&self, photo: &Photo, task: &Task) -> Result<(Stack, bool, Vec<PathBuf>)> {
        task.go_on()?;
        let inputs = self.inputs.hash(photo)?;
        if !self.options.force
            && let Some(stack) = self.store.up_to_date(&photo.name, &inputs)?
        {
            let (stack, kept) = self.with_names(stack, task)?;
            return Ok((stack, true, kept));
        }
        let decided = self.options.decisions.of(&photo.name);
        let (model, options) = (&self.site.model, &decided.options.applied_to(&self.options.layers));
        let (camera, wishes) = (&photo.camera, decided.wishes());
        let sorted = sort_photo(model, camera, &photo.pose, self.rasteriser, options, &wishes, task)?;
        let assembled = || assemble(model, photo, &sorted, options, &wishes, &inputs);
        let mut stack = task.timed("assemble", assembled);
        note_unmet(&stack, task);
        give_names(&mut stack, &decided, task);
        let pixels = task.timed("decode", || read_shown(photo))?;
        if pixels.has_alpha() {
            count_valid(&mut stack, &sorted, &pixels);
            stack.untextured.extend(untextured::of_mask(model, &sorted, &pixels));
        }
        let writer = self.store.begin(&photo.name)?;
        stack.bytes = task.timed("write", || write_files(&writer, &stack, &sorted, &pixels, task))?;
        drop(pixels);
        let committed = task.timed("commit", || writer.commit(stack))?;
        Ok((committed.stack, false, committed.kept))
    }
}

/// Tells what was decided and could not be done.
fn note_unmet(stack: &Stack, task: &Task) {
    stack.unmet.iter().for_each(|unmet| task.note(unmet));
}

/// Gives the layers the names that were decided, and tells of those that found none. Whether one changed.
fn give_names(stack: &mut Stack, decided: &PhotoDecisions, task: &Task) -> bool {
    let renamed = rename(stack, &decided.names);
    renamed.homeless.iter().for_each(|name| task.note(name));
    renamed.changed
}

/// Writes every image layer and its needed area; returns their bytes.
fn write_files(
    writer: &StackWriter,
    stack: &Stack,
    sorted: &Sorted,
    pixels: &PhotoPixels,
    task: &Task,
) -> Result<u64> {
    let layers: Vec<_> = stack.image_layers.iter().zip(&sorted.contents).collect();
    layers
        .par_iter()
        .map(|(layer, content)| {
            task.go_on()?;
            let layer_file = writer.folder().join(&layer.file);
            let needed_file = writer.folder().join(&layer.needed_file);
            let beside = content.beside([pixels.width, pixels.height]);
            let spans = LayerSpans { visible: &content.visible, beside: &beside };
            Ok(write_layer(&layer_file, pixels, layer.rect, spans)?
                + write_mask(&needed_file, layer.rect, &content.needed)?)
        })
        .sum()
}

/// Where the photo is not valid it shows nothing: what covers it there is not visible after all.
fn count_valid(stack: &mut Stack, sorted: &Sorted, pixels: &PhotoPixels) {
    for (layer, content) in stack.image_layers.iter_mut().zip(&sorted.contents) {
        let valid = content.visible.iter().flat_map(|s| (s.x0..s.x1).filter(|&x| pixels.is_valid(x, s.y)));
        layer.texels_visible = valid.count() as u64;
    }
}
