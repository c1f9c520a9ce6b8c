//! Tests of tiles against the levels that they are cut from.

use super::*;
use crate::LayerTexturePixels;
use crate::pyramid::tests::random_texture;
use crate::pyramid::{PyramidOptions, pyramid};
use quadratura_base::scene::synthetic::Rng;

const RECT: PixelRect = PixelRect { x: 5, y: -9, w: 256, h: 128 };

fn random_pyramid(seed: u64) -> Pyramid {
    let pixels = random_texture(RECT, &mut Rng::new(seed));
    pyramid(RECT, &pixels, &PyramidOptions::default())
}

fn slot(pyramid: &Pyramid, level: u32, x: u32, y: u32) -> Vec<[u8; 4]> {
    let row_bytes = 4 * SLOT as usize;
    let mut slot = vec![77; row_bytes * SLOT as usize];
    pyramid.cut(TileKey { layer_texture: LayerTextureId(0), level, x, y }, &mut slot, row_bytes);
    slot.as_chunks().0.to_vec()
}

/// Returns a texel of a slot, counted from its corner.
fn at(slot: &[[u8; 4]], x: u32, y: u32) -> [u8; 4] {
    slot[(y * SLOT + x) as usize]
}

#[test]
fn gutters_are_the_neighbours_own_texels() {
    for seed in 0..5 {
        let pyramid = random_pyramid(seed);
        for level in 0..pyramid.shape.tail() {
            let [columns, rows] = pyramid.shape.tiles(level);
            for (y, x) in (0..rows).flat_map(|y| (1..columns).map(move |x| (y, x))) {
                let (left, right) = (slot(&pyramid, level, x - 1, y), slot(&pyramid, level, x, y));
                // Four columns are in both slots.
                let shared = |i: u32| (i % (2 * GUTTER), i / (2 * GUTTER));
                let shared = (0..2 * GUTTER * SLOT).map(shared);
                assert!(shared.clone().all(|(i, j)| at(&left, TILE + i, j) == at(&right, i, j)));
            }
            for (y, x) in (1..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
                let (above, below) = (slot(&pyramid, level, x, y - 1), slot(&pyramid, level, x, y));
                let all = (0..SLOT).flat_map(|i| (0..2 * GUTTER).map(move |j| (i, j)));
                assert!(all.clone().all(|(i, j)| at(&above, i, TILE + j) == at(&below, i, j)));
            }
        }
    }
}

#[test]
fn a_tile_is_occupied_where_a_filtered_lookup_can_find_content() {
    for seed in 0..5 {
        let pyramid = random_pyramid(seed);
        let occupancy = Occupancy::from_pyramid(&pyramid);
        for level in 0..pyramid.shape.tail() {
            let [columns, rows] = pyramid.shape.tiles(level);
            let mut count = 0;
            for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
                let slot = slot(&pyramid, level, x, y);
                // The outermost texel of the gutter is beyond the reach of lookups.
                let inner = (1..SLOT - 1).flat_map(|j| (1..SLOT - 1).map(move |i| (i, j)));
                let found = inner.clone().any(|(i, j)| at(&slot, i, j)[3] > 0);
                assert_eq!(occupancy.holds(level, x, y), found, "{x}, {y} of level {level}");
                count += u64::from(found);
                // The parent of an occupied tile is occupied, too, because page tables fall back to it.
                let parents = pyramid.shape.tiles(level + 1);
                let parent = [(x / 2).min(parents[0] - 1), (y / 2).min(parents[1] - 1)];
                assert!(!found || occupancy.holds(level + 1, parent[0], parent[1]));
            }
            assert_eq!(occupancy.count(level), count);
            assert_eq!(occupancy.tiles(level).count() as u64, count);
        }
    }
}

#[test]
fn levels_of_the_tail_lie_side_by_side_in_one_slot() {
    let mut taken = vec![false; (SLOT * SLOT) as usize];
    for ([x, y], log) in TAIL_SPOTS.into_iter().zip(0..) {
        assert!(x % 4 == 0 && y % 4 == 0, "blocks begin there");
        let side = (1 << log) + 2 * GUTTER;
        assert!(x + side <= SLOT && y + side <= SLOT);
        for (j, i) in (y..y + side).flat_map(|j| (x..x + side).map(move |i| (j, i))) {
            assert!(!std::mem::replace(&mut taken[(j * SLOT + i) as usize], true), "{i}, {j} twice");
        }
    }
}

#[test]
fn the_tail_holds_its_levels_with_their_gutters() {
    let pyramid = random_pyramid(3);
    let tail = slot(&pyramid, pyramid.shape.tail(), 0, 0);
    for level in pyramid.shape.tail()..pyramid.shape.levels() {
        let [w, h] = pyramid.shape.size(level);
        let [left, top] = TAIL_SPOTS[w.max(h).ilog2() as usize];
        let held = &pyramid.levels[level as usize];
        for (y, run) in held.content.iter() {
            for x in run.clone() {
                let from = held.index(x, y);
                let place = (left + GUTTER + x as u32, top + GUTTER + y as u32);
                assert_eq!(at(&tail, place.0, place.1), held.rgba[from..from + 4]);
            }
        }
    }
}

#[test]
fn shapes_follow_from_the_sides() {
    let shape = TextureShape::from_rect(PixelRect::of_size(512, 16));
    assert_eq!((shape.levels(), shape.tail()), (10, 4));
    assert_eq!(shape.size(2), [128, 4]);
    assert_eq!((shape.tiles(0), shape.tiles(2), shape.tiles(3)), ([8, 1], [2, 1], [1, 1]));
    assert_eq!(shape.entries(), 8 + 4 + 2 + 7);
    assert_eq!((shape.halves(3), shape.halves(4)), ([true, true], [true, false]));
    let dot = TextureShape::from_rect(PixelRect::of_size(1, 1));
    assert_eq!((dot.levels(), dot.tail(), dot.entries()), (1, 0, 1));
}

#[test]
fn only_tiles_that_differ_are_not_the_same() {
    let mut pixels = random_texture(RECT, &mut Rng::new(1));
    let make = |pixels: &LayerTexturePixels| pyramid(RECT, pixels, &PyramidOptions::default());
    let before = make(&pixels);
    let texel = pixels.rgba.chunks(4).position(|texel| texel[3] > 0).expect("there is content");
    pixels.rgba[4 * texel] ^= 0xff;
    let after = make(&pixels);
    let tile = [texel as u32 % RECT.w / TILE, texel as u32 / RECT.w / TILE];
    let [columns, rows] = before.shape.tiles(0);
    for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
        let key = TileKey { layer_texture: LayerTextureId(0), level: 0, x, y };
        assert!(before.same_tile(&before, key));
        assert_eq!(before.same_tile(&after, key), slot(&before, 0, x, y) == slot(&after, 0, x, y));
        assert!([x, y] != tile || !before.same_tile(&after, key));
    }
}

/// Counts the tiles of level 0 that a rectangle needs, including adjacent ones.
fn tiles_of(rect: PixelRect, needed: PixelRect) -> i32 {
    let near = needed.grown(1).intersection(&rect);
    let count = |low: i32, high: i32| (high - 1) / TILE as i32 - low / TILE as i32 + 1;
    count(near.x - rect.x, near.right() - rect.x) * count(near.y - rect.y, near.bottom() - rect.y)
}

#[test]
fn a_sheet_is_moved_to_where_it_takes_fewer_tiles_and_keeps_what_is_needed_with_its_gutter() {
    let mut rng = Rng::new(12);
    let (mut before, mut after) = (0, 0);
    for _ in 0..2000 {
        let side = |rng: &mut Rng| 1 << rng.whole(0, 12);
        let at = |rng: &mut Rng| rng.whole(0, 5000) as i32 - 1000;
        let rect = PixelRect { x: at(&mut rng), y: at(&mut rng), w: side(&mut rng), h: side(&mut rng) };
        let share = |rng: &mut Rng, side: u32| {
            let (a, b) = (rng.whole(0, side - 1), rng.whole(0, side - 1));
            [a.min(b) as i32, a.max(b) as i32 + 1]
        };
        let (x, y) = (share(&mut rng, rect.w), share(&mut rng, rect.h));
        let needed = PixelRect::from_edges(rect.x + x[0], rect.y + y[0], rect.x + x[1], rect.y + y[1]);
        let moved = in_few_tiles(rect, needed);
        assert_eq!((moved.w, moved.h), (rect.w, rect.h));
        assert!((moved.x - rect.x) % 16 == 0 && (moved.y - rect.y) % 16 == 0);
        let around = needed.grown(GUTTER);
        let kept = around.intersection(&rect);
        assert_eq!(kept.intersection(&moved), kept, "{rect:?} {needed:?} {moved:?}");
        before += tiles_of(rect, needed);
        after += tiles_of(moved, needed);
        assert!(tiles_of(moved, needed) <= tiles_of(rect, needed), "{rect:?} {needed:?} {moved:?}");
    }
    assert!(f64::from(after) < 0.97 * f64::from(before), "{after} of {before} tiles");
    let rect = PixelRect::of_size(256, 256);
    let nothing = PixelRect { x: 9, y: 9, w: 0, h: 0 };
    assert_eq!(in_few_tiles(rect, nothing), rect);
}
