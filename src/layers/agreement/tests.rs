//! Photos of a painted wall, one of which shows a thing that is not there.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec2, DVec3};

use super::parallax::shown_nearby;
use super::{
    AgreementOptions, PhotoAgreement, ReducedPhoto, ReducedPhotos, Votes, contradicted_regions,
    photo_agreement, things, votes,
};
use crate::fill::{Donor, DonorContent, FillSurfaceId, FillSurfaces, PaintedSurface};
use quadratura_base::geometry::{PixelRect, Spans};
use quadratura_base::raster::Image;
use quadratura_base::scene::synthetic::{Modeller, centred, look_at};
use quadratura_base::scene::{FaceId, Model, PhotoId, PhotoPixels, Samples};
use quadratura_base::task::Task;
use quadratura_projection::Projector;
use quadratura_projection::exposure::LightGroups;
use quadratura_projection::relief::Relief;
use quadratura_view::agreement::ContradictedPixel;
use quadratura_view::optics::Optics;

const SIZE: [u32; 2] = [240, 160];
/// The middle and the radius of the thing, in world units on the wall's plane.
const THING: (DVec3, f64) = (DVec3::new(0.5, 6.0, 2.0), 0.6);
/// A thing before the wall's foot, across the wall's lower edge.
const AT_THE_FOOT: (DVec3, f64) = (DVec3::new(0.5, 6.0, 0.1), 0.6);
/// The wall, and the ground before it.
const WALL: FaceId = FaceId(0);

fn model() -> std::sync::Arc<Model> {
    let mut m = Modeller::new();
    m.object("wall").quad_facing(DVec3::NEG_Y, DVec3::new(-9.0, 6.0, 0.0), DVec3::X * 18.0, DVec3::Z * 8.0);
    m.object("ground").quad(DVec3::new(-9.0, -9.0, 0.0), DVec3::X * 18.0, DVec3::Y * 15.0);
    m.finish()
}

fn projector(x: f64) -> Projector {
    let pose = look_at(DVec3::new(x, -4.0, 2.0), DVec3::new(0.0, 6.0, 2.0));
    Projector { name: format!("{x}"), camera: centred(SIZE[0], SIZE[1], 200.0), pose }
}

/// The point of the wall's plane that a pixel shows.
fn on_wall(projector: &Projector, x: i32, y: i32) -> DVec3 {
    on_plane(projector, x, y, 6.0)
}

/// The point that a pixel shows of a plane parallel to the wall, through this place of the y axis.
fn on_plane(projector: &Projector, x: i32, y: i32, at: f64) -> DVec3 {
    let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
    let eye = projector.pose.center_in_world();
    let ray = projector.pose.rotation.transpose() * projector.camera.ray_in_camera(px);
    eye + ray * ((at - eye.y) / ray.y)
}

/// A photo of these colours.
fn reduced(
    projector: &Projector,
    model: &std::sync::Arc<Model>,
    surfaces: &FillSurfaces,
    colour: impl FnMut((i32, i32)) -> [u8; 3],
) -> ReducedPhoto {
    let samples = PixelRect::of_size(SIZE[0], SIZE[1]).pixels().flat_map(colour).collect();
    let samples = Samples::U8(samples);
    let pixels = PhotoPixels { width: SIZE[0], height: SIZE[1], channels: 3, samples, icc: None };
    let content = DonorContent { pixels: &pixels, painted: &[], agreement: None };
    let donor = Donor::new(projector, &content, model, surfaces, 1e-4);
    ReducedPhoto::new(donor, PhotoAgreement::default(), [0.0; 3], &Optics::default())
}

/// A grey that varies slowly over the wall's plane, and a red thing.
fn pixels(projector: &Projector, thing: Option<(DVec3, f64)>) -> PhotoPixels {
    let colour = |(x, y): (i32, i32)| {
        let point = on_wall(projector, x, y);
        let grey = (150.0 + 20.0 * point.x.sin() + 20.0 * point.z.cos()) as u8;
        let is_thing = thing.is_some_and(|(middle, radius)| point.distance(middle) < radius);
        if is_thing { [200, 20, 20] } else { [grey; 3] }
    };
    let samples = PixelRect::of_size(SIZE[0], SIZE[1]).pixels().flat_map(colour).collect();
    PhotoPixels { width: SIZE[0], height: SIZE[1], channels: 3, samples: Samples::U8(samples), icc: None }
}

/// The votes on the photo at `xs[0]`, and the agreement found from them, where these photos show the thing.
fn compared(xs: &[f64], things: &[bool]) -> (Vec<Votes>, PhotoAgreement, usize) {
    compared_with(THING, xs, things)
}

/// [`compared`] with another thing.
fn compared_with(thing: (DVec3, f64), xs: &[f64], things: &[bool]) -> (Vec<Votes>, PhotoAgreement, usize) {
    compared_in_groups(thing, xs, things, &LightGroups::default())
}

/// [`compared_with`] photos of several groups of light.
/// All photos but the first.
fn others(all: &ReducedPhotos) -> Vec<PhotoId> {
    PhotoId::all(all.photos.len()).skip(1).collect()
}

fn compared_in_groups(
    thing: (DVec3, f64),
    xs: &[f64],
    things: &[bool],
    groups: &LightGroups,
) -> (Vec<Votes>, PhotoAgreement, usize) {
    let model = model();
    let surfaces = FillSurfaces::from_model(&model);
    let photo = |(x, shows_it): (&f64, &bool)| {
        let projector = projector(*x);
        let pixels = pixels(&projector, shows_it.then_some(thing));
        let content = DonorContent { pixels: &pixels, painted: &[], agreement: None };
        let donor = Donor::new(&projector, &content, &model, &surfaces, 1e-4);
        Some(ReducedPhoto::new(donor, PhotoAgreement::default(), [0.0; 3], &Optics::default()))
    };
    let photos: Vec<_> = xs.iter().zip(things).map(photo).collect();
    let all = ReducedPhotos { photos: &photos, surfaces: &surfaces, groups, relief: &Relief::default() };
    let options = AgreementOptions::default();
    let votes = votes(&all, PhotoId(0), &others(&all), &Task::silent()).unwrap();
    let regions = contradicted_regions(&votes, SIZE[0] as usize, &options);
    let agreement = photo_agreement(photos[0].as_ref().unwrap(), &votes, &regions, 1.0, &options);
    (votes, agreement, regions.len())
}

/// The share of pixels of the first photo with an agreement below a half: within the thing, and well outside of it.
fn outvoted(agreement: &PhotoAgreement, x: f64) -> [f64; 2] {
    let projector = projector(x);
    let mut counts = [(0.0, 0.0); 2];
    let outvoted: BTreeSet<(i32, i32)> = agreement.outvoted(SIZE).map(|(rect, _)| (rect.x, rect.y)).collect();
    for (u, v) in PixelRect::of_size(SIZE[0], SIZE[1]).pixels() {
        let away = on_wall(&projector, u, v).distance(THING.0);
        let place = if away < 0.85 * THING.1 { 0 } else { 1 };
        // Beside the thing, within what neighbourhoods and the ramp reach, is neither.
        if place == 0 || away > 2.2 * THING.1 {
            counts[place].0 += f64::from(u8::from(outvoted.contains(&(u, v))));
            counts[place].1 += 1.0;
        }
    }
    counts.map(|(some, all)| some / all)
}

#[test]
fn a_thing_in_one_photo_of_five_is_outvoted_as_a_whole_and_nothing_else_is() {
    let xs = [0.0, -2.0, -1.0, 1.0, 2.0];
    let (votes, agreement, regions) = compared(&xs, &[true, false, false, false, false]);
    assert_eq!(regions, 1);
    let [inside, outside] = outvoted(&agreement, xs[0]);
    assert!(inside > 0.99 && outside == 0.0, "{inside} {outside}");
    let middle = votes[(SIZE[1] / 2 * SIZE[0] + SIZE[0] / 2 + 10) as usize];
    assert!(middle.own == 1.0 && middle.against > 3.5 && middle.distance > 0.5, "{middle:?}");
}

#[test]
fn a_thing_that_most_photos_show_is_confirmed_and_a_tie_of_two_stays_undecided() {
    let xs = [0.0, -2.0, -1.0, 1.0, 2.0];
    let (_, agreement, regions) = compared(&xs, &[true, true, true, true, false]);
    assert_eq!((regions, agreement.contradicted.len()), (0, 0));
    let (_, agreement, regions) = compared(&xs[..2], &[true, false]);
    assert_eq!((regions, agreement.contradicted.len()), (0, 0), "one photo does not overrule another");
    let (_, agreement, _) = compared(&xs[..1], &[true]);
    assert!(agreement.contradicted.is_empty(), "nobody else sees it");
}

#[test]
fn two_against_one_lower_the_agreement_without_taking_the_thing_as_a_whole() {
    let (_, agreement, regions) = compared(&[0.0, -1.0, 1.0], &[true, false, false]);
    assert_eq!(regions, 0);
    let least = agreement.contradicted.iter().map(|pixel| pixel.agreement).min().unwrap();
    // A lead of one: 1 - 0.9 / 2.
    assert!((f64::from(least) / 255.0 - 0.55).abs() < 0.02, "{least}");
}

#[test]
fn what_lies_beside_a_contradicted_face_has_the_agreement_of_that_face() {
    let shows = [true, false, false, false, false];
    let (_, agreement, _) = compared_with(AT_THE_FOOT, &[0.0, -2.0, -1.0, 1.0, 2.0], &shows);
    let faces = |pixels: &[ContradictedPixel]| pixels.iter().map(|pixel| pixel.face).collect::<BTreeSet<_>>();
    assert_eq!(faces(&agreement.contradicted).len(), 2, "wall and ground are contradicted");
    let shown: BTreeMap<[u16; 2], FaceId> =
        agreement.contradicted.iter().map(|pixel| (pixel.at, pixel.face)).collect();
    let foreign =
        agreement.beside.iter().filter(|pixel| shown.get(&pixel.at).is_some_and(|f| *f != pixel.face));
    assert!(foreign.count() > 5, "along the edge between them each face goes on beyond its outline");
    for pixel in &agreement.beside {
        let near = agreement.contradicted.iter().any(|other| {
            let away = [0, 1].map(|axis| pixel.at[axis].abs_diff(other.at[axis]));
            other.face == pixel.face && away.iter().all(|by| *by <= 1)
        });
        assert!(near || pixel.agreement == u8::MAX, "{pixel:?}");
    }
}

#[test]
fn fillings_take_paint_but_nothing_outvoted_from_a_photo() {
    let (_, agreement, _) = compared(&[0.0, -2.0, -1.0, 1.0, 2.0], &[true, false, false, false, false]);
    let (model, projector) = (model(), projector(0.0));
    let surfaces = FillSurfaces::from_model(&model);
    let pixels = pixels(&projector, Some(THING));
    let middle = projector.camera.image_from_camera(projector.pose.camera_from_world(THING.0)).unwrap();
    let corner = [middle.x as i32 - 1, middle.y as i32 - 1];
    let rect = PixelRect::from_edges(corner[0], corner[1], corner[0] + 3, corner[1] + 3);
    let paint = Image::new(rect, vec![Some([10, 200, 10, 255]); 9]);
    let painted = [PaintedSurface { surface: FillSurfaceId(WALL.0), pixels: paint }];
    let content = DonorContent { pixels: &pixels, painted: &painted, agreement: Some(&agreement) };
    let donor = Donor::new(&projector, &content, &model, &surfaces, 1e-4);
    let item = donor.item(FillSurfaceId(WALL.0)).unwrap();
    let shows = |radius: f64| {
        let around = (0..16).map(|i| f64::from(i) * std::f64::consts::TAU / 16.0);
        around
            .map(move |turn| middle + DVec2::new(turn.cos(), turn.sin()) * radius)
            .map(|px| donor.shows(item, px))
    };
    let px_per_unit = 20.0;
    assert!(shows(0.8 * THING.1 * px_per_unit).all(|shown| !shown), "the thing is not shown");
    assert!(shows(2.5 * THING.1 * px_per_unit).all(|shown| shown), "the wall around it is");
    let green = donor.colour(middle, 0);
    assert!(green[1] > 0.5 && green[0] < 0.1, "paint is: {green:?}");
    // Coarser levels mix nothing of the thing into what is beside it.
    let beside = middle + DVec2::X * (2.2 * THING.1 * px_per_unit);
    for level in 0..3 {
        let [red, green, _] = donor.colour(beside, level);
        assert!((red - green).abs() < 0.02, "level {level}: {red} {green}");
    }
}

#[test]
fn photos_of_another_light_confirm_what_they_agree_with_and_contradict_nothing() {
    let (xs, things) = ([0.0, -1.0, 1.0, 2.0], [true, false, false, false]);
    let contradicted = |groups: &[u32]| {
        let (_, agreement, _) = compared_in_groups(THING, &xs, &things, &LightGroups::new(groups));
        outvoted(&agreement, xs[0])[0]
    };
    assert!(contradicted(&[0; 4]) > 0.9, "three photos of the same light contradict it");
    assert_eq!(contradicted(&[0, 1, 1, 1]), 0.0, "in another light it may look like that");
    assert!(contradicted(&[0, 0, 0, 0]) == contradicted(&[1, 1, 1, 1]));
    let own = |groups: &[u32]| -> f32 {
        let (votes, ..) = compared_in_groups(THING, &xs, &[false; 4], &LightGroups::new(groups));
        votes.iter().map(|votes| votes.own).sum()
    };
    assert!((own(&[0; 4]) / own(&[0, 1, 1, 1]) - 1.0).abs() < 1e-3, "where they agree their gains fit");
}

/// What a photo of a wall with windows shows: the light at a point of the wall's plane, given what is there.
type Seen = fn(DVec3, f64) -> [f64; 3];

/// The things that a photo shows of which four others show the wall alone. The wall ends at a height of 3; above is sky.
fn things_in(seen: Seen) -> (Vec<super::Thing>, Projector) {
    let mut m = Modeller::new();
    m.object("wall").quad_facing(DVec3::NEG_Y, DVec3::new(-9.0, 6.0, 0.0), DVec3::X * 18.0, DVec3::Z * 3.0);
    m.object("ground").quad(DVec3::new(-9.0, -9.0, 0.0), DVec3::X * 18.0, DVec3::Y * 15.0);
    let model = m.finish();
    let surfaces = FillSurfaces::from_model(&model);
    let photo = |x: f64| {
        let projector = projector(x);
        let colour = |(u, v): (i32, i32)| {
            let point = on_wall(&projector, u, v);
            let is_window = point.x.rem_euclid(1.0) < 0.4 && point.z.rem_euclid(1.0) < 0.5;
            let wall = if point.z > 3.0 {
                0.9
            } else if is_window {
                0.1
            } else {
                0.45
            };
            let light = if x == 0.0 { seen(point, wall) } else { [wall; 3] };
            light.map(|light| (255.0 * quadratura_base::scene::light::srgb_from_linear(light)).round() as u8)
        };
        Some(reduced(&projector, &model, &surfaces, colour))
    };
    let photos: Vec<_> = [0.0, -2.0, -1.0, 1.0, 2.0].map(photo).into_iter().collect();
    let (groups, relief) = (LightGroups::default(), Relief::default());
    let all = ReducedPhotos { photos: &photos, surfaces: &surfaces, groups: &groups, relief: &relief };
    let votes = votes(&all, PhotoId(0), &others(&all), &Task::silent()).unwrap();
    (things(&all, PhotoId(0), &others(&all), &votes, &AgreementOptions::default()), projector(0.0))
}

/// A branch before the wall and the sky.
fn is_branch(point: DVec3) -> bool {
    (point.x - 0.5).abs() < 0.9 && (1.2..4.2).contains(&point.z)
}

#[test]
fn a_branch_before_the_wall_is_likely_a_thing_and_goes_on_before_the_sky() {
    let (found, projector) = things_in(|point, wall| {
        let leaf = 0.03 + 0.02 * (9.0 * point.x).sin() * (7.0 * point.z).cos();
        if is_branch(point) { [leaf, 2.5 * leaf, 0.5 * leaf] } else { [wall; 3] }
    });
    let [branch] = &found[..] else { panic!("{found:?}") };
    assert!(branch.likelihood > 0.6 && !branch.is_light, "{}", branch.likelihood);
    let (mut inside, mut masked, mut outside) = (0.0, 0.0, 0.0);
    for (x, y) in PixelRect::of_size(SIZE[0], SIZE[1]).pixels() {
        let (truth, held) = (is_branch(on_wall(&projector, x, y)), branch.pixels.holds(x, y));
        inside += f64::from(u8::from(truth));
        masked += f64::from(u8::from(truth && held));
        outside += f64::from(u8::from(held && !truth));
    }
    assert!(masked > 0.9 * inside && outside < 0.1 * inside, "{masked} of {inside}, {outside} beside");
}

#[test]
fn haze_over_windows_is_light_and_no_thing() {
    let (found, _) = things_in(|point, wall| {
        let haze = (1.0 - ((point.x - 0.5) / 1.8).powi(2) - ((point.z - 1.5) / 1.4).powi(2)).max(0.0);
        [wall + 0.9 * haze * (1.0 - wall); 3]
    });
    assert!(!found.is_empty(), "the others contradict it");
    for thing in &found {
        assert!(thing.is_light && thing.likelihood < 0.3, "{thing:?}");
    }
}

/// How well four other photos show, at about the distance of the wall, what a photo shows of a block that the model lacks. The block
/// reaches this far before the wall, and the others show it or the wall alone.
fn nearby(before_wall: f64, others_show_it: bool) -> f32 {
    let model = model();
    let surfaces = FillSurfaces::from_model(&model);
    let on_block = |projector: &Projector, x: i32, y: i32| {
        let point = on_plane(projector, x, y, 6.0 - before_wall);
        ((-1.0..2.0).contains(&point.x) && (1.0..3.0).contains(&point.z)).then_some(point)
    };
    // Stones a quarter of a unit wide.
    let stones = |point: DVec3, seed: i64| {
        let [column, row] = [point.x, point.z].map(|at| (at / 0.25).floor() as i64);
        (40 + 2 * ((column * 73_856_093) ^ (row * 19_349_663) ^ (seed * 83_492_791)).rem_euclid(97)) as u8
    };
    let photo = |x: f64| {
        let projector = projector(x);
        let colour = |(u, v): (i32, i32)| {
            let block = on_block(&projector, u, v).filter(|_| others_show_it || x == 0.0);
            [block.map_or_else(|| stones(on_wall(&projector, u, v), 0), |point| stones(point, 1)); 3]
        };
        Some(reduced(&projector, &model, &surfaces, colour))
    };
    let photos: Vec<_> = [0.0, -2.0, -1.0, 1.0, 2.0].map(photo).into_iter().collect();
    let (groups, relief) = (LightGroups::default(), Relief::default());
    let all = ReducedPhotos { photos: &photos, surfaces: &surfaces, groups: &groups, relief: &relief };
    let whole = PixelRect::of_size(SIZE[0], SIZE[1]);
    let region = Spans::of_pixels(whole, |x, y| on_block(&projector(0.0), x, y).is_some());
    shown_nearby(&all, PhotoId(0), &others(&all), &region)
}

#[test]
fn a_relief_is_shown_nearby_by_the_others_and_neither_a_passer_by_nor_what_stands_well_before_the_wall_is() {
    let [relief, passer_by, stand] = [nearby(0.25, true), nearby(0.25, false), nearby(3.0, true)];
    assert!(relief > 0.8 && passer_by < 0.55 && stand < 0.55, "{relief} {passer_by} {stand}");
}
