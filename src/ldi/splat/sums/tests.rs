//! Tests of slots.

use super::*;
use quadratura_base::scene::synthetic::Rng;

/// Four slots at once are what they are one by one, also where they hold neighbouring faces, or not at all.
#[test]
fn four_slots_at_once_are_as_they_are_one_by_one() {
    let mut rng = Rng::new(57);
    let light = [[0.5; 256]; 3];
    let (mut at_once, mut of_two) = (0, 0);
    for _ in 0..20_000 {
        // Depths, surfaces and slopes that are alike as often as not.
        let mut addition = || {
            let q = 0.1 * (1.0 + 0.002 * (rng.between(-4.0, 4.0)).round() as f32);
            let surface = rng.between(0.0, 3.0).floor() as f32;
            let seen = [Vec4::splat(rng.between(0.1, 1.0) as f32)];
            SlotAddition { q, surface, slope: rng.between(0.0, 4e-4) as f32, along: APART_PIXELS, seen }
        };
        let (own, others) = (addition(), [0; 4].map(|_| addition()));
        let mut share = || rng.between(-0.3, 1.2).max(0.0) as f32;
        let (filled, weights) = ([0; 4].map(|_| share()), [0; 4].map(|_| share()));
        let slots = |canvas: &mut SumsCanvas<COLOUR>| {
            for ((at, weight), other) in [0, 1, 3, 4].into_iter().zip(filled).zip(&others) {
                canvas.near[at] = if weight > 0.0 { Slot::new(weight, other) } else { Slot::default() };
            }
        };
        // One pixel and its border: rows of three slots.
        let mut one_by_one = SumsCanvas::new(1, 1, &light);
        slots(&mut one_by_one);
        one_by_one.add_one_by_one(0, weights, &own);
        let mut four = SumsCanvas::new(1, 1, &light);
        slots(&mut four);
        let (upper, lower) = four.near.split_at_mut(3);
        let ([a, b, ..], [c, d, ..]) = (upper, lower) else { panic!("three rows of three") };
        if !add_to_four([a, b, c, d], Vec4::from_array(weights), &own) {
            continue;
        }
        at_once += 1;
        let is_other =
            |other: &SlotAddition<COLOUR>| other.surface != own.surface && other.surface * own.surface > 0.0;
        of_two += u32::from(
            others
                .iter()
                .zip(filled)
                .zip(weights)
                .any(|((other, filled), weight)| filled > 0.0 && weight > 0.0 && is_other(other)),
        );
        for (found, expected) in four.near.iter().zip(&one_by_one.near) {
            assert_eq!((found.head, found.seen), (expected.head, expected.seen), "{own:?} {others:?}");
        }
        assert!(one_by_one.far_used.iter().all(|used| !used));
    }
    assert!(at_once > 2000 && of_two > 500, "{at_once} {of_two}");
}
