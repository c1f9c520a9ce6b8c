//! Invented sites that are turned, scaled and shifted, and what cannot be aligned.

use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3, dvec3};

use super::pairs::{CornerPair, Unpaired, from_pairs};
use super::*;
use quadratura_base::geometry::bvh::Bvh;
use quadratura_base::scene::synthetic::{Modeller, Rng, centred, look_at};
use quadratura_base::task::Task;

struct Invented {
    model: Arc<Model>,
    cameras: Vec<(Pinhole, Pose)>,
    points: Vec<SparsePoint>,
}

/// A yard without any symmetry: ground, two walls of different height, a tower, a shed, and window panes.
fn yard() -> Invented {
    let mut m = Modeller::new();
    m.object("ground").quad(dvec3(-8.0, -6.0, 0.0), DVec3::X * 20.0, DVec3::Y * 16.0);
    m.object("north").quad_facing(DVec3::NEG_Y, dvec3(-8.0, 10.0, 0.0), DVec3::X * 20.0, DVec3::Z * 5.0);
    m.object("east").quad_facing(DVec3::NEG_X, dvec3(12.0, -6.0, 0.0), DVec3::Y * 16.0, DVec3::Z * 3.0);
    m.object("tower").cuboid(dvec3(-5.0, 7.0, 4.5), dvec3(1.5, 1.2, 4.5), DMat3::from_rotation_z(0.3));
    m.object("shed").cuboid(dvec3(7.0, 2.0, 1.0), dvec3(2.0, 1.0, 1.0), DMat3::from_rotation_z(-0.5));
    m.object("sills");
    for x in [-2.0, 1.5, 4.0, 8.0] {
        m.cuboid(dvec3(x, 9.8, 2.0), dvec3(0.6, 0.2, 0.8), DMat3::IDENTITY);
    }
    let eyes = [dvec3(-6.0, -5.0, 2.0), dvec3(2.0, -5.0, 1.7), dvec3(6.0, -4.0, 6.0), dvec3(-7.0, 1.0, 3.0)];
    site(m.finish(), &eyes, dvec3(2.0, 6.0, 1.5))
}

/// A square courtyard, the same from all four sides.
fn square() -> Invented {
    let mut m = Modeller::new();
    m.object("ground").quad(dvec3(-5.0, -5.0, 0.0), DVec3::X * 10.0, DVec3::Y * 10.0);
    for i in 0..4 {
        let turn = DMat3::from_rotation_z(f64::from(i) * std::f64::consts::FRAC_PI_2);
        m.object(format!("wall {i}")).quad_facing(
            turn * DVec3::NEG_Y,
            turn * dvec3(-5.0, 5.0, 0.0),
            turn * (DVec3::X * 10.0),
            DVec3::Z * 4.0,
        );
        m.object(format!("door {i}")).cuboid(turn * dvec3(0.0, 4.8, 1.0), dvec3(1.0, 0.2, 1.0), turn);
    }
    let eyes = [dvec3(0.0, -3.0, 1.6), dvec3(3.0, 0.5, 1.6), dvec3(0.3, 3.0, 1.6), dvec3(-3.0, 0.0, 1.6)];
    let mut all = site(m.finish(), &eyes, dvec3(0.0, 0.0, 1.4));
    all.points.truncate(2000);
    all
}

/// Looks at a model from several places, and at points on what is seen there, with a noise of a thousandth.
fn site(model: Arc<Model>, eyes: &[DVec3], target: DVec3) -> Invented {
    let triangle = |face| {
        model.face_triangles(face).iter().map(|t| t.map(|v| model.vertices[v as usize])).collect::<Vec<_>>()
    };
    let (tree, mut rng) = (Bvh::new(model.face_ids().flat_map(triangle).collect()), Rng::new(7));
    let cameras: Vec<_> = eyes.iter().map(|eye| (centred(640, 480, 400.0), look_at(*eye, target))).collect();
    let mut points = Vec::new();
    for (photo, (camera, pose)) in (0..).zip(&cameras) {
        let eye = pose.center_in_world();
        for _ in 0..500 {
            let px = DVec2::new(rng.between(0.0, 640.0), rng.between(0.0, 480.0));
            let ray = pose.world_from_camera(camera.ray_in_camera(px)) - eye;
            let Some((t, _)) = tree.first_hit(eye, ray, f64::INFINITY) else { continue };
            let position = eye + ray * t * rng.between(0.999, 1.001);
            points.push(SparsePoint { position, observations: vec![(photo, px)] });
        }
    }
    Invented { model, cameras, points }
}

fn turned(seed: u64) -> Similarity {
    let mut rng = Rng::new(seed);
    let axis = dvec3(rng.between(-1.0, 1.0), rng.between(-1.0, 1.0), rng.between(-1.0, 1.0)).normalize();
    Similarity {
        scale: 10f64.powf(rng.between(-3.0, 3.0)),
        rotation: DMat3::from_axis_angle(axis, rng.between(0.0, 3.0)),
        translation: dvec3(rng.between(-100.0, 100.0), 4e5, rng.between(-9.0, 9.0)),
    }
}

/// The model as its file has it, when `right` takes it to the world.
fn in_file(site: &Invented, right: &Similarity) -> Model {
    site.model.transformed(&right.inverse())
}

fn searched(site: &Invented, model: &Model) -> (AlignmentAnswer, Vec<AlignmentCandidate>) {
    let aligner = Aligner::new(model, &site.cameras, &site.points).unwrap_or_else(|why| panic!("{why:?}"));
    aligner.search(&Task::silent()).unwrap()
}

/// How far corners of the yard are from where they belong, in the world's unit.
fn off(found: &AlignmentCandidate, right: &Similarity) -> f64 {
    let corners = [dvec3(-8.0, 10.0, 5.0), dvec3(12.0, 10.0, 0.0), dvec3(7.0, 2.0, 2.0)];
    let off = |corner: DVec3| found.world_from_model.apply(right.inverse().apply(corner)).distance(corner);
    corners.into_iter().map(off).fold(0.0, f64::max)
}

#[test]
fn a_model_that_was_turned_scaled_and_shifted_is_found_on_any_number_of_threads() {
    let yard = yard();
    for seed in [1, 2] {
        let right = turned(seed);
        let (answer, found) = searched(&yard, &in_file(&yard, &right));
        assert_eq!(answer, AlignmentAnswer::Aligned, "{found:?}");
        // Ten metres away, two pixels are 5 cm, and the noise is 1 cm.
        assert!(off(&found[0], &right) < 0.05, "seed {seed}: {}", off(&found[0], &right));
        if seed == 1 {
            let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
            let again = one.install(|| searched(&yard, &in_file(&yard, &right)));
            assert_eq!(again, (answer, found), "the same on one thread");
        }
    }
}

#[test]
fn a_model_in_far_coordinates_and_points_without_observations_are_no_obstacle() {
    let mut yard = yard();
    let right = Similarity { translation: dvec3(-500_000.0, -5_400_000.0, -80.0), ..turned(3) };
    yard.points.iter_mut().for_each(|point| point.observations.clear());
    let (answer, found) = searched(&yard, &in_file(&yard, &right));
    assert_ne!(answer, AlignmentAnswer::Foreign);
    // The nearest camera that has a point in its picture may look at it through a wall.
    let best = found.iter().take(3).map(|found| off(found, &right)).fold(f64::INFINITY, f64::min);
    assert!(best < 0.1, "{best}");
}

#[test]
fn a_square_court_has_several_candidates_and_one_of_them_is_right() {
    let square = square();
    let right = turned(4);
    let (answer, found) = searched(&square, &in_file(&square, &right));
    assert_eq!(answer, AlignmentAnswer::Several, "{found:?}");
    assert!(found.len() >= 2 && found[1].score > 0.8 * found[0].score, "{found:?}");
}

#[test]
fn a_model_of_another_site_is_never_called_aligned() {
    let (yard, square) = (yard(), square());
    let (answer, found) = searched(&square, &in_file(&yard, &turned(5)));
    assert_ne!(answer, AlignmentAnswer::Aligned, "{found:?}");
}

#[test]
fn parallel_faces_alone_are_not_called_aligned() {
    let yard = yard();
    let mut m = Modeller::new();
    for z in [0.0, 1.0, 2.0] {
        m.object(format!("{z}")).quad(DVec3::Z * z, DVec3::X * 8.0, DVec3::Y * 6.0);
    }
    let (answer, found) = searched(&yard, &m.finish());
    assert_ne!(answer, AlignmentAnswer::Aligned, "{found:?}");
}

#[test]
fn nothing_is_searched_without_faces_points_or_planes() {
    let yard = yard();
    let why = |model: &Model, cameras: &[(Pinhole, Pose)], points: &[SparsePoint]| {
        Aligner::new(model, cameras, points).err()
    };
    let mut m = Modeller::new();
    m.object("Sky").quad(DVec3::ZERO, DVec3::X, DVec3::Y);
    assert_eq!(why(&m.finish(), &yard.cameras, &yard.points), Some(Unsearchable::NoFaces));
    assert_eq!(why(&Model::default(), &yard.cameras, &yard.points), Some(Unsearchable::NoFaces));
    assert_eq!(why(&yard.model, &yard.cameras, &yard.points[..5]), Some(Unsearchable::FewPoints));
    assert_eq!(why(&yard.model, &yard.cameras, &[]), Some(Unsearchable::FewPoints));
    assert_eq!(why(&yard.model, &[], &yard.points), Some(Unsearchable::FewPoints));
    let mut rng = Rng::new(9);
    let mut anywhere = yard.points[..100].to_vec();
    for point in &mut anywhere {
        point.position = dvec3(rng.between(-9.0, 9.0), rng.between(-9.0, 9.0), rng.between(-9.0, 9.0));
    }
    assert_eq!(why(&yard.model, &yard.cameras, &anywhere), Some(Unsearchable::NoPlanes));
}

#[test]
fn a_search_stops_when_it_is_asked_to() {
    let yard = yard();
    let task = Task::silent();
    task.stop_flag().store(true, std::sync::atomic::Ordering::Relaxed);
    let aligner = Aligner::new(&yard.model, &yard.cameras, &yard.points).ok().unwrap();
    assert!(matches!(aligner.search(&task), Err(quadratura_base::Error::Cancelled)));
}

/// Corners of the yard and the pixels that show them, in two photos, off by up to two pixels.
fn pairs(yard: &Invented, right: &Similarity, count: usize) -> Vec<CornerPair> {
    let corners = [
        dvec3(-8.0, 10.0, 5.0),
        dvec3(12.0, 10.0, 0.0),
        dvec3(-8.0, 10.0, 0.0),
        dvec3(12.0, 10.0, 3.0),
        dvec3(4.6, 9.6, 2.8),
        dvec3(-2.6, 9.6, 1.2),
        dvec3(0.9, 9.6, 2.8),
    ];
    let mut rng = Rng::new(12);
    let mut pair = |(i, corner): (usize, &DVec3)| {
        let photo = i % 2;
        let (camera, pose) = &yard.cameras[photo];
        let px = camera.image_from_camera(pose.camera_from_world(*corner)).unwrap();
        let noise = DVec2::new(rng.between(-2.0, 2.0), rng.between(-2.0, 2.0));
        CornerPair { corner: right.inverse().apply(*corner), photo, px: px + noise }
    };
    corners.iter().take(count).enumerate().map(&mut pair).collect()
}

#[test]
fn five_pairs_in_two_photos_align_the_model_and_a_wrong_one_of_seven_is_told() {
    let (yard, right) = (yard(), turned(6));
    let fit = from_pairs(&pairs(&yard, &right, 5), &yard.cameras, &yard.points).unwrap();
    let candidate = AlignmentCandidate { world_from_model: fit.world_from_model, score: 0.0 };
    // Fifteen metres away, ten pixels are 38 cm.
    assert!(off(&candidate, &right) < 0.4, "{}", off(&candidate, &right));
    assert!(fit.residuals_px.iter().all(|px| *px < 4.0), "{fit:?}");
    let mut wrong = pairs(&yard, &right, 7);
    assert_eq!(from_pairs(&wrong, &yard.cameras, &yard.points).unwrap().doubtful, None);
    wrong[3].px += DVec2::new(90.0, -40.0);
    assert_eq!(from_pairs(&wrong, &yard.cameras, &yard.points).unwrap().doubtful, Some(3));
}

#[test]
fn pairs_without_points_are_enough_and_pairs_of_one_photo_are_not() {
    let (yard, right) = (yard(), turned(7));
    let fit = from_pairs(&pairs(&yard, &right, 6), &yard.cameras, &[]).unwrap();
    let candidate = AlignmentCandidate { world_from_model: fit.world_from_model, score: 0.0 };
    assert!(off(&candidate, &right) < 0.4, "{}", off(&candidate, &right));
    let refused = |pairs: &[CornerPair]| from_pairs(pairs, &yard.cameras, &yard.points).unwrap_err();
    let mut one_photo = pairs(&yard, &right, 6);
    one_photo.retain(|pair| pair.photo == 0);
    assert_eq!(refused(&one_photo), Unpaired::OnePlace);
    assert_eq!(refused(&one_photo[..2]), Unpaired::TooFew);
    let mut same = pairs(&yard, &right, 6);
    let corner = same[0].corner;
    same.iter_mut().for_each(|pair| pair.corner = corner);
    assert_eq!(refused(&same), Unpaired::NoFit);
}
