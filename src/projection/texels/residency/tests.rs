//! Tests of page tables against their definition, over random sequences of views.

use super::*;
use crate::pyramid::tests::random_texture;
use crate::pyramid::{PyramidOptions, pyramid};
use quadratura_base::scene::synthetic::Rng;

const SIZES: [[u32; 2]; 6] = [[512, 256], [128, 128], [64, 512], [32, 16], [256, 256], [1, 2]];

fn rects() -> impl Iterator<Item = PixelRect> {
    SIZES.into_iter().map(|[w, h]| PixelRect::of_size(w, h))
}

fn random_occupancy(rect: PixelRect, rng: &mut Rng) -> Occupancy {
    Occupancy::from_pyramid(&pyramid(rect, &random_texture(rect, rng), &PyramidOptions::default()))
}

fn all_wants() -> Vec<TileRequest> {
    (0..SIZES.len() as u32).map(|layer_texture| TileRequest::all(LayerTextureId(layer_texture))).collect()
}

fn random_want(rng: &mut Rng) -> TileRequest {
    let layer_texture = rng.whole(0, SIZES.len() as u32 - 1);
    let rect = PixelRect {
        x: rng.whole(0, 300) as i32 - 50,
        y: rng.whole(0, 300) as i32 - 50,
        w: rng.whole(1, 300),
        h: rng.whole(1, 300),
    };
    TileRequest { layer_texture: LayerTextureId(layer_texture), finest: rng.whole(0, 4), rect }
}

/// Returns the expected entry of a tile: the nearest resident one of the tile and its ancestors.
fn expected(book: &Residency, key: TileKey) -> u32 {
    let (shape, Some(occupancy)) = (book.shape(key.layer_texture), book.occupancy(key.layer_texture)) else {
        return NOTHING;
    };
    if !occupancy.holds(key.level, key.x, key.y) {
        return NOTHING;
    }
    for level in key.level..=shape.tail().max(key.level) {
        let up = level - key.level;
        let resident = TileKey { level: level.min(shape.tail()), x: key.x >> up, y: key.y >> up, ..key };
        if let Some(slot) = book.slot(resident) {
            return slot + (up << SLOT_BITS);
        }
    }
    NOTHING
}

fn check(book: &mut Residency, entries: &mut [u32]) {
    // The copy is updated like a device's: only in the ranges reported as changed.
    for range in book.write_entries() {
        entries[range.clone()].copy_from_slice(&book.entries()[range]);
    }
    let mut slots: Vec<u32> = Vec::new();
    for layer_texture in (0..SIZES.len() as u32).map(LayerTextureId) {
        let (shape, record) = (book.shape(layer_texture), book.records()[layer_texture.0 as usize]);
        slots.extend(book.resident_of(layer_texture).iter().filter_map(|key| book.slot(*key)));
        for level in 0..shape.levels() {
            let [columns, rows] = shape.tiles(level);
            for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
                let entry = entries[(record.offsets[level as usize] + y * columns + x) as usize];
                let key = TileKey { layer_texture, level, x, y };
                assert_eq!(entry, expected(book, key), "{key:?}");
            }
        }
    }
    slots.sort_unstable();
    slots.dedup();
    assert_eq!(slots.len(), book.len(), "no two tiles share a slot");
    assert!(book.len() <= book.capacity() as usize);
}

#[test]
fn page_tables_lead_to_the_nearest_resident_tile_whatever_happened_before() {
    for seed in 0..6 {
        let mut rng = Rng::new(seed);
        let mut book = Residency::new(rects());
        let mut entries = book.entries().to_vec();
        for step in 0..60 {
            match rng.whole(0, 9) {
                0 => book.grow({
                    let next = book.capacity();
                    next..next + rng.whole(1, 20)
                }),
                1 | 2 => {
                    let layer_texture = rng.whole(0, SIZES.len() as u32 - 1);
                    let rect = rects().nth(layer_texture as usize).expect("there is one");
                    book.learn(LayerTextureId(layer_texture), random_occupancy(rect, &mut rng));
                }
                _ => {
                    let wants: Vec<TileRequest> =
                        (0..rng.whole(1, 5)).map(|_| random_want(&mut rng)).collect();
                    let (chosen, _) = book.choose(&wants, book.capacity());
                    book.enter(&chosen);
                    assert!(chosen.iter().all(|key| book.slot(*key).is_some()), "step {step}");
                }
            }
            check(&mut book, &mut entries);
        }
    }
}

#[test]
fn with_room_for_the_tails_every_occupied_tile_is_served_at_some_level() {
    for slots in [6, 10, 25, 70] {
        let mut rng = Rng::new(u64::from(slots));
        let mut book = Residency::new(rects());
        book.grow(0..slots);
        for (layer_texture, rect) in (0..).map(LayerTextureId).zip(rects()) {
            book.learn(layer_texture, random_occupancy(rect, &mut rng));
        }
        let (chosen, wanted) = book.choose(&all_wants(), slots);
        assert_eq!(chosen.len(), wanted.min(slots as usize), "no slot is left unused");
        book.enter(&chosen);
        let mut entries = book.entries().to_vec();
        check(&mut book, &mut entries);
        for (layer_texture, record) in (0..).map(LayerTextureId).zip(book.records()) {
            let occupancy = book.occupancy(layer_texture).expect("it was learnt");
            for level in 0..record.tail {
                let columns = book.shape(layer_texture).tiles(level)[0];
                let entry =
                    |[x, y]: [u32; 2]| entries[(record.offsets[level as usize] + y * columns + x) as usize];
                assert!(occupancy.tiles(level).all(|tile| entry(tile) != NOTHING));
            }
        }
    }
}

#[test]
fn what_was_not_wanted_for_longest_leaves_first() {
    let mut book = Residency::new(rects());
    let mut rng = Rng::new(1);
    for (layer_texture, rect) in (0..).map(LayerTextureId).zip(rects()) {
        book.learn(layer_texture, random_occupancy(rect, &mut rng));
    }
    let wants = |layer_texture| [TileRequest::all(LayerTextureId(layer_texture))];
    let count = |book: &Residency, layer_texture| book.tiles(&wants(layer_texture)[0], 0).len() as u32;
    book.grow(0..count(&book, 0) + count(&book, 1));
    for layer_texture in [1, 0] {
        let (chosen, _) = book.choose(&wants(layer_texture), book.capacity());
        book.enter(&chosen);
    }
    assert!(book.is_resident(&wants(1)), "a look at it is a use of it");
    assert!(!book.is_resident(&wants(4)));
    let (chosen, _) = book.choose(&wants(3), book.capacity());
    book.enter(&chosen);
    assert!(book.is_resident(&wants(1)) && book.is_resident(&wants(3)) && !book.is_resident(&wants(0)));
}
