//! Colours of surface points change little by little with the camera.
//!
//! Points are compared by [`Patch`]es: the same ones from every viewpoint, at the same level of
//! resolution, in the common exposure; the flight's own exposure is followed beside it. Of *best photo*
//! nothing of the kind is promised: where another photo becomes the best one, colours jump.

use glam::{DVec2, DVec3};
use quadratura::geometry::polygon::PlaneFrame;
use quadratura::gpu::Renderer;
use quadratura::projection::cells::{Unknown, cells};
use quadratura::projection::exposure::seen_shares;
use quadratura::projection::flight::Flight;
use quadratura::projection::relief::{FaceRelief, Relief};
use quadratura::projection::surface::Surface;
use quadratura::projection::twin::Twin;
use quadratura::projection::{Mode, Quality, Renders, Shot};
use quadratura::scene::light::srgb_of_linear;
use quadratura::scene::synthetic::{Dice, random};
use quadratura::scene::{FaceId, Model};
use quadratura::task::Task;

use crate::bench::Bench;
use crate::flights::{between, shot};
use crate::patch::Patch;
use crate::shoot::Shoot;

const CONTINUOUS: [Mode; 3] = [Mode::Debevec, Mode::Lumigraph, Mode::Smooth];

/// Surface points that are compared, at least.
const POINTS: usize = 10_000;

/// Frames that are looked at, a thousandth of the flight apart.
const FRAMES: usize = 17;

/// Of frames so many thousandths of a flight apart, each twice the one before.
const STRIDES: [usize; 5] = [1, 2, 4, 8, 16];

/// What a colour of 255 changes by, in steps, when the logarithm of its light changes by 1: the slope of
/// sRGB there. Darker ones change less.
const STEPS_PER_LOG: f64 = 255.0 * 1.055 / 2.4;

/// A stretch of a flight with the surface points that can be seen all along it.
struct Stretch<'a> {
    bench: &'a Bench,
    surface: Surface,
    flight: Flight,
    first_s: f64,
    /// Of each face; those beyond the list have none.
    heights: &'a [f64],
    /// With the pixels that are seen.
    patches: Vec<(Patch, Vec<bool>)>,
}

impl<'a> Stretch<'a> {
    fn new(
        bench: &'a Bench,
        flight: Flight,
        (first_s, seed): (f64, u64),
        (renderer, twin): (&mut Renderer, &mut Twin),
        heights: &'a [f64],
    ) -> Self {
        let surface = Surface::of(&bench.site.model);
        let mut stretch = Self { bench, surface, flight, first_s, heights, patches: Vec::new() };
        let (eyes, mut dice) = (stretch.eyes(), Dice::new(seed));
        let texel = 1.0 / bench.site.photos[0].camera.fx;
        let (mut points, mut tries) = (0, 0..1000);
        while points < POINTS {
            tries.next().expect("the flight sees surfaces");
            let (model, view) = (&bench.site.model, stretch.view(0));
            let Some(patch) = Patch::random(&stretch.surface, model, &view, texel, &mut dice) else {
                continue;
            };
            let mut seen = patch.seen(renderer, &eyes, stretch.height(&patch));
            if !heights.is_empty() {
                let raised = patch.points(stretch.height(&patch));
                let served = stretch.served(twin, &patch, &raised);
                seen.iter_mut().zip(served).for_each(|(seen, served)| *seen &= served);
            }
            points += seen.iter().filter(|seen| **seen).count();
            stretch.patches.push((patch, seen));
        }
        stretch
    }

    /// For each point of a relief whether a photo shows it. Where none does one may show the plane: that is
    /// no point that stays where it is while the view moves.
    fn served(&self, twin: &mut Twin, patch: &Patch, points: &[DVec3]) -> Vec<bool> {
        let mut view = patch.shot(self.view(0).viewpoint(), 0.0);
        // The points are taken as they are.
        view.relief = false;
        let points: Vec<_> = points.iter().map(|point| (patch.face, *point)).collect();
        let colours = twin.colours_at(&view, &points, &Task::silent()).unwrap();
        colours.iter().map(Option::is_some).collect()
    }

    fn height(&self, patch: &Patch) -> f64 {
        self.heights.get(patch.face.0 as usize).copied().unwrap_or(0.0)
    }

    fn view(&self, frame: usize) -> Shot {
        shot(&self.flight, self.first_s + 1e-3 * frame as f64)
    }

    fn eyes(&self) -> Vec<DVec3> {
        (0..FRAMES).map(|frame| self.view(frame).viewpoint()).collect()
    }

    /// The largest change of a colour, in steps of 8 bits, by stride.
    fn changes(&self, renderer: &mut Renderer, mode: Mode, quality: Quality) -> [u8; STRIDES.len()] {
        let eyes = self.eyes();
        let mut largest = [0; STRIDES.len()];
        for (patch, seen) in &self.patches {
            let mut draw = |&eye: &DVec3| {
                let mut shot = patch.shot(eye, self.height(patch));
                (shot.blend.mode, shot.quality) = (mode, quality);
                renderer.picture(&shot, &Task::silent()).unwrap().rgba
            };
            let frames: Vec<Vec<u8>> = eyes.iter().map(&mut draw).collect();
            for (largest, stride) in largest.iter_mut().zip(STRIDES) {
                for first in (0..FRAMES - stride).step_by(stride) {
                    *largest = (*largest).max(change(&frames[first], &frames[first + stride], seen));
                }
            }
        }
        largest
    }

    /// The same without rounding, as the twin has it, over a thousandth of the flight and half of that.
    fn exact_changes(&self, twin: &mut Twin, mode: Mode) -> [f64; 2] {
        let mut largest = [0.0f64; 2];
        for (patch, seen) in &self.patches {
            let points = patch.points(self.height(patch)).into_iter().zip(seen).filter(|(_, seen)| **seen);
            let points: Vec<DVec3> = points.map(|(point, _)| point).collect();
            let mut colours = |time_s: f64| {
                let eye = shot(&self.flight, self.first_s + time_s).viewpoint();
                let mut view = patch.shot(eye, self.height(patch));
                view.blend.mode = mode;
                let on_plane = points.iter().map(|point| (patch.face, patch.on_plane(eye, *point)));
                twin.colours_at(&view, &on_plane.collect::<Vec<_>>(), &Task::silent()).unwrap()
            };
            let [before, after, halfway] = [0.0, 1e-3, 0.5e-3].map(&mut colours);
            for (largest, other) in largest.iter_mut().zip([after, halfway]) {
                *largest = before.iter().zip(&other).map(|(a, b)| apart(a, b)).fold(*largest, f64::max);
            }
        }
        largest
    }

    /// The largest change of the view's own exposure between frames, in steps of 8 bits of white.
    fn exposure_change(&self, mode: Mode) -> f64 {
        let Bench { site, sources, gains, .. } = self.bench;
        let exposure = |frame: usize| {
            let mut view = self.view(frame);
            view.blend.mode = mode;
            let cells = cells(&site.model, sources, &view, 16, &[], &Unknown);
            let shares = seen_shares(&view, &site.model, sources, &self.surface, &cells);
            gains.of_view(&view.pose, &shares)
        };
        let all: Vec<[f64; 3]> = (0..FRAMES).map(exposure).collect();
        let pairs = all.windows(2).flat_map(|pair| (0..3).map(|c| (pair[1][c] - pair[0][c]).abs()));
        STEPS_PER_LOG * pairs.fold(0.0, f64::max)
    }
}

/// Of colours in linear light, in steps of 8 bits of sRGB, without rounding.
fn apart(a: &Option<[f64; 3]>, b: &Option<[f64; 3]>) -> f64 {
    let step = |a: f64, b: f64| 255.0 * (srgb_of_linear(a) - srgb_of_linear(b)).abs();
    match (a, b) {
        (Some(a), Some(b)) => (0..3).map(|c| step(a[c], b[c])).fold(0.0, f64::max),
        (None, None) => 0.0,
        _ => 255.0,
    }
}

/// Between two pictures of a patch: of what is seen, alpha included.
fn change(a: &[u8], b: &[u8], seen: &[bool]) -> u8 {
    let pixels = a.chunks(4).zip(b.chunks(4)).zip(seen).filter(|(_, seen)| **seen);
    pixels.flat_map(|((a, b), _)| a.iter().zip(b)).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

/// What does not pop changes by half as much in half a step. A quarter of that is left for curvature, and
/// pictures of 8 bits move each difference by less than one step, up or down.
fn halves(changes: &[u8]) -> bool {
    let fits = |pair: &[u8]| f64::from(pair[0]) - 1.0 <= 0.625 * (f64::from(pair[1]) + 1.0);
    changes.windows(2).all(fits)
}

/// All along some flights, from one photo to another each, with faces so far off their planes. The largest
/// change from frame to frame with *best photo*.
fn check(bench: &Bench, pairs: &[[usize; 2]], heights: &[f64], what: &str) -> u8 {
    let relief = raised(&bench.site.model, heights);
    let (mut renderer, mut twin) = (bench.renderer(&relief), bench.twin(&relief));
    let mut jumps = 0;
    for (seed, &pair) in (1..).zip(pairs) {
        let first_s = Dice::new(seed).between(0.1, 0.8);
        let flight = between(bench, pair, seed);
        let stretch = Stretch::new(bench, flight, (first_s, seed), (&mut renderer, &mut twin), heights);
        for mode in CONTINUOUS {
            let exposure = stretch.exposure_change(mode);
            let [step, half] = stretch.exact_changes(&mut twin, mode);
            for quality in [Quality::Preview, Quality::Final] {
                let changes = stretch.changes(&mut renderer, mode, quality);
                let line = format!(
                    "{what}, from photo {} to {}, {first_s:.3}, {mode}, {quality:?}: {changes:?} over {STRIDES:?} \
                     thousandths of the flight; {step:.3} and, in half a step, {half:.3} without rounding; \
                     exposure {exposure:.3}",
                    pair[0], pair[1]
                );
                println!("{line}");
                assert!(changes[0] <= 2 && halves(&changes), "{line}");
                assert!(step + exposure <= 2.0 && half <= 0.625 * step, "{line}");
            }
        }
        jumps = jumps.max(stretch.changes(&mut renderer, Mode::Best, Quality::Final)[0]);
    }
    println!("{what}: {jumps} with the best photo alone");
    jumps
}

/// Faces at these heights over their planes, all over.
fn raised(model: &Model, heights: &[f64]) -> Relief {
    let face = |(face, height): (FaceId, &f64)| {
        let frame = PlaneFrame::of(&model.face(face).plane);
        let heights = vec![*height as f32];
        model.face(face).planar.then_some(FaceRelief {
            frame,
            low: DVec2::ZERO,
            cell: 1.0,
            size: [1, 1],
            heights,
        })
    };
    Relief { of_face: model.face_ids().zip(heights).map(face).collect() }
}

/// Of every face, up to 5 cm up or down, in steps that 16 bits hold exactly.
fn random_heights(model: &Model) -> Vec<f64> {
    let mut dice = Dice::new(17);
    model.face_ids().map(|_| (f64::from(dice.whole(0, 24)) - 12.0) / 256.0).collect()
}

#[test]
fn nothing_pops_on_flights_over_the_piazza() {
    let Some(bench) = Bench::piazza(&["0"]) else { return };
    let pairs = [[0, 1], [2, 4], [7, 3]];
    let jumps = check(&bench, &pairs, &[], "piazza");
    assert!(jumps > 20, "what is measured here would show it if something popped: {jumps}");
    check(&bench, &pairs[..2], &random_heights(&bench.site.model), "piazza with relief");
}

#[test]
fn nothing_pops_on_flights_over_an_invented_site() {
    let scene = random::boxes(5, 8);
    let shoot = Shoot { photos: 9, depth: 20.0, spread_rad: 1.0, difference: 15.0 };
    let folder = tempfile::tempdir().unwrap();
    let site = shoot.site(&scene, &mut Dice::new(5), folder.path());
    let Some(bench) = Bench::of(site, folder) else { return };
    let jumps = check(&bench, &[[0, 1], [2, 3]], &[], "boxes");
    assert!(jumps > 10, "what is measured here would show it if something popped: {jumps}");
    check(&bench, &[[4, 5]], &random_heights(&bench.site.model), "boxes with relief");
    let mut pinned = bench;
    pinned.pin(0.5, &mut Dice::new(6));
    check(&pinned, &[[2, 3]], &[], "boxes, half of the faces pinned");
}
