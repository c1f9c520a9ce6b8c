//! The textures of mattes: for texture memory, the matte of a layer texture is a texture of its own, with the same
//! rectangle. Their ids follow those of all layer textures.

use std::borrow::Cow;

use super::residency::TileRequest;
use crate::{LayerTexture, LayerTextureId};

/// Which textures are mattes, and of which layer textures.
#[derive(Debug, Clone, Default)]
pub struct MatteTextures {
    /// The layer textures with mattes, in ascending order; their mattes follow the layer textures in this order.
    with_matte: Vec<LayerTextureId>,
    /// The number of layer textures.
    first: u32,
}

impl MatteTextures {
    /// Numbers the mattes of layer textures.
    pub fn new(layer_textures: &[LayerTexture]) -> Self {
        let all = (0..).map(LayerTextureId).zip(layer_textures);
        Self {
            with_matte: all.filter(|(_, texture)| texture.see_through).map(|(id, _)| id).collect(),
            first: layer_textures.len() as u32,
        }
    }

    /// Returns the layer textures with mattes, each with its matte.
    pub fn iter(&self) -> impl Iterator<Item = (LayerTextureId, LayerTextureId)> {
        self.with_matte.iter().copied().zip((self.first..).map(LayerTextureId))
    }

    /// Returns the matte of a layer texture; `None` where it has none.
    pub fn of(&self, layer_texture: LayerTextureId) -> Option<LayerTextureId> {
        let index = self.with_matte.binary_search(&layer_texture).ok()?;
        Some(LayerTextureId(self.first + index as u32))
    }

    /// Returns the layer texture whose matte a texture is; `None` where it is a layer texture.
    pub fn source(&self, texture: LayerTextureId) -> Option<LayerTextureId> {
        self.with_matte.get(texture.0.checked_sub(self.first)? as usize).copied()
    }

    /// Returns layer textures and their mattes.
    pub fn and_mattes<'a>(&self, layer_textures: &'a [LayerTextureId]) -> Cow<'a, [LayerTextureId]> {
        if self.with_matte.is_empty() {
            return layer_textures.into();
        }
        let mattes = layer_textures.iter().filter_map(|id| self.of(*id));
        layer_textures.iter().copied().chain(mattes).collect()
    }

    /// Returns requests of layer textures, and the same ones of their mattes.
    pub fn and_requests<'a>(&self, wants: &'a [TileRequest]) -> Cow<'a, [TileRequest]> {
        if self.with_matte.is_empty() {
            return wants.into();
        }
        let of_matte =
            |want: &TileRequest| Some(TileRequest { layer_texture: self.of(want.layer_texture)?, ..*want });
        wants.iter().copied().chain(wants.iter().filter_map(of_matte)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::geometry::PixelRect;
    use quadratura_base::scene::PhotoId;

    #[test]
    fn mattes_follow_all_layer_textures_and_are_wanted_with_theirs() {
        let layer_texture = |see_through: bool| LayerTexture {
            photo: PhotoId(0),
            id: String::new(),
            rect: PixelRect::of_size(8, 8),
            see_through,
        };
        let mattes = MatteTextures::new(&[false, true, false, true].map(layer_texture));
        let id = LayerTextureId;
        assert_eq!(mattes.iter().collect::<Vec<_>>(), [(id(1), id(4)), (id(3), id(5))]);
        assert_eq!([0, 1, 2, 3, 4].map(|at| mattes.of(id(at))), [None, Some(id(4)), None, Some(id(5)), None]);
        assert_eq!([3, 4, 5, 6].map(|at| mattes.source(id(at))), [None, Some(id(1)), Some(id(3)), None]);
        assert_eq!(*mattes.and_mattes(&[id(3), id(0)]), [id(3), id(0), id(5)]);
        let wants = [TileRequest::from_level(id(0), 2), TileRequest::from_level(id(3), 1)];
        assert_eq!(mattes.and_requests(&wants)[2..], [TileRequest::from_level(id(5), 1)]);
        assert_eq!(MatteTextures::new(&[layer_texture(false)]).and_requests(&wants).len(), 2);
    }
}
