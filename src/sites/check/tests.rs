//! Reports on a small site that is correct, and on the same site with errors.

use std::sync::Arc;

use glam::{DVec2, DVec3, dvec3};

use super::*;
use quadratura_base::scene::synthetic::{Modeller, Rng, centred, look_at};
use quadratura_layers::SoftwareRasteriser;

/// Makes a yard without any symmetry: ground, two walls of different height, a tower and a shed, with one side of a
/// wall that no photo sees.
fn yard() -> Arc<Model> {
    let mut m = Modeller::new();
    m.object("ground").quad(dvec3(-8.0, -6.0, 0.0), DVec3::X * 20.0, DVec3::Y * 16.0);
    m.object("north").quad_facing(DVec3::NEG_Y, dvec3(-8.0, 10.0, 0.0), DVec3::X * 20.0, DVec3::Z * 5.0);
    m.object("east").quad_facing(DVec3::NEG_X, dvec3(12.0, -6.0, 0.0), DVec3::Y * 16.0, DVec3::Z * 3.0);
    m.object("tower").cuboid(dvec3(-5.0, 7.0, 4.5), dvec3(1.5, 1.2, 4.5), glam::DMat3::from_rotation_z(0.3));
    m.object("shed").cuboid(dvec3(7.0, 2.0, 1.0), dvec3(2.0, 1.0, 1.0), glam::DMat3::from_rotation_z(-0.5));
    m.finish()
}

fn photos() -> Vec<Photo> {
    let eyes = [dvec3(-6.0, -5.0, 2.0), dvec3(2.0, -5.0, 1.7), dvec3(6.0, -4.0, 6.0), dvec3(-7.0, 1.0, 3.0)];
    let photo = |(i, eye): (usize, DVec3)| Photo {
        name: format!("{i}.png"),
        camera: centred(160, 120, 110.0),
        pose: look_at(eye, dvec3(2.0, 6.0, 1.5)),
        file: PathBuf::from("missing.png"),
        masks: Vec::new(),
        exposure: None,
    };
    eyes.into_iter().enumerate().map(photo).collect()
}

/// Returns points on surfaces that photos see, every tenth of them off the model, as on a tree.
fn points(model: &Model, photos: &[Photo]) -> Vec<SparsePoint> {
    let (tree, mut rng) = (CheckedSurface::from_model(model).tree, Rng::new(7));
    let mut points = Vec::new();
    for (photo, from) in (0..).zip(photos) {
        let eye = from.pose.center_in_world();
        for i in 0..250 {
            let px = DVec2::new(rng.between(0.0, 160.0), rng.between(0.0, 120.0));
            let ray = from.pose.world_from_camera(from.camera.ray_in_camera(px)) - eye;
            let Some((t, _)) = tree.first_hit(eye, ray, f64::INFINITY) else { continue };
            let position = eye + ray * if i % 10 == 0 { t * 0.6 } else { t };
            points.push(SparsePoint { position, observations: vec![(photo, px)] });
        }
    }
    points
}

fn check(model: &Model, points: &[SparsePoint], options: &CheckOptions) -> CheckReport {
    let site = Site { photos: photos(), model: Arc::new(model.clone()) };
    check_site(&site, points, options, &SoftwareRasteriser, &Task::silent()).unwrap()
}

#[test]
fn a_good_site_fits_and_needs_no_suggestion() {
    let model = yard();
    let report = check(&model, &points(&model, &photos()), &CheckOptions::default());
    assert_eq!((report.verdict, &report.suggestion), (Verdict::Fits, &None));
    assert!((0.85..=0.95).contains(&report.agreement.unwrap()), "{:?}", report.agreement);
    assert!(report.photos.iter().all(|p| p.covered > 0.5 && p.inside > 0.1 && p.faces >= 4));
    assert_eq!((report.faces.count, report.faces.flipped.count, report.faces.duplicate.count), (15, 0, 0));
    let unseen = &report.faces.unseen.names;
    assert!(unseen.contains(&"shed[5]".to_owned()), "it stands on its underside: {unseen:?}");
}

#[test]
fn each_of_the_24_conventions_is_found_again() {
    let model = yard();
    let points = points(&model, &photos());
    for (name, rotation) in axes::conventions().into_iter().skip(1) {
        let right = Similarity { rotation, ..Similarity::IDENTITY };
        let report = check(&model.transformed(&right.inverse()), &points, &CheckOptions::default());
        let suggestion = report.suggestion.unwrap_or_else(|| panic!("{name}: {:?}", report.agreement));
        assert_eq!(suggestion.transform, name);
        assert!(suggestion.agreement.unwrap() > 0.85 && report.verdict != Verdict::Fits);
    }
}

#[test]
fn scale_and_shift_are_fitted_on_top_of_the_convention() {
    let model = yard();
    let points = points(&model, &photos());
    for (name, scale, shift) in [
        ("x,-z,y", 0.01, dvec3(0.0, 0.0, 0.0)),
        ("z,x,y", 0.3048, dvec3(3.0, -2.0, 1.0)),
        ("-y,x,z", 2.7, dvec3(-40.0, 12.0, 8.0)),
        ("x,y,z", 1.0, dvec3(500_000.0, 4_000_000.0, 80.0)),
    ] {
        let right = Similarity { scale, rotation: axes::named(name).unwrap(), translation: shift };
        let report = check(&model.transformed(&right.inverse()), &points, &CheckOptions::default());
        let found = Similarity::parse(&report.suggestion.expect(name).transform).unwrap();
        assert!((found.scale / scale - 1.0).abs() < 0.01, "{name}: {found}");
        let off = found.compose(&right.inverse()).apply(dvec3(2.0, 4.0, 1.0)).distance(dvec3(2.0, 4.0, 1.0));
        assert!(off < 0.1, "{name}: {found} is {off} off");
    }
}

#[test]
fn a_suggestion_replaces_the_transform_that_was_given() {
    let model = yard();
    let points = points(&model, &photos());
    // The file has y up, and the user gave the inverse rotation.
    let (right, wrong) = (Similarity::parse("y-up").unwrap(), Similarity::parse("x,z,-y").unwrap());
    let file = model.transformed(&right.inverse());
    let options = CheckOptions { world_from_model: wrong, ..CheckOptions::default() };
    let report = check(&file.transformed(&wrong), &points, &options);
    assert_eq!(report.suggestion.unwrap().transform, "x,-z,y");
}

/// Makes small scattered faces, which have nothing in common with the yard.
fn litter() -> Model {
    let (mut m, mut rng) = (Modeller::new(), Rng::new(11));
    let mut place = |size: f64| DVec3::from_array([(); 3].map(|()| rng.between(-size, size)));
    m.object("litter");
    for _ in 0..300 {
        let (corner, right, up) = (place(10.0), place(0.3), place(0.3));
        m.quad(corner, right, up);
    }
    m.finish().as_ref().clone()
}

#[test]
fn a_model_of_another_site_is_told_to_be_one_and_is_moved_nowhere() {
    let report = check(&litter(), &points(&yard(), &photos()), &CheckOptions::default());
    assert_eq!((report.verdict, &report.suggestion), (Verdict::Misses, &None));
    assert!(
        mistake::advice_without_fix(report.verdict, report.search)
            .starts_with("The cameras and the model are probably not of the same site")
    );
}

#[test]
fn a_model_turned_by_13_degrees_is_found_and_a_mirrored_one_is_told() {
    let model = yard();
    let points = points(&model, &photos());
    let rotation = glam::DMat3::from_axis_angle(dvec3(0.36, 0.48, 0.8), 13f64.to_radians());
    let right = Similarity { scale: 0.02, rotation, translation: dvec3(4.0, 2.0, -7.0) };
    let report = check(&model.transformed(&right.inverse()), &points, &CheckOptions::default());
    let found = Similarity::parse(&report.suggestion.unwrap().transform).unwrap();
    for corner in [dvec3(2.0, 10.0, 1.0), dvec3(12.0, 0.0, 3.0)] {
        let off = found.compose(&right.inverse()).apply(corner).distance(corner);
        assert!(off < 0.05, "{off}: three pixels of these photos");
    }
    let mut mirrored = model.as_ref().clone();
    mirrored.vertices.iter_mut().for_each(|vertex| vertex.x = -vertex.x);
    let report = check(&mirrored.transformed(&right.inverse()), &points, &CheckOptions::default());
    assert_eq!((report.search, &report.suggestion), (Some(SearchOutcome::Mirrored), &None));
    assert!(mistake::advice_without_fix(report.verdict, report.search).contains("left-handed"));
}

#[test]
fn what_cannot_be_searched_is_told() {
    let (model, away) = (yard(), Similarity { translation: dvec3(1e6, 0.0, 0.0), ..Similarity::IDENTITY });
    let all = points(&model, &photos());
    let outcome = |model: &Model, points: &[SparsePoint]| {
        let report = check(&model.transformed(&away), points, &CheckOptions::default());
        assert_eq!(report.suggestion, None);
        report.search
    };
    let mut m = Modeller::new();
    m.object("sky.backdrop").quad(dvec3(-8.0, -6.0, 0.0), DVec3::X * 20.0, DVec3::Y * 16.0);
    assert_eq!(outcome(&m.finish(), &all), Some(SearchOutcome::NoFaces));
    let seen_often: Vec<SparsePoint> = all[..5]
        .iter()
        .map(|point| SparsePoint { observations: point.observations.repeat(20), ..point.clone() })
        .collect();
    assert_eq!(outcome(&model, &seen_often), Some(SearchOutcome::FewPoints));
}

#[test]
fn without_points_the_photos_cover_decides() {
    let model = yard();
    assert_eq!(check(&model, &[], &CheckOptions::default()).verdict, Verdict::Fits);
    // The whole model is behind the cameras.
    let turned =
        model.transformed(&Similarity { rotation: axes::named("-x,-y,z").unwrap(), ..Similarity::IDENTITY });
    let away = Similarity { translation: dvec3(0.0, -20.0, 0.0), ..Similarity::IDENTITY };
    let report = check(&turned.transformed(&away), &[], &CheckOptions::default());
    assert_eq!((report.verdict, report.agreement), (Verdict::Misses, None));
    assert_eq!(report.faces.unseen.count, 0, "says nothing");
    let suggestion = report.suggestion.unwrap();
    assert!(suggestion.covered.unwrap() > 0.1, "{suggestion:?}");
}

#[test]
fn flipped_duplicate_crossing_and_degenerate_faces_are_named() {
    let mut m = Modeller::new();
    m.object("ground").quad(dvec3(-8.0, -6.0, 0.0), DVec3::X * 20.0, DVec3::Y * 16.0);
    m.object("wall").quad_facing(DVec3::Y, dvec3(-8.0, 10.0, 0.0), DVec3::X * 20.0, DVec3::Z * 5.0);
    let sign = [dvec3(0.0, 6.0, 1.0), DVec3::X * 4.0, DVec3::Z * 2.0];
    m.object("sign").quad_facing(DVec3::NEG_Y, sign[0], sign[1], sign[2]);
    m.object("again").quad_facing(DVec3::NEG_Y, sign[0], sign[1], sign[2]);
    m.object("back").quad_facing(DVec3::Y, sign[0], sign[1], sign[2]);
    m.object("post").cuboid(dvec3(6.0, 6.0, 0.5), dvec3(0.5, 0.5, 1.0), glam::DMat3::IDENTITY);
    let model = m.finish();
    let faces = check(&model, &[], &CheckOptions::default()).faces;
    assert_eq!(faces.duplicate.names, ["again[0]"]);
    assert_eq!(faces.flipped.names, ["wall[0]"]);
    let pairs: Vec<_> = faces.crossing.iter().map(|c| c.faces.clone()).collect();
    assert_eq!((faces.crossing_pairs, faces.crossing_gave_up), (0, false), "{pairs:?}");
    assert_eq!(faces.sunk_pairs, 4, "the sides of the post end below the ground, where no photo shows them");
}

#[test]
fn a_face_that_photos_show_on_both_sides_of_another_intersects_it() {
    let mut m = Modeller::new();
    m.object("ground").quad(dvec3(-8.0, -6.0, 0.0), DVec3::X * 20.0, DVec3::Y * 16.0);
    m.object("sign").quad_facing(DVec3::NEG_Y, dvec3(0.0, 6.0, 1.0), DVec3::X * 4.0, DVec3::Z * 2.0);
    // It is higher than the sign, so that its end behind the sign is seen, too.
    m.object("fin").quad_facing(DVec3::X, dvec3(2.0, 5.0, 2.0), DVec3::Y * 2.0, DVec3::Z * 2.0);
    let faces = check(&m.finish(), &[], &CheckOptions::default()).faces;
    assert_eq!((faces.crossing_pairs, faces.sunk_pairs), (1, 0));
    assert_eq!(faces.crossing[0].faces, ["sign[0]", "fin[0]"]);
    assert!(faces.crossing[0].depth > 0.5, "{:?}", faces.crossing);
}

#[test]
fn a_face_is_from_behind_where_more_pixels_show_its_back_in_however_many_photos() {
    let model = yard();
    let face = model.face_ids().next().unwrap();
    let photo = |back: bool, px: u32| VisibleModel {
        in_front: 1.0,
        inside: 1.0,
        covered: 1.0,
        faces: vec![seen::VisibleFace { face, back, px }],
    };
    let is_flipped = |seen: &[VisibleModel]| FaceVisibility::new(&model, seen).is_flipped(face);
    assert!(!is_flipped(&[photo(false, 5000), photo(true, 90), photo(true, 300), photo(true, 100)]));
    assert!(is_flipped(&[photo(false, 90), photo(false, 100), photo(true, 5000)]));
    assert!(!is_flipped(&[photo(true, WELL_SEEN_PX - 1)]), "a sliver beyond a ridge");
}

#[test]
fn the_object_that_is_drawn_beside_what_the_photos_show_has_the_largest_distances() {
    let photos = photos();
    let points = points(&yard(), &photos);
    let north = |y: f64| {
        let mut m = Modeller::new();
        m.object("ground").quad(dvec3(-8.0, -6.0, 0.0), DVec3::X * 20.0, DVec3::Y * 16.0);
        m.object("north").quad_facing(DVec3::NEG_Y, dvec3(-8.0, y, 0.0), DVec3::X * 20.0, DVec3::Z * 5.0);
        m.object("east").quad_facing(DVec3::NEG_X, dvec3(12.0, -6.0, 0.0), DVec3::Y * 16.0, DVec3::Z * 3.0);
        m.finish()
    };
    let distances = |y: f64| check(&north(y), &points, &CheckOptions::default()).distances;
    let moved = distances(10.3);
    assert_eq!(moved[0].object, "north", "{moved:?}");
    assert!((moved[0].median - 0.3).abs() < 0.01 && moved[0].most <= moved[0].largest, "{moved:?}");
    let right = distances(10.0);
    let north = right.iter().find(|of| of.object == "north").unwrap();
    assert!(north.median < 1e-6 && north.points > 50, "{right:?}");
}

#[test]
fn a_photo_that_cannot_be_read_is_told_and_stops_nothing() {
    let folder = tempfile_folder();
    let options = CheckOptions { pictures: Some(folder.clone()), ..CheckOptions::default() };
    let report = check(&yard(), &[], &options);
    assert!(
        report
            .photos
            .iter()
            .all(|p| p.picture.is_none() && p.problem.as_ref().unwrap().contains("missing.png"))
    );
    std::fs::remove_dir(folder).unwrap();
}

fn tempfile_folder() -> PathBuf {
    std::env::temp_dir().join(format!("quadratura-check-{}", std::process::id()))
}
