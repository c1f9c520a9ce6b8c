//! What views show instead of colours.

use glam::DVec3;

use super::of_model;
use crate::holes::Hole;
use crate::{DepthPixelOrigin, Ldi, Shown, Splat, SplatKind, WarpOptions, warp_shown};
use quadratura_base::geometry::Pose;
use quadratura_base::scene::synthetic::{Modeller, camera_is_world, centred};
use quadratura_base::task::Task;
use quadratura_view::Shot;
use quadratura_view::legend::{DENSITY, Legend, Origin, colour_of_number};

const PIXELS: WarpOptions = WarpOptions {
    splat: SplatKind::Pixel,
    spacing: crate::Spacing::Exact,
    order: crate::DrawingOrder::McMillan,
    level: Some(0),
    exposure: [0.0; 3],
    unculled: false,
};

/// A card of 1 x 1 at 2 before a wall that fills the frame at 4; both are seen from the origin.
fn card_before_a_wall() -> Ldi {
    let mut model = Modeller::new();
    model.object("card").screen(2.0, [-0.5, -0.5, 0.5, 0.5]);
    model.object("wall").screen(4.0, [-4.0, -4.0, 4.0, 4.0]);
    of_model(&model.finish(), centred(128, 128, 128.0), camera_is_world(), |_, _| [200, 200, 200, 255])
}

/// Removes what the camera does not see.
fn seen_alone(ldi: &Ldi) -> Ldi {
    ldi.depth_image()
}

fn shown(ldi: &Ldi, shot: &Shot, shown: Shown, options: &WarpOptions) -> Vec<[u8; 3]> {
    let warped = warp_shown(&ldi.clone().into(), shot, shown, options, &Task::silent()).unwrap();
    warped.picture.pixels().iter().map(|[r, g, b, _]| [*r, *g, *b]).collect()
}

fn aside(x: f64) -> Shot {
    Shot::new(centred(128, 128, 128.0), Pose { translation: DVec3::new(-x, 0.0, 0.0), ..camera_is_world() })
}

#[test]
fn holes_are_told_apart_by_frame_by_what_hides_them_and_by_magnification() {
    let image = seen_alone(&card_before_a_wall());
    // A step of 0.5 to the right: the card moves by 32 pixels, the wall by 16.
    let picture = shown(&image, &aside(0.5), Shown::Holes, &WarpOptions { splat: SplatKind::Sums, ..PIXELS });
    let at = |x: usize, y: usize| picture[y * 128 + x];
    assert_eq!(at(120, 64), Hole::OutsideFrame.colour(), "the wall ends 16 pixels from the right");
    assert_eq!(at(72, 64), Hole::Empty.colour(), "the card hid the wall from 64 to 80");
    assert_eq!([at(40, 64), at(100, 64), at(10, 10)], [[200; 3]; 3], "the card and the wall");
    // Nothing is hidden from what has all layers.
    let whole = shown(&card_before_a_wall(), &aside(0.5), Shown::Holes, &PIXELS);
    assert!(!whole.contains(&Hole::Empty.colour()) && whole.contains(&Hole::OutsideFrame.colour()));
    // Single pixels leave gaps in what is magnified twice, and nothing else is missing.
    let near = Shot::new(centred(128, 128, 256.0), camera_is_world());
    let magnified = shown(&card_before_a_wall(), &near, Shown::Holes, &PIXELS);
    let gaps = magnified.iter().filter(|colour| **colour == Hole::TooNear.colour()).count();
    let others = magnified.iter().filter(|colour| **colour == [200; 3]).count();
    assert!(gaps > magnified.len() / 2 && gaps + others == magnified.len(), "{gaps} and {others}");
}

#[test]
fn layers_are_counted_from_the_nearest_one() {
    let ldi = card_before_a_wall();
    let own = Shot::new(ldi.camera, ldi.pose);
    let picture = shown(&ldi, &own, Shown::Layer, &PIXELS);
    assert!(picture.iter().all(|colour| *colour == colour_of_number(0)), "its own camera sees the first");
    let picture = shown(&ldi, &aside(0.5), Shown::Layer, &PIXELS);
    assert_eq!(picture[64 * 128 + 72], colour_of_number(1), "the wall behind the card");
    assert_eq!(picture[64 * 128 + 100], colour_of_number(0), "the wall beside it");
    let Legend::Entries { entries, .. } = Shown::Layer.legend(2) else { panic!("layers are listed") };
    assert_eq!(entries.iter().map(|(_, colour)| *colour).collect::<Vec<_>>(), [0, 1].map(colour_of_number));
}

#[test]
fn provenance_shows_the_origins_of_depth_pixels() {
    let mut ldi = card_before_a_wall();
    let level = &mut ldi.levels[0];
    for (surface, splat) in level.surfaces.iter().zip(&mut level.splats) {
        let origin = if *surface == 1 { DepthPixelOrigin::Paint } else { DepthPixelOrigin::Invented };
        *splat = Splat::new(splat.entry(), origin);
    }
    let picture = shown(&ldi, &Shot::new(ldi.camera, ldi.pose), Shown::Provenance, &PIXELS);
    assert_eq!(picture[64 * 128 + 64], Origin::Paint.colour());
    assert_eq!(picture[5 * 128 + 5], Origin::Example.colour());
}

#[test]
fn density_is_the_number_of_depth_pixels_per_pixel() {
    let ldi = card_before_a_wall();
    for (focal, expected) in [(128.0, DENSITY[1]), (1024.0, DENSITY[0]), (16.0, DENSITY[2])] {
        let shot = Shot::new(centred(16, 16, focal), camera_is_world());
        let options = WarpOptions { splat: SplatKind::Sums, ..PIXELS };
        let middle = shown(&ldi, &shot, Shown::Density, &options)[8 * 16 + 8];
        let off = (0..3).map(|c| middle[c].abs_diff(expected[c])).max();
        // Sums round.
        assert!(off <= Some(2), "{middle:?} instead of {expected:?} at a focal length of {focal}");
    }
}
