//! How samples become layers, and layers levels.

use glam::DVec3;

use super::super::levels::pyramid;
use super::super::merge::{Merging, SurfaceSample, merge};
use crate::{DepthPixel, DepthPixelOrigin, LdiSurface, ResolutionLevel, Splat};
use quadratura_base::scene::synthetic::{Rng, centred};

fn sample(depth: f64, source: u16, place: u32, rng: &mut Rng) -> SurfaceSample {
    let mut byte = || rng.whole(0, 255) as u8;
    let colour = [byte(), byte(), byte(), 255];
    let splat = Splat::new(0, DepthPixelOrigin::Photo);
    let pixel = DepthPixel { inverse_depth: (1.0 / depth) as f32, colour, surface: 0, splat };
    SurfaceSample { pixel, source, place, weight: rng.between(0.1, 1.0) as f32, hidden: false }
}

fn samples(rng: &mut Rng) -> Vec<SurfaceSample> {
    let count = rng.whole(1, 8);
    (0..count).map(|place| sample(rng.between(1.0, 1.06), rng.whole(0, 2) as u16, place, rng)).collect()
}

#[test]
fn the_order_of_samples_does_not_count() {
    let mut rng = Rng::new(11);
    let merging = Merging::default();
    for _ in 0..200 {
        let mut some = samples(&mut rng);
        let expected = merge(&mut some.clone(), &[], 1.0, &merging);
        for _ in 0..4 {
            let (i, j) = (rng.whole(0, some.len() as u32 - 1), rng.whole(0, some.len() as u32 - 1));
            some.swap(i as usize, j as usize);
            assert_eq!(merge(&mut some.clone(), &[], 1.0, &merging), expected);
        }
    }
}

/// Returns the least number of layers of a tolerance into which depths can be divided, by trying all divisions.
fn fewest(depths: &[f64], tolerance: f64) -> usize {
    let Some(nearest) = depths.iter().copied().reduce(f64::max) else { return 0 };
    // The nearest sample is in some layer; which others are with it, is tried.
    let others: Vec<f64> = {
        let mut others = depths.to_vec();
        others.remove(depths.iter().position(|d| *d == nearest).unwrap());
        others
    };
    let fits: Vec<f64> = others.iter().copied().filter(|d| nearest - d <= tolerance * nearest).collect();
    let far: Vec<f64> = others.iter().copied().filter(|d| nearest - d > tolerance * nearest).collect();
    (0..1u32 << fits.len())
        .map(|with| {
            let left = fits.iter().enumerate().filter(|(i, _)| with & (1 << i) == 0).map(|(_, d)| *d);
            1 + fewest(&left.chain(far.iter().copied()).collect::<Vec<_>>(), tolerance)
        })
        .min()
        .unwrap()
}

#[test]
fn without_slopes_no_division_has_fewer_layers_and_none_is_wider_than_its_tolerance() {
    let mut rng = Rng::new(12);
    let merging = Merging { epsilon: 0.01, slopes: false, layers: 64 };
    for _ in 0..300 {
        let mut some: Vec<SurfaceSample> = samples(&mut rng).into_iter().take(6).collect();
        let depths: Vec<f64> = some.iter().map(|s| f64::from(s.pixel.inverse_depth)).collect();
        let layers = merge(&mut some, &[], 1.0, &merging).layers;
        assert_eq!(layers.len(), fewest(&depths, 0.01));
        // Every mean is within the samples of its layer, and layers are in order.
        assert!(layers.windows(2).all(|pair| pair[0].inverse_depth > pair[1].inverse_depth));
    }
}

#[test]
fn copies_of_one_sample_give_its_own_bytes() {
    let mut rng = Rng::new(13);
    let merging = Merging::default();
    for _ in 0..200 {
        let one = sample(rng.between(0.1, 100.0), 1, 7, &mut rng);
        let copies = rng.whole(2, 8) as u16;
        let mut all: Vec<SurfaceSample> = (0..copies)
            .map(|source| SurfaceSample { source, weight: rng.between(0.01, 1.0) as f32, ..one })
            .collect();
        assert_eq!(merge(&mut all, &[], 1.0, &merging).layers, [one.pixel]);
    }
}

#[test]
fn what_is_right_behind_a_surface_does_not_shine_through_it() {
    let mut rng = Rng::new(17);
    let hidden = |sample: SurfaceSample| SurfaceSample { hidden: true, ..sample };
    let seen = sample(1.0, 1, 4, &mut rng);
    let behind = hidden(sample(1.002, 1, 5, &mut rng));
    let merging = Merging::default();
    assert_eq!(merge(&mut [behind, seen], &[], 1.0, &merging).layers, [seen.pixel]);
    // Not even what the reference camera has filled in there.
    let filled = SurfaceSample { source: 0, ..behind };
    assert_eq!(merge(&mut [filled, seen], &[], 1.0, &merging).layers, [seen.pixel]);
    assert_eq!(merge(&mut [behind], &[], 1.0, &merging).layers, [behind.pixel], "where nobody sees it");
    // Farther behind it is a layer of its own.
    let far = hidden(sample(1.5, 1, 6, &mut rng));
    assert_eq!(merge(&mut [far, seen], &[], 1.0, &merging).layers, [seen.pixel, far.pixel]);
}

#[test]
fn a_surface_keeps_its_colour_in_coarser_levels_whatever_is_right_behind_it() {
    let mut rng = Rng::new(18);
    let (ceiling, roof) = (sample(5.0, 0, 0, &mut rng).pixel, sample(5.01, 0, 0, &mut rng).pixel);
    let row = |_| (0..64).flat_map(|column| [(column, ceiling), (column, roof)]).collect();
    let rows: Vec<Vec<(u16, DepthPixel)>> = (0..64).map(row).collect();
    let levels = pyramid(ResolutionLevel::of_rows(centred(64, 64, 100.0), rows), &[]);
    assert!(levels.len() > 2);
    for level in &levels[1..] {
        assert!(level.colours.iter().all(|colour| *colour == ceiling.colour));
    }
}

#[test]
fn a_plane_seen_along_it_is_one_layer_and_of_too_many_the_nearest_and_the_farthest_stay() {
    let mut rng = Rng::new(15);
    let mut of_floor: Vec<SurfaceSample> =
        (0..6).map(|place| sample(10.0 + 0.3 * f64::from(place), 1, place, &mut rng)).collect();
    of_floor.iter_mut().for_each(|sample| sample.pixel.surface = 1);
    let floor = LdiSurface { nu: DVec3::new(0.0, 0.02, 0.0), object: "floor".into(), face: None };
    let with = |slopes, layers, samples: &[SurfaceSample]| {
        merge(
            &mut samples.to_vec(),
            std::slice::from_ref(&floor),
            1.0,
            &Merging { slopes, layers, ..Merging::default() },
        )
    };
    assert_eq!(with(true, 10, &of_floor).layers.len(), 1);
    let plain = with(false, 10, &of_floor);
    assert_eq!((plain.layers.len(), plain.dropped), (6, 0));
    let few = with(false, 3, &of_floor);
    assert_eq!(few.layers, [plain.layers[0], plain.layers[1], plain.layers[5]]);
    assert_eq!(few.dropped, 3);
}

#[test]
fn a_level_has_half_the_resolution_and_the_same_light() {
    let camera = centred(130, 71, 100.0);
    let mut rng = Rng::new(16);
    let row = |_| (0..130).map(|column| (column, sample(5.0, 1, 0, &mut rng).pixel)).collect();
    let mut rows: Vec<Vec<(u16, DepthPixel)>> = (0..71).map(row).collect();
    rows[3].retain(|(column, _)| *column < 60);
    let levels = pyramid(ResolutionLevel::of_rows(camera, rows), &[]);
    let sizes: Vec<_> = levels.iter().map(|level| (level.camera.width, level.camera.height)).collect();
    assert_eq!(sizes, [(130, 71), (65, 36), (33, 18), (17, 9), (9, 5)]);
    assert_eq!(levels[1].len(), 65 * 36);
    assert_eq!((levels[1].camera.fx, levels[1].camera.cx), (50.0, 32.5));
    let light = |level: &ResolutionLevel| {
        let linear = |byte: u8| f64::from(quadratura_base::scene::light::LINEAR_FROM_BYTE[usize::from(byte)]);
        level.colours.iter().map(|colour| linear(colour[1])).sum::<f64>() / level.len() as f64
    };
    // Each pixel's light is rounded to a byte, alike often up and down.
    assert!((light(&levels[0]) - light(&levels[1])).abs() < 0.01);
}
