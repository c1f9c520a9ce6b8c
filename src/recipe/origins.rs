//! Layer textures that show the sources of their texels as colours ([`Origin::colour`]), so that they can be
//! projected like the textures themselves.

use quadratura_base::error::Result;
use quadratura_document::stack::origins;
use quadratura_projection::{LayerTextureId, LayerTexturePixels, Texels};
use quadratura_view::legend::Origin;

use super::layer_textures::LayerTextureFiles;

/// Returns the kind of source that a name of [`origins`] stands for.
pub fn origin_of(name: &str) -> Origin {
    match name {
        origins::NONE => Origin::Photo,
        origins::PAINTED => Origin::Paint,
        origins::EXEMPLAR => Origin::Example,
        origins::DIFFUSED => Origin::Diffused,
        name if origins::painter(name).is_some() => Origin::Propagated,
        _ => Origin::OtherPhoto,
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_origins_are_told_apart() {
        let names = ["[none]", "[painted]", "[painted in a.jpg]", "b.jpg", "[exemplar]", "[diffused]"];
        assert_eq!(names.map(origin_of), Origin::ALL);
    }
}
