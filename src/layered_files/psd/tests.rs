//! Reads files back with ag-psd, which shares no code with this writer.

use std::io::Cursor;
use std::sync::Arc;

use ag_psd::psd::{Layer as ReadLayer, Psd as ReadPsd, ReadOptions};

use super::*;
use crate::{Group, LayerNode, PixelLayer, PixelSource, Raster, Tag};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::Samples;

/// Returns pixels that mix long runs, noise and transparency, different for each `seed`.
fn pattern(w: u32, h: u32, seed: u32, depth: Depth) -> Raster {
    let value = |i: u32| match (i / 4 + seed) / 7 % 3 {
        0 => 0,
        1 => i.wrapping_add(seed).wrapping_mul(2_654_435_761),
        _ => 0xd020_d020u32.wrapping_mul(seed + 1),
    };
    let samples = 0..4 * w * h;
    match depth {
        Depth::Eight => Raster::new(w, h, Samples::U8(samples.map(|i| (value(i) >> 24) as u8).collect())),
        Depth::Sixteen => Raster::new(w, h, Samples::U16(samples.map(|i| (value(i) >> 16) as u16).collect())),
    }
}

fn source(rect: PixelRect, seed: u32, depth: Depth) -> PixelSource<'static> {
    Box::new(move || Ok(Arc::new(pattern(rect.w, rect.h, seed, depth))))
}

fn layer(name: &str, rect: [i64; 4], seed: u32, depth: Depth) -> PixelLayer<'static> {
    let rect = rect.into();
    PixelLayer::new(name, rect, source(rect, seed, depth))
}

/// Returns a locked photo below two groups, with layers outside, larger than the canvas, empty, and hidden.
fn document(depth: Depth) -> LayeredDocument<'static> {
    let photo = PixelLayer { locked: true, ..layer("photo", [0, 0, 70, 50], 1, depth) };
    let far = vec![
        layer("wall [aaa]", [-9, -7, 100, 90], 2, depth),
        layer("Säule ö [bbb]", [60, 45, 30, 200], 3, depth),
    ];
    let guide = PixelLayer { visible: false, ..layer("guide", [3, 4, 5, 6], 4, depth) };
    let near =
        vec![PixelLayer { tag: Some(Tag::Green), ..layer("tree [ccc]", [200, 300, 16, 1], 5, depth) }, guide];
    LayeredDocument {
        width: 70,
        height: 50,
        depth,
        icc: Some(b"not a real profile".to_vec()),
        key: "k-<&>".into(),
        title: "a.png".into(),
        nodes: vec![
            LayerNode::Layer(photo),
            LayerNode::Group(Group { name: "order 1".into(), layers: far }),
            LayerNode::Group(Group { name: "order 0".into(), layers: near }),
        ],
        merged: source([0, 0, 70, 50].into(), 1, depth),
    }
}

fn written(document: &LayeredDocument, kind: PsdVariant) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    assert_eq!(write(&mut file, Path::new("test.psd"), document, kind).unwrap(), FormatFit::Whole);
    file.into_inner()
}

fn read(bytes: &[u8]) -> ReadPsd {
    let options = ReadOptions { use_image_data: Some(true), ..ReadOptions::default() };
    ag_psd::reader::read_psd(bytes, &options).expect("ag-psd reads it")
}

fn name(layer: &ReadLayer) -> &str {
    layer.additional_info.name.as_deref().unwrap()
}

/// Checks one layer that was read against one that was written.
fn assert_same(found: &ReadLayer, expected: &PixelLayer) {
    assert_eq!(name(found), expected.name);
    let rect = expected.rect;
    let edges = [found.left, found.top, found.right, found.bottom].map(|edge| edge.unwrap() as i32);
    assert_eq!(edges, [rect.x, rect.y, rect.right(), rect.bottom()], "{}", expected.name);
    assert_eq!(found.hidden.unwrap_or(false), !expected.visible, "{}", expected.name);
    let pixels = (expected.pixels)().unwrap();
    if let Samples::U8(samples) = pixels.samples() {
        assert_eq!(&found.image_data.as_ref().unwrap().data, samples, "{}", expected.name);
    }
}

fn assert_read_back(document: &LayeredDocument, kind: PsdVariant) {
    let psd = read(&written(document, kind));
    assert_eq!((psd.width, psd.height), (f64::from(document.width), f64::from(document.height)));
    assert_eq!(psd.bits_per_channel, Some(f64::from(document.depth.bits())));
    let nodes = psd.children.as_ref().unwrap();
    assert_eq!(nodes.len(), document.nodes.len());
    for (found, expected) in nodes.iter().zip(&document.nodes) {
        match expected {
            LayerNode::Layer(layer) => assert_same(found, layer),
            LayerNode::Group(group) => {
                assert_eq!(name(found), group.name);
                let children = found.children.as_ref().unwrap();
                assert_eq!(children.len(), group.layers.len());
                children.iter().zip(&group.layers).for_each(|(found, layer)| assert_same(found, layer));
            }
        }
    }
}

#[test]
fn an_8_bit_psd_comes_back_layer_by_layer_and_pixel_by_pixel() {
    assert_read_back(&document(Depth::Eight), PsdVariant::Psd);
}

#[test]
fn an_8_bit_psb_comes_back_layer_by_layer_and_pixel_by_pixel() {
    assert_read_back(&document(Depth::Eight), PsdVariant::Psb);
}

#[test]
fn a_16_bit_psd_comes_back_with_names_groups_and_places() {
    assert_read_back(&document(Depth::Sixteen), PsdVariant::Psd);
}

#[test]
fn the_merged_picture_is_the_photo_on_white() {
    let document = document(Depth::Eight);
    let psd = read(&written(&document, PsdVariant::Psd));
    let white = document.merged_pixels().unwrap().on_white();
    let Samples::U8(expected) = white.samples() else { panic!("8 bits") };
    assert_eq!(&psd.image_data.unwrap().data, expected);
}

#[test]
fn profile_key_lock_and_colour_tag_come_back() {
    let bytes = written(&document(Depth::Eight), PsdVariant::Psd);
    let profile = b"8BIM\x04\x0f\0\0\0\0\0\x12not a real profile";
    assert!(bytes.windows(profile.len()).any(|window| window == profile), "ag-psd skips resource 1039");
    let psd = read(&bytes);
    let xmp = psd.image_resources.unwrap().xmp_metadata.unwrap();
    let xml = roxmltree::Document::parse(xmp.trim_start_matches('\u{feff}')).unwrap();
    let identifier = xml.descendants().find(|node| node.has_tag_name("identifier")).unwrap();
    assert_eq!(identifier.text(), Some("k-<&>"));
    let nodes = psd.children.unwrap();
    assert_eq!(nodes[0].transparency_protected, Some(true));
    let tree = &nodes[2].children.as_ref().unwrap()[0];
    assert_eq!(tree.additional_info.layer_color, Some(ag_psd::psd::LayerColor::Green));
}

#[test]
fn same_document_same_bytes_whatever_the_number_of_threads() {
    let document = document(Depth::Eight);
    let here = written(&document, PsdVariant::Psd);
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one_thread.install(|| written(&document, PsdVariant::Psd)), here);
}

#[test]
fn a_file_that_grows_too_large_for_its_kind_is_given_up() {
    let document = document(Depth::Eight);
    let size = written(&document, PsdVariant::Psd).len() as u64;
    let within = |largest| {
        write_within(Cursor::new(Vec::new()), Path::new("a"), &document, PsdVariant::Psd, largest).unwrap()
    };
    assert_eq!(within(size), FormatFit::Whole);
    assert_eq!(within(size - 1), FormatFit::TooLarge, "known in the end");
    assert_eq!(within(1000), FormatFit::TooLarge, "known on the way");
}

#[test]
fn a_side_of_more_than_30_000_pixels_makes_it_a_psb() {
    let mut document = document(Depth::Eight);
    assert_eq!(PsdVariant::to_try_first(&document), PsdVariant::Psd);
    document.width = 30_001;
    assert_eq!(PsdVariant::to_try_first(&document), PsdVariant::Psb);
}

#[test]
fn a_source_that_fails_fails_the_file() {
    let mut document = document(Depth::Eight);
    let LayerNode::Layer(photo) = &mut document.nodes[0] else { panic!("the photo") };
    photo.pixels = Box::new(|| Err(Error::Cancelled));
    let result = write(Cursor::new(Vec::new()), Path::new("a"), &document, PsdVariant::Psd);
    assert!(matches!(result, Err(Error::Cancelled)));
}

#[test]
fn a_full_disk_is_an_error_that_names_the_file() {
    let mut small = [0u8; 5000];
    let result =
        write(Cursor::new(&mut small[..]), Path::new("full.psd"), &document(Depth::Eight), PsdVariant::Psd);
    assert!(result.unwrap_err().to_string().contains("full.psd"));
}
