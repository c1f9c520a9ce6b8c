//! A model whose faces one photo shows.

use crate::{Domain, LayerTexture, LayerTextureId, Projector, Server, Sources};
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_base::scene::PhotoId;

/// Returns the sources of a model with this number of faces, each of which a single photo serves from either side: from one layer texture,
/// which is as large as the photo.
pub fn one_photo(camera: Pinhole, pose: Pose, faces: usize) -> Sources {
    let server = |back: bool| Server {
        layer_texture: LayerTextureId(0),
        photo: PhotoId(0),
        back,
        pinned: false,
        domain: Domain::Whole,
    };
    let faces = faces as u32;
    Sources {
        photos: vec![Projector { name: "photo".into(), camera, pose }],
        layer_textures: vec![LayerTexture {
            photo: PhotoId(0),
            id: "all".into(),
            rect: PixelRect::of_size(camera.width, camera.height),
            see_through: false,
        }],
        servers: (0..faces).flat_map(|_| [false, true]).map(server).collect(),
        of_face: (0..faces).map(|face| 2 * face..2 * face + 2).collect(),
        ..Sources::default()
    }
}
