//! XCF as GIMP writes it, in all its versions.

use quadratura::testing::layered_files::{BlendMode, Depth, EditedDocument, EditedLayer, read_layered};
use quadratura::testing::scene::Samples;

use crate::xcf_file::{Coding, File, Layer, numbers, parasites};

const SIZE: (u32, u32) = (70, 66);
const PIXELS: usize = 70 * 66;

/// Noise, `bytes` a pixel.
fn noise(bytes: usize) -> Vec<u8> {
    (0..(PIXELS * bytes) as u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 21) as u8).collect()
}

fn read(file: &File) -> EditedDocument {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.xcf");
    std::fs::write(&path, file.bytes()).unwrap();
    read_layered(&path).unwrap_or_else(|error| panic!("{error}"))
}

fn refused(file: &File) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.xcf");
    std::fs::write(&path, file.bytes()).unwrap();
    read_layered(&path).unwrap_err().to_string()
}

fn bytes(layer: &EditedLayer) -> Vec<u8> {
    match layer.pixels.read().unwrap().samples() {
        Samples::U8(samples) => samples.clone(),
        Samples::U16(_) => panic!("16 bits"),
    }
}

fn words(layer: &EditedLayer) -> Vec<u16> {
    match layer.pixels.read().unwrap().samples() {
        Samples::U8(_) => panic!("8 bits"),
        Samples::U16(samples) => samples.clone(),
    }
}

/// One file with all that readers stumble over.
pub fn everything() -> File {
    let group = Layer {
        properties: vec![(29, vec![]), (8, numbers(&[0])), (6, numbers(&[128]))],
        ..Layer::new("group", (1, 1), 1, vec![9; 4])
    };
    let masked = Layer {
        properties: vec![
            (30, numbers(&[0, 0])),
            (15, numbers(&[(-5i32) as u32, 7])),
            (33, 0.25f32.to_be_bytes().to_vec()),
            (7, numbers(&[30])),
            (11, numbers(&[0])),
            (28, numbers(&[1])),
            (21, parasites(&[("other", b"x"), ("quadratura-layer", b"tok\0")])),
        ],
        mask: Some(noise(1)),
        ..Layer::new("masked", SIZE, 1, noise(4))
    };
    let floating =
        Layer { properties: vec![(5, numbers(&[0, 99]))], ..Layer::new("Floating", (3, 2), 1, vec![1; 24]) };
    let grey = Layer::new("bottom", SIZE, 0, noise(3));
    let image = parasites(&[("icc-profile", &[7; 140]), ("quadratura-key", b"the key")]);
    let layers = vec![floating, group, masked, grey];
    File { coding: Coding::Zlib, properties: vec![(21, image), (99, vec![1, 2, 3])], ..File::new(14, layers) }
}

#[test]
fn every_version_and_coding_gives_the_same_pixels() {
    for version in (0..=14).filter(|version| *version != 4) {
        for coding in [Coding::Raw, Coding::Rle, Coding::Zlib] {
            let layer = Layer::new("Säule", SIZE, 1, noise(4));
            let document = read(&File { coding, ..File::new(version, vec![layer]) });
            assert_eq!((document.depth, document.notes.len()), (Depth::Eight, 0), "{:?}", document.notes);
            assert_eq!(document.layers[0].name, "Säule");
            assert_eq!(bytes(&document.layers[0]), noise(4), "version {version}, {coding:?}");
        }
    }
}

#[test]
fn groups_masks_parasites_and_the_rest_are_told() {
    let document = read(&everything());
    let [bottom, masked] = &document.layers[..] else { panic!("{:?}", document.layers) };
    assert_eq!((document.key.as_deref(), document.icc.clone()), (Some("the key"), Some(vec![7; 140])));
    assert_eq!((bottom.name.as_str(), bottom.groups.len(), bottom.id.clone()), ("bottom", 0, None));
    assert_eq!(
        (masked.groups.clone(), masked.hidden_by_group, masked.visible),
        (vec!["group".into()], true, true)
    );
    assert_eq!(
        (masked.id.as_deref(), masked.locked, masked.opacity),
        (Some("tok"), true, 0.25 * 128.0 / 255.0)
    );
    assert_eq!((masked.rect.x, masked.rect.y), (-5, 7));
    assert_eq!(masked.blend, BlendMode::Other("multiply".into()));
    let mask = masked.masks.first().unwrap();
    assert_eq!((mask.enabled, mask.rect), (false, masked.rect));
    assert_eq!(mask.pixels.read().unwrap().samples(), &Samples::U8(noise(1)));
    let said = document.notes.join("; ");
    assert!(said.contains("\"Floating\" is a floating selection"), "{said}");
}

#[test]
fn the_key_of_a_psd_that_gimp_saved_as_xcf_is_found_in_its_metadata() {
    let xml = b"<?xml version='1.0' encoding='UTF-8'?>\n<metadata>\n  <tag name=\"Exif.Image.Orientation\">1</tag>\n  \
        <tag name=\"Xmp.dc.identifier\">k&amp;1</tag>\n</metadata>\n\0";
    let key = |list: &[(&str, &[u8])]| {
        let layers = vec![Layer::new("a", (1, 1), 1, vec![0; 4])];
        read(&File { properties: vec![(21, parasites(list))], ..File::new(11, layers) }).key
    };
    assert_eq!(key(&[("gimp-image-metadata", xml)]), Some("k&1".into()));
    assert_eq!(key(&[("quadratura-key", b"ours"), ("gimp-image-metadata", xml)]), Some("ours".into()));
    assert_eq!(key(&[("gimp-image-metadata", b"<broken")]), None);
}

#[test]
fn rgb_grey_and_indexed_become_rgba() {
    let of = |model, kind, pixels: Vec<u8>| {
        let properties = vec![(1, [numbers(&[2]), vec![10, 20, 30, 40, 50, 60]].concat())];
        let layer = Layer::new("a", (2, 1), kind, pixels);
        bytes(&read(&File { model, properties, ..File::new(3, vec![layer]) }).layers[0])
    };
    assert_eq!(of(0, 0, vec![1, 2, 3, 4, 5, 6]), [1, 2, 3, 255, 4, 5, 6, 255]);
    assert_eq!(of(1, 2, vec![7, 8]), [7, 7, 7, 255, 8, 8, 8, 255]);
    assert_eq!(of(1, 3, vec![7, 0, 8, 99]), [7, 7, 7, 0, 8, 8, 8, 99]);
    assert_eq!(of(2, 4, vec![1, 0]), [40, 50, 60, 255, 10, 20, 30, 255]);
    assert_eq!(of(2, 5, vec![1, 255, 200, 0]), [40, 50, 60, 255, 0, 0, 0, 0]);
}

#[test]
fn the_wrong_length_that_old_versions_gave_a_colour_map_does_no_harm() {
    let layer = Layer::new("a", (1, 1), 4, vec![1]);
    let properties = vec![(1, [numbers(&[2]), vec![10, 20, 30, 40, 50, 60]].concat())];
    let mut file = File { model: 2, properties, ..File::new(1, vec![layer]) }.bytes();
    let at = file.windows(8).position(|window| window == numbers(&[1, 10])).unwrap();
    file[at + 7] = 6;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.xcf");
    std::fs::write(&path, file).unwrap();
    assert_eq!(bytes(&read_layered(&path).unwrap().layers[0]), [40, 50, 60, 255]);
}

#[test]
fn sixteen_bits_are_read_in_either_order_of_bytes() {
    let pixels: Vec<u16> = (0..4 * PIXELS as u32).map(|i| (i * 40_503) as u16).collect();
    for (version, bytes) in [(7, u16::to_le_bytes as fn(u16) -> [u8; 2]), (12, u16::to_be_bytes)] {
        let stored = pixels.iter().flat_map(|sample| bytes(*sample)).collect();
        let layer = Layer::new("a", SIZE, 1, stored);
        let document = read(&File { precision: 250, sample: 2, ..File::new(version, vec![layer]) });
        assert_eq!((document.depth, document.notes.len()), (Depth::Sixteen, 0));
        assert_eq!(words(&document.layers[0]), pixels);
    }
}

#[test]
fn light_and_floating_point_are_converted_and_said() {
    let half = 0.214_041_14f32; // the light of half the range of sRGB
    let pixel: Vec<u8> = [half, 0.0, 2.0, half].iter().flat_map(|value| value.to_be_bytes()).collect();
    let layer = Layer { mask: Some(half.to_be_bytes().to_vec()), ..Layer::new("a", (1, 1), 1, pixel) };
    let document = read(&File { precision: 600, sample: 4, ..File::new(12, vec![layer]) });
    let found = words(&document.layers[0]);
    assert!(found[0].abs_diff(32768) <= 1, "{found:?}");
    assert_eq!(found[1..], [0, 65535, (half * 65535.0).round() as u16], "alpha has no tone curve");
    let mask = document.layers[0].masks.first().unwrap().pixels.read().unwrap();
    assert_eq!(mask.samples(), &Samples::U16(vec![found[3]]), "nor has a mask");
    assert!(document.notes[0].contains("floating-point linear-light"), "{:?}", document.notes);
}

#[test]
fn a_newer_version_is_read_and_said() {
    let document = read(&File::new(23, vec![Layer::new("a", SIZE, 1, noise(4))]));
    assert_eq!(bytes(&document.layers[0]), noise(4));
    assert!(document.notes[0].contains("version 23"), "{:?}", document.notes);
    let error = refused(&File::new(101, vec![]));
    assert!(error.contains("v101") && error.contains("export it from GIMP as PSD"), "{error}");
}

#[test]
fn a_layer_with_more_tiles_than_the_file_can_hold_is_refused_before_memory_is_taken() {
    let mut file = File::new(3, vec![Layer::new("a", (2, 1), 1, vec![0; 8])]).bytes();
    let size = numbers(&[2, 1]);
    let places: Vec<usize> = (0..file.len() - 8).filter(|at| file[*at..at + 8] == size).collect();
    assert_eq!(places.len(), 3, "layer, hierarchy, level");
    places.iter().for_each(|at| file[*at..at + 8].copy_from_slice(&numbers(&[1 << 20, 1 << 20])));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.xcf");
    std::fs::write(&path, file).unwrap();
    let error = read_layered(&path).unwrap_err().to_string();
    assert!(error.contains("268435456 tiles in a file of"), "{error}");
}

#[test]
fn a_file_whose_middle_is_lost_is_damaged_and_not_one_without_layers() {
    let told = refused(&File::new(11, vec![]));
    assert!(told.contains("no layers, expected one at least") && told.contains("a.xcf, byte"), "{told}");
}
