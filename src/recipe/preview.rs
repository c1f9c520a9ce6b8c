//! A project becomes a renderer: stacks are read, and sheets, gains and relief made ready.

use std::path::Path;
use std::sync::Arc;

use super::budget::default_memory;
use super::gains::photo_gains;
use super::open::Opened;
use super::sheets::SheetFiles;
use super::sources::sources;
use super::survey::{StackState, Survey};
use crate::document::Stack;
use crate::error::{Error, Result};
use crate::gpu::{Gpu, Renderer, TextureOptions, TileStore};
use crate::io::stack_store::StackStore;
use crate::projection::Gains;
use crate::projection::relief::Relief;
use crate::task::Task;

/// How a project is shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PreviewOptions {
    /// Texture memory.
    pub textures: TextureOptions,
    /// Differences of exposure between photos are evened out.
    pub gains: bool,
    /// Surfaces are shown with the relief that the photos tell.
    pub relief: bool,
}

impl Default for PreviewOptions {
    fn default() -> Self {
        Self { textures: TextureOptions::default(), gains: true, relief: true }
    }
}

/// The renderer of an opened project. Photos without a stack serve nothing, with a note; those whose
/// stack is older than the project do, with a note.
///
/// # Errors
/// [`Error::Request`] when no photo has a stack, [`Error::Io`] and [`Error::Input`] for stacks that
/// cannot be read, [`Error::Gpu`].
pub fn open(
    folder: &Path,
    opened: &Opened,
    gpu: &Gpu,
    options: &PreviewOptions,
    task: &Task,
) -> Result<Renderer> {
    let store = StackStore::new(folder);
    let stacks = task.timed("read stacks", || stacks(opened, &store, task))?;
    let sources = Arc::new(sources(&opened.site, &stacks));
    let files = SheetFiles::new(&store, stacks.iter().flatten());
    let tiles = TileStore::new(gpu, &sources, Arc::new(files), options.textures)?;
    let gains = match options.gains {
        true => task.timed("gains", || photo_gains(&opened.site, &stacks, folder, default_memory(), task))?,
        false => Gains::none(opened.site.photos.len()),
    };
    let relief = Relief::default();
    Renderer::new(gpu, opened.site.model.clone(), sources, gains, &relief, tiles)
}

/// The photos' current stacks, in the site's order.
fn stacks(opened: &Opened, store: &StackStore, task: &Task) -> Result<Vec<Option<Stack>>> {
    let survey = Survey::new(opened, store);
    let mut stacks = Vec::with_capacity(opened.site.photos.len());
    let (mut missing, mut stale) = (Vec::new(), Vec::new());
    for photo in &opened.site.photos {
        stacks.push(match survey.state(photo)? {
            StackState::Current(stack) => Some(stack),
            StackState::Stale(stack) => {
                stale.push(photo.name.as_str());
                Some(stack)
            }
            StackState::Missing => {
                missing.push(photo.name.as_str());
                None
            }
            StackState::Broken(error) => {
                task.of(&photo.name).note(format!("its stack serves nothing: {error}"));
                None
            }
        });
    }
    if stacks.iter().all(Option::is_none) {
        return Err(Error::Request("no photo has a stack yet; `quadratura build` makes them".into()));
    }
    if !missing.is_empty() {
        let missing = missing.join(", ");
        task.note(format!("no stack, so they serve nothing: {missing}; `quadratura build` makes them"));
    }
    if !stale.is_empty() {
        let stale = stale.join(", ");
        task.note(format!("older than the project: the stacks of {stale}; `quadratura build` renews them"));
    }
    Ok(stacks)
}
