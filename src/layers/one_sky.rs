//! One sky for all photos: the factors that bring each photo's surroundings to a common, smooth brightness and colour
//! ([`quadratura_projection::exposure::surroundings`], `docs/method.md`, section 7).
//!
//! On a coarse cube of directions, offsets of whole photos are found first, from the directions that two photos or more show
//! unclipped, robustly. The common sky is then the mean of the photos, each with a weight that falls to 0 at its frame, so that it
//! has no trace of frames. Clipped channels are unknown, but no darker than they are shown. At last each photo gets the slowly
//! varying factors that remain between it and the common sky; where both differ by what they show, such as something near, the
//! factors continue from around.
//!
//! Two bands in the sense of Burt and Adelson (*A Multiresolution Spline With Application to Image Mosaics*, 1983): low frequencies
//! are blended over whole photos, detail at their frames alone.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::agreement::directions::{DirectionPhoto, DirectionPhotos};
use super::dome::{BLACK, STRAY, filled};
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_projection::dome::CubeMap;
use quadratura_projection::exposure::surroundings::{GRID, SurroundingsFactors};

/// The cells along a side of the coarse cube: about as fine as the photos' grids.
const SIDE: usize = 56;

/// Every so many rows and columns of the reduced photos are looked at.
const STEP: usize = 2;

/// The distance from what is not surroundings, in reduced pixels, over which the weight of a photo rises.
const RAMP_PX: f32 = 8.0;

/// The share of a photo's own weight by which its offset is held at 0, and that by which channels are held at the one that is known
/// best: whites differ less than brightnesses do, and little may be known of a channel that is mostly clipped.
const HELD: f32 = 0.002;
const HELD_HUE: f32 = 0.1;

/// The weight of a photo by the distance from its frame from which on the common sky follows what it shows where photos meet: a third
/// of the way to its middle.
const INNER: f32 = 0.1;

/// The number of times that offsets and the common sky are found from each other.
const ROUNDS: usize = 60;

/// The weight of a cell's neighbours in a photo's grid, in pixels that were looked at: as much as the cell's own in a photo of 1024
/// pixels, so that noise and small clouds do not count. And the number of times that cells are averaged with their neighbours: 400
/// carry a value over 20 cells.
const NEIGHBOURS: f32 = 256.0;
const SMOOTHINGS: usize = 400;

/// The largest factor that is found at once, as a natural logarithm: clipped photos may be two stops from what others show.
const LARGEST: f32 = 1.5;

/// What a photo shows in one cell of the coarse cube, by channel; logarithms of light in the common exposure.
#[derive(Debug, Clone, Copy, Default)]
struct CellSums {
    /// Sums of logarithms with weights, and of weights, where the channel is not clipped.
    known: [(f32, f32); 3],
    /// The same where it is.
    clipped: [(f32, f32); 3],
    /// The sums of weights without regard to frames, and with it.
    whole: f32,
    feathered: f32,
}

impl CellSums {
    /// Returns the mean logarithm of a channel that is not clipped, and its weight without regard to frames: photos that overlap in
    /// a narrow strip are compared by it, although neither counts for much in the common sky there.
    fn compared(&self, c: usize) -> Option<(f32, f32)> {
        let (sum, weight) = self.known[c];
        (weight > 0.0).then(|| (sum / weight, weight * self.whole / self.feathered))
    }
}

/// What a photo shows in the cells of the coarse cube.
type Coarse = BTreeMap<usize, CellSums>;

/// The common sky: logarithms of light by cell of the coarse cube.
type Sky = CubeMap<[f32; 3]>;

/// Finds the factors of each photo, in the order of `photos`; each counts as far as others confirm it.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`], and those of reading photos back.
pub fn one_sky(photos: &dyn DirectionPhotos, task: &Task) -> Result<Vec<SurroundingsFactors>> {
    task.check_cancelled()?;
    let numbers = || (0..photos.count()).into_par_iter();
    let coarse: Vec<Coarse> =
        numbers().map(|number| Ok(coarse(&*photos.photo(number)?))).collect::<Result<_>>()?;
    task.check_cancelled()?;
    let offsets = offsets(&coarse);
    let sky = common_sky(&coarse, &offsets);
    task.check_cancelled()?;
    numbers().map(|number| Ok(factors(&*photos.photo(number)?, offsets[number], &sky))).collect()
}

/// A pixel of a photo that is looked at.
struct Looked {
    px: DVec2,
    direction: DVec3,
    /// The logarithms of its light in the common exposure.
    log: [f32; 3],
    /// How far each channel is known, 0 where it is clipped.
    known: [f32; 3],
    trust: f32,
}

/// Returns what is looked at of a photo.
fn looked(photo: &DirectionPhoto) -> impl Iterator<Item = Looked> {
    let [width, height] = [photo.camera.width as usize, photo.camera.height as usize];
    let places = (0..height).step_by(STEP).flat_map(move |y| (0..width).step_by(STEP).map(move |x| (x, y)));
    places.filter_map(move |(x, y)| {
        let at = y * width + x;
        let place = photo.place(at)?;
        let light = photo.exposed(at)?;
        let px = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let ramp = (f32::from(photo.inside_px(at)) / RAMP_PX).min(1.0);
        Some(Looked {
            px,
            direction: photo.pose.rotation.transpose() * photo.camera.ray_in_camera(px),
            log: light.map(|light| light.max(BLACK).ln()),
            known: photo.known(at),
            trust: photo.agreement(place) * photo.agreement(place) * ramp,
        })
    })
}

/// Returns the weight of a photo at a position, 1 in its middle, falling to 0 at its frame.
fn feather(photo: &DirectionPhoto, px: DVec2) -> f32 {
    let size = DVec2::new(f64::from(photo.camera.width), f64::from(photo.camera.height));
    let edge = px.min(size - px).min_element() / (0.5 * size.min_element());
    (edge * edge) as f32
}

/// Returns what a photo shows on the coarse cube.
fn coarse(photo: &DirectionPhoto) -> Coarse {
    let mut cells = Coarse::new();
    for seen in looked(photo).filter(|seen| seen.trust > 0.0) {
        let sums = cells.entry(Sky::cell_of(SIDE, seen.direction)).or_default();
        let weight = seen.trust * feather(photo, seen.px);
        sums.whole += seen.trust;
        sums.feathered += weight;
        for c in 0..3 {
            let parts = [(&mut sums.known[c], seen.known[c]), (&mut sums.clipped[c], 1.0 - seen.known[c])];
            for ((sum, all), share) in parts {
                *sum += weight * share * seen.log[c];
                *all += weight * share;
            }
        }
    }
    cells
}

/// Returns the weight of a difference of logarithms: what differs more shows something else.
fn robust(difference: f32) -> f32 {
    1.0 / (1.0 + (difference / STRAY).powi(2))
}

/// Returns the channel of which most is known.
fn best_known(known: [f32; 3]) -> usize {
    (0..3).max_by(|a, b| known[*a].total_cmp(&known[*b])).unwrap_or(0)
}

/// Returns the logarithms that bring whole photos nearest to one another.
fn offsets(photos: &[Coarse]) -> Vec<[f32; 3]> {
    let known = |c: usize| photos.iter().flat_map(Coarse::values).map(|sums| sums.known[c].1).sum::<f32>();
    let best = best_known([0, 1, 2].map(known));
    let mut offsets = vec![[0.0f32; 3]; photos.len()];
    let groups = groups(photos);
    let order = [best, (best + 1) % 3, (best + 2) % 3];
    for c in order.into_iter().flat_map(|c| std::iter::repeat_n(c, ROUNDS)) {
        let mut means: BTreeMap<usize, (f32, f32)> = BTreeMap::new();
        for (photo, offset) in photos.iter().zip(&offsets) {
            for (cell, sums) in photo {
                if let Some((light, weight)) = sums.compared(c) {
                    let mean = means.entry(*cell).or_default();
                    mean.0 += weight * (light + offset[c]);
                    mean.1 += weight;
                }
            }
        }
        for (photo, offset) in photos.iter().zip(&mut offsets) {
            let (mut sum, mut all) = (0.0, 0.0);
            for (cell, (light, weight)) in photo.iter().filter_map(|(at, sums)| Some((at, sums.compared(c)?)))
            {
                let (of_all, weight_of_all) = means[cell];
                let others = weight_of_all - weight;
                // What one photo alone shows says nothing about offsets.
                if others > 1e-3 * weight {
                    let mean = (of_all - weight * (light + offset[c])) / others;
                    let apart = mean - light;
                    let weight = weight * others / weight_of_all * robust(apart - offset[c]);
                    sum += weight * apart;
                    all += weight;
                }
            }
            let own: f32 = photo.values().map(|sums| sums.whole).sum();
            let (at, held) = if c == best { (0.0, HELD * own) } else { (offset[best], HELD_HUE * own) };
            offset[c] = (sum + held * at) / (all + held).max(f32::MIN_POSITIVE);
        }
        level(photos, &groups, &mut offsets, c);
    }
    offsets
}

/// Returns the group of each photo: those of a group show common cells, directly or by way of others.
fn groups(photos: &[Coarse]) -> Vec<usize> {
    let mut groups: Vec<usize> = (0..photos.len()).collect();
    let mut first: BTreeMap<usize, usize> = BTreeMap::new();
    for (number, photo) in photos.iter().enumerate() {
        for cell in photo.keys() {
            let other = groups[*first.entry(*cell).or_insert(number)];
            let own = groups[number];
            if other != own {
                groups.iter_mut().filter(|group| **group == own).for_each(|group| *group = other);
            }
        }
    }
    groups
}

/// Shifts a channel's offsets so that their mean is 0 within each group: only their differences are known.
fn level(photos: &[Coarse], groups: &[usize], offsets: &mut [[f32; 3]], c: usize) {
    let mut means = vec![(0.0f32, 0.0f32); photos.len()];
    for ((photo, group), offset) in photos.iter().zip(groups).zip(offsets.iter()) {
        let own: f32 = photo.values().map(|sums| sums.whole).sum();
        means[*group].0 += own * offset[c];
        means[*group].1 += own;
    }
    for (offset, group) in offsets.iter_mut().zip(groups) {
        let (sum, all) = means[*group];
        offset[c] -= sum / all.max(f32::MIN_POSITIVE);
    }
}

/// Returns the common sky of photos with these offsets, in all directions.
fn common_sky(photos: &[Coarse], offsets: &[[f32; 3]]) -> Sky {
    let mut channels: [Vec<(f32, f32)>; 3] = [0, 1, 2].map(|_| vec![(0.0, 0.0); Sky::cells(SIDE)]);
    let mut least = vec![[f32::NEG_INFINITY; 3]; Sky::cells(SIDE)];
    let inner = inner(photos);
    for (c, values) in channels.iter_mut().enumerate() {
        let each = || {
            photos
                .iter()
                .zip(offsets)
                .flat_map(|(photo, offset)| photo.iter().zip(std::iter::repeat(offset[c])))
        };
        let mut first = vec![(0.0f32, 0.0f32); values.len()];
        for ((cell, sums), offset) in each() {
            let (sum, weight) = sums.known[c];
            first[*cell].0 += sum + weight * offset;
            first[*cell].1 += weight;
        }
        let mut clipped = vec![0.0f32; values.len()];
        for ((cell, sums), offset) in each() {
            let ((sum, weight), (bound, of_bound)) = (sums.known[c], sums.clipped[c]);
            if weight > 0.0 {
                let light = sum / weight + offset;
                let weight = weight * robust(light - first[*cell].0 / first[*cell].1);
                values[*cell].0 += weight * light;
                values[*cell].1 += weight;
            }
            if of_bound > 0.0 {
                clipped[*cell] += of_bound;
                // Few clipped pixels are noise.
                if of_bound > weight {
                    least[*cell][c] = least[*cell][c].max(bound / of_bound + offset);
                }
            }
        }
        for ((sum, weight), (clipped, inner)) in values.iter_mut().zip(clipped.into_iter().zip(&inner)) {
            *sum /= weight.max(f32::MIN_POSITIVE);
            *weight *= inner / (*weight + clipped).max(f32::MIN_POSITIVE);
        }
    }
    continued(&channels, &least)
}

/// Returns how closely the common sky follows the photos in each cell, 0 to 1: less where photos meet that show the cell near their
/// frames alone, so that it goes over from one to the other gradually.
fn inner(photos: &[Coarse]) -> Vec<f32> {
    let mut cells = vec![(0.0f32, 0u32); Sky::cells(SIDE)];
    for (cell, sums) in photos.iter().flatten() {
        let (inner, count) = &mut cells[*cell];
        *inner = inner.max(sums.feathered / sums.whole / INNER);
        *count += 1;
    }
    cells.into_iter().map(|(inner, count)| if count > 1 { inner.min(1.0) } else { 1.0 }).collect()
}

/// Returns the common sky from what is known of each channel, logarithms with weights of 0 to 1, and the least that each has in each
/// cell. Cells that are mostly clipped continue what is known around them: the channel that is known best its brightness, the others
/// their hue, which changes less.
fn continued(channels: &[Vec<(f32, f32)>; 3], least: &[[f32; 3]]) -> Sky {
    let best = best_known([0, 1, 2].map(|c| channels[c].iter().map(|(_, known)| known).sum()));
    let fill = |values: Vec<(f32, f32)>| {
        let values = values.into_iter().map(|(log, known)| ([log; 3], known)).collect();
        filled(&CubeMap { side: SIDE, values }).values.into_iter().map(|[log, ..]| log).collect::<Vec<f32>>()
    };
    let bounded = |log: f32, at: usize, c: usize| log.max(least[at][c]);
    let brightness = fill(channels[best].clone());
    let brightness: Vec<f32> = (0..).zip(brightness).map(|(at, log)| bounded(log, at, best)).collect();
    let mut sky = vec![[0.0; 3]; brightness.len()];
    for (c, values) in channels.iter().enumerate() {
        let both = values.iter().zip(&channels[best]);
        let hue = fill(
            both.map(|((log, known), (of_best, best_known))| (log - of_best, known * best_known)).collect(),
        );
        for (at, (log, known)) in values.iter().enumerate() {
            let continued = brightness[at] + if c == best { 0.0 } else { hue[at] };
            sky[at][c] = bounded(known * log + (1.0 - known) * continued, at, c);
        }
    }
    CubeMap { side: SIDE, values: sky }
}

/// Returns the factors that bring a photo to the common sky.
fn factors(photo: &DirectionPhoto, offset: [f32; 3], sky: &Sky) -> SurroundingsFactors {
    let mut cells = vec![([0.0f32; 3], 0.0f32); GRID * GRID];
    let mut known = [(0.0f32, 0.0f32); 3];
    let mut all = 0.0;
    let size = DVec2::new(f64::from(photo.camera.width), f64::from(photo.camera.height));
    for seen in looked(photo).filter(|seen| seen.trust > 0.0) {
        let common = sky.between(seen.direction, |log| log);
        let apart = [0, 1, 2].map(|c| common[c] - seen.log[c]);
        // A clipped channel may be darker than the sky by any amount.
        let stray = |c: usize| seen.known[c] * (apart[c] - offset[c]).abs();
        let weight = seen.trust * robust([0, 1, 2].map(stray).into_iter().fold(0.0, f32::max));
        let at = (seen.px / size * GRID as f64).floor();
        let cell = &mut cells[at.y as usize * GRID + at.x as usize];
        (0..3).for_each(|c| cell.0[c] += weight * apart[c]);
        cell.1 += weight;
        for c in 0..3 {
            known[c].0 += weight * seen.known[c] * apart[c];
            known[c].1 += weight * seen.known[c];
        }
        all += weight;
    }
    let mut found = vec![offset; GRID * GRID];
    for _ in 0..SMOOTHINGS {
        let value = |at: usize| {
            let (x, y) = (at % GRID, at / GRID);
            let beside = [
                y * GRID + x.saturating_sub(1),
                y * GRID + (x + 1).min(GRID - 1),
                y.saturating_sub(1) * GRID + x,
                (y + 1).min(GRID - 1) * GRID + x,
            ];
            let (sum, weight) = cells[at];
            [0, 1, 2].map(|c| {
                let around = beside.iter().map(|at| found[*at][c]).sum::<f32>() / 4.0;
                (sum[c] + NEIGHBOURS * around) / (weight + NEIGHBOURS)
            })
        };
        found = (0..GRID * GRID).map(value).collect();
    }
    let limited = |logs: [f32; 3]| logs.map(|log| log.clamp(-LARGEST, LARGEST));
    // As a whole the photo differs as it does where it is not clipped.
    let best = best_known(known.map(|(_, weight)| weight));
    let mean = |c: usize, at: f32, held: f32| {
        let (sum, weight) = known[c];
        (sum + held * all * at) / (weight + held * all).max(f32::MIN_POSITIVE)
    };
    let of_best = mean(best, offset[best], HELD);
    let offset = [0, 1, 2].map(|c| if c == best { of_best } else { mean(c, of_best, HELD_HUE) });
    SurroundingsFactors { offset: limited(offset), cells: found.into_iter().map(limited).collect() }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DMat3;

    use super::*;
    use quadratura_base::geometry::{Pinhole, Pose};
    use quadratura_view::optics::Optics;

    const CAMERA: Pinhole = Pinhole { width: 120, height: 80, fx: 90.0, fy: 90.0, cx: 60.0, cy: 40.0 };

    /// A photo that looks along a direction turned about y, with this gain, of a sky of this light in each direction.
    fn photo(turn: f64, gain: f64, sky: impl Fn(DVec3) -> [f64; 3]) -> DirectionPhoto {
        let pose = Pose { rotation: DMat3::from_rotation_y(turn), translation: DVec3::ZERO };
        let light = (0..120 * 80).map(|at| {
            let px = DVec2::new((at % 120) as f64 + 0.5, (at / 120) as f64 + 0.5);
            let direction = pose.rotation.transpose() * CAMERA.ray_in_camera(px);
            (at / 120 < 60)
                .then(|| sky(direction.normalize()).map(|light| (light * gain.exp()).min(1.0) as f32))
        });
        let mut photo = DirectionPhoto::new(CAMERA, pose, light.collect());
        photo.set_exposure([gain; 3], &Optics::default());
        photo
    }

    /// Brings photos to one sky; returns their factors.
    fn united(photos: &mut [DirectionPhoto]) -> Vec<SurroundingsFactors> {
        let shared: Vec<Arc<DirectionPhoto>> = photos.iter().cloned().map(Arc::new).collect();
        let found = one_sky(&shared, &Task::silent()).unwrap();
        for (photo, factors) in photos.iter_mut().zip(&found) {
            photo.multiply(factors);
        }
        found
    }

    /// Returns the light of a photo in a direction, in the common exposure.
    fn shown(photo: &DirectionPhoto, direction: DVec3) -> [f32; 3] {
        photo.exposed(photo.index(photo.position(direction).unwrap())).unwrap()
    }

    #[test]
    fn photos_whose_gains_do_not_explain_their_skies_agree_afterwards_and_stay_level_on_average() {
        let sky = |direction: DVec3| [0.3 - 0.1 * direction.y, 0.4 - 0.1 * direction.y, 0.5];
        let brighter = |factor: f64| move |direction: DVec3| sky(direction).map(|light| factor * light);
        let mut photos =
            [photo(0.0, 0.0, sky), photo(0.5, 0.3, brighter(1.3)), photo(1.0, -0.2, brighter(0.9))];
        let before = (shown(&photos[1], DVec3::new(-0.25, -0.1, 1.0))[0] / 0.3).ln();
        assert!(before > 0.2);
        let factors = united(&mut photos);
        let mean: f32 = factors.iter().map(|factors| factors.offset[0]).sum::<f32>() / 3.0;
        assert!(mean.abs() < 0.05, "{mean}");
        for x in [-0.2f64, -0.3, -0.4] {
            let direction = DVec3::new(x.sin(), -0.1, x.cos());
            let [a, b] = [0, 1].map(|at| shown(&photos[at], direction));
            // A step of 3 of 255 is 2.6 % of light at these values.
            (0..3).for_each(|c| assert!((a[c] / b[c]).ln().abs() < 0.026, "{x}: {a:?} {b:?}"));
        }
    }

    #[test]
    fn a_clipped_channel_becomes_what_others_show_there_and_something_near_changes_nothing_around_it() {
        let sky = |_: DVec3| [0.5, 0.6, 0.9];
        // The first photo is two thirds of a stop brighter, so that its blue is clipped at 0.63.
        let mut photos = [photo(0.0, 0.46, sky), photo(0.3, -0.1, sky)];
        assert!((shown(&photos[0], DVec3::Z)[2] - 0.63).abs() < 0.01);
        united(&mut photos);
        let [r, _, b] = shown(&photos[0], DVec3::new(-0.1, -0.1, 1.0));
        assert!((b / 0.9).ln().abs() < 0.05 && (r / 0.5).ln().abs() < 0.03, "{r} {b}");

        let tree = |direction: DVec3| if direction.x.abs() < 0.04 { [0.05; 3] } else { [0.5, 0.6, 0.7] };
        let mut photos = [photo(0.0, 0.0, tree), photo(0.2, 0.0, |_| [0.5, 0.6, 0.7])];
        let factors = united(&mut photos);
        let most = factors
            .iter()
            .flat_map(|of| of.cells.iter().flatten())
            .fold(0.0f32, |most, log| most.max(log.abs()));
        assert!(most < 0.06, "{most}");
    }

    #[test]
    fn a_photo_that_overlaps_with_none_stays_as_it_is() {
        let mut photos = [photo(0.0, 0.0, |_| [0.2; 3]), photo(3.0, 0.0, |_| [0.6; 3])];
        for factors in united(&mut photos) {
            assert!(factors.cells.iter().flatten().all(|log| log.abs() < 0.02), "{:?}", factors.offset);
        }
        assert!(one_sky(&Vec::new(), &Task::silent()).unwrap().is_empty());
    }
}
