//! Parameters beside the pixels of a PSD: density and feather of masks, Blend If, vector masks, layers that the editor
//! draws.

use quadratura::testing::layered_files::{
    BlendMode, EditedDocument, EditedLayer, StoredColours, read_layered,
};
use quadratura::testing::scene::Samples;

use crate::psd_file::{Coding, File, Layer};

const RECT: [i32; 4] = [2, 3, 4, 2];
/// The mask lets these values through, in two rows of three from (3, 3).
const MASK: [u16; 6] = [0, 51, 102, 153, 204, 255];

fn read(file: &File) -> EditedDocument {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.psd");
    std::fs::write(&path, file.bytes()).unwrap();
    read_layered(&path).unwrap()
}

fn plain(name: &'static str) -> Layer {
    Layer::new(name, RECT, [-1, 0, 1, 2].map(|id| (id, Coding::Raw, vec![200; 8])).to_vec())
}

/// A layer with a mask with these flags and data behind them.
fn masked(flags: u8, data: &[u8]) -> Layer {
    let mut layer = plain("wall");
    layer.channels.push((-2, Coding::Raw, MASK.to_vec()));
    Layer { mask: Some(([3, 3, 3, 2], 51, flags)), mask_data: data.to_vec(), ..layer }
}

/// What the first mask lets through: its values and that outside.
fn shown(layer: &EditedLayer) -> Result<(Vec<u8>, u8), String> {
    let mask = &layer.masks[0];
    let grey = mask.pixels.read().map_err(|error| error.to_string())?;
    let Samples::U8(values) = grey.samples() else { panic!("8 bits") };
    Ok((values.clone(), (mask.outside * 255.0).round() as u8))
}

fn first(layer: Layer) -> EditedLayer {
    read(&File::new(8, vec![layer])).layers.remove(0)
}

#[test]
fn a_density_lets_through_what_a_mask_hides() {
    let plain: Vec<u8> = MASK.iter().map(|value| *value as u8).collect();
    assert_eq!(shown(&first(masked(0, &[0, 0]))).unwrap(), (plain.clone(), 51));
    // A fifth of the density: a fifth of what is hidden remains hidden.
    let density = |density: u8| first(masked(16, &[1, density, 0, 0]));
    for (parameter, expected, outside) in
        [(0, vec![255; 6], 255), (255, plain.clone(), 51), (51, vec![204, 214, 224, 235, 245, 255], 214)]
    {
        assert_eq!(shown(&density(parameter)).unwrap(), (expected, outside), "density {parameter}");
    }
    // Inverted masks are inverted first.
    let inverted = first(masked(16 | 4, &[1, 0, 0, 0]));
    assert_eq!(shown(&inverted).unwrap(), (vec![255; 6], 255));
}

#[test]
fn a_feather_is_refused_by_name_unless_the_mask_is_off() {
    let mut feather = vec![2];
    feather.extend(7.25f64.to_be_bytes());
    let found = shown(&first(masked(16, &feather))).unwrap_err();
    assert!(found.contains("feather of 7.2 pixels") && found.contains("\"wall\""), "{found}");
    assert!(!first(masked(16 | 2, &feather)).masks[0].enabled);
    let mut none = vec![2];
    none.extend(0f64.to_be_bytes());
    assert!(shown(&first(masked(16, &none))).is_ok(), "a feather of nothing");
}

#[test]
fn parameters_of_a_vector_mask_count_where_there_is_one() {
    let mut of_vector = vec![4 | 8, 100];
    of_vector.extend(3f64.to_be_bytes());
    assert!(shown(&first(masked(16, &of_vector))).is_ok(), "the layer has no vector mask");
    let with_vector_mask = |disabled: u8| {
        let blocks = vec![(b"vmsk", vec![0, 0, 0, 3, 0, 0, 0, disabled])];
        first(Layer { blocks, ..masked(16, &of_vector) })
    };
    let found = shown(&with_vector_mask(0)).unwrap_err();
    assert!(found.contains("of its vector mask") && found.contains("a density of 39 %"), "{found}");
    assert!(shown(&with_vector_mask(4)).is_ok(), "it is disabled");
    let drawn = shown(&first(masked(16 | 8, &of_vector))).unwrap_err();
    assert!(drawn.contains("vector mask"), "{drawn}");
}

#[test]
fn parameters_stand_before_or_behind_the_place_of_the_other_mask() {
    let real = |values: [u16; 6], data: Vec<u8>| {
        let mut layer = masked(16, &data);
        layer.channels.push((-3, Coding::Raw, values.to_vec()));
        first(layer)
    };
    // Flags, outside, top, left, bottom, right.
    let mut place = vec![0, 255];
    [3i32, 3, 5, 6].iter().for_each(|edge| place.extend(edge.to_be_bytes()));
    let parameters = [1, 255];
    for data in [[&place[..], &parameters].concat(), [&parameters[..], &place].concat()] {
        let layer = real([255, 0, 255, 0, 255, 0], data);
        let (values, outside) = shown(&layer).unwrap();
        assert_eq!((values, outside), (MASK.iter().map(|value| *value as u8).collect(), 51));
        let other = layer.masks[0].lowest_with.as_ref().unwrap();
        let grey = other.pixels.read().unwrap();
        assert_eq!(grey.samples(), &Samples::U8(vec![255, 0, 255, 0, 255, 0]));
        assert_eq!((other.rect, other.outside), (layer.masks[0].rect, 1.0));
    }
}

#[test]
fn a_mask_of_a_group_has_its_density_too() {
    let mut end = Layer::section("</group>", 3);
    let mut start = Layer::section("group", 1);
    start.channels.push((-2, Coding::Raw, MASK.to_vec()));
    (start.mask, start.mask_data) = (Some(([3, 3, 3, 2], 0, 16)), vec![1, 0]);
    end.rect = [0; 4];
    let document = read(&File::new(8, vec![end, plain("wall"), start]));
    assert_eq!(shown(&document.layers[0]).unwrap(), (vec![255; 6], 255));
}

#[test]
fn blend_if_knockout_and_channels_that_are_off_are_named_with_the_mode() {
    let of = |ranges: [u8; 8], blend: &'static [u8; 4], blocks| {
        first(Layer { ranges: ranges.to_vec(), blend, blocks, ..plain("wall") }).blend
    };
    let (all, below) = ([0, 0, 255, 255, 0, 0, 255, 255], [0, 0, 255, 255, 0, 0, 90, 140]);
    assert_eq!(of(all, b"norm", vec![]), BlendMode::Normal);
    assert_eq!(of([0; 8], b"norm", vec![]), BlendMode::Normal, "as some writers leave it");
    assert_eq!(of(below, b"norm", vec![]), BlendMode::Other("normal with Blend If".into()));
    assert_eq!(of(below, b"mul ", vec![]), BlendMode::Other("multiply with Blend If".into()));
    let knockout = vec![(b"knko", vec![1, 0, 0, 0]), (b"brst", vec![])];
    assert_eq!(of(all, b"norm", knockout), BlendMode::Other("normal with knockout".into()));
}

#[test]
fn layers_that_the_editor_draws_are_told_and_grey_is_known() {
    let blocks = vec![(b"SoLd", vec![0; 4])];
    let document = read(&File::new(8, vec![Layer { blocks, ..plain("sign") }]));
    assert!(
        document.notes.iter().any(|note| note.contains("\"sign\" is a smart object")),
        "{:?}",
        document.notes
    );
    assert_eq!(document.layers[0].colours, StoredColours::Full);
    let grey =
        Layer { channels: vec![(-1, Coding::Raw, vec![255; 8]), (0, Coding::Raw, vec![9; 8])], ..plain("a") };
    assert_eq!(read(&File { mode: 1, ..File::new(8, vec![grey]) }).layers[0].colours, StoredColours::Grey);
}

#[test]
fn what_is_not_read_of_a_group_is_told_like_that_of_a_layer() {
    let of = |start: Layer| {
        let (end, start) = (Layer::section("</group>", 3), Layer { name: "towers", ..start });
        let document = read(&File::new(8, vec![end, plain("wall"), start]));
        (document.notes, document.layers.into_iter().next().unwrap())
    };
    let with = |blocks: Vec<(&'static [u8; 4], Vec<u8>)>| {
        let mut start = Layer::section("towers", 1);
        start.blocks.extend(blocks);
        of(start)
    };
    let (notes, _) = with(vec![(b"vmsk", vec![0, 0, 0, 3, 0, 0, 0, 0])]);
    assert!(notes.iter().any(|note| note == "group \"towers\": its vector mask is not applied"), "{notes:?}");
    let (notes, _) = with(vec![(b"vmsk", vec![0, 0, 0, 3, 0, 0, 0, 4])]);
    assert!(notes.is_empty(), "it is disabled: {notes:?}");
    let (notes, _) = with(vec![(b"lfx2", vec![0; 8])]);
    assert!(notes.iter().any(|note| note.contains("group \"towers\": its layer style")), "{notes:?}");
    let (notes, _) = with(vec![(b"artb", vec![0; 8])]);
    assert!(notes.iter().any(|note| note.contains("artboard are not applied")), "{notes:?}");
    let (notes, layer) = with(vec![(b"iOpa", vec![51, 0, 0, 0])]);
    assert!(notes.is_empty() && (layer.opacity - 0.2).abs() < 1e-6, "{notes:?} {}", layer.opacity);
    let (_, layer) = of(Layer { clipping: 1, ..Layer::section("towers", 1) });
    let clipped = "clipped to the layer below with its group \"towers\"".to_owned();
    assert_eq!(layer.blend, BlendMode::Other(clipped));
}
