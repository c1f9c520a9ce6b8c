//! Pictures of random scenes against the processor's.

use glam::DVec3;

use super::{GpuWarp, SPLATS, of_splat, on_adapter, on_processor, picture, uploaded};
use quadratura_base::scene::synthetic::{Rng, camera_is_world, centred, random};
use quadratura_ldi::synthetic::{floor, from_above};
use quadratura_ldi::synthetic::{of_model, step_aside, with_level};
use quadratura_ldi::transfer::{Positions, Transfer};
use quadratura_ldi::warp::DrawingOrder;
use quadratura_ldi::{DepthPixel, Ldi, ResolutionLevel, Splat, SplatKind, WarpOptions};
use quadratura_view::Shot;

/// The difference of stored values up to which pixels are the same.
const STEPS: u8 = 2;

/// Returns the layered depth image of a random scene, and a view from beside it. Every fourth is partly translucent.
fn scene(seed: u64) -> (Ldi, Shot) {
    let scene = if seed.is_multiple_of(2) { random::boxes(seed, 6) } else { random::soup(seed, 20) };
    let scene = scene.resized(200);
    let colour = |face: usize, point: DVec3| {
        let wave = |rate: f64| (127.0 + 100.0 * (rate * (point.x + 2.0 * point.y - point.z)).sin()) as u8;
        let opacity = if seed % 4 == 3 && face.is_multiple_of(3) { wave(2.0) } else { 255 };
        [wave(3.0), wave(1.0), (40 * face % 256) as u8, opacity]
    };
    let mut rng = Rng::new(seed);
    let eye = scene.pose.center_in_world();
    let middle = scene.model.vertices.iter().sum::<DVec3>() / scene.model.vertices.len() as f64;
    let apart = 0.05 * eye.distance(middle);
    let pose = step_aside(&mut rng, eye, eye.lerp(middle, 0.9), apart);
    let (width, height) = (rng.whole(90, 260), rng.whole(60, 200));
    let camera = centred(width, height, f64::from(width) * rng.between(0.6, 1.6));
    (of_model(&scene.model, scene.camera, scene.pose, colour), Shot::new(camera, pose))
}

/// How far pictures are from the processor's, in pixels.
#[derive(Debug, Clone, Copy, Default)]
struct Difference {
    /// Those that are seen in both.
    both: usize,
    /// Those that are seen in one alone.
    alone: usize,
    /// Those of the first that differ by more than [`STEPS`].
    apart: usize,
    /// Those that differ so much when the processor draws in the opposite order.
    of_order: usize,
    /// Those that are not among these, but among those before.
    apart_without_order: usize,
    /// The sum of squared differences, and that of the processor from itself in the opposite order.
    squares: [f64; 2],
}

impl Difference {
    /// Draws a view both ways and adds its differences.
    fn add(&mut self, gpu: &mut GpuWarp, ldi: Ldi, shot: &Shot, options: &WarpOptions) {
        let expected = on_processor(&ldi, shot, options);
        let reversed = WarpOptions { order: DrawingOrder::Reversed, ..*options };
        let reversed = on_processor(&ldi, shot, &reversed);
        let ldi = uploaded(gpu, ldi);
        let found = picture(gpu, &ldi, shot, options);
        assert_eq!((found.level, found.too_near > 0), (expected.level, expected.too_near > 0));
        let [found, expected, reversed] = [found, expected, reversed].map(|warped| warped.picture);
        let pixels = found.pixels().iter().zip(expected.pixels()).zip(reversed.pixels());
        for ((found, expected), reversed) in pixels {
            self.add_pixel(found, expected, reversed);
        }
    }

    fn add_pixel(&mut self, found: &[u8; 4], expected: &[u8; 4], reversed: &[u8; 4]) {
        if found[3] == 0 || expected[3] == 0 {
            self.alone += usize::from(found[3] != expected[3]);
            return;
        }
        let is_apart = |other: &[u8; 4]| (0..4).any(|c| other[c].abs_diff(expected[c]) > STEPS);
        let square =
            |other: &[u8; 4]| (0..4).map(|c| f64::from(other[c].abs_diff(expected[c])).powi(2)).sum::<f64>();
        let (apart, of_order) = (is_apart(found), is_apart(reversed));
        self.both += 1;
        self.apart += usize::from(apart);
        self.of_order += usize::from(of_order);
        self.apart_without_order += usize::from(apart && !of_order);
        self.squares[0] += square(found);
        self.squares[1] += square(reversed);
    }

    /// Asserts that only the order of drawing makes a difference, and no larger one than that order itself: where three
    /// surfaces meet in a pixel, so that it decides which two are kept; where two are at nearly one depth; and where a surface
    /// changes its depth by more than the tolerance within a splat. These images are coarse and have many such pixels.
    fn assert_of_order(&self, most: f64) {
        let steady = (self.both - self.of_order) as f64;
        // What is left are colours that both orders mix alike by chance, and what rounding takes across the tolerance.
        assert!(self.apart_without_order as f64 <= most * steady, "{self:?}");
        assert!(self.apart <= self.of_order, "{self:?}");
        assert!(self.alone * 1000 <= self.both, "{self:?}");
    }
}

#[test]
fn sums_are_those_of_the_processor_where_the_order_of_drawing_does_not_count() {
    let Some(mut gpu) = on_adapter() else { return };
    let mut difference = Difference::default();
    for seed in 0..40 {
        let (ldi, shot) = scene(seed);
        difference.add(&mut gpu, ldi, &shot, &of_splat(SplatKind::Sums));
    }
    println!("{difference:?}");
    assert!(difference.both > 100_000, "{difference:?}");
    difference.assert_of_order(0.01);
    assert!(difference.squares[0] < difference.squares[1], "{difference:?}");
}

/// Finds the nearest depth pixel at each pixel of a view, one after the other, from the positions of the processor's warp.
fn nearest_colours(ldi: &Ldi, level: usize, shot: &Shot) -> Vec<[u8; 4]> {
    let level = &ldi.levels[level];
    let rows = Transfer::new(&level.camera, &ldi.pose, &shot.camera, &shot.pose).rows();
    let (width, height) = (shot.camera.width as f32, shot.camera.height as f32);
    let mut nearest = vec![(-1.0, [0; 4]); shot.camera.width as usize * shot.camera.height as usize];
    let mut positions = Positions::default();
    for y in 0..level.camera.height {
        for at in level.row(y) {
            let (columns, depths) = (&level.columns[at..=at], &level.inverse_depths[at..=at]);
            let run = rows.start(u32::from(columns[0]), y);
            rows.place(&run, columns, depths, &mut positions);
            let (u, v) = (positions.u[0], positions.v[0]);
            if !(u >= 0.0 && u < width && v >= 0.0 && v < height) || level.colours[at][3] < 128 {
                continue;
            }
            let pixel = &mut nearest[v as usize * shot.camera.width as usize + u as usize];
            let q = depths[0] * positions.per_omega[0];
            if q > pixel.0 {
                *pixel = (q, level.colours[at]);
            }
        }
    }
    nearest.into_iter().map(|(_, colour)| colour).collect()
}

#[test]
fn single_pixels_show_the_nearest_depth_pixel_with_wide_words_and_without() {
    let Some(mut gpu) = on_adapter() else { return };
    let Some(mut plain) = on_adapter().map(GpuWarp::without_wide_atomics) else { return };
    let (mut all, mut apart) = (0, 0);
    for seed in 0..20 {
        let (ldi, shot) = scene(seed);
        let shot = Shot { backs: true, ..shot };
        let options = of_splat(SplatKind::Pixel);
        let images = [uploaded(&gpu, ldi.clone()), uploaded(&plain, ldi.clone())];
        let found = picture(&mut gpu, &images[0], &shot, &options);
        let again = picture(&mut plain, &images[1], &shot, &options);
        assert_eq!(found, again, "seed {seed}: two runs in place of one change nothing");
        let expected = nearest_colours(&ldi, found.level, &shot);
        all += expected.iter().filter(|colour| colour[3] > 0).count();
        apart += found.picture.pixels().iter().zip(&expected).filter(|(a, b)| a != b).count();
    }
    println!("{apart} of {all} pixels differ");
    // A device may divide less exactly than a processor, which moves a position across the border of a pixel, or changes which
    // of two is nearer, once in some ten thousand times.
    assert!(all > 50_000 && apart * 1000 <= all, "{apart} of {all} pixels differ");
}

#[test]
fn runs_parts_and_rows_give_the_same_bytes() {
    let Some(mut gpu) = on_adapter() else { return };
    let Some(mut small) = on_adapter().map(|whole| whole.with_limits(1009, 2300)) else { return };
    for (seed, splat) in (0..8).flat_map(|seed| SPLATS.map(|splat| (seed, splat))) {
        let (ldi, shot) = scene(seed);
        let images = [uploaded(&gpu, ldi.clone()), uploaded(&small, ldi)];
        assert!(images[1].chunks(0).len() > 5 && images[0].chunks(0).len() == 1);
        let first = picture(&mut gpu, &images[0], &shot, &of_splat(splat));
        assert_eq!(first, picture(&mut gpu, &images[0], &shot, &of_splat(splat)), "{seed}: a second run");
        assert_eq!(first, picture(&mut small, &images[1], &shot, &of_splat(splat)), "{seed}: parts");
    }
}

#[test]
fn an_exposure_changes_the_colours_as_on_the_processor() {
    let Some(mut gpu) = on_adapter() else { return };
    for exposure in [[0.4, -0.3, 0.0], [-2.0, 1.5, 3.0]] {
        let options = WarpOptions { exposure, ..WarpOptions::default() };
        let mut difference = Difference::default();
        for seed in 0..8 {
            let (ldi, shot) = scene(seed);
            difference.add(&mut gpu, ldi, &shot, &options);
        }
        println!("{difference:?}");
        // Of fewer scenes; light that saturates hides what the order changes.
        difference.assert_of_order(0.02);
    }
    let (ldi, _) = scene(2);
    let on_device = uploaded(&gpu, ldi.clone());
    // Of single pixels both show one depth pixel; where each pixel of the picture has one, it is the same.
    let options = WarpOptions { exposure: [0.4, -0.3, 0.0], ..of_splat(SplatKind::Pixel) };
    let own = Shot::new(ldi.camera, ldi.pose);
    let found = picture(&mut gpu, &on_device, &own, &options).picture;
    assert_eq!(found, on_processor(&ldi, &own, &options).picture);
}

#[test]
fn stretched_depth_pixels_are_parallelograms_as_on_the_processor() {
    let Some(mut gpu) = on_adapter() else { return };
    let (_, ldi) = floor();
    let on_device = uploaded(&gpu, ldi.clone());
    let options = WarpOptions { level: Some(0), ..WarpOptions::default() };
    let mut rng = Rng::new(35);
    for view in 0..12 {
        let shot = from_above(&mut rng);
        let expected = on_processor(&ldi, &shot, &options).picture;
        let found = picture(&mut gpu, &on_device, &shot, &options).picture;
        let covered = |pixel: &&[u8; 4]| pixel[3] == 255;
        assert!(expected.pixels().iter().filter(covered).count() > 3000, "view {view}");
        for (i, (found, expected)) in found.pixels().iter().zip(expected.pixels()).enumerate() {
            let off = (0..4).map(|c| found[c].abs_diff(expected[c])).max();
            // The two add up weights of up to a hundred depth pixels at a pixel, one of them in integers.
            assert!(off <= Some(STEPS), "{found:?} instead of {expected:?} at {i} in view {view}");
        }
    }
}

/// Returns an image of rows that all have these layered depth pixels, with a surface for each layer.
fn of_layers(layers: &[(f32, [u8; 4])]) -> Ldi {
    let camera = centred(40, 30, 40.0);
    let surfaces: Vec<_> = layers
        .iter()
        .map(|(inverse_depth, _)| quadratura_ldi::LdiSurface {
            nu: DVec3::new(0.0, 0.0, f64::from(*inverse_depth)),
            object: "pane".into(),
            face: None,
        })
        .collect();
    let column = |x: u16| {
        let pixel = move |(surface, &(inverse_depth, colour)): (u16, &(f32, [u8; 4]))| {
            (x, DepthPixel { inverse_depth, colour, surface, splat: Splat(0) })
        };
        (1..).zip(layers).map(pixel)
    };
    let rows = (0..30).map(|_| (0..40).flat_map(column).collect());
    with_level(ResolutionLevel::of_rows(camera, rows), camera_is_world(), surfaces)
}

#[test]
fn of_two_surfaces_at_nearly_the_same_depth_the_nearer_one_is_shown_as_far_as_it_is_opaque() {
    let Some(mut gpu) = on_adapter() else { return };
    let grey = |byte: u8, opacity| [byte, byte, byte, opacity];
    // Behind both, and seen where both are translucent, is a white wall.
    for (opacities, expected) in
        [([255, 255], 255), ([128, 255], 188), ([0, 255], 0), ([128, 0], 255), ([0, 128], 187), ([0, 0], 255)]
    {
        let layers = [(0.5, grey(255, opacities[0])), (0.4997, grey(0, opacities[1])), (0.1, grey(255, 255))];
        let ldi = of_layers(&layers);
        // Between the pixels of the image, where four of its pixels share each pixel of the picture.
        for offset in [0.0, 0.5] {
            let camera = ldi.camera;
            let moved = quadratura_base::geometry::Pinhole {
                cx: camera.cx + offset,
                cy: camera.cy + offset,
                ..camera
            };
            let options = WarpOptions { level: Some(0), ..WarpOptions::default() };
            let on_device = uploaded(&gpu, ldi.clone());
            let shot = Shot::new(moved, camera_is_world());
            let found = picture(&mut gpu, &on_device, &shot, &options).picture.pixels()[40 * 15 + 20];
            let off = (0..3).map(|c| found[c].abs_diff(expected)).max();
            // Positions in single precision give neighbours a weight of some thousandths, of white against black.
            assert!(off <= Some(2) && found[3] >= 254, "{found:?} with {opacities:?} at {offset}");
        }
    }
}

#[test]
fn what_is_far_away_and_of_slight_weights_does_not_vanish() {
    let Some(mut gpu) = on_adapter() else { return };
    let ldi = of_layers(&[(0.5, [100, 150, 200, 255])]);
    let on_device = uploaded(&gpu, ldi.clone());
    // From 200 times the distance, where the weights are less than two units of the sums.
    let away =
        quadratura_base::geometry::Pose { translation: DVec3::new(0.0, 0.0, 400.0), ..camera_is_world() };
    let shot = Shot::new(centred(3, 3, 40.0), away);
    let options = WarpOptions { level: Some(0), ..WarpOptions::default() };
    let expected = on_processor(&ldi, &shot, &options).picture.pixels()[4];
    let found = picture(&mut gpu, &on_device, &shot, &options).picture.pixels()[4];
    assert!(expected[3] > 20, "{expected:?}");
    // 1200 weights, each off by half a unit by chance: 17 of 1900 units, a hundredth.
    let off = (0..4).map(|c| found[c].abs_diff(expected[c])).max();
    assert!(off <= Some(4), "{found:?} instead of {expected:?}");
}
