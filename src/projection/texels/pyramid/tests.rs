//! Tests of pyramids against plain means over the photo's own texels.

use super::*;
use quadratura_base::scene::synthetic::Rng;

/// Makes a layer texture in which half of the needed texels have content: blots of random colours with holes between
/// them.
pub fn random_texture(rect: PixelRect, rng: &mut Rng) -> LayerTexturePixels {
    let blots: Vec<[f64; 3]> = (0..4)
        .map(|_| [rng.unit() * f64::from(rect.w), rng.unit() * f64::from(rect.h), rng.between(1.0, 40.0)])
        .collect();
    let mut pixels = LayerTexturePixels { rect, rgba: Vec::new(), needed: Vec::new(), matte: None };
    for (y, x) in (0..rect.h).flat_map(|y| (0..rect.w).map(move |x| (f64::from(y), f64::from(x)))) {
        let needed = blots.iter().any(|[bx, by, r]| (x - bx).hypot(1.5 * (y - by)) < *r);
        let visible = needed && (x / 7.0).sin() + (y / 5.0).cos() > -0.7;
        let colour = rng.bits().to_le_bytes();
        let texel = if visible { [colour[0], colour[1], colour[2], 255] } else { [9, 9, 9, 0] };
        pixels.rgba.extend(texel);
        pixels.needed.push(u8::from(needed));
    }
    pixels
}

fn uniform(rect: PixelRect, colour: [u8; 3], holds: impl Fn(i32, i32) -> bool) -> LayerTexturePixels {
    let mut pixels = LayerTexturePixels { rect, rgba: Vec::new(), needed: Vec::new(), matte: None };
    for (y, x) in (rect.y..rect.bottom()).flat_map(|y| (rect.x..rect.right()).map(move |x| (y, x))) {
        let [r, g, b] = colour;
        pixels.rgba.extend(if holds(x, y) { [r, g, b, 255] } else { [0, 255, 0, 0] });
        pixels.needed.push(1);
    }
    pixels
}

fn texel(level: &Level, x: i32, y: i32) -> [u8; 4] {
    let inside = level.rect.contains(x, y);
    let at = level.index(x.max(level.rect.x), y.max(level.rect.y));
    if inside { level.rgba[at..at + 4].try_into().expect("four bytes") } else { [0; 4] }
}

fn holds(spans: &Spans, x: i32, y: i32) -> bool {
    spans.row(y).iter().any(|run| run.contains(&x))
}

const SQUARE: PixelRect = PixelRect { x: -20, y: 30, w: 64, h: 64 };

#[test]
fn one_colour_stays_that_colour_at_every_level_and_two_texels_beyond() {
    let pixels = uniform(SQUARE, [200, 30, 7], |x, y| (x * x + y * 3 + x * y) % 5 < 2 && x > -9);
    let pyramid = pyramid(SQUARE, &pixels, &PyramidOptions::default());
    assert_eq!(pyramid.levels.len(), 7);
    for level in &pyramid.levels {
        let carried = level.content.grown(2);
        for (y, x) in (-4..70).flat_map(|y| (-4..70).map(move |x| (y, x))) {
            let [r, g, b, confidence] = texel(level, x, y);
            assert_eq!(confidence > 0, holds(&level.content, x, y));
            let colour = if holds(&carried, x, y) { [200, 30, 7] } else { [0; 3] };
            assert_eq!([r, g, b], colour, "{x}, {y} of {:?}", level.rect);
        }
    }
}

#[test]
fn level_0_is_the_photo_bit_for_bit() {
    let rect = PixelRect { w: 40, h: 50, ..SQUARE };
    let pixels = random_texture(rect, &mut Rng::new(4));
    let pyramid = pyramid(SQUARE, &pixels, &PyramidOptions::default());
    assert_eq!(pyramid.covered, pixels.needed.iter().map(|&needed| u64::from(needed)).sum::<u64>());
    for (i, expected) in pixels.rgba.as_chunks::<4>().0.iter().enumerate() {
        let [r, g, b, confidence] = texel(&pyramid.levels[0], i as i32 % 40, i as i32 / 40);
        assert_eq!(confidence > 0, expected[3] > 0);
        assert!(confidence == 0 || [r, g, b] == expected[..3], "texel {i}");
    }
}

#[test]
fn black_and_white_make_half_the_light() {
    let mut pixels = uniform(SQUARE, [255; 3], |_, _| true);
    for (i, texel) in pixels.rgba.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let value = if (i % 64 + i / 64) % 2 == 0 { 255 } else { 0 };
        texel[..3].fill(value);
    }
    let pyramid = pyramid(SQUARE, &pixels, &PyramidOptions::default());
    for level in &pyramid.levels[1..] {
        assert!(level.content.iter().all(|(y, run)| run.clone().all(|x| texel(level, x, y)[0] == 188)));
    }
}

/// Computes the mean light and confidence of the content of level 0 within a texel of `level`; `None` where
/// there is no content.
fn mean(first: &Level, level: u32, x: i32, y: i32) -> Option<([f32; 3], f32)> {
    let side = 1 << level;
    let (mut sum, mut trust, mut count) = ([0.0f32; 3], 0.0, 0.0);
    for (y, x) in (y * side..(y + 1) * side).flat_map(|y| (x * side..(x + 1) * side).map(move |x| (y, x))) {
        if holds(&first.content, x, y) {
            let [r, g, b, confidence] = texel(first, x, y);
            let light = [r, g, b].map(|value| Srgb::tables().linear(value));
            (0..3).for_each(|c| sum[c] += light[c]);
            trust += f32::from(confidence);
            count += 1.0;
        }
    }
    (count > 0.0).then(|| (sum.map(|sum| sum / count), trust / (side * side) as f32))
}

#[test]
fn every_level_is_the_mean_of_what_is_there_and_of_nothing_else() {
    let mut rng = Rng::new(12);
    for _ in 0..4 {
        let pixels = random_texture(SQUARE, &mut rng);
        let pyramid = pyramid(SQUARE, &pixels, &PyramidOptions::default());
        for (level, l) in pyramid.levels.iter().zip(0..) {
            let side = 64 >> l;
            for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
                let expected = mean(&pyramid.levels[0], l, x, y);
                assert_eq!(holds(&level.content, x, y), expected.is_some(), "{x}, {y} of level {l}");
                let Some((light, trust)) = expected else { continue };
                let found = texel(level, x, y);
                let expected = light.map(|light| Srgb::tables().encoded(light));
                assert!((0..3).all(|c| found[c].abs_diff(expected[c]) <= 1), "{found:?}, {expected:?}");
                assert!((f32::from(found[3]) - trust.max(1.0)).abs() <= 0.51, "{found:?}, {trust}");
            }
        }
    }
}

#[test]
fn a_sheet_that_is_longer_than_wide_is_halved_until_one_texel_is_left() {
    let rect = PixelRect { x: 3, y: 4, w: 2, h: 64 };
    let pixels = uniform(rect, [50, 60, 70], |_, y| y > 60);
    let pyramid = pyramid(rect, &pixels, &PyramidOptions::default());
    assert_eq!(pyramid.levels.len(), 7);
    assert_eq!(texel(&pyramid.levels[6], 0, 0)[..3], [50, 60, 70]);
    assert_eq!(pyramid.levels[5].content.count(), 1);
}

#[test]
fn an_empty_sheet_has_empty_levels() {
    let pixels = LayerTexturePixels {
        rect: PixelRect { w: 0, h: 0, ..SQUARE },
        rgba: vec![],
        needed: vec![],
        matte: None,
    };
    let pyramid = pyramid(SQUARE, &pixels, &PyramidOptions::default());
    assert!(pyramid.levels.iter().all(|level| level.content.is_empty() && level.rgba.is_empty()));
}

/// Random pixels with a random matte.
fn random_see_through(seed: u64) -> LayerTexturePixels {
    let mut rng = Rng::new(seed);
    let mut pixels = random_texture(SQUARE, &mut rng);
    let matte = |_| [0, 255, rng.whole(0, 255) as u8][rng.whole(0, 2) as usize];
    pixels.matte = Some(pixels.needed.iter().map(matte).collect());
    pixels
}

#[test]
fn colours_are_multiplied_by_the_matte_and_both_are_halved_alike() {
    let (srgb, options) = (Srgb::tables(), PyramidOptions::default());
    let pixels = random_see_through(5);
    let (colours, mattes) = (pyramid(SQUARE, &pixels, &options), matte_pyramid(SQUARE, &pixels, &options));
    let plain = pyramid(SQUARE, &LayerTexturePixels { matte: None, ..pixels.clone() }, &options);
    let matte = pixels.matte.as_ref().unwrap();
    for (y, x) in colours.levels[0].content.iter().flat_map(|(y, run)| run.clone().map(move |x| (y, x))) {
        let alpha = matte[(y * 64 + x) as usize];
        let (found, own) = (texel(&colours.levels[0], x, y), texel(&plain.levels[0], x, y));
        assert_eq!(texel(&mattes.levels[0], x, y), [0, 0, 0, alpha]);
        assert_eq!(found[3], own[3], "the matte is no confidence");
        let product = |c: usize| srgb.encoded(f32::from(alpha) / 255.0 * srgb.linear(own[c]));
        assert_eq!(found[..3], [product(0), product(1), product(2)]);
        assert!(alpha != 255 || found == own, "where the surface covers all, colours are the photo's");
    }
    let first = &mattes.levels[0];
    for ((of_colour, of_matte), level) in colours.levels.iter().zip(&mattes.levels).zip(0..) {
        assert_eq!((&of_colour.content, of_colour.rect), (&of_matte.content, of_matte.rect));
        for (y, x) in of_matte.content.iter().flat_map(|(y, run)| run.clone().map(move |x| (y, x))) {
            let within = |at: i32| at << level..(at + 1) << level;
            let all = within(y).flat_map(|y| within(x).map(move |x| (x, y)));
            let known: Vec<f32> = all
                .filter(|(x, y)| holds(&first.content, *x, *y))
                .map(|(x, y)| f32::from(texel(first, x, y)[3]))
                .collect();
            let mean = known.iter().sum::<f32>() / known.len() as f32;
            assert!((f32::from(texel(of_matte, x, y)[3]) - mean).abs() <= 0.51, "{x}, {y} of level {level}");
        }
    }
}

#[test]
fn mattes_are_extended_past_outlines_so_that_no_solid_fringe_appears() {
    let mut pixels = uniform(SQUARE, [200, 100, 50], |x, _| x < SQUARE.x + 20);
    pixels.needed.iter_mut().for_each(|needed| *needed |= BLEED);
    let matte = vec![64; pixels.needed.len()];
    pixels.matte = Some(matte);
    let options = PyramidOptions::default();
    for level in [0, 1] {
        let (colours, mattes) =
            (pyramid(SQUARE, &pixels, &options), matte_pyramid(SQUARE, &pixels, &options));
        let (colours, mattes) = (&colours.levels[level], &mattes.levels[level]);
        let (inside, outside) = ((20 >> level) - 1, 20 >> level);
        for x in [inside, outside, outside + 1] {
            let (at, same) = (colours.index(x, 9), colours.index(inside, 9));
            assert_eq!(colours.rgba[at..at + 3], colours.rgba[same..same + 3], "level {level}, column {x}");
            assert_eq!(mattes.rgba[at + 3], 64, "level {level}, column {x}");
        }
    }
}
