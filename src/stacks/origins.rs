//! Layer textures that show the sources of their texels as colours ([`Origin::colour`]), so that they can be
//! projected like the textures themselves.

use quadratura_base::error::Result;
use quadratura_projection::{LayerTextureId, LayerTexturePixels, Texels};

use crate::layer_textures::LayerTextureFiles;

/// Layer textures in the colours of their texels' sources, with the confidence of the textures themselves.
#[derive(Debug, Clone)]
pub struct LayerTextureOrigins(pub LayerTextureFiles);

impl Texels for LayerTextureOrigins {
    fn layer_texture(&self, layer_texture: LayerTextureId) -> Result<LayerTexturePixels> {
        let mut pixels = self.0.layer_texture(layer_texture)?;
        let origins = self.0.origins(layer_texture, pixels.rect)?;
        for (texel, origin) in pixels.rgba.as_chunks_mut::<4>().0.iter_mut().zip(origins) {
            let [r, g, b] = origin.colour();
            *texel = [r, g, b, texel[3]];
        }
        Ok(pixels)
    }
}
