//! What a view requests, the layered depth image of some photos of a project, and what it gets.

use std::path::PathBuf;
use std::sync::Arc;

use crate::StackLdiOptions;
use quadratura_base::error::Result;
use quadratura_base::scene::PhotoId;
use quadratura_base::task::Task;
use quadratura_ldi::Ldi;
use quadratura_projection::Gains;
use quadratura_projection::relief::Relief;
use quadratura_sites::open::Opened;
use quadratura_views::preview::Preview;

/// A state of a project from which layered depth images are made.
pub struct LiveInputs {
    /// The project's folder.
    pub(super) folder: PathBuf,
    /// The project.
    pub(super) opened: Arc<Opened>,
    /// The gains with which the projective renderer draws the photos.
    pub(super) gains: Gains,
    /// The relief that it shows.
    pub(super) relief: Option<Arc<Relief>>,
}

impl LiveInputs {
    /// Takes the state of the project in `folder` that `preview` shows.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`], [`quadratura_base::Error::Cancelled`].
    pub fn new(folder: PathBuf, opened: Arc<Opened>, preview: &mut Preview, task: &Task) -> Result<Self> {
        let (gains, relief) = preview.estimates_without(&[], task)?;
        Ok(Self { folder, opened, gains, relief })
    }
}

/// How a view is drawn from layered depth images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveOptions {
    /// The nearest depth pixels of each layered depth pixel that are left out.
    pub peeled: u32,
    /// The factor by which the view is larger than this picture, which is coarse while the view moves.
    pub larger: f64,
    /// Whether nothing is drawn while an image is built that shows more, because the model can be drawn.
    pub complete: bool,
}

impl Default for LiveOptions {
    fn default() -> Self {
        Self { peeled: 0, larger: 1.0, complete: false }
    }
}

/// A request for the layered depth image of some photos.
#[derive(Clone)]
pub struct ImageRequest {
    /// The state of the project.
    pub inputs: Arc<LiveInputs>,
    /// The photos, the reference first; at least one.
    pub photos: Vec<PhotoId>,
    /// How often the reference camera is halved.
    pub halvings: u32,
    /// See [`LiveOptions::peeled`].
    pub peeled: u32,
    /// What is taken from stacks.
    pub stack: StackLdiOptions,
}

impl ImageRequest {
    /// Returns whether two requests are for the same image.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.inputs, &other.inputs)
            && (&self.photos, self.halvings) == (&other.photos, other.halvings)
            && (self.peeled, self.stack) == (other.peeled, other.stack)
    }
}

/// How much of what was requested an image has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum RequestStage {
    /// One photo, at a coarse level.
    Coarse,
    /// The reference photo alone.
    OnePhoto,
    /// All of it.
    Whole,
}

/// An image that was built for a request, or on the way to what was requested.
#[derive(Debug)]
pub struct BuiltImage {
    /// The image, as it is drawn.
    pub ldi: Arc<Ldi>,
    /// The photos that it was made of; its colours have the exposure of the first one.
    pub photos: Vec<PhotoId>,
    /// How much of what was requested it has.
    pub stage: RequestStage,
}
