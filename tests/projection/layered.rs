//! Where nothing is hidden, a photo in layers shows what the whole photo shows.

use std::sync::Arc;

use glam::DVec2;
use quadratura::Result;
use quadratura::task::Task;
use quadratura::testing::geometry::PixelRect;
use quadratura::testing::projection::model_surface::ModelSurface;
use quadratura::testing::projection::relief::Relief;
use quadratura::testing::projection::{
    Domain, Gains, LayerTexture, LayerTextureId, LayerTexturePixels, Renders, Server, Sources, Texels,
};
use quadratura::testing::scene::FaceId;
use quadratura::testing::view::hidden::Culling;
use quadratura::testing::view::{Quality, Shot};
use rayon::prelude::*;

use crate::bench::{Bench, apart, renderer_of};

/// The whole photo as one sheet.
struct Whole(LayerTexturePixels);

impl Texels for Whole {
    fn layer_texture(&self, _: LayerTextureId) -> Result<LayerTexturePixels> {
        Ok(self.0.clone())
    }
}

fn whole(bench: &Bench) -> (Arc<Sources>, Arc<dyn Texels>) {
    let pixels = bench.pixels(0);
    let (w, h) = (pixels.width, pixels.height);
    let rgba = (0..w * h).flat_map(|i| pixels.rgba16(i % w, i / w).map(|s| (s >> 8) as u8)).collect();
    let rect = PixelRect { x: 0, y: 0, w: w.next_power_of_two(), h: h.next_power_of_two() };
    let mut sources = (*bench.sources).clone();
    sources.layer_textures = vec![LayerTexture { rect, ..sources.layer_textures[0].clone() }];
    let mut servers: Vec<Server> = Vec::new();
    for range in &mut sources.of_face {
        let first = sources.servers[range.start as usize..range.end as usize].first().cloned();
        range.start = servers.len() as u32;
        servers.extend(first.map(|server| Server {
            layer_texture: LayerTextureId(0),
            domain: Domain::Whole,
            ..server
        }));
        range.end = servers.len() as u32;
    }
    sources.servers = servers;
    sources.surroundings = 0..0;
    let needed = vec![1; (w * h) as usize];
    (sources.into(), Arc::new(Whole(LayerTexturePixels { rect: pixels.rect(), rgba, needed, matte: None })))
}

#[test]
fn where_nothing_is_hidden_layers_show_what_the_whole_photo_shows() {
    let Some(bench) = Bench::piazza(&["02"]) else { return };
    let (sources, texels) = whole(&bench);
    let (gains, flat) = (Gains::none(1), Relief::default());
    let mut of_whole = renderer_of(&bench.gpu, &bench.site, &sources, &gains, &flat, &texels);
    let mut of_layers = bench.renderer(&flat);
    let photo = &bench.site.photos[0];
    // A step aside and nearer, half as large again: level 0 everywhere.
    let mut camera = photo.camera;
    (camera.width, camera.height) = (480, 320);
    (camera.fx, camera.fy, camera.cx, camera.cy) = (1.5 * camera.fx, 1.5 * camera.fy, 240.0, 160.0);
    let mut pose = photo.pose;
    pose.translation += glam::DVec3::new(-0.6, 0.1, 0.4);
    let display = unhidden(&bench, &Shot::new(camera, pose));
    for quality in [Quality::Preview, Quality::Final] {
        let shot = Shot { quality, ..Shot::new(camera, pose) };
        let [a, b] = [&mut of_whole, &mut of_layers].map(|r| r.picture(&shot, &Task::silent()).unwrap());
        let pixels = a.rgba.chunks(4).zip(b.rgba.chunks(4)).zip(&display).filter(|(_, display)| **display);
        let off: Vec<u8> = pixels.map(|((a, b), _)| if b[3] == 255 { apart(a, b) } else { 255 }).collect();
        let mean = off.iter().map(|off| f64::from(*off)).sum::<f64>() / off.len() as f64;
        let most = *off.iter().max().unwrap();
        println!("{quality:?}: {} pixels, at most {most} off, {mean:.4} on average", off.len());
        // Both pictures look up the same texels; each may be stored 0.6 steps off, and a lookup lands up to 1/256 of a
        // texel elsewhere. 2 was seen; what is wrong by a layer is off by tens.
        assert!(off.len() > 50_000 && most <= 3 && mean <= 0.1, "{most}, {mean} over {}", off.len());
    }
}

/// For each pixel whether the photo shows what it sees, and nothing else nearby.
fn unhidden(bench: &Bench, shot: &Shot) -> Vec<bool> {
    let surface = ModelSurface::from_model(&bench.site.model);
    let photo = &bench.site.photos[0];
    let owner = |camera: &quadratura::testing::geometry::Pinhole,
                 pose: &quadratura::testing::geometry::Pose,
                 px: DVec2| {
        let direction = pose.rotation.transpose() * camera.ray_in_camera(px);
        let hit = surface.owner(pose.center_in_world(), direction, 1e-4, Culling::nothing())?;
        Some((hit.face, pose.center_in_world() + direction * hit.t))
    };
    // Around, in pixels, 5 x 5: as far as a bilinear lookup, a sample of the pixel and rounding reach.
    let around =
        |spacing: f64| (0..25).map(move |k| DVec2::new(f64::from(k % 5 - 2), f64::from(k / 5 - 2)) * spacing);
    // One server all around: elsewhere is a cut, where f32 may choose the other side.
    let serves = |face: FaceId, px: DVec2| {
        let servers = bench.sources.servers_of(face);
        let one = |step: DVec2| servers.iter().position(|server| server.domain.holds(px + step));
        one(DVec2::ZERO).is_some() && around(1.0).all(|step| one(step) == one(DVec2::ZERO))
    };
    let width = shot.camera.width;
    let seen = |i: u32| {
        let px = DVec2::new(f64::from(i % width) + 0.5, f64::from(i / width) + 0.5);
        let Some((face, point)) = owner(&shot.camera, &shot.pose, px) else { return false };
        let same = |found: Option<(FaceId, _)>| found.is_some_and(|(other, _)| other == face);
        let Some(in_photo) = photo.camera.image_from_camera(photo.pose.camera_from_world(point)) else {
            return false;
        };
        let inside = in_photo.cmpge(DVec2::splat(3.0)).all()
            && in_photo.x < f64::from(photo.camera.width) - 3.0
            && in_photo.y < f64::from(photo.camera.height) - 3.0;
        inside
            && serves(face, in_photo)
            && around(0.3).all(|step| same(owner(&shot.camera, &shot.pose, px + step)))
            && around(1.0).all(|step| same(owner(&photo.camera, &photo.pose, in_photo + step)))
    };
    (0..width * shot.camera.height).into_par_iter().map(seen).collect()
}
