//! Tests of the CPU reference: it reproduces the photos.

use glam::DVec3;

use super::*;
use crate::{Domain, LayerTexture, LayerTexturePixels, Projector, Server};
use quadratura_base::geometry::{PixelRect, Pose};
use quadratura_base::scene::PhotoId;
use quadratura_base::scene::synthetic::{Modeller, centred, look_at};

/// A source with one photo of a wall, in one layer texture, with a pattern of stripes.
struct Stripes;

impl Texels for Stripes {
    fn layer_texture(&self, _: LayerTextureId) -> Result<LayerTexturePixels> {
        let rect = PixelRect::of_size(64, 64);
        let rgba = (0..64 * 64).flat_map(|i| stripe(i % 64, i / 64)).collect();
        Ok(LayerTexturePixels { rect, rgba, needed: vec![1; 64 * 64], matte: None })
    }
}

fn stripe(x: u32, y: u32) -> [u8; 4] {
    [(x * 37 % 251) as u8, (y * 53 % 251) as u8, ((x + y) * 29 % 251) as u8, 255]
}

fn twin(photos: Vec<Pose>) -> ReferenceRenderer {
    let mut m = Modeller::new();
    m.object("wall").quad_facing(DVec3::NEG_Y, DVec3::new(-5.0, 0.0, -5.0), DVec3::X * 10.0, DVec3::Z * 10.0);
    let layer_texture = |photo: u32| LayerTexture {
        photo: PhotoId(photo),
        id: format!("{photo}"),
        rect: PixelRect::of_size(64, 64),
        see_through: false,
    };
    let server = |photo: u32| Server {
        layer_texture: LayerTextureId(photo),
        photo: PhotoId(photo),
        back: false,
        pinned: false,
        domain: Domain::Whole,
    };
    let count = photos.len() as u32;
    let projector = |pose| Projector { name: String::new(), camera: centred(64, 64, 64.0), pose };
    let sources = Sources {
        photos: photos.into_iter().map(projector).collect(),
        layer_textures: (0..count).map(layer_texture).collect(),
        servers: (0..count).map(server).collect(),
        of_face: std::iter::once(0..count).collect(),
        ..Sources::default()
    };
    let gains = Gains::none(count as usize);
    let (relief, options) = (Relief::default(), PyramidOptions::default());
    ReferenceRenderer::new(m.finish(), sources.into(), gains, relief, Arc::new(Stripes), options)
}

#[test]
fn in_its_own_camera_a_photo_is_itself_but_for_its_outermost_pixels() {
    let pose = look_at(DVec3::new(0.7, -5.0, 0.3), DVec3::new(0.1, 0.0, 0.0));
    let mut twin = twin(vec![pose, look_at(DVec3::new(-2.0, -5.0, 0.0), DVec3::ZERO)]);
    let camera = twin.sources.photos[0].camera;
    for mode in quadratura_view::Mode::ALL {
        let mut shot = Shot::new(camera, pose);
        shot.blend.mode = mode;
        let picture = twin.picture(&shot, &Task::silent()).unwrap();
        let (pixels, _) = picture.rgba.as_chunks::<4>();
        for (i, pixel) in (0..).zip(pixels) {
            let (x, y) = (i % 64, i / 64);
            // Near the border of a photo, the photo has less weight.
            let inside = x.min(63 - x).min(y.min(63 - y)) >= 9;
            let expected = stripe(x, y);
            let near = pixel.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 1);
            assert!(near || !inside, "{mode}: {x}, {y}: {pixel:?}, not {expected:?}");
        }
    }
}

#[test]
fn from_behind_nobody_serves_and_beside_the_wall_there_is_nothing() {
    let pose = look_at(DVec3::new(0.0, -5.0, 0.0), DVec3::ZERO);
    let mut twin = twin(vec![pose]);
    let camera = twin.sources.photos[0].camera;
    let behind = Shot::new(camera, look_at(DVec3::new(0.0, 5.0, 0.0), DVec3::ZERO));
    assert!(twin.picture(&behind, &Task::silent()).unwrap().rgba.chunks(4).all(|p| p == FLAT));
    let far = Shot::new(camera, look_at(DVec3::new(0.0, -50.0, 0.0), DVec3::ZERO));
    let faces = twin.faces(&far, &Task::silent()).unwrap();
    // Ten metres at a distance of fifty, with 64 pixels per unit of tangent: 12.8 pixels.
    assert!((140..190).contains(&faces.iter().filter(|face| **face == 1).count()), "{faces:?}");
    let mut without = Shot::new(camera, pose);
    without.without = vec![PhotoId(0)];
    assert!(twin.picture(&without, &Task::silent()).unwrap().rgba.chunks(4).all(|p| p == FLAT));
}
