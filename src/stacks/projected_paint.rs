//! Paint of other photos on image layers whose files do not contain it yet.

use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::PhotoId;
use quadratura_layers::LayerIndex;

/// Paint on an image layer that the layer's files do not contain yet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProjectedPaint {
    /// The photo.
    pub photo: PhotoId,
    /// The image layer in the photo's stack.
    pub layer: LayerIndex,
    /// The part of the image layer that changes, in photo pixels.
    pub rect: PixelRect,
    /// The texels of `rect`, row by row.
    pub texels: Vec<ProjectedTexel>,
}

/// A texel of a layer, as paint of other photos leaves it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProjectedTexel {
    /// The texel is as in the files.
    AsFiled,
    /// No paint of other photos covers what the photo shows.
    Bare,
    /// Paint of another photo: sRGB, and the confidence in 255ths.
    Paint([u8; 3], u8),
}
