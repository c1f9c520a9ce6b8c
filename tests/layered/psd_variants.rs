//! PSD as others write it.

use quadratura::testing::layered_files::{BlendMode, Depth, EditedDocument, EditedLayer, read_layered};
use quadratura::testing::scene::Samples;

use crate::psd_file::{Channel, Coding, File, Layer, unicode};

const RECT: [i32; 4] = [-3, 4, 7, 5];

/// Samples of a channel of RECT, other ones for each number.
fn samples(number: u16, full: u16) -> Vec<u16> {
    (0..35).map(|i: u16| (i * 977 + number * 131) % full).collect()
}

fn channels(coding: Coding, full: u16) -> Vec<Channel> {
    [-1, 0, 1, 2].map(|id: i16| (id, coding, samples((id + 1) as u16, full))).to_vec()
}

fn read(file: &File) -> EditedDocument {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.psd");
    std::fs::write(&path, file.bytes()).unwrap();
    read_layered(&path).unwrap_or_else(|error| panic!("{error}"))
}

fn refused(file: &File) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.psd");
    std::fs::write(&path, file.bytes()).unwrap();
    read_layered(&path).unwrap_err().to_string()
}

fn words(layer: &EditedLayer) -> Vec<u16> {
    match layer.pixels.read().unwrap().samples() {
        Samples::U8(samples) => samples.iter().map(|s| u16::from(*s)).collect(),
        Samples::U16(samples) => samples.clone(),
    }
}

/// R, G, B, A of each pixel of [`channels`].
fn expected(full: u16) -> Vec<u16> {
    let planes = [1, 2, 3, 0].map(|number| samples(number, full));
    (0..35).flat_map(|i| [0, 1, 2, 3].map(|plane: usize| planes[plane][i])).collect()
}

/// One file with all that readers stumble over.
pub fn everything() -> File {
    let masked = Layer {
        mask: Some(([1, 2, 3, 2], 255, 16)),
        mask_data: vec![1, 255],
        blocks: vec![(b"luni", unicode("Maske\0")), (b"lfx2", vec![0; 5])],
        ..Layer::new(
            "masked",
            RECT,
            [channels(Coding::Zip, 256), vec![(-2, Coding::Rle, vec![0, 1, 2, 3, 4, 255])]].concat(),
        )
    };
    let layers = vec![
        Layer::new("raw", RECT, channels(Coding::Raw, 256)),
        Layer::section("</Layer group>", 3),
        Layer { clipping: 1, ..Layer::new("zip", RECT, channels(Coding::Predicted, 256)) },
        masked,
        Layer { blocks: vec![(b"curv", vec![1, 2, 3])], ..Layer::new("curves", [0; 4], vec![]) },
        Layer { flags: 2, opacity: 128, ..Layer::section("group", 1) },
    ];
    File {
        resources: vec![(1039, vec![5; 131]), (1060, b"<x/>".to_vec())],
        padding: 1,
        ..File::new(8, layers)
    }
}

#[test]
fn every_coding_gives_the_same_pixels_in_8_and_16_bits() {
    for coding in [Coding::Raw, Coding::Rle, Coding::Zip, Coding::Predicted] {
        for (depth, bits, full) in [(Depth::Eight, 8, 256), (Depth::Sixteen, 16, u16::MAX)] {
            let document = read(&File::new(bits, vec![Layer::new("a", RECT, channels(coding, full))]));
            assert_eq!(document.depth, depth);
            assert_eq!(<[i64; 4]>::from(document.layers[0].rect), RECT.map(i64::from));
            assert_eq!(words(&document.layers[0]), expected(full), "{coding:?} {bits}");
        }
    }
}

#[test]
fn sixteen_bit_layers_are_found_in_a_block_of_their_own() {
    let layers = vec![Layer::new("a", RECT, channels(Coding::Predicted, u16::MAX))];
    let document = read(&File { in_block: true, ..File::new(16, layers) });
    assert_eq!(words(&document.layers[0]), expected(u16::MAX));
}

#[test]
fn blocks_may_be_padded_or_not() {
    for padding in 0..4 {
        let blocks = vec![(b"lfx2", vec![1]), (b"luni", unicode("Größe")), (b"lspf", vec![0x80, 0, 0, 0])];
        let layer = Layer { blocks, ..Layer::new("short", RECT, channels(Coding::Raw, 256)) };
        let document = read(&File { padding, ..File::new(8, vec![layer]) });
        let found = &document.layers[0];
        assert_eq!((found.name.as_str(), found.locked), ("Größe", true), "{padding} zeros");
    }
}

#[test]
fn a_layer_without_alpha_is_opaque_and_a_grey_one_has_three_equal_channels() {
    let opaque = Layer::new("a", RECT, channels(Coding::Rle, 256)[1..].to_vec());
    let alphas: Vec<u16> =
        words(&read(&File::new(8, vec![opaque])).layers[0]).iter().skip(3).step_by(4).copied().collect();
    assert_eq!(alphas, [255; 35]);
    let grey = Layer::new("a", RECT, channels(Coding::Rle, 256)[..2].to_vec());
    let found = words(&read(&File { mode: 1, ..File::new(8, vec![grey]) }).layers[0]);
    let (value, alpha) = (samples(1, 256), samples(0, 256));
    let expected: Vec<u16> = (0..35).flat_map(|i| [value[i], value[i], value[i], alpha[i]]).collect();
    assert_eq!(found, expected);
}

#[test]
fn a_mask_has_its_own_place_a_value_outside_and_a_switch() {
    let values = vec![0, 1, 2, 3, 4, 255];
    for (flags, enabled, place) in
        [(0, true, [1, 2, 3, 2]), (2, false, [1, 2, 3, 2]), (1, true, [-2, 6, 3, 2])]
    {
        let mut layer = Layer::new("a", RECT, channels(Coding::Raw, 256));
        layer.channels.push((-2, Coding::Zip, values.clone()));
        layer.mask = Some(([1, 2, 3, 2], 51, flags));
        let document = read(&File::new(8, vec![layer]));
        let mask = document.layers[0].masks.first().unwrap();
        assert_eq!((mask.enabled, mask.outside), (enabled, 0.2));
        assert_eq!(<[i64; 4]>::from(mask.rect), place, "flags {flags}: 1 counts from the layer");
        let bytes = values.iter().map(|v| *v as u8).collect();
        assert_eq!(mask.pixels.read().unwrap().samples(), &Samples::U8(bytes));
    }
}

#[test]
fn groups_opacity_blending_and_clipping_are_told() {
    let document = read(&everything());
    let [raw, clipped, masked] = &document.layers[..] else { panic!("{:?}", document.layers) };
    assert_eq!((raw.groups.len(), raw.hidden_by_group), (0, false));
    assert_eq!((clipped.groups.clone(), clipped.hidden_by_group), (vec!["group".into()], true));
    assert_eq!(clipped.blend, BlendMode::Other("clipped to the layer below".into()));
    assert_eq!((masked.name.as_str(), document.icc.as_ref().map(Vec::len)), ("Maske", Some(131)));
    assert_eq!((raw.opacity, clipped.opacity), (1.0, 128.0 / 255.0), "a group's counts");
    for said in ["its layer style", "an adjustment layer"] {
        assert!(document.notes.iter().any(|note| note.contains(said)), "{said}: {:?}", document.notes);
    }
    let blocks = vec![(b"iOpa", vec![51, 0, 0, 0])];
    let multiplied =
        Layer { blend: b"mul ", opacity: 51, blocks, ..Layer::new("a", RECT, channels(Coding::Raw, 256)) };
    let document = read(&File::new(8, vec![multiplied]));
    assert_eq!(document.layers[0].blend, BlendMode::Other("multiply".into()));
    assert!((document.layers[0].opacity - 0.04).abs() < 1e-6);
}

#[test]
fn what_is_not_read_is_refused_with_a_way_out() {
    let layers = || vec![Layer::new("a", RECT, channels(Coding::Raw, 256))];
    for (file, said) in [
        (File { depth: 32, ..File::new(8, layers()) }, "32 bits"),
        (File { mode: 4, ..File::new(8, layers()) }, "CMYK"),
        (File { mode: 9, ..File::new(8, layers()) }, "Lab"),
    ] {
        let error = refused(&file);
        assert!(error.contains(said) && error.contains("convert the image to RGB"), "{error}");
    }
}

#[test]
fn a_flattened_file_says_so() {
    let document = read(&File::new(8, vec![]));
    assert!(document.layers.is_empty() && document.notes[0].contains("flattened"), "{:?}", document.notes);
}

#[test]
fn layers_that_overstep_the_file_are_refused_before_memory_is_taken() {
    let mut layer = Layer::new("a", [0, 0, 300_000, 300_000], channels(Coding::Zip, 256));
    let error = read(&File::new(8, vec![layer.clone()])).layers[0].pixels.read().unwrap_err().to_string();
    assert!(error.contains("expected at least 90000000000"), "{error}");
    layer.channels.iter_mut().for_each(|channel| channel.1 = Coding::Raw);
    assert!(read(&File::new(8, vec![layer])).layers[0].pixels.read().is_err());
    let far = Layer::new("a", [i32::MAX - 7, 0, 7, 5], channels(Coding::Raw, 256));
    assert!(refused(&File::new(8, vec![far])).contains("a rectangle from"));
}
