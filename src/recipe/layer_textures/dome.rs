//! The dome as layer textures, which come after those of the files.

use std::sync::Arc;

use super::LayerTextureFiles;
use crate::geometry::PixelRect;
use crate::projection::dome::{Dome, SIDES};
use crate::projection::legend::Origin;
use crate::projection::{LayerTextureId, LayerTexturePixels};

impl LayerTextureFiles {
    /// Returns the same with another dome, or with none.
    pub fn with_dome(self, dome: Option<Arc<Dome>>) -> Self {
        Self { dome, ..self }
    }

    /// Returns the side of the dome that a layer texture is; `None` for those of photos.
    pub(super) fn side_of_dome(&self, layer_texture: LayerTextureId) -> Option<usize> {
        (layer_texture.0 as usize).checked_sub(self.files.len()).filter(|side| *side < SIDES)
    }
}

/// Returns the texels of a side; none without a dome.
pub(super) fn pixels(dome: Option<&Dome>, side: usize) -> LayerTexturePixels {
    let nothing =
        || LayerTexturePixels { rect: PixelRect::of_size(0, 0), rgba: vec![], needed: vec![], matte: None };
    dome.map_or_else(nothing, |dome| dome.side_pixels(side))
}

/// Returns the origins of the texels of a side of the dome: photos, or nothing but their neighbourhood.
pub(super) fn origins(dome: &Dome, side: usize) -> Vec<Origin> {
    let known = dome.side_known(side);
    known.into_iter().map(|known| if known >= 0.5 { Origin::OtherPhoto } else { Origin::Diffused }).collect()
}
