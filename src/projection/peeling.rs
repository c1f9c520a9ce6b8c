//! Layers of a view: what one would see if everything in front of it were taken away, layer by layer.
//!
//! Everitt 2001, *Interactive Order-Independent Transparency*: each pass draws the nearest surfaces that are farther than those
//! of the pass before (depth peeling). Here surfaces that are level with those of a layer, within the visibility tolerance,
//! belong to it.

use std::sync::Arc;

use quadratura_base::error::Result;
use quadratura_base::scene::{FaceId, Model};
use quadratura_base::task::Task;
use quadratura_view::{Picture, Shot};

/// The surfaces that layers are peeled off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Peeled {
    /// The model's faces.
    Faces,
    /// The skirts on its outlines ([`super::skirts`]).
    Skirts,
}

/// A planar part of a model: a face, or one triangle of a face that is not planar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct PlanarPart {
    /// The face.
    pub face: FaceId,
    /// The index of the triangle within the face; `None` for a planar face.
    pub triangle: Option<u32>,
}

/// One layer of a view.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PeeledLayer {
    /// 1 + the index of the part that each pixel shows, 0 where there is none; row by row from the top.
    pub parts: Vec<u32>,
    /// R, G, B in sRGB and alpha, not premultiplied. Alpha is 0 where no photo shows the part, and its matte where one sees
    /// through it.
    pub colours: Vec<[u8; 4]>,
}

/// A renderer that peels layers off. What it draws is ready for the shot's excluded photos already.
pub trait Peels {
    /// Returns the model with its skirts, and the parts that layers name by their indices.
    fn parts(&self) -> (Arc<Model>, Vec<PlanarPart>);

    /// Draws the layers of a view from the nearest on, one sample at the centre of each pixel, in the quality of the shot's
    /// filters, without surroundings and without the darkening of its lens. The shot shows colours or their sources
    /// ([`super::DisplayMode::Colour`], [`super::DisplayMode::Provenance`]). `each` takes a layer and returns whether the next
    /// one is wanted. It is not given a layer without any part.
    ///
    /// # Errors
    /// Those of [`super::Renders::picture`] and of `each`.
    fn peel(
        &mut self,
        shot: &Shot,
        surfaces: Peeled,
        each: &mut dyn FnMut(PeeledLayer) -> Result<bool>,
        task: &Task,
    ) -> Result<()>;

    /// Draws the surroundings alone, as if there were no faces, without the darkening of the view's lens.
    ///
    /// # Errors
    /// Those of [`super::Renders::picture`].
    fn surroundings(&mut self, shot: &Shot, task: &Task) -> Result<Picture>;
}
