//! Layers that are peeled off: their faces against rays through the model, their colours against the twin's.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};
use quadratura::task::Task;
use quadratura::testing::projection::Renders;
use quadratura::testing::projection::model_surface::ModelSurface;
use quadratura::testing::projection::peeling::{Peeled, PeeledLayer, Peels};
use quadratura::testing::projection::relief::Relief;
use quadratura::testing::scene::FaceId;
use quadratura::testing::scene::synthetic::{Rng, Scene, random};
use quadratura::testing::view::hidden::{Culling, HiddenFaces};
use quadratura::testing::view::{Quality, Shot};

use crate::bench::apart;
use crate::random_scenes::{bench, view};

/// The visibility tolerance of the renderer.
const TOLERANCE: f64 = 1e-4;

/// Steps of 8 bits by which a colour may differ from the twin's, as in the comparison of pictures.
const STEPS: u8 = 3;

fn scenes() -> impl Iterator<Item = (Scene, Rng)> {
    let scenes = (31..=33).flat_map(|seed| [random::soup(seed, 24), random::boxes(seed, 8)]);
    (31..).zip(scenes).map(|(seed, scene)| (scene, Rng::new(seed)))
}

fn layers(renderer: &mut impl Peels, shot: &Shot) -> Vec<PeeledLayer> {
    let mut layers = Vec::new();
    let mut each = |layer: PeeledLayer| {
        layers.push(layer);
        Ok(true)
    };
    renderer.peel(shot, Peeled::Faces, &mut each, &Task::silent()).unwrap();
    layers
}

fn ray(shot: &Shot, pixel: usize) -> DVec3 {
    let width = shot.camera.width as usize;
    let px = DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
    shot.pose.rotation.transpose() * shot.camera.ray_in_camera(px)
}

/// The faces along a ray, of those level with each other the last in the model.
fn expected(surface: &ModelSurface, shot: &Shot, pixel: usize, faces: &BTreeSet<FaceId>) -> Vec<FaceId> {
    let culling = Culling { backs: true, hidden: &HiddenFaces::default() };
    let mut hits = surface.through(shot.viewpoint(), ray(shot, pixel), faces, culling);
    hits.reverse();
    let mut found: Vec<(f64, FaceId)> = Vec::new();
    for hit in hits {
        match found.last_mut() {
            Some((nearest, face)) if hit.t <= *nearest * (1.0 + TOLERANCE) => *face = hit.face.max(*face),
            _ => found.push((hit.t, hit.face)),
        }
    }
    found.into_iter().map(|(_, face)| face).collect()
}

#[test]
fn layers_hold_all_faces_along_each_ray_from_front_to_back() {
    let (mut pixels, mut wrong, mut deepest) = (0, 0, 0);
    for (scene, mut rng) in scenes() {
        let Some(bench) = bench(scene.clone(), &mut rng) else { return };
        let mut renderer = bench.renderer(&Relief::default());
        let shot = view(&scene, &mut rng);
        let layers = layers(&mut renderer, &shot);
        let (_, parts) = renderer.parts();
        let surface = ModelSurface::from_model(&bench.site.model);
        let faces: BTreeSet<FaceId> = bench.site.model.face_ids().collect();
        for pixel in 0..(shot.camera.width * shot.camera.height) as usize {
            let found: Vec<FaceId> = layers
                .iter()
                .map(|layer| layer.parts[pixel])
                .take_while(|part| *part > 0)
                .map(|part| parts[part as usize - 1].face)
                .collect();
            let nothing_after = layers[found.len()..].iter().all(|layer| layer.parts[pixel] == 0);
            pixels += 1;
            wrong += usize::from(found != expected(&surface, &shot, pixel, &faces) || !nothing_after);
            deepest = deepest.max(found.len());
        }
    }
    // At the outlines of faces, where the device's grid of sub-pixels decides: of 24 polygons along a ray some have one there.
    assert!(wrong * 100 < pixels, "{wrong} of {pixels} rays have other layers");
    assert!(deepest >= 5, "{deepest} layers at most");
}

#[test]
fn the_first_layer_is_the_faces_of_the_view() {
    for (scene, mut rng) in scenes() {
        let Some(bench) = bench(scene.clone(), &mut rng) else { return };
        let mut renderer = bench.renderer(&Relief::default());
        let shot = view(&scene, &mut rng);
        let layers = layers(&mut renderer, &shot);
        let (_, parts) = renderer.parts();
        let faces = renderer.faces(&shot, &Task::silent()).unwrap();
        let found = |part: &u32| part.checked_sub(1).map_or(0, |part| parts[part as usize].face.0 + 1);
        let first: Vec<u32> =
            layers.first().map_or(vec![0; faces.len()], |layer| layer.parts.iter().map(found).collect());
        // Another near plane rounds depths otherwise.
        let differ = first.iter().zip(&faces).filter(|(a, b)| a != b).count();
        assert!(differ * 1000 <= faces.len(), "{differ} of {} pixels", faces.len());
    }
}

#[test]
fn the_colours_of_all_layers_are_the_twins_at_the_same_points() {
    let (mut compared, mut far, mut deep) = (0, 0, 0);
    for (scene, mut rng) in scenes() {
        let Some(bench) = bench(scene.clone(), &mut rng) else { return };
        let relief = Relief::default();
        let (mut renderer, mut twin) = (bench.renderer(&relief), bench.twin(&relief));
        let shot = Shot { quality: Quality::Final, ..view(&scene, &mut rng) };
        let layers = layers(&mut renderer, &shot);
        let (_, parts) = renderer.parts();
        let model = bench.site.model.clone();
        let eye = shot.viewpoint();
        for (k, layer) in layers.iter().enumerate() {
            let planar = |(pixel, part): (usize, &u32)| {
                let face = parts[part.checked_sub(1)? as usize].face;
                let plane = model.face(face).plane;
                let direction = ray(&shot, pixel);
                let t = -plane.signed_distance(eye) / plane.normal.dot(direction);
                let billboard = model.object(model.face(face).object).billboard;
                let is_meant = model.face(face).planar && !billboard && t > 0.0;
                is_meant.then_some((pixel, (face, eye + direction * t)))
            };
            let (pixels, points): (Vec<usize>, Vec<(FaceId, DVec3)>) =
                layer.parts.iter().enumerate().filter_map(planar).unzip();
            let colours = twin.colours_at(&shot, &points, &Task::silent()).unwrap();
            for (pixel, expected) in pixels.into_iter().zip(colours) {
                let found = layer.colours[pixel];
                let expected = expected.map_or([0; 4], |[r, g, b, _]| {
                    let byte = |light: f64| {
                        let stored =
                            quadratura::testing::scene::light::srgb_from_linear(light.clamp(0.0, 1.0));
                        (stored * 255.0).round() as u8
                    };
                    [byte(r), byte(g), byte(b), 255]
                });
                let off = expected[3] != found[3] || (found[3] > 0 && apart(&found, &expected) > STEPS);
                compared += 1;
                far += usize::from(off);
                deep += usize::from(k > 0 && found[3] > 0);
            }
        }
    }
    // As in the comparison of pictures, but that pixels at outlines are compared, too.
    assert!(far * 200 < compared, "{far} of {compared} colours differ");
    assert!(deep > 1000, "{deep} colours of hidden points");
}
