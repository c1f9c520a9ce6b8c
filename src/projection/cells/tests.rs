//! Tests that the candidates of a cell include every photo that has weight at any of its points.

use glam::{DVec2, DVec3, dvec3};

use super::depths::ShownDepths;
use super::{Cells, Finder, TexelBounds, Unknown, cells};
use crate::sources::{Domain, LayerTexture, LayerTextureId, Projector, Server, Sources};
use quadratura_base::geometry::{PixelRect, Plane};
use quadratura_base::scene::synthetic::{Modeller, Rng, centred, look_at, random};
use quadratura_base::scene::{Model, PhotoId};
use quadratura_view::shot::{Blend, Mode, Shot};
use quadratura_view::weights;
use quadratura_view::weights::{Claim, angle_at, border, octaves_missing, pixels_per_unit};

/// A source of bounds in which each photo has one confidence and one agreement everywhere.
struct Even;

impl Even {
    fn from_photo(photo: PhotoId) -> f64 {
        0.25 + 0.75 * (f64::from(photo.0) * 0.618).fract()
    }

    fn agreement_of(photo: PhotoId) -> f64 {
        0.05 + 0.95 * (f64::from(photo.0) * 0.414).fract()
    }
}

impl TexelBounds for Even {
    fn least(&self, server: &Server, _: DVec2, _: DVec2) -> f64 {
        Self::from_photo(server.photo)
    }

    fn least_agreement(&self, server: &Server, _: DVec2, _: DVec2) -> f64 {
        Self::agreement_of(server.photo)
    }
}

/// Arranges cameras around the scene, each of which textures the side of every face that it sees.
fn ring_of_photos(rng: &mut Rng, model: &Model, count: u32) -> Sources {
    let mut sources = Sources::default();
    for i in 0..count {
        let turn = std::f64::consts::TAU * f64::from(i) / f64::from(count);
        let eye = dvec3(9.0 * turn.cos(), 9.0 * turn.sin(), rng.between(0.5, 4.0)) + center(model);
        let camera = centred(640, 480, rng.between(300.0, 900.0));
        let pose = look_at(eye, center(model) + dvec3(rng.between(-1.0, 1.0), 0.0, 0.0));
        sources.photos.push(Projector { name: format!("{i}"), camera, pose });
        let rect = PixelRect { x: -32, y: -16, w: 1024, h: 512 };
        sources.layer_textures.push(LayerTexture {
            photo: PhotoId(i),
            id: format!("s{i}"),
            rect,
            see_through: false,
        });
    }
    for face in model.face_ids() {
        let plane = model.face(face).plane;
        let start = sources.servers.len() as u32;
        let pin = rng.chance(0.3).then(|| rng.whole(0, count - 1));
        for photo in 0..count {
            let eye = sources.photos[photo as usize].pose.center_in_world();
            let back = plane.signed_distance(eye) < 0.0;
            let pinned = pin == Some(photo);
            let (layer_texture, photo) = (LayerTextureId(photo), PhotoId(photo));
            sources.servers.push(Server { layer_texture, photo, back, pinned, domain: Domain::Whole });
        }
        sources.of_face.push(start..sources.servers.len() as u32);
    }
    sources
}

fn center(model: &Model) -> DVec3 {
    model.vertices.iter().sum::<DVec3>() / model.vertices.len() as f64
}

/// Computes the penalty of a server at a point, by the definition.
fn penalty(sources: &Sources, shot: &Shot, plane: &Plane, server: &Server, p: DVec3) -> f64 {
    let photo = sources.photo(server.photo);
    let in_photo = photo.pose.camera_from_world(p);
    let Some(px) = photo.camera.image_from_camera(in_photo) else { return f64::INFINITY };
    if server.back != (plane.signed_distance(shot.viewpoint()) < 0.0) {
        return f64::INFINITY;
    }
    let density = |camera, center, depth| pixels_per_unit(camera, plane, center, depth);
    let eye = photo.pose.center_in_world();
    let in_view = density(&shot.camera, shot.viewpoint(), shot.pose.camera_from_world(p).z);
    let claim = Claim {
        angle: angle_at(p, shot.viewpoint(), eye),
        octaves: octaves_missing(in_view, density(&photo.camera, eye, in_photo.z)),
        border: border(&photo.camera, px),
        confidence: Even::from_photo(server.photo),
        agreement: Even::agreement_of(server.photo),
    };
    claim.penalty(&shot.blend)
}

/// Compares, at pixels of the view, the weights of the cell's candidates with those of all servers. Returns
/// the number of points compared and the total number of their candidates.
fn compare(model: &Model, sources: &Sources, shot: &Shot, cells: &Cells, rng: &mut Rng) -> (u32, usize) {
    let (mut points, mut candidates) = (0, 0);
    for found in &cells.faces {
        let plane = model.face(found.face).plane;
        let corners: Vec<DVec3> = model.ring_points(found.face).collect();
        for _ in 0..40 {
            let shares: Vec<f64> = corners.iter().map(|_| rng.unit()).collect();
            let sum: f64 = shares.iter().sum();
            let p = corners.iter().zip(&shares).map(|(c, s)| *c * (s / sum)).sum::<DVec3>();
            let Some(px) = shot.camera.image_from_camera(shot.pose.camera_from_world(p)) else { continue };
            let (width, height) = (f64::from(shot.camera.width), f64::from(shot.camera.height));
            if px.min_element() < 0.0 || px.x >= width || px.y >= height {
                continue;
            }
            let list = cells.of(found, px.x as u32 / cells.side_px, px.y as u32 / cells.side_px);
            let all = sources.of_face[found.face.0 as usize].clone();
            let of = |s: u32| penalty(sources, shot, &plane, &sources.servers[s as usize], p);
            let everybody: Vec<f64> = all.clone().map(of).collect();
            let pinned = |s: u32| sources.servers[s as usize].pinned;
            let trust = |s: u32| pinned(s).then(|| if of(s).is_finite() { 0.5 } else { 0.0 });
            let truth = weights::shares(&everybody, &all.clone().map(trust).collect::<Vec<_>>(), &shot.blend);
            let listed: Vec<f64> = list.iter().map(|c| of(c.server)).collect();
            let trusts: Vec<Option<f64>> = list.iter().map(|c| trust(c.server)).collect();
            let found_weights = weights::shares(&listed, &trusts, &shot.blend);
            for (server, truth) in all.zip(&truth) {
                let place = list.iter().position(|c| c.server == server);
                let weight = place.map_or(0.0, |i| found_weights[i]);
                assert!((weight - truth).abs() < 1e-9, "{}: {weight} for {truth}", shot.blend.mode);
            }
            for (candidate, q) in list.iter().zip(&listed) {
                assert!(candidate.least <= q * (1.0 + 1e-12), "{} > {q}", candidate.least);
            }
            assert!(list.is_sorted_by(|a, b| a.least <= b.least));
            points += 1;
            candidates += list.len();
        }
    }
    (points, candidates)
}

#[test]
fn no_cell_misses_a_photo_that_has_weight_at_any_of_its_points() {
    let mut rng = Rng::new(21);
    for seed in 0..6 {
        let model = random::boxes(seed, 5).model;
        let sources = ring_of_photos(&mut rng, &model, 24);
        for mode in Mode::ALL {
            let eye = center(&model) + dvec3(rng.between(-8.0, 8.0), rng.between(5.0, 9.0), 2.0);
            let mut shot = Shot::new(centred(400, 300, 350.0), look_at(eye, center(&model)));
            shot.blend = Blend { mode, photos: 4, without_transients: rng.chance(0.5), ..Blend::default() };
            for known in [false, true] {
                let found = match known {
                    true => cells(&model, &sources, &shot, 32, &[], &[], &Even),
                    false => cells(&model, &sources, &shot, 32, &[], &[], &Unknown),
                };
                let (points, candidates) = compare(&model, &sources, &shot, &found, &mut rng);
                assert!(points > 100, "seed {seed}: {points} points");
                // Where lower bounds of confidence are known, lists are short: 24 photos texture every side.
                if known && mode == Mode::Lumigraph {
                    assert!(candidates < 16 * points as usize, "{candidates} at {points} points");
                }
            }
        }
    }
}

#[test]
fn a_photo_that_must_not_take_part_is_no_candidate() {
    let mut rng = Rng::new(22);
    let model = random::boxes(3, 4).model;
    let sources = ring_of_photos(&mut rng, &model, 6);
    let photo = sources.photo(PhotoId(2)).clone();
    let mut shot = Shot::new(photo.camera, photo.pose);
    shot.without = vec![PhotoId(2)];
    let found = cells(&model, &sources, &shot, 32, &[], &[], &Unknown);
    assert!(!found.candidates.is_empty());
    let photos = found.candidates.iter().map(|c| sources.servers[c.server as usize].photo);
    assert!(photos.into_iter().all(|p| p != PhotoId(2)));
}

/// A street of ground with a photo every metre, all looking along it, and a view near its beginning.
fn street(photos: u32) -> (Model, Sources, Shot) {
    let length = f64::from(photos);
    let mut modeller = Modeller::new();
    modeller.object("ground").quad(dvec3(-4.0, 0.0, -1.6), DVec3::X * 8.0, DVec3::Y * length);
    let model = Model::clone(&modeller.finish());
    let camera = centred(640, 480, 500.0);
    let mut sources = Sources::default();
    let back = model.face(model.face_ids().next().unwrap()).plane.signed_distance(DVec3::ZERO) < 0.0;
    for i in 0..photos {
        let eye = dvec3(0.5, f64::from(i) - 2.0, 0.0);
        sources.photos.push(Projector { name: format!("{i}"), camera, pose: look_at(eye, eye + DVec3::Y) });
        let (photo, rect) = (PhotoId(i), PixelRect { x: 0, y: 0, w: 1024, h: 512 });
        sources.layer_textures.push(LayerTexture { photo, id: format!("s{i}"), rect, see_through: false });
        let layer_texture = LayerTextureId(i);
        sources.servers.push(Server { layer_texture, photo, back, pinned: false, domain: Domain::Whole });
    }
    sources.of_face.push(0..photos);
    (model, sources, Shot::new(camera, look_at(dvec3(0.0, 1.0, 0.0), dvec3(0.0, 9.0, 0.0))))
}

#[test]
fn of_the_photos_of_a_street_those_near_the_ground_that_a_cell_shows_are_listed_at_its_depths() {
    let (model, sources, shot) = street(200);
    let finder = Finder {
        model: &model,
        sources: &sources,
        shot: &shot,
        side_px: 16,
        heights: &[],
        leaning: &[],
        confidence: &Even,
    };
    let cells = finder.cells();
    let ground = cells.faces[0];
    let all = sources.of_face[0].clone();
    let plane = model.face(ground.face).plane;
    // The cell below the horizon shows the ground from 50 m on.
    let [column, row] = [20, 15];
    let whole = cells.of(&ground, column, row).len();
    let mut nearest = whole;
    for depth in [60.0, 80.0, 120.0, 190.0] {
        let p = dvec3(0.1, 1.0 + depth, -1.6);
        let px = shot.camera.image_from_camera(shot.pose.camera_from_world(p)).unwrap();
        assert_eq!([px.x as u32 / 16, px.y as u32 / 16], [column, row], "{px}");
        let shown = ShownDepths::between_inverse([1.0 / depth; 2], cells.depths[1]);
        let listed = finder.at_depths(&cells, &ground, [column, row], shown);
        let of = |s: u32| penalty(&sources, &shot, &plane, &sources.servers[s as usize], p);
        let truth = weights::shares(&all.clone().map(of).collect::<Vec<_>>(), &vec![None; 200], &shot.blend);
        for (server, weight) in all.clone().zip(truth) {
            let is_listed = listed.iter().any(|candidate| candidate.server == server);
            assert!(is_listed || weight == 0.0, "{server} has a weight of {weight} at {depth} m");
        }
        nearest = nearest.min(listed.len());
    }
    // Photos beyond the ground that is shown do not see it.
    assert!(whole > 150 && 2 * nearest < whole, "{nearest} of {whole}");
}
