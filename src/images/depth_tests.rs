//! Tests of depth images from elsewhere: a slanted plane, photographed at a wide angle, with sparse points on it.

#![cfg(test)]

use std::fs;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use glam::{DVec2, DVec3};
use tempfile::TempDir;

use super::of_depth::{DepthImageOptions, depth_images};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Pinhole;
use quadratura_base::task::{Event, Task};
use quadratura_io::depth_image::DepthKind;
use quadratura_ldi::file::{Packing, read_ldi, write_ldi};
use quadratura_ldi::spacing::{distance, entry_of, normal_of_plane};
use quadratura_ldi::{DepthPixelOrigin, Ldi, LdiKind};

/// What reading a list gives.
type ListResult = Result<(Vec<Ldi>, Vec<Error>)>;

/// A wide angle: a corner's ray is 1.3 times as long as the axis.
const CAMERA: Pinhole = Pinhole { width: 40, height: 30, fx: 30.0, fy: 30.0, cx: 20.0, cy: 15.0 };

/// The inverse depth of the plane over the picture; depths are 4.3 to 7.6.
const NU: DVec3 = DVec3::new(0.002, -0.001, 0.16);

/// The translation of the camera, world to camera.
const T: DVec3 = DVec3::new(0.5, -0.25, 2.0);

fn centre(x: u32, y: u32) -> DVec3 {
    DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0)
}

fn pixels() -> impl Iterator<Item = (u32, u32)> {
    (0..CAMERA.height).flat_map(|y| (0..CAMERA.width).map(move |x| (x, y)))
}

/// Returns the number that a file of this kind has.
fn number(kind: DepthKind, x: u32, y: u32) -> f64 {
    let inverse_depth = NU.dot(centre(x, y));
    match kind {
        DepthKind::Axis => 1.0 / inverse_depth,
        DepthKind::Ray => CAMERA.ray_in_camera(centre(x, y).truncate()).length() / inverse_depth,
        DepthKind::Inverse => inverse_depth,
    }
}

fn colour(x: u32, y: u32) -> [u8; 3] {
    [x as u8, y as u8, 200]
}

/// A folder with a picture, its camera in COLMAP's files, and sparse points.
struct DepthFolder {
    folder: TempDir,
}

impl DepthFolder {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let picture = image::RgbImage::from_fn(40, 30, |x, y| image::Rgb(colour(x, y)));
        picture.save(folder.path().join("a.png")).unwrap();
        let (mut seen, mut points) = (String::new(), String::new());
        for (number, (x, y)) in (1..).zip(pixels().filter(|(x, y)| x % 5 == 2 && y % 4 == 1)) {
            let depth = 1.0 / NU.dot(centre(x, y));
            let DVec2 { x: u, y: v } = centre(x, y).truncate();
            let at = CAMERA.ray_in_camera(DVec2::new(u, v)) * depth - T;
            seen += &format!("{u} {v} {number} ");
            points += &format!("{number} {} {} {} 9 9 9 0.5 1 {}\n", at.x, at.y, at.z, number - 1);
        }
        let files = Self { folder };
        fs::create_dir(files.path("sparse")).unwrap();
        files
            .write("sparse/cameras.txt", "1 PINHOLE 40 30 30 30 20 15\n2 SIMPLE_RADIAL 40 30 30 20 15 0.1\n");
        let pose = format!("1 0 0 0 {} {} {}", T.x, T.y, T.z);
        files.write("sparse/images.txt", &format!("1 {pose} 1 a.png\n{seen}\n2 {pose} 2 lens.png\n\n"));
        files.write("sparse/points3D.txt", &points);
        files
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    /// Writes a PFM file of numbers.
    fn depths(&self, name: &str, number: impl Fn(u32, u32) -> f64) {
        let rows = (0..CAMERA.height).rev();
        let numbers = rows.flat_map(|y| (0..CAMERA.width).map(move |x| (x, y)));
        let mut bytes = b"Pf\n40 30\n-1\n".to_vec();
        bytes.extend(numbers.flat_map(|(x, y)| (number(x, y) as f32).to_le_bytes()));
        fs::write(self.path(name), bytes).unwrap();
    }

    /// Reads a list of images, given as the fields after the picture; returns the notes, too.
    fn read_with(&self, images: &[&str], force: bool) -> (ListResult, Vec<String>) {
        let images: Vec<_> =
            images.iter().map(|fields| format!(r#"{{"colour": "a.png", {fields}}}"#)).collect();
        let text = format!(r#"{{"version": 1, "cameras": "sparse", "images": [{}]}}"#, images.join(", "));
        self.write("list.json", &text);
        let notes = Arc::new(Mutex::new(Vec::new()));
        let kept = notes.clone();
        let task = Task::new(move |event| {
            if let Event::Note { text, .. } = event {
                kept.lock().unwrap().push(text.to_string());
            }
        });
        let read = depth_images(&self.path("list.json"), &DepthImageOptions { force }, &task);
        let notes = notes.lock().unwrap().clone();
        (read, notes)
    }

    /// Reads one image that can be used.
    fn image(&self, fields: &str) -> (Ldi, Vec<String>) {
        let (read, notes) = self.read_with(&[fields], false);
        let (mut images, errors) = read.unwrap();
        assert!(errors.is_empty(), "{errors:?}");
        (images.pop().unwrap(), notes)
    }

    /// Reads one image that cannot be used.
    fn error(&self, fields: &str) -> String {
        let (images, errors) = self.read_with(&[fields], false).0.unwrap();
        let [Error::Input { .. }] = &errors[..] else { panic!("{errors:?}") };
        assert!(images.is_empty());
        errors[0].to_string()
    }
}

#[test]
fn numbers_of_each_kind_become_the_same_image_of_one_layer() {
    let files = DepthFolder::new();
    for kind in DepthKind::ALL {
        files.depths("a.pfm", |x, y| (number(kind, x, y) - 0.5) / 4.0);
        let fields = format!(
            r#""depth": "a.pfm", "camera": "a.png", "kind": "{}", "scale": 4, "offset": 0.5"#,
            kind.name()
        );
        let (ldi, notes) = files.image(&fields);
        assert!(notes.is_empty(), "{notes:?}");
        assert_eq!((ldi.kind, ldi.camera, ldi.pose.translation), (LdiKind::Depth, CAMERA, T));
        assert_eq!(
            (ldi.sources.as_slice(), ldi.surfaces.len(), ldi.gain),
            (["a.png".to_owned()].as_slice(), 0, [0.0; 3])
        );
        let level = &ldi.levels[0];
        assert_eq!((level.len(), ldi.report.layers, ldi.report.depth_complexity), (1200, 1, 1.0));
        for (index, (x, y)) in pixels().enumerate() {
            let pixel = level.pixel(index);
            let expected = NU.dot(centre(x, y));
            // Numbers of the file are 32-bit floats, of which an offset takes a few bits.
            assert!((f64::from(pixel.inverse_depth) / expected - 1.0).abs() < 2e-6, "{kind:?} {x} {y}");
            let [r, g, b] = colour(x, y);
            assert_eq!((level.columns[index], pixel.colour, pixel.surface), (x as u16, [r, g, b, 255], 0));
            assert_eq!(pixel.splat.origin(), DepthPixelOrigin::Photo);
            let normal = normal_of_plane(NU, &CAMERA);
            let entry =
                entry_of(normal, distance(&CAMERA, x as u16, y, pixel.inverse_depth), &ldi.report.quartiles);
            assert_eq!(pixel.splat.entry(), entry, "{kind:?} {x} {y}");
        }
        let file = files.path("a.ldi");
        write_ldi(&file, &ldi, Packing::None).unwrap();
        assert_eq!(read_ldi(&file, &Task::silent()).unwrap(), ldi, "the file's checks accept it");
    }
}

#[test]
fn where_the_kind_is_left_out_the_one_that_fits_the_points_is_named() {
    let files = DepthFolder::new();
    for kind in DepthKind::ALL {
        // A scale that is wrong, too, does not matter for that.
        files.depths("a.pfm", |x, y| 7.0 * number(kind, x, y));
        let error = files.error(r#""depth": "a.pfm", "camera": "a.png""#);
        let name = kind.name();
        assert!(
            error.contains("`axis` (depth along")
                && error.contains("`ray` (")
                && error.contains("`inverse` (")
        );
        assert!(
            error.contains(&format!("; `{name}` fits 64 sparse points within 0.00 %, apart from scale; ")),
            "{error}"
        );
        assert!(error.matches(" misses them by ").count() == 2, "{error}");
        assert!(error.ends_with(&format!("add `\"kind\": \"{name}\"` to this image")), "{error}");
    }
    // A camera of the list's own has no points.
    let own = r#""camera": {"K": [[30, 0, 20], [0, 30, 15], [0, 0, 1]], "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [0, 0, 0]}"#;
    let error = files.error(&format!(r#""depth": "a.pfm", {own}"#));
    assert!(error.ends_with("add the kind that the program writes which made the depths"), "{error}");
}

#[test]
fn a_kind_that_fits_less_than_another_is_noted() {
    let files = DepthFolder::new();
    files.depths("a.pfm", |x, y| number(DepthKind::Ray, x, y));
    let (_, notes) = files.image(r#""depth": "a.pfm", "camera": "a.png", "kind": "axis""#);
    assert!(
        notes.iter().any(|note| note.starts_with("`ray` fits the sparse points within 0.00 %, `axis`")),
        "{notes:?}"
    );
}

#[test]
fn a_scale_that_contradicts_the_points_is_noted_and_then_refused() {
    let files = DepthFolder::new();
    let fields =
        |scale: f64| format!(r#""depth": "a.pfm", "camera": "a.png", "kind": "axis", "scale": {scale}"#);
    files.depths("a.pfm", |x, y| number(DepthKind::Axis, x, y));
    assert!(files.image(&fields(1.05)).1.is_empty());
    for (scale, ratio) in [(1.2, "1.200"), (0.8, "0.800")] {
        let (_, notes) = files.image(&fields(scale));
        let [note] = &notes[..] else { panic!("{notes:?}") };
        assert!(
            note.starts_with(&format!("the depths are {ratio} times those of 64 sparse points")),
            "{note}"
        );
        assert!(note.ends_with("with `\"scale\": 1.000000` they would agree"), "{note}");
    }
    for scale in [3.0, 0.3] {
        let error = files.error(&fields(scale));
        assert!(
            error.contains(&format!("the depths are {scale:.3} times"))
                && error.ends_with("or use `--force`"),
            "{error}"
        );
        let (images, errors) = files.read_with(&[&fields(scale)], true).0.unwrap();
        assert_eq!((images.len(), errors.len()), (1, 0));
    }
    files.depths("a.pfm", |x, y| number(DepthKind::Inverse, x, y));
    let error = files.error(r#""depth": "a.pfm", "camera": "a.png", "kind": "axis""#);
    assert!(error.contains("check `kind`") && error.contains("correct `kind`"), "{error}");
    assert!(!error.contains("would agree"), "the scale of another kind is another one: {error}");
    files.depths("a.pfm", |x, y| 5.0 * number(DepthKind::Inverse, x, y));
    let error = files.error(r#""depth": "a.pfm", "camera": "a.png", "kind": "inverse""#);
    assert!(error.contains("0.200 times") && error.contains("\"scale\": 0.200000"), "{error}");
}

#[test]
fn an_image_that_cannot_be_used_does_not_stop_the_others() {
    let files = DepthFolder::new();
    files.depths("a.pfm", |x, y| number(DepthKind::Axis, x, y));
    files.depths("empty.pfm", |x, _| [0.0, -1.0, f64::NAN, f64::INFINITY][x as usize % 4]);
    fs::write(files.path("small.bin"), [b"2&1&1&".as_slice(), &[0; 8]].concat()).unwrap();
    let image =
        |depth: &str, camera: &str| format!(r#""depth": "{depth}", "camera": "{camera}", "kind": "axis""#);
    let images = [
        image("empty.pfm", "a.png"),
        image("small.bin", "a.png"),
        image("a.pfm", "lens.png"),
        image("a.pfm", "b.png"),
        image("a.pfm", "a.png"),
    ];
    let images: Vec<&str> = images.iter().map(String::as_str).collect();
    let (images, errors) = files.read_with(&images, false).0.unwrap();
    assert_eq!(images.len(), 1);
    let found: Vec<String> = errors.iter().map(ToString::to_string).collect();
    for expected in [
        "no pixel has a depth",
        "2 x 1 numbers; expected 40 x 30",
        "a lens with distortion",
        "\"b.png\", which is none of the 2 in",
    ] {
        assert!(found.iter().any(|error| error.contains(expected)), "{expected}: {found:?}");
    }
    assert_eq!(errors.len(), 4);
}

#[test]
fn pixels_without_depth_or_beyond_the_background_or_invalid_in_the_picture_are_left_out() {
    let files = DepthFolder::new();
    let picture = image::RgbaImage::from_fn(40, 30, |x, y| {
        let [r, g, b] = colour(x, y);
        image::Rgba([r, g, b, if x == 39 { 254 } else { 255 }])
    });
    picture.save(files.path("a.png")).unwrap();
    files.depths("a.pfm", |x, y| if x < 3 { f64::NAN } else { number(DepthKind::Axis, x, y) });
    let fields = r#""depth": "a.pfm", "camera": "a.png", "kind": "axis", "background": 6"#;
    let (ldi, _) = files.image(fields);
    let level = &ldi.levels[0];
    for (x, y) in pixels() {
        let expected = (3..39).contains(&x) && number(DepthKind::Axis, x, y) < 6.0;
        assert_eq!(level.at(x, y).len(), usize::from(expected), "{x} {y}");
    }
    assert!((100..1080).contains(&level.len()), "the background is within the picture");
    assert_eq!(ldi.report.options["background"], "6");
}

#[test]
fn across_a_jump_of_depth_there_is_no_normal() {
    let files = DepthFolder::new();
    // Two walls towards the camera; each pixel has a neighbour of its own wall on one side at least.
    files.depths("a.pfm", |x, _| if x < 20 { 4.0 } else { 8.0 });
    let own = r#""camera": {"K": [[30, 0, 20], [0, 30, 15], [0, 0, 1]], "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [0, 0, 0]}"#;
    let (ldi, _) = files.image(&format!(r#""depth": "a.pfm", "kind": "axis", {own}"#));
    let level = &ldi.levels[0];
    for (index, (x, y)) in pixels().enumerate() {
        let far = distance(&CAMERA, x as u16, y, level.inverse_depths[index]);
        assert_eq!(level.splats[index].entry(), entry_of(-DVec3::Z, far, &ldi.report.quartiles), "{x} {y}");
    }
}
