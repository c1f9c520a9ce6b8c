//! Tests of the folder of layers: what is read is what was written, within 16 bits of depth, and nothing of a user is lost.

use std::fs;
use std::path::Path;

use glam::{DMat3, DVec3};

use super::picture_kind::PictureKind;
use super::*;
use crate::levels::pyramid;
use crate::{DepthPixel, Ldi, LdiKind, LdiReport, LdiSurface, ResolutionLevel, Splat};
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_base::scene::FaceIndex;
use quadratura_base::scene::synthetic::Rng;
use quadratura_base::task::Task;

/// Returns an image with random content: empty positions, sky, and up to four layers.
fn random(seed: u64, width: u32, height: u32) -> Ldi {
    let mut rng = Rng::new(seed);
    let mut below = move |end: u64| rng.bits() % end;
    let surfaces: Vec<LdiSurface> = (0..3u32)
        .map(|index| LdiSurface {
            nu: DVec3::new(1e-4, -2e-4, 0.1 + 0.01 * f64::from(index)),
            object: format!("house {index} \"é\""),
            face: (index > 0).then_some(FaceIndex(index)),
        })
        .collect();
    let camera = Pinhole { width, height, fx: 40.5, fy: 41.0, cx: 6.25, cy: 1.0 / 3.0 };
    let mut row = |_| {
        let mut row = Vec::new();
        for column in 0..width as u16 {
            let mut depths: Vec<f32> =
                (0..below(8).saturating_sub(3)).map(|_| below(1000) as f32 / 999.0).collect();
            depths.sort_by(|a, b| b.total_cmp(a));
            for inverse_depth in depths {
                let colour = (below(1 << 32) as u32).to_le_bytes();
                let (surface, splat) = (below(4) as u16, Splat(below(256) as u8));
                row.push((column, DepthPixel { inverse_depth, colour, surface, splat }));
            }
        }
        row
    };
    let rows: Vec<_> = (0..height).map(&mut row).collect();
    let report = LdiReport { quartiles: [1.0, 2.5, 1.0 / 3.0], samples: 77, ..LdiReport::default() };
    Ldi {
        kind: LdiKind::Stack,
        inputs: "0123-ef".to_owned(),
        camera,
        pose: Pose { rotation: DMat3::from_rotation_y(0.7), translation: DVec3::new(5e6, -0.1, 1e-7) },
        photo_rect: Some(PixelRect { x: (width / 2) as i32, y: 0, w: width - width / 2, h: height }),
        gain: [0.0, -0.25, 0.1],
        levels: pyramid(ResolutionLevel::of_rows(camera, rows), &surfaces),
        surfaces,
        sources: vec!["nord/0028.jpg".to_owned()],
        report,
    }
}

fn bytes_in(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = entries
        .map(|path| (path.file_name().unwrap().to_str().unwrap().to_owned(), fs::read(&path).unwrap()))
        .collect();
    files.sort();
    files
}

#[test]
fn what_is_read_is_what_was_written_within_half_a_step_of_16_bits() {
    let folder = tempfile::tempdir().unwrap();
    for (seed, width, height) in [(1, 17, 9), (2, 1, 1), (3, 40, 33)] {
        let ldi = random(seed, width, height);
        let written = write_ldi_layers(&folder.path().join(format!("{seed}")), &ldi).unwrap();
        let read = read_ldi_layers(&written.folder, &Task::silent()).unwrap();
        let (level, back) = (&ldi.levels[0], &read.levels[0]);
        let depths = level.inverse_depths.iter().copied();
        let range = depths.clone().fold(0.0, f32::max) - depths.fold(f32::MAX, f32::min).min(f32::MAX);
        // Half a step, and the rounding of a 32-bit float below 1.
        let tolerance = range.max(0.0) / 131_070.0 + f32::EPSILON / 2.0;
        for (a, b) in level.inverse_depths.iter().zip(&back.inverse_depths) {
            assert!((a - b).abs() <= tolerance, "{a} {b}");
        }
        let depths = back.inverse_depths.clone();
        let mut expected = Ldi { levels: vec![level.clone()], ..ldi };
        expected.levels[0].inverse_depths = depths;
        expected.levels = pyramid(expected.levels[0].clone().finished(), &expected.surfaces);
        assert_eq!(read, expected, "all but the depths is the same");
        assert_eq!(written.depth_pixels, back.len() as u64);
    }
}

#[test]
fn an_image_without_depth_pixels_is_a_folder_without_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let mut ldi = random(1, 4, 3);
    ldi.levels = pyramid(ResolutionLevel::of_rows(ldi.camera, [Vec::new(), Vec::new(), Vec::new()]), &[]);
    let written = write_ldi_layers(&folder.path().join("a"), &ldi).unwrap();
    assert_eq!((written.layers, bytes_in(&written.folder).len()), (0, 1));
    assert_eq!(read_ldi_layers(&written.folder, &Task::silent()).unwrap(), ldi);
}

#[test]
fn the_error_of_16_bits_is_that_of_the_largest_displacement() {
    let folder = tempfile::tempdir().unwrap();
    let ldi = random(3, 40, 33);
    let error = write_ldi_layers(&folder.path().join("a"), &ldi).unwrap().error;
    // Half of the median distance 2.5; f 41; inverse depths from 0 to 1: 41 * 1.25 / 131070.
    assert_eq!((error.step, error.exact_enough), (1.25, true));
    assert!((error.pixels - 41.0 * 1.25 / 131_070.0).abs() < 1e-6, "{error:?}");
    let coarse = Ldi { camera: Pinhole { fx: 1e5, ..ldi.camera }, ..ldi };
    let error = write_ldi_layers(&folder.path().join("b"), &coarse).unwrap().error;
    assert!(!error.exact_enough && error.pixels > 0.9, "{error:?}");
}

#[test]
fn an_unchanged_folder_is_replaced_and_all_else_is_kept() {
    let parent = tempfile::tempdir().unwrap();
    let at = |name: &str| parent.path().join(name);
    let (ldi, other) = (random(1, 17, 9), random(2, 12, 5));
    write_ldi_layers(&at("a"), &ldi).unwrap();
    let first = bytes_in(&at("a"));
    let again = write_ldi_layers(&at("a"), &ldi).unwrap();
    assert_eq!((again.folder, again.spared.len()), (at("a"), 0));
    assert_eq!(bytes_in(&at("a")), first, "the same content gives the same bytes");
    assert_eq!(write_ldi_layers(&at("a"), &other).unwrap().folder, at("a"));
    let changes: [&dyn Fn(&Path); 4] = [
        &|folder| fs::write(folder.join("notes.txt"), "mine").unwrap(),
        &|folder| fs::remove_file(folder.join("depth-01.png")).unwrap(),
        &|folder| fs::write(folder.join("layer-00.png"), "painted").unwrap(),
        &|folder| {
            let text = fs::read_to_string(folder.join(JSON)).unwrap();
            fs::write(folder.join(JSON), text.replace("1.25", "1.5")).unwrap();
        },
    ];
    for (number, change) in (0..).zip(changes) {
        let (name, next) = (format!("b{number}"), format!("b{number}-2"));
        write_ldi_layers(&at(&name), &ldi).unwrap();
        change(&at(&name));
        let kept = bytes_in(&at(&name));
        let second = write_ldi_layers(&at(&name), &ldi).unwrap();
        assert_eq!((second.folder, second.spared), (at(&next), vec![at(&name)]), "change {number}");
        assert_eq!(bytes_in(&at(&name)), kept);
    }
    fs::write(at("file"), "theirs").unwrap();
    assert_eq!(write_ldi_layers(&at("file"), &ldi).unwrap().folder, at("file-2"));
    fs::create_dir(at("empty")).unwrap();
    assert_eq!(write_ldi_layers(&at("empty"), &ldi).unwrap().folder, at("empty"));
}

#[test]
fn painted_colours_come_back_in_the_kinds_that_image_editors_save() {
    let folder = tempfile::tempdir().unwrap();
    let ldi = random(1, 17, 9);
    let written = write_ldi_layers(&folder.path().join("a"), &ldi).unwrap().folder;
    let first_colours = |folder: &Path| {
        let read = read_ldi_layers(folder, &Task::silent()).unwrap();
        (0..9)
            .flat_map(|y| read.levels[0].layered_pixels(y).collect::<Vec<_>>())
            .map(|pixels| read.levels[0].colours[pixels.start])
            .collect::<Vec<_>>()
    };
    let file = written.join("layer-00.png");
    image::RgbImage::from_pixel(17, 9, image::Rgb([9, 8, 7])).save(&file).unwrap();
    assert!(first_colours(&written).iter().all(|colour| *colour == [9, 8, 7, 255]));
    image::GrayImage::from_pixel(17, 9, image::Luma([5])).save(&file).unwrap();
    assert!(first_colours(&written).iter().all(|colour| *colour == [5, 5, 5, 255]));
    let deep =
        image::ImageBuffer::<image::Rgba<u16>, _>::from_pixel(17, 9, image::Rgba([257 * 4, 0, 65535, 257]));
    deep.save(&file).unwrap();
    assert!(first_colours(&written).iter().all(|colour| *colour == [4, 0, 255, 1]));
}

#[test]
fn broken_folders_give_errors_or_the_same_image_and_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let ldi = random(4, 5, 4);
    let written = write_ldi_layers(&folder.path().join("a"), &ldi).unwrap().folder;
    let silent = Task::silent();
    let files = bytes_in(&written);
    let mut errors = 0;
    for (name, bytes) in &files {
        let file = written.join(name);
        for at in 0..bytes.len() {
            fs::write(&file, &bytes[..at]).unwrap();
            // A PNG whose pixels are whole may lack its end; a JSON file its last line feed.
            errors += usize::from(read_ldi_layers(&written, &silent).is_err());
            let mut changed = bytes.clone();
            changed[at] ^= 1 << (at % 8);
            fs::write(&file, &changed).unwrap();
            if let Err(error) = read_ldi_layers(&written, &silent) {
                // A frame of another size in the JSON shows in the pictures.
                assert!(error.to_string().contains(name.as_str()) || name == JSON, "{error}");
                errors += 1;
            }
        }
        fs::write(&file, bytes).unwrap();
    }
    // Most cuts are errors; flipped bits of numbers and names in the JSON are other images.
    let all: usize = files.iter().map(|(_, bytes)| bytes.len()).sum();
    assert!(errors > all, "{errors} of {}", 2 * all);
    fs::remove_file(written.join("depth-00.png")).unwrap();
    assert!(read_ldi_layers(&written, &silent).unwrap_err().to_string().contains("depth-00.png"));
}

#[test]
fn pictures_that_contradict_each_other_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let camera = Pinhole { width: 3, height: 2, fx: 1.0, fy: 1.0, cx: 1.0, cy: 1.0 };
    let pixel = |inverse_depth| DepthPixel { inverse_depth, colour: [0; 4], surface: 0, splat: Splat(0) };
    let rows = [vec![], vec![(2, pixel(1.0)), (2, pixel(0.5))]];
    let ldi = Ldi {
        camera,
        levels: vec![ResolutionLevel::of_rows(camera, rows)],
        surfaces: Vec::new(),
        ..random(1, 2, 2)
    };
    let written = write_ldi_layers(&folder.path().join("a"), &ldi).unwrap().folder;
    let picture = |picture: PictureKind, layer, samples: &[u8]| {
        fs::write(written.join(picture.file_name(layer)), picture.encoded([3, 2], samples).unwrap()).unwrap();
    };
    let error = || read_ldi_layers(&written, &Task::silent()).unwrap_err().to_string();
    let (near, far) = ([255u8; 12], [0u8; 12]);
    picture(PictureKind::Depths, 0, &far);
    picture(PictureKind::Depths, 1, &near);
    assert!(error().contains("depth-01.png, column 2, row 1: it is nearer"), "{}", error());
    picture(PictureKind::Surfaces, 0, &[0; 36]);
    assert!(
        error().contains("surface-01.png, column 2, row 1: a depth pixel, but none in layer 0"),
        "{}",
        error()
    );
    picture(PictureKind::Surfaces, 0, &[[0, 9, 0, 0, 255, 255]; 6].concat());
    assert!(error().contains("surface-00.png, column 0, row 0: surface 9; expected 0 to 0"), "{}", error());
    fs::write(written.join("depth-00.png"), PictureKind::Depths.encoded([2, 3], &far).unwrap()).unwrap();
    picture(PictureKind::Surfaces, 0, &[0; 36]);
    assert!(error().contains("depth-00.png: 2 x 3 pixels; expected 3 x 2"), "{}", error());
}
