//! Scores of synthetic photos, predicted by a test renderer.

use std::path::Path;
use std::sync::Arc;

use super::*;
use quadratura_base::scene::PhotoId;
use quadratura_base::scene::synthetic::closed_form::two_quads;
use quadratura_base::scene::{Photo, Site};
use quadratura_view::{Picture, Shot};

/// A renderer that draws every shot in one grey level except the top row; the left half shows the first face, the
/// right half no face.
struct Flat {
    shade: u8,
    shots: Vec<Shot>,
}

impl Renders for Flat {
    fn picture(&mut self, shot: &Shot, _: &Task) -> Result<Picture> {
        self.shots.push(shot.clone());
        let (width, height) = (shot.camera.width, shot.camera.height);
        let mut rgba = vec![self.shade; (width * height * 4) as usize];
        for (i, pixel) in rgba.chunks_exact_mut(4).enumerate() {
            pixel[3] = if i < width as usize { 0 } else { 255 };
        }
        Ok(Picture { width, height, rgba })
    }

    fn faces(&mut self, shot: &Shot, _: &Task) -> Result<Vec<u32>> {
        let (width, height) = (shot.camera.width, shot.camera.height);
        Ok((0..width * height).map(|i| u32::from(i % width < width / 2)).collect())
    }
}

/// Makes two photos of 20 x 10 with grey level 100; the second one's file is missing.
fn site(folder: &Path) -> Site {
    let scene = two_quads().resized(20);
    let (width, height) = (scene.camera.width, scene.camera.height);
    image::RgbImage::from_pixel(width, height, image::Rgb([100; 3])).save(folder.join("a.png")).unwrap();
    let photo = |name: &str| Photo {
        name: name.into(),
        camera: scene.camera,
        pose: scene.pose,
        file: folder.join(name),
        masks: Vec::new(),
        exposure: None,
    };
    Site { photos: vec![photo("a.png"), photo("b.png")], model: Arc::clone(&scene.model) }
}

fn options() -> ScoreOptions {
    ScoreOptions {
        look: Appearance::default(),
        size: Size::Own,
        only: Vec::new(),
        trees: Vec::new(),
        ignored: Vec::new(),
        ignore_background: false,
        pictures: None,
    }
}

fn scored(site: &Site, options: &ScoreOptions) -> (ScoreReport, Flat) {
    let mut flat = Flat { shade: 110, shots: Vec::new() };
    let report = score(&site.model, &leave_one_out(site), &mut flat, options, &Task::silent()).unwrap();
    (report, flat)
}

/// Returns the PSNR of a constant error in dB.
fn db(error: f64) -> f64 {
    20.0 * (255.0 / error).log10()
}

#[test]
fn covered_pixels_and_holes_are_counted_apart() {
    let folder = tempfile::tempdir().unwrap();
    let site = site(folder.path());
    let (report, flat) = scored(&site, &options());
    assert_eq!(report.failed.len(), 1, "the photo that is missing");
    let view = &report.views[0];
    let rows = f64::from(view.height);
    assert!((view.coverage - (rows - 1.0) / rows).abs() < 1e-12);
    let covered = view.covered.unwrap();
    assert!((covered.psnr - db(10.0)).abs() < 1e-9, "{covered:?}");
    assert_eq!(covered.psnr_fitted, quadratura_view::metrics::HIGHEST_DB, "an offset of ten");
    let mean_squared = (10.0 * 10.0 * (rows - 1.0) + 100.0 * 100.0) / rows;
    assert!((view.with_holes.psnr - db(mean_squared.sqrt())).abs() < 1e-9, "{view:?}");
    assert_eq!(report.mean.unwrap().with_holes.psnr, view.with_holes.psnr);
    assert_eq!(flat.shots[0].without, [PhotoId(0)], "a photo does not predict itself");
}

#[test]
fn a_fit_that_explains_much_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let site = site(folder.path());
    let (report, _) = scored(&site, &options());
    let mut mean = report.mean.unwrap();
    let covered = mean.covered.unwrap();
    assert_eq!(mean.unexplained_light(), Some(covered.psnr_fitted - covered.psnr), "an offset of ten");
    mean.covered = Some(MeanMetrics { psnr_fitted: covered.psnr + 0.9, ..covered });
    assert_eq!(mean.unexplained_light(), None);
    mean.covered = None;
    assert_eq!(mean.unexplained_light(), None);
}

#[test]
fn errors_are_told_by_object_and_the_background_has_no_name() {
    let folder = tempfile::tempdir().unwrap();
    let site = site(folder.path());
    let (report, _) = scored(&site, &options());
    let pixels = u64::from(report.views[0].width) * u64::from(report.views[0].height);
    assert_eq!(report.objects.len(), 2);
    for object in &report.objects {
        assert_eq!(object.pixels + object.holes, pixels / 2);
        assert!((object.error_share - 0.5).abs() < 1e-12 && (object.psnr.unwrap() - db(10.0)).abs() < 1e-9);
    }
    let first = &site.model.objects[site.model.faces[0].object.0 as usize].name;
    assert!(report.objects.iter().any(|object| object.object.as_ref() == Some(first)));
    assert!(report.objects.iter().any(|object| object.object.is_none()));
}

#[test]
fn ignored_objects_and_the_background_are_left_out_of_every_count() {
    let folder = tempfile::tempdir().unwrap();
    let site = site(folder.path());
    let first = site.model.objects[site.model.faces[0].object.0 as usize].name.clone();
    let (report, _) = scored(&site, &ScoreOptions { ignored: vec![first], ..options() });
    let pixels = u64::from(report.views[0].width) * u64::from(report.views[0].height);
    assert_eq!(report.views[0].with_holes.pixels, pixels / 2);
    assert_eq!(report.objects.len(), 1);
    let all = ScoreOptions { ignored: vec!["*".into()], ignore_background: true, ..options() };
    let (report, _) = scored(&site, &all);
    assert!(report.views.is_empty() && report.mean.is_none());
    let unknown = ScoreOptions { ignored: vec!["sky".into()], ..options() };
    let mut flat = Flat { shade: 0, shots: Vec::new() };
    let message = score(&site.model, &[], &mut flat, &unknown, &Task::silent()).unwrap_err();
    assert!(message.to_string().contains("\"sky\""), "{message}");
}

#[test]
fn only_the_objects_that_are_asked_for_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let site = site(folder.path());
    let [first, other] = [0, 1].map(|object: usize| site.model.objects[object].name.clone());
    let only = |patterns: &[&str], ignored: &[&str]| {
        let [only, ignored] =
            [patterns, ignored].map(|list| list.iter().map(|name| (*name).into()).collect());
        ScoreOptions { only, ignored, ..options() }
    };
    // Any beginning of the first name that the other one does not have.
    let (report, _) = scored(&site, &only(&[&format!("*{}", &first[1..])], &[]));
    let half = u64::from(report.views[0].width) * u64::from(report.views[0].height) / 2;
    assert_eq!(report.views[0].with_holes.pixels, half, "the background is not asked for");
    assert_eq!((report.objects.len(), report.objects[0].object.as_ref()), (1, Some(&first)));
    let failed = |options: &ScoreOptions| {
        let mut flat = Flat { shade: 0, shots: Vec::new() };
        let photo = &leave_one_out(&site)[..1];
        score(&site.model, photo, &mut flat, options, &Task::silent()).unwrap_err().to_string()
    };
    let hidden = failed(&only(&[&other], &[]));
    assert!(hidden.contains("no photo shows") && hidden.contains(&other), "{hidden}");
    let unknown = failed(&only(&["sky"], &["fog"]));
    assert!(unknown.contains("\"sky\"") && unknown.contains("\"fog\""), "{unknown}");
    let taken_away = failed(&only(&["*"], &["*"]));
    assert!(taken_away.contains("no photo shows"), "{taken_away}");
}

#[test]
fn pictures_show_photo_prediction_and_difference_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    let site = site(folder.path());
    let pictures = folder.path().join("differences");
    let (report, _) = scored(&site, &ScoreOptions { pictures: Some(pictures.clone()), ..options() });
    assert_eq!(report.views[0].picture, Some(pictures.join("a.png")));
    let picture = image::open(pictures.join("a.png")).unwrap().to_rgb8();
    let (width, height) = (report.views[0].width, report.views[0].height);
    assert_eq!(picture.dimensions(), (3 * width + 16, height));
    let at = |panel: u32, y: u32| picture.get_pixel(panel * (width + 8) + 3, y).0;
    assert_eq!((at(0, 5), at(1, 5), at(2, 5)), ([100; 3], [110; 3], [40; 3]));
    assert_eq!((at(1, 0), at(2, 0)), ([0; 3], [0, 40, 140]), "a hole");
}

#[test]
fn photos_are_compared_at_the_size_that_was_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let site = site(folder.path());
    let (report, flat) = scored(&site, &ScoreOptions { size: Size::Scaled(0.5), ..options() });
    assert_eq!((report.views[0].width, flat.shots[0].camera.width), (10, 10));
}

#[test]
fn held_out_photos_are_imported_with_their_own_cameras() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("cameras.txt", "1 SIMPLE_RADIAL 20 10 15 10 5 -0.1\n");
    write("images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n2 1 0 0 0 0 0 0 1 gone.png\n\n");
    image::RgbImage::new(20, 10).save(folder.path().join("a.png")).unwrap();
    let cache = folder.path().join("cache");
    let (targets, problems) = held_out(folder.path(), folder.path(), &cache, &Task::silent()).unwrap();
    assert_eq!((targets.len(), problems.len()), (1, 1));
    assert!(targets[0].without.is_empty());
    assert!(targets[0].photo.file.starts_with(&cache) && targets[0].photo.file.exists());
}
