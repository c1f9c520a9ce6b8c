//! The layers of a direction: what each texel of a slab shows, and what is painted where its colour or opacity differs.

use std::collections::{BTreeMap, BTreeSet};

use glam::Vec3;

use super::change::Change;
use super::frame::SlabFrame;
use crate::images::{MBuffer, MSample};
use quadratura_base::scene::light::{LINEAR_FROM_BYTE, linear_of_srgb, srgb_from_linear};

/// How many texels around paint are kept as unchanged, so that it ends where it was painted.
const RIM: i32 = 2;

/// A point of a surface that was painted, or one beside paint that was not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaintPoint {
    /// The point, in the sub-object's frame.
    pub at: Vec3,
    /// The change; none for a point beside paint.
    pub change: Change,
    /// True for leaves, which stand for the leaves that they hide in their slab.
    pub leaf: bool,
}

/// Paint where the plant has nothing. It is kept, and shown in exports, and changes no image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BesidePixel {
    /// The middle of the texel, in rotated coordinates ([`SlabFrame`]).
    pub at: [f32; 2],
    /// sRGB and opacity; an opacity of 0 takes away what was kept before.
    pub colour: [u16; 4],
}

/// What was painted in one slab of one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintedSlab {
    /// The direction, an index of [`super::DIRECTION_NAMES`].
    pub direction: usize,
    /// The slab, 0 nearest to the viewer.
    pub slab: usize,
    /// The side of a texel.
    pub delta: f64,
    /// The upper left corner of the image, in rotated coordinates.
    pub corner: [f64; 2],
    /// The far end of the slab, in rotated coordinates.
    pub far: f64,
    /// The points.
    pub points: Vec<PaintPoint>,
    /// The pixels where nothing is.
    pub beside: Vec<BesidePixel>,
}

/// What became of the painted pixels of a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SlabTally {
    /// Pixels whose colour or opacity changes something of the plant.
    pub painted: u64,
    /// Of these, pixels that are wholly transparent now.
    pub erased: u64,
    /// Of these, pixels that are more opaque than the plant is there: their colour alone is taken.
    pub more_opaque: u64,
    /// Pixels where the plant has nothing.
    pub beside: u64,
}

/// Painted pixels of a slab: column, row, and sRGB with opacity.
pub type SlabPixels = Vec<(u32, u32, [u16; 4])>;

/// A view with its samples by texel.
struct SlabTexels<'a> {
    view: &'a MBuffer,
    frame: &'a SlabFrame,
    direction: usize,
    /// The index of the first sample of each texel.
    first: Vec<usize>,
}

impl<'a> SlabTexels<'a> {
    fn new(view: &'a MBuffer, frame: &'a SlabFrame, direction: usize) -> Self {
        let starts = view.counts.iter().scan(0, |next, count| {
            let first = *next;
            *next += usize::from(*count);
            Some(first)
        });
        Self { view, frame, direction, first: starts.collect() }
    }

    /// Returns the samples of a texel that are in a slab, nearest first.
    fn samples(&self, (x, y): (u32, u32), slab: usize) -> impl Iterator<Item = &'a MSample> {
        let pixel = (y * self.frame.side + x) as usize;
        let samples = &self.view.samples[self.first[pixel]..][..usize::from(self.view.counts[pixel])];
        let (frame, direction) = (self.frame, self.direction);
        samples.iter().filter(move |of| frame.slab(direction, frame.depth(of.depth)) == slab)
    }

    /// Returns what a texel of a slab shows: the mean colour of the sub-pixels that are covered, as sRGB, and their share.
    fn shown(&self, texel: (u32, u32), slab: usize) -> [u8; 4] {
        let (mut left, mut sum) = (u16::MAX, Vec3::ZERO);
        for sample in self.samples(texel, slab) {
            let seen = sample.mask & left;
            left &= !seen;
            sum += seen.count_ones() as f32 * sample.reflected();
        }
        let covered = left.count_zeros();
        if covered == 0 {
            return [0; 4];
        }
        let byte = |linear: f32| (255.0 * srgb_from_linear(f64::from(linear.clamp(0.0, 1.0)))).round() as u8;
        let [r, g, b] = (sum / covered as f32).to_array().map(byte);
        [r, g, b, (255.0 * covered as f32 / 16.0).round() as u8]
    }

    fn points(&self, texel: (u32, u32), slab: usize, change: Change) -> impl Iterator<Item = PaintPoint> {
        self.samples(texel, slab).map(move |sample| {
            let middle = sample.middle().as_dvec2() + 0.5;
            let place = [f64::from(texel.0) + middle.x, f64::from(texel.1) + middle.y];
            let at = self.frame.point(self.direction, place, self.frame.depth(sample.depth));
            PaintPoint { at: at.as_vec3(), change, leaf: sample.normal.is_leaf() }
        })
    }
}

/// Returns what the slabs of a direction show, nearest first: for each `side` x `side` texels row by row, R, G, B as sRGB and the
/// share that is covered, straight alpha.
pub fn slab_pictures(view: &MBuffer, frame: &SlabFrame, direction: usize) -> Vec<Vec<[u8; 4]>> {
    let texels = SlabTexels::new(view, frame, direction);
    let places = || (0..frame.side).flat_map(|y| (0..frame.side).map(move |x| (x, y)));
    (0..usize::from(frame.slabs)).map(|slab| places().map(|at| texels.shown(at, slab)).collect()).collect()
}

/// Returns the paint of the slabs of a direction whose pixels differ from what they show, with what became of them. `painted` has
/// the pixels by slab; all are within the image.
pub fn painted_slabs(
    view: &MBuffer,
    frame: &SlabFrame,
    direction: usize,
    painted: &BTreeMap<usize, SlabPixels>,
) -> BTreeMap<usize, (PaintedSlab, SlabTally)> {
    let texels = SlabTexels::new(view, frame, direction);
    let places = |pixels: &SlabPixels| pixels.iter().map(|(x, y, _)| (*x, *y)).collect::<BTreeSet<_>>();
    let places: BTreeMap<usize, BTreeSet<(u32, u32)>> =
        painted.iter().map(|(slab, pixels)| (*slab, places(pixels))).collect();
    let of_slab = |(&slab, pixels): (&usize, &SlabPixels)| (slab, one_slab(&texels, slab, pixels, &places));
    painted.iter().map(of_slab).collect()
}

fn one_slab(
    texels: &SlabTexels,
    slab: usize,
    pixels: &SlabPixels,
    places: &BTreeMap<usize, BTreeSet<(u32, u32)>>,
) -> (PaintedSlab, SlabTally) {
    let SlabTexels { frame, direction, .. } = *texels;
    let corner = frame.corner(direction);
    let (mut points, mut beside, mut tally) = (Vec::new(), Vec::new(), SlabTally::default());
    for &(x, y, colour) in pixels {
        let shown = texels.shown((x, y), slab);
        if shown[3] == 0 {
            let middle = |index: u32, corner: f64| (corner + (f64::from(index) + 0.5) * frame.delta) as f32;
            beside.push(BesidePixel { at: [middle(x, corner[0]), middle(y, corner[1])], colour });
            tally.beside += 1;
            continue;
        }
        let opacity = f32::from(colour[3]) / f32::from(u16::MAX);
        let ratio = opacity * 255.0 / f32::from(shown[3]);
        tally.painted += 1;
        tally.erased += u64::from(colour[3] == 0);
        tally.more_opaque += u64::from(ratio > 1.004);
        points.extend(texels.points((x, y), slab, change(shown, colour, ratio)));
    }
    if !points.is_empty() {
        points.extend(rim(texels, slab, &places[&slab], places));
    }
    let far = frame.far(direction, slab);
    (PaintedSlab { direction, slab, delta: frame.delta, corner, far, points, beside }, tally)
}

/// Returns the change of a texel that shows something to a painted colour, whose opacity is so many times what it was.
fn change(shown: [u8; 4], painted: [u16; 4], ratio: f32) -> Change {
    // Steps of 8 bits are no change of opacity.
    let alpha = if ratio > 0.996 { 1.0 } else { ratio };
    if painted[3] == 0 {
        return Change { alpha: 0.0, ..Change::NONE };
    }
    let before =
        Vec3::from_array([0, 1, 2].map(|channel: usize| LINEAR_FROM_BYTE[usize::from(shown[channel])]));
    let after = [0, 1, 2].map(|channel: usize| match painted[channel] == 257 * u16::from(shown[channel]) {
        true => before[channel],
        false => linear_of_srgb(f64::from(painted[channel]) / f64::from(u16::MAX)) as f32,
    });
    Change { alpha, ..Change::of_colour(before, Vec3::from_array(after)) }
}

/// Returns the points around painted texels that were not painted, of this slab and of those before and behind it.
fn rim<'a>(
    texels: &'a SlabTexels,
    slab: usize,
    painted: &BTreeSet<(u32, u32)>,
    places: &'a BTreeMap<usize, BTreeSet<(u32, u32)>>,
) -> Vec<PaintPoint> {
    let side = texels.frame.side as i32;
    let mut around: BTreeSet<(u32, u32)> = BTreeSet::new();
    for &(x, y) in painted {
        for (dx, dy) in (-RIM..=RIM).flat_map(|dy| (-RIM..=RIM).map(move |dx| (dx, dy))) {
            let (x, y) = (x as i32 + dx, y as i32 + dy);
            if (0..side).contains(&x) && (0..side).contains(&y) {
                around.insert((x as u32, y as u32));
            }
        }
    }
    let slabs = slab.saturating_sub(1)..=(slab + 1).min(usize::from(texels.frame.slabs) - 1);
    let mut points = Vec::new();
    for other in slabs {
        let is_painted = |texel: &(u32, u32)| places.get(&other).is_some_and(|of| of.contains(texel));
        for &texel in around.iter().filter(|texel| !is_painted(texel)) {
            let of_texel = texels.points(texel, other, Change::NONE);
            // Those of other slabs hide nothing in this one.
            points.extend(of_texel.map(|point| PaintPoint { leaf: point.leaf && other == slab, ..point }));
        }
    }
    points
}
