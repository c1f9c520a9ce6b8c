//! What several photos contradict: whether fillings and views take it, and that paint on it stays.

use glam::DVec3;
use quadratura::task::Task;
use quadratura::testing::document::PhotoDecisions;
use quadratura::testing::document::paint::PaintColour;
use quadratura::testing::layers::fill::FillOptions;
use quadratura::testing::layers::{Faces, Options};
use quadratura::testing::projection::Renders;
use quadratura::testing::stacks::fill::{FillRequest, fill};
use quadratura::testing::view::Shot;
use quadratura::testing::views::preview::{PreviewOptions, open_reference};

use super::bench::Bench;
use super::propagated::paint;

const GREEN: PaintColour = [0, 40000, 0, 65535];

/// The middle of the stain that one photo alone shows on the wall, and its radius.
/// The cube hides a part of it from the photo farthest to the right.
const STAIN: (DVec3, f64) = (DVec3::new(-2.6, 6.0, 1.6), 0.8);

fn is_stained(point: DVec3) -> bool {
    point.distance(STAIN.0) < STAIN.1
}

/// Seven photos, the first of which shows a red stain.
fn stained() -> Bench {
    let bench = Bench::from_places(&[0.5, -2.0, -1.0, -3.0, -3.5, 1.5, 2.5]);
    bench.repaint(0, [220, 10, 10], is_stained);
    bench.build(Options::default());
    bench
}

/// Whether a colour is that of the stain rather than any of the wall.
fn is_red([r, g, _]: [u8; 3]) -> bool {
    r > 120 && g < 60
}

/// Renders the first photo's own camera, and returns the colours on the wall within the stain but for its rim, left and
/// right of its middle.
fn rendered(bench: &Bench, without_transients: bool) -> [Vec<[u8; 3]>; 2] {
    let opened = bench.opened();
    let options = PreviewOptions { relief: false, gains: false, ..PreviewOptions::default() };
    let mut view =
        open_reference(bench.folder.path(), &opened.project, &opened.site, &options, &Task::silent())
            .unwrap();
    let photo = &opened.site.photos[0];
    let mut shot = Shot::new(photo.camera, photo.pose);
    shot.blend.without_transients = without_transients;
    let picture = view.picture(&shot, &Task::silent()).unwrap();
    let colour = |[x, y]: [i32; 2]| {
        let at = 4 * (y as usize * photo.camera.width as usize + x as usize);
        [0, 1, 2].map(|c| picture.rgba[at + c])
    };
    let half = |from: f64, to: f64| {
        let wanted = |point: DVec3| {
            let aside = point.x - STAIN.0.x;
            point.distance(STAIN.0) < 0.75 * STAIN.1 && (from..to).contains(&aside)
        };
        bench.pixels_where(0, wanted).into_iter().map(colour).collect()
    };
    [half(-9.0, -0.15), half(0.15, 9.0)]
}

#[test]
fn a_stain_of_one_photo_stays_in_its_own_camera_until_it_is_asked_away_and_paint_on_it_stays_anyway() {
    let bench = stained();
    let share_red = |colours: &[[u8; 3]]| {
        colours.iter().filter(|colour| is_red(**colour)).count() as f64 / colours.len() as f64
    };
    let [left, right] = rendered(&bench, false);
    assert!(left.len() > 100 && right.len() > 100);
    assert!(share_red(&left) == 1.0 && share_red(&right) == 1.0, "its own camera shows the photo");
    let [left, right] = rendered(&bench, true);
    assert_eq!([share_red(&left), share_red(&right)], [0.0; 2], "the others show the wall there");
    let painted = bench.pixels_where(0, |point| is_stained(point) && point.x < STAIN.0.x);
    paint(&bench, 0, "wall", &painted.iter().map(|at| (at[0], at[1], GREEN)).collect::<Vec<_>>());
    let [left, right] = rendered(&bench, true);
    let is_green = |[r, g, _]: &[u8; 3]| *r < 30 && *g > 120;
    assert!(left.iter().all(is_green), "photos do not overrule a hand");
    assert_eq!(share_red(&right), 0.0, "beside the paint they do");
}

#[test]
fn no_filling_takes_what_other_photos_contradict() {
    let bench = stained();
    let filled = bench.fill(&FillOptions::default());
    for (photo, filled) in filled.iter().enumerate() {
        let texels = bench.texels(photo, filled.stack.as_ref().unwrap());
        let red = texels.iter().filter(|texel| is_red(texel.rgb.map(|value| value as u8))).count();
        assert!(!texels.is_empty() && red == 0, "{red} of {} texels of {photo}", texels.len());
    }
}

/// Fills with a pin of an object to the first photo, and returns for each photo whether its filling was confirmed as it is.
fn confirmed_with_pin(bench: &Bench, object: &str, force: bool) -> Vec<bool> {
    let mut opened = bench.opened();
    let mut decided = PhotoDecisions::default();
    decided.pin.push(Faces::whole(object));
    opened.project.decisions.set("0.png", decided);
    let request = FillRequest { memory: 1 << 30, force, ..FillRequest::default() };
    let filled = fill(bench.folder.path(), &opened.project, &opened.site, &request, &Task::silent()).unwrap();
    filled.iter().map(|filled| filled.up_to_date).collect()
}

#[test]
fn a_pin_makes_out_of_date_what_takes_from_the_photo_what_others_contradict_and_nothing_else() {
    let bench = stained();
    bench.fill(&FillOptions::default());
    assert_eq!(confirmed_with_pin(&bench, "cube", false), [true; 7], "nothing of the cube is contradicted");
    let of_wall = confirmed_with_pin(&bench, "wall", false);
    assert!(of_wall.contains(&false), "the photo gives its stain");
    assert_eq!(confirmed_with_pin(&bench, "wall", false), [true; 7], "nothing has changed since");
    let partial = bench.files();
    confirmed_with_pin(&bench, "wall", true);
    assert_eq!(partial, bench.files(), "the files are those of a complete filling");
}
