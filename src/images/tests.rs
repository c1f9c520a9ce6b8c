//! Tests on the tiny site: a box in front of a wall.

use super::*;
use quadratura_base::scene::PhotoId;
use quadratura_base::task::Task;
use quadratura_editing::peel::photo_picture;
use quadratura_layers::ProjectedModel;
use quadratura_ldi::warp;
use quadratura_ldi::{Ldi, SplatKind, WarpOptions};
use quadratura_sites::open::Opened;
use quadratura_stacks::tiny_site::tiny_stacks;
use quadratura_view::Shot;

fn first_photo() -> PhotoId {
    PhotoId::new(0)
}

fn flat() -> StackLdiOptions {
    StackLdiOptions { relief: false, ..StackLdiOptions::default() }
}

/// Returns the layered depth image of the first photo of the tiny site.
fn made(options: &StackLdiOptions) -> (tempfile::TempDir, Opened, Ldi) {
    let folder = tempfile::tempdir().unwrap();
    let (project, opened) = tiny_stacks(folder.path()).unwrap();
    let mut site = LdiSite::open(&project, &opened.project, &opened.site).unwrap();
    let ldi = site.ldi_of_stack(first_photo(), options, &Task::silent()).unwrap();
    drop(site);
    (folder, opened, ldi)
}

#[test]
fn the_first_layer_is_the_photo_bit_for_bit() {
    for options in [flat(), StackLdiOptions::default()] {
        let (_folder, opened, ldi) = made(&options);
        let photo = photo_picture(opened.site.photo(first_photo())).unwrap();
        let level = &ldi.levels[0];
        for ((x, y), pixel) in photo.rect().pixels().zip(photo.pixels()) {
            let first = level.at(x as u32, y as u32).next().expect("the wall covers all of the photo");
            assert_eq!(level.colours[first], *pixel, "{x}, {y}");
        }
    }
}

#[test]
fn layers_are_strictly_nearer_to_farther_and_the_box_hides_the_wall() {
    let (_folder, _, ldi) = made(&StackLdiOptions { filled: false, ..flat() });
    assert!(ldi.report.empty_needed > 100, "{:?}", ldi.report);
    let (_folder, _, ldi) = made(&flat());
    for y in 0..ldi.camera.height {
        for pixel in ldi.levels[0].layered_pixels(y) {
            assert!(ldi.levels[0].inverse_depths[pixel].is_sorted_by(|a, b| a > b));
        }
    }
}

#[test]
fn inverse_depths_have_the_bits_of_the_sort() {
    let (_folder, opened, ldi) = made(&flat());
    let (photo, model) = (opened.site.photo(first_photo()), &opened.site.model);
    let view = ProjectedModel::new(model, &photo.camera, &photo.pose);
    let level = &ldi.levels[0];
    assert!(level.len() >= 64 * 48);
    for y in 0..ldi.camera.height {
        for index in level.row(y) {
            let surface = &ldi.surfaces[usize::from(level.surfaces[index]) - 1];
            let Some(face) = surface.face else { continue };
            let id = model.face_named(&surface.object, face).unwrap();
            let item = view.items.iter().find(|item| item.face == id).unwrap();
            let x = u32::from(level.columns[index]);
            let expected = item.inverse_depth.at(x, y);
            assert_eq!(level.inverse_depths[index].to_bits(), expected.to_bits());
            let on_plane = surface.nu.dot(glam::DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0));
            // The plane's coefficients are rounded to f32.
            assert!((on_plane / f64::from(expected) - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn its_own_camera_sees_the_photo() {
    let (_folder, opened, ldi) = made(&StackLdiOptions::default());
    let photo = photo_picture(opened.site.photo(first_photo())).unwrap();
    let shot = Shot::new(ldi.camera, ldi.pose);
    let options = WarpOptions { splat: SplatKind::Pixel, level: Some(0), ..WarpOptions::default() };
    let warped = warp(&ldi, &shot, &options, &Task::silent()).unwrap();
    assert!(warped.picture == photo);
}

#[test]
fn any_number_of_threads_makes_the_same() {
    let of_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| made(&StackLdiOptions::default()).2)
    };
    assert!(of_threads(1) == of_threads(3));
}

#[test]
fn it_is_out_of_date_when_options_or_the_stack_are_others() {
    let folder = tempfile::tempdir().unwrap();
    let (project, opened) = tiny_stacks(folder.path()).unwrap();
    let site = LdiSite::open(&project, &opened.project, &opened.site).unwrap();
    let inputs = |options: &StackLdiOptions| site.inputs(first_photo(), options).unwrap();
    assert_eq!(inputs(&flat()), inputs(&flat()));
    assert_ne!(inputs(&flat()), inputs(&StackLdiOptions::default()));
    assert_ne!(inputs(&flat()), site.inputs(PhotoId::new(1), &flat()).unwrap());
}
