//! Peeled views of synthetic scenes, whose photos are noise, so that no pixel is right by chance.

use std::path::Path;

use super::*;
use quadratura_base::scene::Site;
use quadratura_base::scene::synthetic::{Rng, Scene, closed_form, random};
use quadratura_document::Decisions;
use quadratura_layers::{Options, SoftwareRasteriser};
use quadratura_stacks::build::{BuildOptions, build};

struct Built {
    photo: Picture,
    stack: Stack,
    layers: PhotoLayers,
    _folder: tempfile::TempDir,
}

fn built(scene: Scene) -> Built {
    let folder = tempfile::tempdir().unwrap();
    let photo = photo_of_noise(&scene, folder.path());
    let site = Site { photos: vec![photo.clone()], model: scene.model };
    let store = StackStore::new(folder.path());
    let options = BuildOptions {
        layers: Options::default(),
        decisions: Decisions::default(),
        photos: Vec::new(),
        memory: 1 << 30,
        threads: 1,
        force: false,
    };
    build(&site, &store, &SoftwareRasteriser, &options, &Task::silent()).unwrap();
    let stack = store.current(&photo.name).unwrap().unwrap();
    let layers = PhotoLayers::read(folder.path(), &stack, &Task::silent()).unwrap();
    Built { photo: photo_picture(&photo).unwrap(), stack, layers, _folder: folder }
}

fn photo_of_noise(scene: &Scene, folder: &Path) -> Photo {
    let mut rng = Rng::new(7);
    let (width, height) = (scene.camera.width, scene.camera.height);
    let file = folder.join("noise.png");
    image::RgbImage::from_fn(width, height, |_, _| image::Rgb([0; 3].map(|_: u8| rng.whole(60, 255) as u8)))
        .save(&file)
        .unwrap();
    Photo { file, ..scene.photo() }
}

fn bare() -> PeelOptions {
    PeelOptions { hidden_layers: 0, filling: true, paint: true, opacities: Opacities::default() }
}

fn without(built: &Built, hidden_layers: u32) -> PeeledPhoto {
    built.layers.peeled(&built.photo, &PeelOptions { hidden_layers, ..bare() }, &Task::silent()).unwrap()
}

#[test]
fn with_nothing_taken_off_the_layers_give_the_photo_back() {
    let scenes = closed_form::all().into_iter().chain((0..12).map(|seed| random::soup(seed, 40)));
    for scene in scenes {
        let name = scene.name.clone();
        let built = built(scene);
        let peeled = without(&built, 0);
        assert!(peeled.picture == built.photo, "{name}: {} hidden", peeled.hidden.count());
        assert_eq!(peeled.hidden.count(), 0, "{name}");
    }
}

#[test]
fn behind_the_layer_that_is_taken_off_the_next_one_shows_what_it_has() {
    let built = built(closed_form::two_quads());
    assert_eq!(built.layers.depth(), 3, "two walls, and the surroundings behind them");
    let of = |name: &str| built.layers.shapes.iter().find(|shape| shape.object == name).unwrap();
    let (near, far) = (of("near"), of("far"));
    let behind = built.layers.hidden_of(|shape| shape.face.is_none());
    let peeled = without(&built, 1);
    let pixel = |x: i32, y: i32| {
        let at = 4 * (y as usize * built.photo.width as usize + x as usize);
        (&peeled.picture.rgba[at..at + 4], &built.photo.rgba[at..at + 4])
    };
    let mut hidden = 0;
    for y in 0..built.photo.height as i32 {
        for x in 0..built.photo.width as i32 {
            let (now, photo) = pixel(x, y);
            match (near.covers(x, y), far.covers(x, y)) {
                (true, true) => hidden += 1,
                (false, true) => assert_eq!(now, photo, "{x}, {y}: the far wall is seen beside the near one"),
                (true, false) if behind.holds(x, y) => hidden += 1,
                (true, false) => assert_eq!(now, [0; 4], "{x}, {y}: nothing is behind"),
                (false, false) => assert_eq!(now, photo, "{x}, {y}: the surroundings"),
            }
            let expected = near.covers(x, y) && (far.covers(x, y) || behind.holds(x, y));
            assert_eq!(peeled.hidden.holds(x, y), expected, "{x}, {y}");
        }
    }
    assert!(hidden > 100 && peeled.hidden.count() == hidden);
    let of_wall = built.layers.hidden_of(|shape| shape.object == "far").count();
    assert!(of_wall > 100 && of_wall < hidden, "some of the surroundings are hidden, too");
    assert_eq!(without(&built, 3).hidden.count(), 0, "all is gone");
}

#[test]
fn a_layer_whose_eye_is_closed_is_left_out_and_a_faint_one_shows_what_is_behind() {
    let built = built(closed_form::two_quads());
    let of = |name: &str| built.layers.shapes.iter().find(|shape| shape.object == name).unwrap();
    let (near, far) = (of("near"), of("far"));
    let drawn = |opacity: u8| {
        let opacities = [(near.layer, opacity)].into_iter().collect();
        built.layers.peeled(&built.photo, &PeelOptions { opacities, ..bare() }, &Task::silent()).unwrap()
    };
    let (whole, faint, gone) = (drawn(255), drawn(128), drawn(0));
    assert!(whole.picture == built.photo, "an opaque layer is as it was");
    assert!(gone.picture == without(&built, 1).picture, "the near wall is all of the first visibility layer");
    let width = built.photo.width as usize;
    let mut both = 0;
    for (x, y) in (0..built.photo.height as i32).flat_map(|y| (0..width as i32).map(move |x| (x, y))) {
        if near.covers(x, y) && far.covers(x, y) {
            let at = 4 * (y as usize * width + x as usize);
            let [whole, faint, gone] = [&whole, &faint, &gone].map(|it| i32::from(it.picture.rgba[at]));
            assert!((2 * faint - whole - gone).abs() <= 3, "{x}, {y}: {whole} {faint} {gone}");
            both += 1;
        }
    }
    assert!(both > 100);
    let hits = built.layers.at(0, 0, &bare()).len();
    let opacities = [(near.layer, 0), (far.layer, 0)].into_iter().collect();
    assert!(built.layers.at(0, 0, &PeelOptions { opacities, ..bare() }).len() <= hits);
}

#[test]
fn at_a_pixel_surfaces_come_from_front_to_back_without_those_taken_off() {
    let built = built(closed_form::stairs());
    let names = |hits: &[PeelHit]| -> Vec<String> {
        hits.iter().map(|hit| built.layers.shapes[hit.shape].object.clone()).collect()
    };
    let (mut deepest, photo) = (0, &built.stack.photo);
    for y in 0..photo.height as i32 {
        for x in 0..photo.width as i32 {
            let hits = built.layers.at(x, y, &bare());
            assert_eq!(names(&hits).last().map(String::as_str), Some("[surroundings]"), "{x}, {y}");
            assert!(hits.windows(2).all(|pair| pair[0].distance < pair[1].distance), "{x}, {y}");
            assert!(hits.iter().enumerate().all(|(index, hit)| hit.visible == (index == 0)), "{x}, {y}");
            deepest = deepest.max(hits.len());
            let left = built.layers.at(x, y, &PeelOptions { hidden_layers: 2, ..bare() });
            assert!(left.iter().all(|hit| built.layers.shapes[hit.shape].depth >= 2), "{x}, {y}");
            assert!(names(&hits).ends_with(&names(&left)), "{x}, {y}");
        }
    }
    assert_eq!(deepest, 3, "each step overlaps its neighbours only, and the surroundings are behind all");
}

/// Returns the number of edges that an object's shapes have, and how many of them are inner.
fn edges(built: &Built, object: &str) -> Vec<(usize, usize)> {
    let shapes = built.layers.shapes.iter().filter(|shape| shape.object == object);
    let inner = |shape: &PeelShape| shape.edges.iter().filter(|edge| edge.inner).count();
    shapes.map(|shape| (shape.edges.len(), inner(shape))).collect()
}

#[test]
fn outlines_leave_out_bridges_and_know_where_their_element_goes_on() {
    let holed = built(closed_form::concave_and_holed());
    assert_eq!(edges(&holed, "frame"), [(8, 0)], "four around, four around the hole");
    assert_eq!(edges(&holed, "ell"), [(6, 0)]);
    assert_eq!(edges(&built(closed_form::bent_quad()), "bent"), [(3, 1), (3, 1)], "two triangles");
    assert_eq!(edges(&built(closed_form::two_sided_walls()), "wall").first(), Some(&(4, 0)), "both sides");
    let photo = (f64::from(holed.photo.width), f64::from(holed.photo.height));
    for end in holed.layers.shapes.iter().flat_map(|shape| &shape.edges).flat_map(|edge| edge.ends) {
        let within = |at: f64, size: f64| (-1e-9..=size + 1e-9).contains(&at);
        assert!(within(end.x, photo.0) && within(end.y, photo.1), "{end}");
    }
}

#[test]
fn soft_paint_mixes_with_what_is_below_and_stays_soft_on_nothing() {
    let mut pixel = [200, 100, 0, 255];
    lay_over([0, 100, 200, 51], &mut pixel);
    assert_eq!(pixel, [160, 100, 40, 255]);
    let mut empty = [0; 4];
    lay_over([9, 8, 7, 128], &mut empty);
    assert_eq!(empty, [9, 8, 7, 128]);
}
