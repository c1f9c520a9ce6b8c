//! People who are pasted into photos of the piazza are contradicted by the other photos and suggested as masks, and
//! little else is.

use std::path::{Path, PathBuf};

use crate::common;
use image::{Rgb, RgbImage};
use quadratura::task::Task;
use quadratura::testing::document::masks::MaskOrigin;
use quadratura::testing::geometry::{PixelRect, Spans};
use quadratura::testing::gpu::{Gpu, GpuRasteriser};
use quadratura::testing::io::stack_store::StackStore;
use quadratura::testing::layers::agreement::PhotoEvidence;
use quadratura::testing::projection::framing::scaled;
use quadratura::testing::projection::relief::Relief;
use quadratura::testing::projection::{Gains, Renders};
use quadratura::testing::scene::PhotoId;
use quadratura::testing::sites::create::{NewProject, create_project};
use quadratura::testing::sites::masks::MaskEdit;
use quadratura::testing::sites::open::Opened;
use quadratura::testing::stacks::agreement::{AgreementInputs, SiteAgreement};
use quadratura::testing::stacks::build::{BuildOptions, build};
use quadratura::testing::stacks::masks::suggest::{MARGIN_PX, Suggestions, accepted, suggest, suggestions};
use quadratura::testing::view::{Picture, Shot};
use quadratura::testing::views::preview::{self, PreviewOptions};

/// Photo, where the feet are in its pixels, height in pixels, coat.
const PEOPLE: [(&str, [i32; 2], i32, [u8; 3]); 3] = [
    ("01_church.jpg", [1180, 1120], 210, [40, 60, 110]),
    ("02_from_southwest.jpg", [427, 1000], 260, [45, 48, 62]),
    ("03_from_southeast.jpg", [1450, 1020], 190, [70, 90, 60]),
];

/// Paints somebody into a photo; returns the pixels.
fn paste(photo: &mut RgbImage, [x, y]: [i32; 2], height: i32, coat: [u8; 3]) -> Spans {
    let h = f64::from(height);
    let in_ellipse = |u: f64, v: f64, [cx, cy, rx, ry]: [f64; 4]| {
        ((u - cx) / (rx * h)).powi(2) + ((v - cy) / (ry * h)).powi(2) <= 1.0
    };
    let colour = |u: i32, v: i32| {
        let (u, v) = (f64::from(u - x), f64::from(v - y));
        let leg = u.abs() > 0.01 * h && u.abs() < 0.085 * h && v > -0.48 * h && v < 0.0;
        match () {
            () if in_ellipse(u, v, [0.0, -0.93 * h, 0.065, 0.07]) => Some([200, 160, 135]),
            () if in_ellipse(u, v, [0.0, -0.635 * h, 0.125, 0.235]) => Some(coat),
            () if leg => Some(coat.map(|value| value / 2 + 15)),
            () => None,
        }
    };
    let area = PixelRect { x: x - height, y: y - height, w: 2 * height as u32, h: height as u32 };
    let pixels = Spans::of_pixels(area, |u, v| colour(u, v).is_some());
    for (v, run) in pixels.iter() {
        run.clone().for_each(|u| photo.put_pixel(u as u32, v as u32, Rgb(colour(u, v).unwrap())));
    }
    pixels
}

/// The piazza's first photos with people in them, as a project; and what these cover.
fn peopled(folder: &Path, count: usize) -> (Opened, Vec<Spans>) {
    let piazza = Path::new(env!("CARGO_MANIFEST_DIR")).join("projects/piazza");
    let photos = folder.join("photos");
    std::fs::create_dir(&photos).unwrap();
    let files = std::fs::read_dir(piazza.join("photos")).unwrap();
    let mut files: Vec<PathBuf> = files.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    for file in files.into_iter().take(count) {
        std::fs::copy(&file, photos.join(file.file_name().unwrap())).unwrap();
    }
    let paste_one = |&(name, feet, height, coat): &(&str, [i32; 2], i32, [u8; 3])| {
        let mut photo = image::open(photos.join(name)).unwrap().to_rgb8();
        let pixels = paste(&mut photo, feet, height, coat);
        photo.save(photos.join(name)).unwrap();
        pixels
    };
    let people = PEOPLE.iter().map(paste_one).collect();
    let new = NewProject {
        photos,
        cameras: piazza.join("sparse"),
        model: piazza.join("piazza.obj"),
        ..NewProject::default()
    };
    (create_project(&folder.join("project"), &new, &Task::silent()).unwrap(), people)
}

/// What accepting one suggestion masks.
fn masked(project: &Path, number: u32) -> Spans {
    match accepted(project, &[number], 0).unwrap().remove(0) {
        MaskEdit::Add { masked, from: MaskOrigin::Suggested, .. } => masked,
        other => panic!("{other:?}"),
    }
}

#[test]
fn people_who_stand_in_one_photo_are_suggested_first_and_little_else_is() {
    let folder = tempfile::tempdir().unwrap();
    let (opened, people) = peopled(folder.path(), 9);
    let project = folder.path().join("project");
    let found: Suggestions =
        suggest(&project, &opened.project, &opened.site, &[], MARGIN_PX, 2 << 30, &Task::silent()).unwrap();
    assert_eq!(suggestions(&project).unwrap(), found, "it is kept");
    let listed = found.list.iter().filter(|suggestion| suggestion.is_likely()).count();
    assert!(listed <= 30, "{listed} suggestions are listed");
    for ((photo, ..), person) in PEOPLE.iter().zip(&people) {
        let of_photo = found.list.iter().filter(|suggestion| suggestion.photo == *photo);
        let hit = of_photo.max_by_key(|s| masked(&project, s.number).intersection(person).count());
        let hit = hit.unwrap_or_else(|| panic!("nobody is found in {photo}"));
        let mask = masked(&project, hit.number);
        let covered = mask.intersection(person).count() as f64 / person.count() as f64;
        assert!(hit.number <= 8 && covered > 0.6, "{photo}: number {}, covered {covered:.2}", hit.number);
        assert!((hit.pixels as f64) < 3.0 * person.count() as f64, "{photo}: {} pixels", hit.pixels);
        assert!(project.join("cache/suggestions").join(&hit.picture).is_file());
    }
}

/// What the photos say of each other when the first has no vote; and with all votes.
fn evidence(folder: &Path, opened: &Opened) -> [Vec<PhotoEvidence>; 2] {
    let (relief, task) = (Relief::default(), Task::silent());
    let stacks = vec![None; opened.site.photos.len()];
    let gains = Gains::none(stacks.len());
    let inputs = AgreementInputs::new(&opened.project, &opened.site, &stacks, 1 << 30);
    let mut all = SiteAgreement::open(folder, &opened.site, inputs, &gains, &relief, &task).unwrap();
    let without = all.without(&[PhotoId(0)], &relief, &gains, &task).unwrap();
    [without.to_vec(), all.whole().to_vec()]
}

/// Gives a photo other pixels everywhere.
fn invert(file: &Path) {
    let mut photo = image::open(file).unwrap().to_rgb8();
    photo.pixels_mut().for_each(|Rgb(pixel)| *pixel = pixel.map(|value| 255 - value));
    photo.save(file).unwrap();
}

/// Predictions of the first two photos, each from all others, with everything that is estimated from them.
fn predictions(folder: &Path, opened: &Opened, gpu: &Gpu) -> [Picture; 2] {
    let (project, task) = (folder.join("project"), Task::silent());
    let (store, rasteriser) = (StackStore::new(&project), GpuRasteriser::new(gpu).unwrap());
    for built in build(&opened.site, &store, &rasteriser, &BuildOptions::default(), &task).unwrap() {
        built.stack.unwrap();
    }
    let options = PreviewOptions { filled: false, ..PreviewOptions::default() };
    let mut preview = preview::open(&project, &opened.project, &opened.site, gpu, &options, &task).unwrap();
    [PhotoId(0), PhotoId(1)].map(|id| {
        let photo = opened.site.photo(id);
        let shot = Shot { without: vec![id], ..Shot::new(scaled(&photo.camera, 0.25), photo.pose) };
        preview.picture(&shot, &task).unwrap()
    })
}

#[test]
fn a_photo_that_is_left_out_has_no_say_in_its_prediction() {
    let Some(gpu) = common::gpu() else { return };
    let [plain, altered] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let opened = [&plain, &altered].map(|folder| peopled(folder.path(), 5).0);
    invert(&opened[1].site.photos[0].file);
    let [first, second] = predictions(plain.path(), &opened[0], &gpu);
    let [first_altered, second_altered] = predictions(altered.path(), &opened[1], &gpu);
    assert!(first.rgba.chunks_exact(4).filter(|pixel| pixel[3] > 0).count() > 10_000, "much is predicted");
    assert!(first == first_altered, "its own pixels change nothing");
    assert!(second != second_altered, "those of another photo do");
}

#[test]
fn a_photo_that_is_left_out_has_no_say_in_what_others_contradict() {
    let [plain, altered] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let opened = [&plain, &altered].map(|folder| peopled(folder.path(), 9).0);
    let file = &opened[1].site.photos[0].file;
    invert(file);
    let [plain, altered] = [(&plain, &opened[0]), (&altered, &opened[1])].map(|(root, opened)| {
        let [without, whole] = evidence(root.path(), opened);
        assert_eq!(without[0], PhotoEvidence::default(), "it is not judged either");
        (without, whole)
    });
    assert!(plain.0 == altered.0, "other pixels of the photo that is left out change nothing");
    let others = |(_, whole): &(Vec<PhotoEvidence>, Vec<PhotoEvidence>)| whole[1..].to_vec();
    assert!(others(&plain) != others(&altered), "with a vote they do");
    assert!(plain.1.iter().any(|photo| !photo.things.is_empty()), "people are things");
}
