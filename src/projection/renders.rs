//! What a renderer can be asked for: pictures of shots, at once or in slices, and of one site's renderer that it takes up
//! what has changed.

use std::sync::Arc;

use super::relief::Relief;
use super::surface::Surface;
use super::{Gains, Picture, SheetId, Shot, Sliced, Sources, Texels};
use crate::error::Result;
use crate::scene::Model;
use crate::task::Task;

/// Who can draw a shot: the GPU, or its plain twin.
pub trait Renders {
    /// The picture of a shot.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`], [`crate::Error::Input`] and [`crate::Error::Io`] for a layer's file that
    /// can't be read, [`crate::Error::Cancelled`].
    fn picture(&mut self, shot: &Shot, task: &Task) -> Result<Picture>;

    /// The nearest face at each pixel centre, in row order from the top: 1 + its id, 0 where there is
    /// none. Faces within the visibility tolerance: the last in the model file.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`], [`crate::Error::Cancelled`].
    fn faces(&mut self, shot: &Shot, task: &Task) -> Result<Vec<u32>>;

    /// Begins a picture that is drawn slice by slice, between which others can be drawn.
    ///
    /// # Errors
    /// Those of [`Renders::picture`].
    fn begin(&mut self, shot: &Shot, task: &Task) -> Result<Sliced> {
        task.go_on()?;
        Ok(Sliced::new(shot, Vec::new()))
    }

    /// Draws the next slice; whether the picture is whole. A renderer that does not know slices draws all at once.
    ///
    /// # Errors
    /// Those of [`Renders::picture`].
    fn advance(&mut self, sliced: &mut Sliced, task: &Task) -> Result<bool> {
        let picture = self.picture(&sliced.shot().clone(), task)?;
        Ok(sliced.add(&picture))
    }
}

/// What a renderer of a site is made of.
pub struct SiteContent<'a> {
    /// Its faces.
    pub model: Arc<Model>,
    /// What serves them.
    pub sources: Arc<Sources>,
    /// The photos' exposures.
    pub gains: Gains,
    /// The depth detail of its surfaces.
    pub relief: &'a Relief,
    /// The sheets' texels.
    pub texels: Arc<dyn Texels>,
}

/// A renderer of one site, kept from picture to picture, that takes up what changes meanwhile. Window, command line and
/// score know a renderer by this alone.
pub trait SiteRenderer: Renders + Send {
    /// The model as rays meet it, and as it is drawn.
    fn surface(&self) -> Arc<Surface>;

    /// Serves faces by other photos from now on, of the same photos and sheets.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`]; all stays as it was.
    fn set_sources(&mut self, sources: Arc<Sources>) -> Result<()>;

    /// Shows photos with other gains from now on.
    fn set_gains(&mut self, gains: Gains);

    /// Shows surfaces with another relief from now on.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] when the device cannot hold it; the old one stays.
    fn set_relief(&mut self, relief: &Relief) -> Result<()>;

    /// Reads these sheets again, from these texels, which are those of all sheets from now on; how many were read at
    /// once, others follow when they are needed.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`], [`crate::Error::Cancelled`].
    fn renew(&mut self, texels: Arc<dyn Texels>, changed: &[SheetId], task: &Task) -> Result<usize>;

    /// Takes what [`super::Shown::Provenance`] shows: sheets in the colours of their texels' origins. `None` gives the
    /// memory for it back.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] when the device cannot hold its page tables.
    fn set_origins(&mut self, origins: Option<Arc<dyn Texels>>) -> Result<()>;

    /// Whether it can show [`super::Shown::Provenance`].
    fn has_origins(&self) -> bool;

    /// How many sheets could not be read so far and serve nothing.
    fn unreadable(&self) -> usize;

    /// What texture memory costs, against what it shows, in words.
    fn statistics(&self) -> String;
}
