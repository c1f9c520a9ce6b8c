//! The interface of renderers: images of views, at once or in slices, and for the long-lived renderer of a site the
//! replacement of what has changed.

use std::sync::Arc;

use super::agreement::Agreement;
use super::continuation::Continuation;
use super::exposure::ViewExposure;
use super::model_surface::ModelSurface;
use super::peeling::Peels;
use super::relief::Relief;
use super::{Gains, LayerTextureId, Sliced, Sources, Texels};
use quadratura_base::error::Result;
use quadratura_base::scene::{FaceId, Model};
use quadratura_base::task::Task;
use quadratura_view::{LinearPicture, Picture, Shot};

/// The bit of the numbers of [`Renders::faces`] that marks a tree; the others are its index then.
pub const TREE: u32 = 1 << 31;

/// Returns the face that a number of [`Renders::faces`] stands for; `None` for nothing and for a tree.
pub fn shown_face(number: u32) -> Option<FaceId> {
    if number & TREE != 0 { None } else { number.checked_sub(1).map(FaceId) }
}

/// A renderer of views: the GPU's, or its CPU reference.
pub trait Renders {
    /// Renders the image of a view.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`], [`quadratura_base::Error::Input`] and [`quadratura_base::Error::Io`] for a layer's file that
    /// can't be read, [`quadratura_base::Error::Cancelled`].
    fn picture(&mut self, shot: &Shot, task: &Task) -> Result<Picture>;

    /// Finds the visible face at each pixel centre, row by row from the top: 1 + its id, 0 where there is
    /// none, [`TREE`] and its index where a tree is. Of faces within the visibility tolerance, the last in the model file
    /// counts.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`], [`quadratura_base::Error::Cancelled`].
    fn faces(&mut self, shot: &Shot, task: &Task) -> Result<Vec<u32>>;

    /// As [`Renders::faces`], but of a see-through face only what is there counts: where its matte is nearly 0, the face
    /// is what the view shows behind it. A renderer without mattes shows all of every face.
    ///
    /// # Errors
    /// Those of [`Renders::picture`].
    fn seen_faces(&mut self, shot: &Shot, task: &Task) -> Result<Vec<u32>> {
        self.faces(shot, task)
    }

    /// Finds the depth of what [`Renders::seen_faces`] finds, along the camera's axis, in units of the world; infinite where
    /// nothing is. `None` where the renderer has no depths.
    ///
    /// # Errors
    /// Those of [`Renders::picture`].
    fn depths(&mut self, shot: &Shot, task: &Task) -> Result<Option<Vec<f32>>> {
        let _ = shot;
        task.check_cancelled().map(|()| None)
    }

    /// Renders the image of a view in linear light, with depths where the renderer has them. A renderer that draws with 8 bits
    /// a channel returns these.
    ///
    /// # Errors
    /// Those of [`Renders::picture`].
    fn linear_picture(&mut self, shot: &Shot, task: &Task) -> Result<LinearPicture> {
        let mut sliced = self.begin(&Shot { linear: true, ..shot.clone() }, task)?.alone();
        while !self.advance(&mut sliced, task)? {}
        Ok(LinearPicture { depths: self.depths(shot, task)?, ..sliced.linear_picture() })
    }

    /// Begins an image that is drawn in slices, between which other images can be drawn.
    ///
    /// # Errors
    /// Those of [`Renders::picture`].
    fn begin(&mut self, shot: &Shot, task: &Task) -> Result<Sliced> {
        task.check_cancelled()?;
        Ok(Sliced::new(shot, ViewExposure::default()))
    }

    /// Draws the next slice; returns whether the image is complete. A renderer without slices draws all at once.
    ///
    /// # Errors
    /// Those of [`Renders::picture`].
    fn advance(&mut self, sliced: &mut Sliced, task: &Task) -> Result<bool> {
        let picture = self.picture(&sliced.shot().clone(), task)?;
        Ok(sliced.add(picture))
    }
}

/// The data from which a renderer of a site is made.
pub struct SiteContent<'a> {
    /// The model, whose faces are drawn.
    pub model: Arc<Model>,
    /// The layer textures that texture the faces.
    pub sources: Arc<Sources>,
    /// The photos' exposures.
    pub gains: Gains,
    /// The depth detail of its surfaces.
    pub relief: &'a Relief,
    /// How far photos confirm each other.
    pub agreement: Agreement,
    /// The layer textures' texels.
    pub texels: Arc<dyn Texels>,
}

/// A long-lived renderer of one site. Window, command line and score use a renderer through this trait alone.
pub trait SiteRenderer: Renders + Send {
    /// Returns the model for ray casting, as it is drawn.
    fn surface(&self) -> Arc<ModelSurface>;

    /// Replaces the table of which layer textures texture which faces; photos and layer textures remain the same.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`]; nothing has changed then.
    fn set_sources(&mut self, sources: Arc<Sources>) -> Result<()>;

    /// Replaces the photos' gains.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`] when the device cannot hold them; the old ones remain.
    fn set_gains(&mut self, gains: Gains) -> Result<()>;

    /// Replaces the relief with which surfaces are drawn.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`] when the device cannot hold it; the old relief remains.
    fn set_relief(&mut self, relief: &Relief) -> Result<()>;

    /// Replaces the colours with which surfaces continue where no photo shows them ([`super::Unseen::Continued`]); without them
    /// they are left empty.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`] when the device cannot hold them; the old ones remain.
    fn set_continuation(&mut self, continuation: Continuation) -> Result<()>;

    /// Replaces the photos' agreement, by which they are weighted.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`] when the device cannot hold it; the old agreement remains.
    fn set_agreement(&mut self, agreement: Agreement) -> Result<()>;

    /// As [`Self::set_agreement`], where only the values of these layer textures have changed since.
    ///
    /// # Errors
    /// As [`Self::set_agreement`].
    fn renew_agreement(&mut self, agreement: &Agreement, changed: &[LayerTextureId]) -> Result<()> {
        debug_assert!(!changed.is_empty());
        self.set_agreement(agreement.clone())
    }

    /// Replaces the texels of all layer textures, and reads those that changed again. Returns the number of layer
    /// textures that were read at once; others are read when they are needed.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`], [`quadratura_base::Error::Cancelled`].
    fn renew(&mut self, texels: Arc<dyn Texels>, changed: &[LayerTextureId], task: &Task) -> Result<usize>;

    /// Sets the data for [`super::DisplayMode::Provenance`]: layer textures in the colours of their texels' origins.
    /// `None` removes it and frees its texture memory.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`] when the device cannot hold its page tables.
    fn set_origins(&mut self, origins: Option<Arc<dyn Texels>>) -> Result<()>;

    /// Returns true when the data for [`super::DisplayMode::Provenance`] is set.
    fn has_origins(&self) -> bool;

    /// Returns the renderer as one that peels layers off; `None` where it cannot.
    fn peels(&mut self) -> Option<&mut dyn Peels> {
        None
    }

    /// Returns the number of layer textures that could not be read so far and are not used.
    fn unreadable(&self) -> usize;

    /// Returns the costs of texture memory, against what it shows, in words.
    fn statistics(&self) -> String;
}
