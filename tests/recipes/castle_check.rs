//! The castle is judged: it fits, and turned, scaled and shifted in any way it is found again.

use crate::common;
use quadratura::task::Task;
use quadratura::testing::geometry::{Similarity, axes};
use quadratura::testing::import::cameras::read_cameras;
use quadratura::testing::import::models::read_model;
use quadratura::testing::layers::SoftwareRasteriser;
use quadratura::testing::scene::{Photo, Site, SparsePoint};
use quadratura::testing::sites::check::alignment::best_alignments;
use quadratura::testing::sites::check::{CheckOptions, SearchOutcome, Verdict, check_site};

fn castle() -> Option<(Site, Vec<SparsePoint>)> {
    let folder = common::castle()?;
    let cameras = read_cameras(&folder.join("sparse"), &Task::silent()).unwrap();
    let (model, _) = read_model(&folder.join("castle.obj"), &Task::silent()).unwrap();
    let photo = |p: quadratura::testing::import::cameras::CameraPhoto| Photo {
        file: folder.join("images").join(&p.name),
        name: p.name,
        camera: p.camera,
        pose: p.pose,
        masks: Vec::new(),
        exposure: None,
    };
    let photos = cameras.photos.into_iter().map(photo).collect();
    Some((Site { photos, model: model.into() }, cameras.points))
}

#[test]
fn the_castle_fits() {
    let Some((mut site, points)) = castle() else { return };
    // Fewer pixels are enough to see whether it fits.
    for photo in &mut site.photos {
        let c = &mut photo.camera;
        (c.width, c.height) = (c.width / 8, c.height / 8);
        (c.fx, c.fy, c.cx, c.cy) = (c.fx / 8.0, c.fy / 8.0, c.cx / 8.0, c.cy / 8.0);
    }
    let report =
        check_site(&site, &points, &CheckOptions::default(), &SoftwareRasteriser, &Task::silent()).unwrap();
    assert_eq!((report.verdict, report.suggestion), (Verdict::Fits, None));
    assert!(report.agreement.unwrap() > 0.85, "{:?}", report.agreement);
    assert!(report.photos.iter().all(|photo| photo.covered > 0.9), "the sky is modelled, too");
    assert_eq!((report.faces.degenerate.count, report.faces.not_planar.count), (0, 0));
}

#[test]
fn a_castle_in_other_axes_units_and_places_is_found_again() {
    let Some((site, points)) = castle() else { return };
    // In the court, where most points are.
    let middle = glam::DVec3::new(15.0, 0.0, 5.0);
    let turned = glam::DMat3::from_axis_angle(glam::DVec3::new(0.6, 0.0, 0.8), 13f64.to_radians());
    let convention = |name: &str| axes::named(name).unwrap();
    let cases = [(convention("x,-z,y"), 0.01), (convention("y,z,x"), 39.0), (turned, 1.0), (turned, 1e-3)];
    for (i, (rotation, scale)) in cases.into_iter().enumerate() {
        let translation = glam::DVec3::new(-30.0, 1e5, 700.0) * (i % 3) as f64;
        let right = Similarity { scale, rotation, translation };
        let moved = site.model.transformed(&right.inverse());
        let site = Site { photos: site.photos.clone(), model: moved.into() };
        let (outcome, found) = best_alignments(&site, &points, &Task::silent()).unwrap();
        assert_eq!((outcome, found.len()), (SearchOutcome::Found, 1), "case {i}");
        let off = found[0].compose(&right.inverse());
        // Points stand a little before coarse walls: at most a decimetre at thirty metres.
        assert!(
            (off.scale - 1.0).abs() < 0.005 && off.apply(middle).distance(middle) < 0.1,
            "case {i}: {off:?}"
        );
        if i < 2 {
            assert_eq!(off.rotation, glam::DMat3::IDENTITY, "case {i}: a convention is exact");
        }
    }
}
