//! Colours of surface points change little by little with the camera.
//!
//! Points are compared by [`Patch`]es: the same ones from every viewpoint, at the same level of
//! resolution, in the common exposure; the flight's own exposure is followed beside it. *Best photo*
//! makes no such promise: where another photo becomes the best one, colours jump.
//!
//! The proof has two halves. The twin computes without rounding, so its changes show directly whether a
//! change is gradual: over half of a short stride a gradual change is half as large, and a jump is as large
//! as before. The adapter's pictures are then held to the twin's changes: over every stride their largest
//! change may exceed the exact one by what rounding explains ([`ROUNDING`]), and not by more. The
//! adapter's own changes are not compared between strides, because over long strides colours do not change
//! linearly: the exact changes over 8 and 16 thousandths of a flight were seen to be up to 0.71 of each other, so a rule
//! of halves would test curvature there, and rounding would decide.

use glam::{DVec2, DVec3};
use quadratura::task::Task;
use quadratura::testing::geometry::polygon::PlaneFrame;
use quadratura::testing::gpu::Renderer;
use quadratura::testing::projection::Renders;
use quadratura::testing::projection::cells::{Unknown, cells};
use quadratura::testing::projection::exposure::visible_shares;
use quadratura::testing::projection::model_surface::ModelSurface;
use quadratura::testing::projection::relief::{FaceRelief, Relief};
use quadratura::testing::projection::twin::ReferenceRenderer;
use quadratura::testing::scene::light::srgb_from_linear;
use quadratura::testing::scene::synthetic::{Rng, random};
use quadratura::testing::scene::{FaceId, Model};
use quadratura::testing::view::flight::Flight;
use quadratura::testing::view::{Mode, Quality, Shot};

use crate::bench::Bench;
use crate::flights::{between, shot};
use crate::patch::Patch;
use crate::shoot::Shoot;

const CONTINUOUS: [Mode; 3] = [Mode::Debevec, Mode::Lumigraph, Mode::Smooth];

/// Surface points that are compared, at least.
const POINTS: usize = 5_000;

/// Frames that are looked at, a thousandth of the flight apart.
const FRAMES: usize = 9;

/// Distances between compared frames, in thousandths of a flight; each is twice the one before.
const STRIDES: [usize; 4] = [1, 2, 4, 8];

/// How much a change between two pictures may exceed the exact change, in steps of 8 bits, on any adapter.
/// Graphics interfaces allow an error of 0.6 steps where light is stored as sRGB, so 1.2 for two pictures.
/// (llvmpipe makes use of it: it takes the processor's approximate reciprocal square root, whose last
/// bits differ between makers.) *Previews* may round each lookup to 8 bits before photos are blended, which
/// is up to another step. The rest is for coordinates in f32 and filter weights of 8 bits. Of 150,000
/// changes the worst was off by 1.5 steps in *final* pictures and by 2.25 in *previews*.
const ROUNDING: f64 = 3.0;

/// The largest ratio between exact changes over half of the shortest stride and over all of it. A linear change
/// has 0.5; curvature was seen to make it 0.52 at most; a jump has 1.
const GRADUAL: f64 = 0.55;

/// A jump that must be noticed even where colours change the other way, in steps of 8 bits: the limit for
/// changes from frame to frame is up to 1.5 + [`ROUNDING`], and the jump loses up to 2 steps to the change.
const JUMP: u8 = 7;

/// What a colour of 255 changes by, in steps, when the logarithm of its light changes by 1: the slope of
/// sRGB there. Darker ones change less.
const STEPS_PER_LOG: f64 = 255.0 * 1.055 / 2.4;

/// A stretch of a flight with the surface points that can be seen all along it.
struct Stretch<'a> {
    bench: &'a Bench,
    surface: ModelSurface,
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
        (renderer, twin): (&mut Renderer, &mut ReferenceRenderer),
        heights: &'a [f64],
    ) -> Self {
        let surface = ModelSurface::from_model(&bench.site.model);
        let mut stretch = Self { bench, surface, flight, first_s, heights, patches: Vec::new() };
        let (eyes, mut rng) = (stretch.eyes(), Rng::new(seed));
        let texel = 1.0 / bench.site.photos[0].camera.fx;
        let (mut points, mut tries) = (0, 0..1000);
        while points < POINTS {
            tries.next().expect("the flight sees surfaces");
            let (model, view) = (&bench.site.model, stretch.view(0));
            let Some(patch) = Patch::random(&stretch.surface, model, &view, texel, &mut rng) else {
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
    fn served(&self, twin: &mut ReferenceRenderer, patch: &Patch, points: &[DVec3]) -> Vec<bool> {
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

    /// The pictures of all patches on the way.
    fn films(&self, renderer: &mut Renderer, mode: Mode, quality: Quality) -> Vec<Film<'_>> {
        let eyes = self.eyes();
        let mut films = Vec::new();
        for (patch, seen) in &self.patches {
            let mut draw = |&eye: &DVec3| {
                let mut shot = patch.shot(eye, self.height(patch));
                (shot.blend.mode, shot.quality) = (mode, quality);
                renderer.picture(&shot, &Task::silent()).unwrap().rgba
            };
            films.push(Film { frames: eyes.iter().map(&mut draw).collect(), seen });
        }
        films
    }

    /// The largest exact changes, as the twin computes them.
    fn exact_changes(&self, twin: &mut ReferenceRenderer, mode: Mode) -> Exact {
        let mut exact = Exact { half: 0.0, over: [0.0; STRIDES.len()] };
        for (patch, seen) in &self.patches {
            let points = patch.points(self.height(patch)).into_iter().zip(seen).filter(|(_, seen)| **seen);
            let points: Vec<DVec3> = points.map(|(point, _)| point).collect();
            let mut colours = |half_frame: usize| {
                let eye = shot(&self.flight, self.first_s + 0.5e-3 * half_frame as f64).viewpoint();
                let mut view = patch.shot(eye, self.height(patch));
                view.blend.mode = mode;
                let on_plane = points.iter().map(|point| (patch.face, patch.on_plane(eye, *point)));
                twin.colours_at(&view, &on_plane.collect::<Vec<_>>(), &Task::silent()).unwrap()
            };
            let halves: Vec<_> = (0..2 * FRAMES - 1).map(&mut colours).collect();
            let largest = |stride: usize| {
                let pairs = (0..halves.len() - stride).step_by(stride).map(|at| (at, at + stride));
                let points = pairs.flat_map(|(a, b)| halves[a].iter().zip(&halves[b]));
                points.map(|(a, b)| apart(a, b)).fold(0.0, f64::max)
            };
            exact.half = exact.half.max(largest(1));
            for (over, stride) in exact.over.iter_mut().zip(STRIDES) {
                *over = over.max(largest(2 * stride));
            }
        }
        exact
    }

    /// The largest change of the view's own exposure between frames, in steps of 8 bits of white.
    fn exposure_change(&self, mode: Mode) -> f64 {
        let Bench { site, sources, gains, .. } = self.bench;
        let exposure = |frame: usize| {
            let mut view = self.view(frame);
            view.blend.mode = mode;
            let cells = cells(&site.model, sources, &view, 16, &[], &[], &Unknown);
            let shares = visible_shares(&view, &site.model, sources, &self.surface, &cells);
            gains.of_view(&view.pose, &shares)
        };
        let all: Vec<[f64; 3]> = (0..FRAMES).map(exposure).collect();
        let pairs = all.windows(2).flat_map(|pair| (0..3).map(|c| (pair[1][c] - pair[0][c]).abs()));
        STEPS_PER_LOG * pairs.fold(0.0, f64::max)
    }
}

/// Of colours in linear light, in steps of 8 bits of sRGB, without rounding.
fn apart(a: &Option<[f64; 4]>, b: &Option<[f64; 4]>) -> f64 {
    let step = |a: f64, b: f64| 255.0 * (srgb_from_linear(a) - srgb_from_linear(b)).abs();
    match (a, b) {
        (Some(a), Some(b)) => (0..3).map(|c| step(a[c], b[c])).fold(0.0, f64::max),
        (None, None) => 0.0,
        _ => 255.0,
    }
}

/// The pictures of one patch, frame by frame.
struct Film<'a> {
    frames: Vec<Vec<u8>>,
    /// For each pixel whether it is seen in all of them.
    seen: &'a [bool],
}

impl Film<'_> {
    /// The largest change of a visible colour, alpha included, over a stride.
    fn change(&self, stride: usize) -> u8 {
        let pairs = (0..FRAMES - stride).step_by(stride).map(|at| (at, at + stride));
        pairs.map(|(a, b)| change(&self.frames[a], &self.frames[b], self.seen)).max().unwrap_or(0)
    }

    /// The same film in which all colours jump by [`JUMP`] steps in the middle, away from black or white.
    fn with_jump(&self) -> Self {
        let mut frames = self.frames.clone();
        for pixel in frames[FRAMES / 2..].iter_mut().flat_map(|frame| frame.chunks_mut(4)) {
            for value in &mut pixel[..3] {
                *value = if *value < 128 { *value + JUMP } else { *value - JUMP };
            }
        }
        Self { frames, seen: self.seen }
    }
}

/// The largest changes by stride, in steps of 8 bits.
fn changes(films: &[Film]) -> [u8; STRIDES.len()] {
    STRIDES.map(|stride| films.iter().map(|film| film.change(stride)).max().unwrap_or(0))
}

/// Between two pictures of a patch: of what is seen, alpha included.
fn change(a: &[u8], b: &[u8], seen: &[bool]) -> u8 {
    let pixels = a.chunks(4).zip(b.chunks(4)).zip(seen).filter(|(_, seen)| **seen);
    pixels.flat_map(|((a, b), _)| a.iter().zip(b)).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

/// The largest changes without rounding, in steps of 8 bits.
#[derive(Debug)]
struct Exact {
    /// Over half of the shortest stride.
    half: f64,
    /// Over each stride.
    over: [f64; STRIDES.len()],
}

impl Exact {
    /// The twin's colours change gradually.
    fn is_gradual(&self) -> bool {
        self.half <= GRADUAL * self.over[0]
    }

    /// An adapter's changes are these, but for rounding.
    fn explains(&self, changes: &[u8]) -> bool {
        changes.iter().zip(&self.over).all(|(change, exact)| f64::from(*change) <= exact + ROUNDING)
    }
}

/// Checks some flights, each from one photo to another, with faces this far off their planes. Returns the
/// largest change from frame to frame with *best photo*.
fn check(bench: &Bench, pairs: &[[usize; 2]], heights: &[f64], what: &str) -> u8 {
    let relief = raised(&bench.site.model, heights);
    let (mut renderer, mut twin) = (bench.renderer(&relief), bench.twin(&relief));
    let mut jumps = 0;
    for (seed, &pair) in (1..).zip(pairs) {
        let first_s = Rng::new(seed).between(0.1, 0.8);
        let flight = between(bench, pair, seed);
        let stretch = Stretch::new(bench, flight, (first_s, seed), (&mut renderer, &mut twin), heights);
        for mode in CONTINUOUS {
            let exposure = stretch.exposure_change(mode);
            let exact = stretch.exact_changes(&mut twin, mode);
            for quality in [Quality::Preview, Quality::Final] {
                let films = stretch.films(&mut renderer, mode, quality);
                let found = changes(&films);
                let line = format!(
                    "{what}, from photo {} to {}, {first_s:.3}, {mode}, {quality:?}: {found:?} over {STRIDES:?} \
                     thousandths of the flight; without rounding {:.3?} and, over half of the first, {:.3}; exposure \
                     {exposure:.3}",
                    pair[0], pair[1], exact.over, exact.half
                );
                println!("{line}");
                assert!(exact.over[0] + exposure <= 2.0 && exact.is_gradual(), "{line}");
                assert!(exact.explains(&found), "{line}");
                // A jump of a single patch would be noticed, whichever patch it is.
                let visible = films.iter().filter(|film| film.seen.contains(&true));
                let unnoticed = visible.filter(|film| exact.explains(&changes(&[film.with_jump()])));
                assert_eq!(unnoticed.count(), 0, "a jump by {JUMP} is not noticed: {line}");
            }
        }
        let jumping = stretch.exact_changes(&mut twin, Mode::Best);
        let has_jump = jumping.over[0] >= f64::from(JUMP);
        assert!(!has_jump || !jumping.is_gradual(), "jumps of the best photo seem gradual: {jumping:?}");
        jumps = jumps.max(changes(&stretch.films(&mut renderer, Mode::Best, Quality::Final))[0]);
    }
    println!("{what}: {jumps} with the best photo alone");
    jumps
}

/// Faces at these heights over their planes, all over.
fn raised(model: &Model, heights: &[f64]) -> Relief {
    let face = |(face, height): (FaceId, &f64)| {
        let frame = PlaneFrame::from_plane(&model.face(face).plane);
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
    let mut rng = Rng::new(17);
    model.face_ids().map(|_| (f64::from(rng.whole(0, 24)) - 12.0) / 256.0).collect()
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
fn nothing_pops_where_photos_contradict_each_other() {
    let Some(mut bench) = Bench::piazza(&["0"]) else { return };
    bench.contradict(10, &mut Rng::new(8));
    check(&bench, &[[0, 1], [2, 4]], &[], "piazza with contradictions");
}

#[test]
fn nothing_pops_on_flights_over_an_invented_site() {
    let scene = random::boxes(5, 8);
    let shoot = Shoot { photos: 9, depth: 20.0, angle_rad: 1.0, difference: 15.0 };
    let folder = tempfile::tempdir().unwrap();
    let site = shoot.site(&scene, &mut Rng::new(5), folder.path());
    let Some(bench) = Bench::of(site, folder) else { return };
    let jumps = check(&bench, &[[0, 1], [2, 3]], &[], "boxes");
    assert!(jumps > 10, "what is measured here would show it if something popped: {jumps}");
    check(&bench, &[[4, 5]], &random_heights(&bench.site.model), "boxes with relief");
    let mut pinned = bench;
    pinned.pin(0.5, &mut Rng::new(6));
    check(&pinned, &[[2, 3]], &[], "boxes, half of the faces pinned");
}
