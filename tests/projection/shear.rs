//! The sheared sub-frustum in the shader: texels lie where they belong, wherever the rectangle, the
//! principal point and the site are.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use quadratura::Result;
use quadratura::task::Task;
use quadratura::testing::geometry::{Pinhole, PixelRect};
use quadratura::testing::projection::relief::Relief;
use quadratura::testing::projection::twin::ReferenceRenderer;
use quadratura::testing::projection::{
    Domain, Gains, LayerTexture, LayerTextureId, LayerTexturePixels, Projector, Renders, Server, Sources,
    Texels,
};
use quadratura::testing::scene::light::linear_of_srgb;
use quadratura::testing::scene::synthetic::{Modeller, Rng, look_at};
use quadratura::testing::scene::{PhotoId, Site};
use quadratura::testing::view::Shot;

use crate::bench::renderer_of;
use crate::common;

/// A chequerboard of single texels in which red rises from column to column and green from row to
/// row: between two texels light says where a lookup was, to a few thousandths of a texel.
struct Chequers(PixelRect);

impl Texels for Chequers {
    fn layer_texture(&self, _: LayerTextureId) -> Result<LayerTexturePixels> {
        let PixelRect { x, y, w, h } = self.0;
        let light = |k: i32| if k.rem_euclid(2) == 0 { 0 } else { 255 };
        let row = |row: i32| (x..x + w as i32).flat_map(move |column| [light(column), light(row), 0, 255]);
        let rgba = (y..y + h as i32).flat_map(row).collect();
        Ok(LayerTexturePixels { rect: self.0, rgba, needed: vec![1; (w * h) as usize], matte: None })
    }
}

struct Case {
    site: Site,
    sources: Arc<Sources>,
    texels: Arc<dyn Texels>,
    shot: Shot,
}

/// A photo of a wall with an odd camera, one rectangle of it, and a look at a few of its texels from
/// elsewhere, 64 pixels a texel.
fn case(rng: &mut Rng, site_at: DVec3) -> Case {
    let camera = Pinhole {
        width: 3072,
        height: 2048,
        fx: rng.between(1500.0, 4000.0),
        fy: rng.between(1500.0, 4000.0),
        cx: rng.between(-200.0, 3300.0),
        cy: rng.between(-200.0, 2300.0),
    };
    let eye = site_at + DVec3::new(rng.between(-4.0, 4.0), -9.0, rng.between(-2.0, 2.0));
    let pose = look_at(eye, site_at + DVec3::new(rng.between(-3.0, 3.0), 0.0, rng.between(-1.0, 1.0)));
    let side = |rng: &mut Rng| 1u32 << rng.whole(4, 10);
    // May reach outside the photo; the texel that is looked at is inside both.
    let (w, h) = (side(rng), side(rng));
    let texel = DVec2::new(rng.between(400.0, 2600.0), rng.between(300.0, 1700.0));
    let within = |rng: &mut Rng, at: f64, side: u32| {
        at as i32 - rng.between(0.3, 0.7).mul_add(f64::from(side), 0.0) as i32
    };
    let rect = PixelRect { x: within(rng, texel.x, w), y: within(rng, texel.y, h), w, h };
    let mut m = Modeller::new();
    let wall = [DVec3::new(-60.0, 0.0, -60.0), DVec3::X * 120.0, DVec3::Z * 120.0];
    m.object("wall").quad_facing(DVec3::NEG_Y, site_at + wall[0], wall[1], wall[2]);
    let ray = pose.rotation.transpose() * camera.ray_in_camera(texel);
    let point = eye + ray * ((site_at - eye).y / ray.y);
    let from = site_at + DVec3::new(rng.between(-3.0, 3.0), -8.0, rng.between(-2.0, 2.0));
    let focal_px = 64.0 * camera.fx * (from - point).length() / (eye - point).length();
    let view = quadratura::testing::scene::synthetic::centred(256, 192, focal_px);
    let shot = Shot::new(view, look_at(from, point));
    let sources = Sources {
        photos: vec![Projector { name: String::new(), camera, pose }],
        layer_textures: vec![LayerTexture { photo: PhotoId(0), id: String::new(), rect, see_through: false }],
        servers: vec![Server {
            layer_texture: LayerTextureId(0),
            photo: PhotoId(0),
            back: false,
            pinned: false,
            domain: Domain::Whole,
        }],
        of_face: std::iter::once(0..1).collect(),
        ..Sources::default()
    };
    let site = Site { photos: Vec::new(), model: m.finish() };
    Case { site, sources: sources.into(), texels: Arc::new(Chequers(rect)), shot }
}

/// How far the shader's lookups are from the twin's, in photo pixels, along x and y: the mean over the
/// picture of the difference in light, with the sign of the slope. Rounding to 8 bits and the filter's
/// own 8 bits cancel over thousands of pixels.
fn offset_px(found: &[u8], expected: &[u8], width: usize, channel: usize) -> (f64, f64) {
    let light = |rgba: &[u8], i: usize| linear_of_srgb(f64::from(rgba[4 * i + channel]) / 255.0);
    let next = |i: usize| if channel == 0 { i + 1 } else { i + width };
    let (mut sum, mut count, mut worst) = (0.0, 0, 0.0f64);
    for i in 0..found.len() / 4 - width - 1 {
        let slope = light(expected, next(i)) - light(expected, i);
        // On the flanks, where light tells the place, and where 8 bits of sRGB are fine enough.
        let (a, b) = (light(found, i), light(expected, i));
        if slope.abs() > 0.005 && (0.03..0.5).contains(&b) && found[4 * i + 3] == 255 {
            sum += (a - b) * slope.signum();
            worst = worst.max((a - b).abs());
            count += 1;
        }
    }
    assert!(count > 1000, "only {count} pixels tell");
    (sum / f64::from(count), worst)
}

fn check(site_at: DVec3) {
    let Some(gpu) = common::gpu() else { return };
    let mut rng = Rng::new(51);
    let (mut most, mut most_single) = (0.0f64, 0.0f64);
    for number in 0..24 {
        let Case { site, sources, texels, shot } = case(&mut rng, site_at);
        let (gains, flat) = (Gains::none(1), Relief::default());
        let mut renderer = renderer_of(&gpu, &site, &sources, &gains, &flat, &texels);
        let options = quadratura::render::TextureOptions::default().pyramid;
        let mut twin = ReferenceRenderer::new(site.model.clone(), sources, gains, flat, texels, options);
        let found = renderer.picture(&shot, &Task::silent()).unwrap();
        let expected = twin.picture(&shot, &Task::silent()).unwrap();
        for channel in [0, 1] {
            let (mean, single) = offset_px(&found.rgba, &expected.rgba, 256, channel);
            most = most.max(mean.abs());
            most_single = most_single.max(single);
            assert!(mean.abs() < 0.01, "case {number}, channel {channel}: {mean} px");
        }
    }
    println!("{site_at}: at most {most:.5} px on average, {most_single:.5} at a single pixel");
    // A single pixel is rounded twice: to 1/256 of a texel by the filter, to 8 bits of sRGB by the
    // picture, which at half the light are 1/115 apart.
    assert!(most_single < 0.01 + 1.0 / 256.0 + 0.5 / 115.0, "{most_single}");
}

#[test]
fn texels_lie_within_a_hundredth_of_a_pixel_of_where_they_belong() {
    check(DVec3::ZERO);
}

#[test]
fn texels_lie_there_five_million_metres_from_the_origin_too() {
    check(DVec3::new(5e6, -3e6, 1200.0));
}
