//! Tests of see-through layers laid over what is behind them.

use super::*;
use crate::content::PixelSpan;
use crate::fill::HiddenSpan;
use quadratura_base::raster::Image;
use quadratura_base::scene::Samples;
use quadratura_base::scene::synthetic::Rng;

const OWN: PhotoId = PhotoId(3);
const OTHER: FillOrigin = FillOrigin::Photo(PhotoId(1));

fn region(surface: u32, layer: u32, width: u32) -> Region {
    let span = PixelSpan { y: 0, x0: 0, x1: width };
    Region {
        surface: FillSurfaceId(surface),
        spans: vec![HiddenSpan { span, layer: LayerIndex(layer), first: 0 }],
    }
}

fn filled(surface: u32, layer: u32, colours: &[[u8; 3]]) -> FilledRegion {
    let texel = |colour: &[u8; 3]| FilledTexel {
        rgb: colour.map(|value| u16::from(value) * 257),
        confidence: 100,
        origin: OTHER,
    };
    let region = region(surface, layer, colours.len() as u32);
    FilledRegion { region, texels: colours.iter().map(texel).collect() }
}

fn photo(colours: &[[u8; 3]]) -> PhotoPixels {
    let samples = Samples::U8(colours.as_flattened().to_vec());
    PhotoPixels { width: colours.len() as u32, height: 1, channels: 3, samples, icc: None }
}

fn layer(layer: u32, surface: u32, visible: bool, width: u32) -> SeeThroughLayer {
    let rect = PixelRect::of_size(width, 1);
    let (surfaces, visible) =
        (vec![Some(FillSurfaceId(surface)); width as usize], vec![visible; width as usize]);
    SeeThroughLayer { layer: LayerIndex(layer), rect, surfaces, visible }
}

fn matte(texels: &[[u8; 4]]) -> Matte {
    let rect = PixelRect::of_size(texels.len() as u32, 1);
    let (texels, known) = (Image::new(rect, texels.to_vec()), Image::filled(rect, Known::Found));
    Matte { object: "tree".into(), texels, known }
}

/// The colour of a mixture in linear light, encoded with 8 bits.
fn mixed(front: [u16; 3], alpha: u8, back: [u16; 3]) -> [f64; 3] {
    let alpha = f64::from(alpha) / 255.0;
    [0, 1, 2].map(|c| 255.0 * srgb_from_linear(alpha * light(front[c]) + (1.0 - alpha) * light(back[c])))
}

#[test]
fn what_is_seen_through_is_the_photos_own_pixel_and_what_is_solid_stays() {
    let pixels = photo(&[[10, 20, 30], [40, 50, 60]]);
    let own = matte(&[[9, 9, 9, 0], [40, 50, 60, 255]]);
    let mattes = BTreeMap::from([(FillSurfaceId(0), &own)]);
    let tree = SeeThroughPhoto { photo: OWN, pixels: &pixels, mattes, layers: vec![layer(0, 0, true, 2)] };
    let wall = filled(5, 1, &[[1, 1, 1], [2, 2, 2]]);
    let mut filling = PhotoFilling { regions: vec![wall.clone()], ..PhotoFilling::default() };
    let counts = tree.lay_over(&mut filling, Vec::new());
    assert_eq!(counts, MattePixels { shown: 2, ..MattePixels::default() });
    let [seen, hidden] = filling.regions[0].texels[..] else { panic!("two texels") };
    let rgb = [10, 20, 30].map(|value: u16| value * 257);
    // One of six steps from what is solid.
    assert_eq!(seen, FilledTexel { rgb, confidence: 43, origin: FillOrigin::Photo(OWN) });
    assert_eq!(hidden, wall.texels[1]);
    assert_eq!(
        (&filling.mattes[0].matte[..], &filling.mattes[0].foreground[..]),
        (&[0, 255][..], &[None; 2][..])
    );
}

#[test]
fn what_is_seen_through_is_fully_trusted_far_from_what_is_shown_of_the_surface() {
    let pixels = photo(&[[10, 20, 30]; 9]);
    let mut texels = [[9, 9, 9, 0]; 9];
    (texels[0], texels[1]) = ([10, 20, 30, 255], [9, 9, 9, 128]);
    let own = matte(&texels);
    let mattes = BTreeMap::from([(FillSurfaceId(0), &own)]);
    let tree = SeeThroughPhoto { photo: OWN, pixels: &pixels, mattes, layers: vec![layer(0, 0, true, 9)] };
    let mut filling =
        PhotoFilling { regions: vec![filled(5, 1, &[[1, 1, 1]; 9])], ..PhotoFilling::default() };
    tree.lay_over(&mut filling, Vec::new());
    let confidence: Vec<u8> = filling.regions[0].texels.iter().map(|texel| texel.confidence).collect();
    assert_eq!(confidence[1], MIXED);
    assert_eq!(confidence[2..], [43, 85, 128, 170, 213, 255, 255]);
}

#[test]
fn a_matte_counts_as_1_where_nothing_behind_is_filled() {
    let pixels = photo(&[[10, 20, 30], [40, 50, 60]]);
    let own = matte(&[[9, 9, 9, 0], [9, 9, 9, 100]]);
    let mattes = BTreeMap::from([(FillSurfaceId(0), &own)]);
    let tree = SeeThroughPhoto { photo: OWN, pixels: &pixels, mattes, layers: vec![layer(0, 0, true, 2)] };
    let mut filling = PhotoFilling { surroundings: None, ..PhotoFilling::default() };
    tree.lay_over(&mut filling, Vec::new());
    assert_eq!(
        (&filling.mattes[0].matte[..], &filling.mattes[0].foreground[..]),
        (&[255; 2][..], &[None; 2][..])
    );
}

#[test]
fn mixtures_give_the_photo_back_to_3_of_255_wherever_colours_in_range_can() {
    let mut rng = Rng::new(11);
    let mut byte = |low: u32, high: u32| (low + (rng.between(0.0, 1.0) * f64::from(high - low)) as u32) as u8;
    let count = 4000;
    let mut of =
        |low, high| -> Vec<[u8; 3]> { (0..count).map(|_| [0; 3].map(|_| byte(low, high))).collect() };
    let (fronts, backs, errors) = (of(20, 120), of(60, 220), of(0, 30));
    let alphas: Vec<u8> = of(8, 247).iter().map(|value| value[0]).collect();
    // The photo is the mixture, but for an error of matte and colours.
    let seen = |i: usize| {
        let [front, back] = [fronts[i], backs[i]].map(|colour| colour.map(|value| u16::from(value) * 257));
        let mixed = mixed(front, alphas[i], back);
        [0, 1, 2].map(|c| (mixed[c] + f64::from(errors[i][c]) - 15.0).clamp(0.0, 255.0).round() as u8)
    };
    let seen: Vec<[u8; 3]> = (0..count).map(seen).collect();
    let pixels = photo(&seen);
    let own: Vec<[u8; 4]> = fronts.iter().zip(&alphas).map(|(&[r, g, b], a)| [r, g, b, *a]).collect();
    let own = matte(&own);
    let mattes = BTreeMap::from([(FillSurfaceId(0), &own)]);
    let layers = vec![layer(0, 0, true, count as u32)];
    let tree = SeeThroughPhoto { photo: OWN, pixels: &pixels, mattes, layers };
    let mut filling =
        PhotoFilling { surroundings: Some(filled(u32::MAX, 1, &backs)), ..PhotoFilling::default() };
    let counts = tree.lay_over(&mut filling, Vec::new());
    assert_eq!(counts.mixed, count as u64);
    let texels = &filling.surroundings.as_ref().unwrap().texels;
    let mut off_by_more = 0;
    for i in 0..count {
        let front = filling.mattes[0].foreground[i].expect("each is a mixture");
        let back = mixed(front, alphas[i], texels[i].rgb);
        let off = (0..3).map(|c| (back[c] - f64::from(seen[i][c])).abs()).fold(0.0, f64::max);
        off_by_more += u64::from(off > 3.0);
    }
    assert_eq!(counts.clipped, off_by_more, "what is not given back is counted");
    assert!(off_by_more * 100 <= count as u64, "{off_by_more}");
    // Filling again what is there, with the matte that was found, is what `corrected` prevents for these surfaces.
    assert_eq!(tree.mixed_surfaces([&region(7, 1, 1)].into_iter()), [FillSurfaceId(7)]);
}

#[test]
fn through_one_tree_the_photo_shows_the_next_one_with_its_own_matte() {
    let pixels = photo(&[[10, 20, 30], [40, 50, 60], [70, 80, 90]]);
    let front = matte(&[[9, 9, 9, 0], [9, 9, 9, 0], [9, 9, 9, 0]]);
    let second = matte(&[[9, 9, 9, 255], [9, 9, 9, 0], [60, 70, 80, 128]]);
    let mattes = BTreeMap::from([(FillSurfaceId(0), &front), (FillSurfaceId(1), &second)]);
    let layers = vec![layer(0, 0, true, 3), layer(1, 1, false, 3)];
    let trees = SeeThroughPhoto { photo: OWN, pixels: &pixels, mattes, layers };
    let wall = filled(5, 2, &[[1, 1, 1], [2, 2, 2], [80, 90, 99]]);
    let mut filling = PhotoFilling { regions: vec![wall], ..PhotoFilling::default() };
    // No other photo knows anything of the second tree.
    let mut hidden = filled(1, 1, &[[0; 3]; 3]);
    hidden.texels.iter_mut().for_each(|texel| texel.confidence = 0);
    let counts = trees.lay_over(&mut filling, vec![MattedRegion { filled: hidden, mattes: vec![0; 3] }]);
    assert_eq!((counts.mixed, counts.clipped), (1, 0));
    assert_eq!(filling.mattes[0].matte, [0; 3]);
    assert_eq!(filling.mattes[1].matte, [255, 0, 128]);
    let own = |x: usize| {
        let [r, g, b] = [[10, 20, 30], [40, 50, 60], [70, 80, 90]][x];
        [r, g, b].map(|value: u16| value * 257)
    };
    let [tree, wall] = &filling.regions[..] else {
        panic!("the tree's region was added: {:?}", filling.regions)
    };
    assert_eq!((tree.region.surface, wall.region.surface), (FillSurfaceId(1), FillSurfaceId(5)));
    assert_eq!(tree.texels[0].rgb, own(0));
    assert_eq!(wall.texels[0].confidence, 100, "the tree hides it");
    assert_eq!((wall.texels[1].rgb, wall.texels[1].confidence), (own(1), 255));
    let given_back = mixed(tree.texels[2].rgb, 128, wall.texels[2].rgb);
    let expected = [70.0, 80.0, 90.0];
    assert!((0..3).all(|c| (given_back[c] - expected[c]).abs() <= 3.0), "{given_back:?}");
}

#[test]
fn hidden_texels_that_no_photo_knows_stay_empty() {
    let pixels = photo(&[[0; 3]; 3]);
    let tree = SeeThroughPhoto {
        photo: OWN,
        pixels: &pixels,
        mattes: BTreeMap::new(),
        layers: vec![layer(0, 0, false, 3)],
    };
    let mut hidden = filled(0, 0, &[[1; 3], [2; 3], [3; 3]]);
    hidden.texels[1].confidence = 0;
    let mut filling = PhotoFilling::default();
    tree.lay_over(&mut filling, vec![MattedRegion { filled: hidden, mattes: vec![20, 0, 255] }]);
    let filled = &filling.regions[0];
    assert_eq!(filled.texels.iter().map(|texel| texel.rgb[0] / 257).collect::<Vec<_>>(), [1, 3]);
    assert_eq!(filled.region.pixels().collect::<Vec<_>>(), [(0, 0), (2, 0)]);
    assert_eq!(filling.mattes[0].matte[0], 20);
}

#[test]
fn where_nobody_knows_what_is_behind_the_surface_is_solid_and_marked() {
    let pixels = photo(&[[10, 20, 30], [40, 50, 60]]);
    let mut own = matte(&[[10, 20, 30, 255], [40, 50, 60, 255]]);
    own.known.pixels_mut()[1] = Known::Unknown;
    let mattes = BTreeMap::from([(FillSurfaceId(0), &own)]);
    let tree = SeeThroughPhoto { photo: OWN, pixels: &pixels, mattes, layers: vec![layer(0, 0, true, 2)] };
    let mut filling = PhotoFilling { regions: vec![filled(5, 1, &[[1; 3]; 2])], ..PhotoFilling::default() };
    tree.lay_over(&mut filling, Vec::new());
    assert_eq!(
        (&filling.mattes[0].matte[..], &filling.mattes[0].unknown[..]),
        (&[255; 2][..], &[false, true][..])
    );
}

#[test]
fn paint_of_other_photos_stays_behind_leaves_and_between_them() {
    let pixels = photo(&[[10, 20, 30], [40, 50, 60]]);
    let own = matte(&[[9, 9, 9, 0], [30, 40, 50, 200]]);
    let mattes = BTreeMap::from([(FillSurfaceId(0), &own)]);
    let tree = SeeThroughPhoto { photo: OWN, pixels: &pixels, mattes, layers: vec![layer(0, 0, true, 2)] };
    let mut wall = filled(5, 1, &[[200, 0, 0]; 2]);
    wall.texels.iter_mut().for_each(|texel| texel.origin = FillOrigin::Painted(PhotoId(1)));
    let mut filling = PhotoFilling { regions: vec![wall.clone()], ..PhotoFilling::default() };
    tree.lay_over(&mut filling, Vec::new());
    assert_eq!(filling.regions[0], wall);
    assert_eq!(filling.mattes[0].matte, [0, 200]);
    assert_eq!(filling.own_texels(OWN), 0);
}

#[test]
fn a_mixture_before_another_tree_gives_the_photo_back() {
    // The photo shows a dark leaf half before the bright wall; another photo says that a second tree is between them.
    let front = [20, 30, 10];
    let (wall, half) = ([200, 190, 180], 128);
    let seen = mixed(front.map(|value| value * 257), half, wall.map(|value| value * 257));
    let pixels = photo(&[seen.map(|value| value.round() as u8)]);
    let own = matte(&[[20, 30, 10, half]]);
    let mattes = BTreeMap::from([(FillSurfaceId(0), &own)]);
    let layers = vec![layer(0, 0, true, 1), layer(1, 1, false, 1)];
    let trees = SeeThroughPhoto { photo: OWN, pixels: &pixels, mattes, layers };
    let behind = filled(5, 2, &[wall.map(|value| value as u8)]);
    let mut filling = PhotoFilling { regions: vec![behind], ..PhotoFilling::default() };
    let second = MattedRegion { filled: filled(1, 1, &[[5, 5, 5]]), mattes: vec![255] };
    let counts = trees.lay_over(&mut filling, vec![second]);
    assert_eq!((counts.mixed, counts.clipped), (1, 0));
    assert_eq!((filling.mattes[0].matte[0], filling.mattes[1].matte[0]), (half, 0));
    let given_back = mixed(filling.mattes[0].foreground[0].unwrap(), half, filling.regions[1].texels[0].rgb);
    assert!((0..3).all(|c| (given_back[c] - seen[c]).abs() <= 3.0), "{given_back:?}, {seen:?}");
}
