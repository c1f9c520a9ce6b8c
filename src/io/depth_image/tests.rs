//! Tests of depth images: the files of `tests/` were written by the reference implementation of OpenEXR 3.5, the others as their
//! formats are described.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::*;
use quadratura_base::task::Task;

/// The size of the OpenEXR files.
const SIZE: [u32; 2] = [24, 20];

/// The OpenEXR files whose numbers are those of [`ramp`].
const SAME: [(&str, &[u8]); 9] = [
    ("none_f32", include_bytes!("tests/none_f32.exr")),
    ("rle_f16", include_bytes!("tests/rle_f16.exr")),
    ("zip_f32_rgbz", include_bytes!("tests/zip_f32_rgbz.exr")),
    ("piz_f16_only", include_bytes!("tests/piz_f16_only.exr")),
    ("piz_f32", include_bytes!("tests/piz_f32.exr")),
    // 24 of 32 bits are kept, which the ramp does not exceed.
    ("pxr24_f32", include_bytes!("tests/pxr24_f32.exr")),
    // B44 packs 16-bit floats alone.
    ("b44_f32", include_bytes!("tests/b44_f32.exr")),
    ("tiled_zip_f32", include_bytes!("tests/tiled_zip_f32.exr")),
    ("cropped_f32", include_bytes!("tests/cropped_f32.exr")),
];
const WHOLE_NUMBERS: &[u8] = include_bytes!("tests/zips_u32.exr");

/// Returns the number of a pixel of the OpenEXR files: exact in 16-bit floats.
fn ramp(x: u32, y: u32) -> f32 {
    (x + 10 * y) as f32 / 8.0 + 0.5
}

fn written(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let file = folder.path().join(name);
    fs::write(&file, bytes).unwrap();
    file
}

fn read(bytes: &[u8], size: [u32; 2]) -> Result<DepthMap> {
    let content = Box::new(Cursor::new(bytes.to_vec()));
    read_source(&mut DepthFile::new(Path::new("a.depth"), content, bytes.len() as u64), size)
}

fn error(bytes: &[u8], size: [u32; 2]) -> String {
    let error = read(bytes, size).unwrap_err();
    assert!(matches!(error, Error::Input { .. }), "{error}");
    error.to_string()
}

/// Returns a PFM file of 3 x 2 numbers: 1 to 6 in reading order, rows from the bottom.
fn pfm(scale: &str, bytes: fn(f32) -> [u8; 4]) -> Vec<u8> {
    let header = format!("Pf\n3 2\n{scale}\n");
    let numbers = [4.0, 5.0, 6.0, 1.0, 2.0, 3.0f32].map(bytes);
    [header.as_bytes(), numbers.as_flattened()].concat()
}

/// Returns a COLMAP file of 3 x 2 numbers: 1 to 6 in reading order.
fn colmap() -> Vec<u8> {
    let numbers = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0f32].map(f32::to_le_bytes);
    [b"3&2&1&", numbers.as_flattened()].concat()
}

fn png(color: png::ColorType, depth: png::BitDepth, [width, height]: [u32; 2], samples: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(samples).unwrap();
    writer.finish().unwrap();
    bytes
}

fn grey16() -> Vec<u8> {
    let samples = [0u16, 1, 256, 65535, 5, 6].map(u16::to_be_bytes);
    png(png::ColorType::Grayscale, png::BitDepth::Sixteen, [3, 2], samples.as_flattened())
}

#[test]
fn openexr_files_of_all_lossless_compressions_have_the_numbers_that_were_written() {
    for (name, bytes) in SAME {
        let map = read(bytes, SIZE).unwrap_or_else(|error| panic!("{name}: {error}"));
        let held = |x, y| name != "cropped_f32" || ((2..20).contains(&x) && (1..18).contains(&y));
        for (x, y) in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))) {
            let found = map.at(x, y);
            match held(x, y) {
                true => assert_eq!(found, ramp(x, y), "{name}, {x} {y}"),
                false => assert!(found.is_nan(), "{name} has no data at {x} {y}"),
            }
        }
    }
    let whole = read(WHOLE_NUMBERS, SIZE).unwrap();
    assert_eq!((whole.at(0, 0), whole.at(23, 19)), (4.0, 8.0 * ramp(23, 19)));
}

#[test]
fn openexr_files_that_do_not_tell_one_depth_a_pixel_are_refused_with_what_helps() {
    let wrong = error(include_bytes!("tests/colours.exr"), SIZE);
    assert!(wrong.contains("the channels B, G, R; expected `Z`, `V` or `depth`"), "{wrong}");
    let wrong = error(include_bytes!("tests/two_layers.exr"), SIZE);
    assert!(wrong.contains("several channels of depth: left.Z, right.Z"), "{wrong}");
    for bytes in [include_bytes!("tests/dwaa_f32.exr").as_slice(), include_bytes!("tests/htj2k_f32.exr")] {
        let wrong = error(bytes, SIZE);
        assert!(wrong.ends_with("with the compression ZIP, PIZ, RLE or none"), "{wrong}");
    }
    let wrong = error(SAME[0].1, [20, 24]);
    assert!(wrong.contains("24 x 20 numbers; expected 20 x 24, as the picture has"), "{wrong}");
}

#[test]
fn pfm_files_have_their_rows_from_the_bottom_and_the_byte_order_of_the_scale() {
    let expected = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    assert_eq!(read(&pfm("-1.0", f32::to_le_bytes), [3, 2]).unwrap().values, expected);
    assert_eq!(read(&pfm("2.5e1", f32::to_be_bytes), [3, 2]).unwrap().values, expected);
    let of_colours = [b"PF\n3 2\n-1\n", [0u8; 72].as_slice()].concat();
    assert!(error(&of_colours, [3, 2]).contains("three channels of colour (`PF`); expected one channel"));
    assert!(error(&pfm("0", f32::to_le_bytes), [3, 2]).contains("\"0\" as the scale"));
    assert!(error(&pfm("-1", f32::to_le_bytes)[..30], [3, 2]).contains("the file is cut short"));
    assert!(error(b"Pf\n99999999 99999999\n-1\n", [3, 2]).contains("99999999 x 99999999 numbers"));
}

#[test]
fn colmaps_maps_are_read_row_by_row_and_normals_are_refused() {
    let map = read(&colmap(), [3, 2]).unwrap();
    assert_eq!((map.at(2, 0), map.at(0, 1)), (3.0, 4.0));
    let normals = [b"3&2&3&", [0u8; 72].as_slice()].concat();
    assert!(error(&normals, [3, 2]).contains("a map of normals"));
    let longer = [colmap(), vec![0]].concat();
    assert!(error(&longer, [3, 2]).contains("25 bytes after the header of 6; expected 24"));
}

#[test]
fn png_of_16_bits_is_read_and_pictures_for_people_are_refused() {
    assert_eq!(read(&grey16(), [3, 2]).unwrap().values, [0.0, 1.0, 256.0, 65535.0, 5.0, 6.0]);
    let colours = png(png::ColorType::Rgb, png::BitDepth::Eight, [3, 2], &[7; 18]);
    assert!(error(&colours, [3, 2]).contains("Rgb with 8 bits; expected grey with 16 bits"));
    assert!(error(&grey16(), [2, 3]).contains("3 x 2 numbers; expected 2 x 3"));
}

#[test]
fn files_are_read_by_their_content_and_others_are_refused_with_the_formats_that_there_are() {
    for bytes in [b"GIF89a".as_slice(), b"II*\0", b"{}", b"12 34"] {
        assert!(error(bytes, [3, 2]).contains("give an OpenEXR file, a PFM file"));
    }
    assert!(error(b"", [3, 2]).contains("the file is empty"));
    let folder = tempfile::tempdir().unwrap();
    let map = read_depth_map(&written(&folder, "a.bin", &colmap()), [3, 2]).unwrap();
    assert_eq!(map, read(&colmap(), [3, 2]).unwrap());
    let missing = read_depth_map(Path::new("no/such.exr"), [3, 2]).unwrap_err();
    assert!(missing.to_string().contains("it does not exist"), "{missing}");
}

#[test]
fn cut_and_changed_files_give_an_error_or_numbers_and_never_panic() {
    let mut files = vec![(pfm("-1.0", f32::to_le_bytes), [3, 2]), (colmap(), [3, 2]), (grey16(), [3, 2])];
    files.extend(SAME.iter().map(|(_, bytes)| (bytes.to_vec(), SIZE)));
    files.push((WHOLE_NUMBERS.to_vec(), SIZE));
    for (number, (bytes, size)) in files.iter().enumerate() {
        let whole = read(bytes, *size).unwrap();
        let check = |changed: &[u8], cut: bool| {
            match read(changed, *size) {
                Ok(map) => assert_eq!(map.values.len(), whole.values.len()),
                Err(Error::Input { found, remedy, .. }) => {
                    // That message is of a panic inside of the package, which the test is to find.
                    assert_ne!(found, "the OpenEXR file cannot be decoded", "file {number}");
                    assert!(!found.is_empty() && !remedy.to_string().is_empty());
                }
                Err(other) => panic!("file {number}, cut {cut}: {other}"),
            }
        };
        for at in 0..bytes.len() {
            check(&bytes[..at], true);
            let mut changed = bytes.clone();
            // The lowest and the highest bit, and all of them, which makes the largest lengths.
            changed[at] ^= [1, 0x80, !bytes[at]][at % 3];
            check(&changed, false);
        }
    }
}

#[test]
fn files_that_say_more_than_they_can_hold_are_refused_before_memory_is_taken() {
    // The data window's last column and row follow its first ones.
    let (bytes, name) = (SAME[0].1, b"dataWindow\0box2i\0");
    let at = bytes.windows(name.len()).position(|window| window == name).unwrap() + name.len() + 4 + 8;
    let mut larger = bytes.to_vec();
    larger[at..at + 8].copy_from_slice([16_383i32.to_le_bytes(), 16_383i32.to_le_bytes()].as_flattened());
    assert!(error(&larger, SIZE).contains("the file is cut short"), "{}", error(&larger, SIZE));
    larger[at + 2] = 1;
    assert!(error(&larger, SIZE).contains("expected sides of at most 16384"), "{}", error(&larger, SIZE));
}

/// Writes a list with pictures of 4 x 3 pixels beside it.
fn list(folder: &TempDir, images: &str) -> PathBuf {
    let picture = image::RgbImage::from_pixel(4, 3, image::Rgb([1, 2, 3]));
    picture.save(folder.path().join("a.png")).unwrap();
    written(folder, "list.json", format!("{{\"version\": 1, \"images\": [{images}]}}").as_bytes())
}

/// A camera of the list.
const CAMERA: &str =
    r#"{"K": [[2, 0, 2], [0, 2, 1.5], [0, 0, 1]], "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [1, 2, 3]}"#;

/// Returns an image of the list with other fields than the usual ones.
fn entry(fields: &str) -> String {
    format!(r#"{{"colour": "a.png", "depth": "a.pfm", {fields}}}"#)
}

#[test]
fn a_list_gives_its_images_and_what_is_wrong_with_one_leaves_that_one_out() {
    let folder = tempfile::tempdir().unwrap();
    let good = entry(&format!(
        r#""camera": {CAMERA}, "kind": "ray", "scale": 0.5, "offset": -1, "background": 100"#
    ));
    let plain = entry(&format!(r#""camera": {CAMERA}"#));
    let singular = CAMERA.replacen("[2, 0, 2]", "[0, 0, 2]", 1);
    let turned = CAMERA.replacen("[[1, 0, 0]", "[[-1, 0, 0]", 1);
    let sized = CAMERA.replacen('{', r#"{"width": 9, "height": 3, "#, 1);
    let skewed = CAMERA.replacen("[2, 0, 2]", "[2, 0.1, 2]", 1);
    let wrong = [
        (entry(r#""kind": "axis""#), "`camera` is missing"),
        (
            entry(&format!(r#""camera": {CAMERA}, "kind": "distance""#)),
            "expected one of `axis`, `ray`, `inverse`",
        ),
        (entry(&format!(r#""camera": {CAMERA}, "knid": "axis""#)), "unknown field `knid`"),
        (entry(&format!(r#""camera": {singular}"#)), "focal lengths above 0"),
        (entry(&format!(r#""camera": {skewed}"#)), "no skew"),
        (entry(&format!(r#""camera": {turned}"#)), "expected a rotation matrix"),
        (entry(&format!(r#""camera": {sized}"#)), "a camera of 9 x 3 pixels; the picture has 4 x 3"),
        (entry(r#""camera": "a.png""#), "the list names no `cameras`"),
        (entry(&format!(r#""camera": {CAMERA}, "scale": 0"#)), "`scale` 0"),
        (good.replacen("a.png", "b.png", 1), "b.png"),
    ];
    let images: Vec<String> =
        std::iter::once(good).chain(wrong.iter().map(|(text, _)| text.clone())).chain([plain]).collect();
    let list = read_list(&list(&folder, &images.join(",")), &Task::silent()).unwrap();
    let [first, last] = &list.images[..] else { panic!("{:?}", list.problems) };
    assert_eq!(
        (first.kind, first.scale, first.offset, first.background),
        (Some(DepthKind::Ray), 0.5, -1.0, 100.0)
    );
    assert_eq!((last.kind, last.scale, last.offset, last.background), (None, 1.0, 0.0, f64::INFINITY));
    assert_eq!((first.camera.width, first.camera.height, first.camera.fx), (4, 3, 2.0));
    assert_eq!((first.pose.translation.to_array(), first.photo), ([1.0, 2.0, 3.0], None));
    assert_eq!((&first.depth, &last.name[..]), (&folder.path().join("a.pfm"), "a.png"));
    assert_eq!(list.problems.len(), wrong.len());
    for (number, (problem, (_, expected))) in (2..).zip(list.problems.iter().zip(&wrong)) {
        let problem = problem.to_string();
        assert!(problem.contains(expected), "{problem}; expected: {expected}");
        assert!(
            problem.contains(&format!("image {number} (a.png)")) || expected.starts_with('b'),
            "{problem}"
        );
    }
}

#[test]
fn a_list_that_cannot_be_understood_is_refused_as_a_whole() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |text: &str| {
        read_list(&written(&folder, "list.json", text.as_bytes()), &Task::silent()).unwrap_err().to_string()
    };
    assert!(refused(r#"{"version": 2, "images": []}"#).contains("`version` is 2; expected 1"));
    assert!(refused(r#"{"version": 1, "image": []}"#).contains("unknown field `image`"));
    assert!(refused(r#"{"version": 1, "images": [], "cameras": "no/sparse"}"#).contains("sparse"));
}

#[test]
fn numbers_mean_depths_by_their_kind() {
    let none = f64::INFINITY;
    assert_eq!(DepthKind::Axis.inverse_depth(4.0, 1.25, none), 0.25);
    assert_eq!(
        DepthKind::Ray.inverse_depth(5.0, 1.25, none),
        0.25,
        "the distance 5 along a ray of 1.25 is the depth 4"
    );
    assert_eq!(DepthKind::Inverse.inverse_depth(0.25, 1.25, none), 0.25);
    for kind in DepthKind::ALL {
        for number in [0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(kind.inverse_depth(number, 1.25, none), 0.0, "{kind:?} {number}");
        }
    }
    assert_eq!(DepthKind::Axis.inverse_depth(100.0, 1.25, 100.0), 0.0);
    assert!(DepthKind::Axis.inverse_depth(99.0, 1.25, 100.0) > 0.0);
    assert_eq!(DepthKind::Inverse.inverse_depth(0.01, 1.25, 100.0), 0.0);
    assert!(DepthKind::Inverse.inverse_depth(0.02, 1.25, 100.0) > 0.0);
}
