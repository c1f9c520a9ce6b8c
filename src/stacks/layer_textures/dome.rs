//! The dome as layer textures, which come after those of the files.

use std::sync::Arc;

use super::LayerTextureFiles;
use quadratura_base::geometry::PixelRect;
use quadratura_projection::dome::{Dome, SIDES};
use quadratura_projection::{LayerTextureId, LayerTexturePixels};
use quadratura_view::legend::Origin;

/// How well a direction is known from where on photos show it.
pub const KNOWN: f32 = 0.5;

impl LayerTextureFiles {
    /// Returns the same with another dome, or with none.
    pub fn with_dome(self, dome: Option<Arc<Dome>>) -> Self {
        Self { dome, ..self }
    }

    /// Returns the same with the dome empty in directions that no photo shows, or whole.
    pub fn with_known_dome(self, known_dome: bool) -> Self {
        Self { known_dome, ..self }
    }

    /// Returns whether the dome is empty in directions that no photo shows.
    pub fn has_known_dome(&self) -> bool {
        self.known_dome
    }

    /// Returns the side of the dome that a layer texture is; `None` for those of photos.
    pub(super) fn side_of_dome(&self, layer_texture: LayerTextureId) -> Option<usize> {
        (layer_texture.0 as usize).checked_sub(self.files.len()).filter(|side| *side < SIDES)
    }
}

/// Returns the texels of a side, those that are not known only if wanted; none without a dome.
pub(super) fn pixels(dome: Option<&Dome>, side: usize, known_only: bool) -> LayerTexturePixels {
    let Some(dome) = dome else {
        return LayerTexturePixels {
            rect: PixelRect::of_size(0, 0),
            rgba: vec![],
            needed: vec![],
            matte: None,
        };
    };
    let mut pixels = dome.side_pixels(side);
    if known_only {
        let known = dome.side_known(side);
        for (texel, _) in
            pixels.rgba.as_chunks_mut::<4>().0.iter_mut().zip(known).filter(|(_, known)| *known < KNOWN)
        {
            texel[3] = 0;
        }
    }
    pixels
}

/// Returns the origins of the texels of a side of the dome: photos, or nothing but their neighbourhood.
pub(super) fn origins(dome: &Dome, side: usize) -> Vec<Origin> {
    let known = dome.side_known(side);
    known
        .into_iter()
        .map(|known| if known >= KNOWN { Origin::OtherPhoto } else { Origin::Diffused })
        .collect()
}
