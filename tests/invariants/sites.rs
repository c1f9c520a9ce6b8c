//! Whole sites: the castle, a real one of 19 photos and 600 faces with everything that real models
//! have, and the sample project.

use std::path::Path;
use std::sync::Arc;

use quadratura::task::Task;
use quadratura::testing::import::cameras::read_cameras;
use quadratura::testing::import::models::read_model;
use quadratura::testing::layers::{Rasteriser, SoftwareRasteriser};
use quadratura::testing::scene::synthetic::{Scene, Truth};
use rayon::prelude::*;

use crate::common;
use crate::oracle::Oracle;
use crate::peeling::check_against_exact_peeling;
use crate::sorted::Case;

/// Columns: an eighth of the photos' own, which takes seconds. `SITE_WIDTH=3072` asks for all of
/// the castle's, which takes minutes.
fn width() -> u32 {
    let asked = std::env::var("SITE_WIDTH").map(|w| w.parse().expect("SITE_WIDTH is a number of columns"));
    asked.unwrap_or(384)
}

/// The castle's photos without their pixels.
fn castle() -> Option<Vec<Scene>> {
    Some(photos(&common::castle()?, "castle.obj"))
}

/// The photos of a site without their pixels.
fn photos(folder: &Path, model: &str) -> Vec<Scene> {
    let task = Task::silent();
    let (model, _) = read_model(&folder.join(model), &task).expect("the model is well-formed");
    let model = Arc::new(model);
    let cameras = read_cameras(&folder.join("sparse"), &task).expect("so are its cameras");
    let scene = |photo: quadratura::testing::import::cameras::CameraPhoto| {
        let (name, model, truth) = (photo.name, model.clone(), Truth::Unknown);
        Scene { name, model, camera: photo.camera, pose: photo.pose, truth }.resized(width())
    };
    cameras.photos.into_iter().map(scene).collect()
}

fn check(scene: &Scene, rasteriser: &dyn Rasteriser) {
    let case = Case::new(scene, rasteriser);
    assert!(case.sorted.layers.count() >= 4, "{}: {} layers", case.name, case.sorted.layers.count());
    Oracle::new(&case).check();
    crate::image_layers::check(&case);
    check_against_exact_peeling(&case, rasteriser);
}

#[test]
fn every_photo_of_the_castle_holds_the_invariants() {
    let Some(photos) = castle() else { return };
    assert_eq!(photos.len(), 19);
    photos.par_iter().for_each(|scene| check(scene, &SoftwareRasteriser));
}

#[test]
fn it_holds_them_on_the_gpu_as_well() {
    let (Some(photos), Some(rasteriser)) = (castle(), common::gpu_rasteriser()) else { return };
    photos.par_iter().step_by(6).for_each(|scene| check(scene, &rasteriser));
}

#[test]
fn every_photo_of_the_sample_project_holds_them() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("projects/piazza");
    let photos = photos(&folder, "piazza.obj");
    assert_eq!(photos.len(), 9);
    photos.par_iter().for_each(|scene| check(scene, &SoftwareRasteriser));
}
