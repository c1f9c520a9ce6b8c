//! Parallax: whether other photos show the same as a region and what is around it, at about the distance of the model's surface.
//!
//! A relief that the model shows flat, a column that stands beside the model's, a window with the room behind it: colours disagree on the
//! model's surface, and yet all photos show one surface, a little nearer or behind. A thing that passes by is shown by no other photo, and
//! one that stands before the surface only well before it, with something else around it.

use glam::{DVec2, DVec3};

use super::{ReducedPhoto, ReducedPhotos};
use quadratura_base::geometry::{PixelRect, Spans};
use quadratura_base::scene::PhotoId;

/// The distances that are tried, relative to the model's surface, inverse: evenly spaced in the image. Models of buildings are off by less
/// than a twentieth of the distance; what is behind, such as a room or a reflection, may be farther away.
const INVERSE: [f64; 13] = [0.75, 0.775, 0.8, 0.825, 0.85, 0.875, 0.9, 0.925, 0.95, 0.975, 1.0, 1.025, 1.05];

/// The most photos that are asked, the nearest ones first.
const MOST_PHOTOS: usize = 6;

/// How far away these are, as a share of the distance of the region: nearer ones show no parallax, others another side.
const BASELINE: [f64; 2] = [0.02, 1.0];

/// Half the side of the squares that are compared, each at a distance of its own, in reduced pixels: as large as what reliefs consist of.
const RADIUS: i32 = 9;

/// The least number of pixels of a square that show a surface.
const LEAST_SAMPLES: usize = 40;

/// The share of these that a photo has to show.
const SHOWN: f64 = 0.7;

/// The variance of brightness, as a natural logarithm, below which a surface has no structure.
const PLAIN: f32 = 0.002;

/// Returns how well other photos show what a region of a photo and its surroundings show at about the distance of the model: the mean
/// correlation of brightness over squares; 0 where no photo can tell. `voters` are asked.
pub fn shown_nearby(photos: &ReducedPhotos, id: PhotoId, voters: &[PhotoId], region: &Spans) -> f32 {
    let Some(tested) = &photos.photos[id.index()] else { return 0.0 };
    let bounds = region.bounds();
    let along = |from: i32, to: i32| (from + RADIUS / 2..to).step_by(RADIUS as usize);
    let middles =
        along(bounds.y, bounds.bottom()).flat_map(|y| along(bounds.x, bounds.right()).map(move |x| (x, y)));
    let others: Vec<&ReducedPhoto> =
        voters.iter().filter_map(|other| photos.photos[other.index()].as_ref()).collect();
    let square = |(x, y): (i32, i32)| {
        let within = PixelRect::from_edges(x - RADIUS, y - RADIUS, x + RADIUS + 1, y + RADIUS + 1);
        best_correlation(&samples(photos, tested, within), tested.donor.pose.center_in_world(), &others)
    };
    let found: Vec<f32> = middles.filter(|(x, y)| region.holds(*x, *y)).filter_map(square).collect();
    found.iter().sum::<f32>() / found.len().max(1) as f32
}

/// Returns the rays from the eye to the surface that a square shows, with the brightness there.
fn samples(photos: &ReducedPhotos, tested: &ReducedPhoto, square: PixelRect) -> Vec<(DVec3, f32)> {
    let camera = &tested.donor.camera;
    let eye = tested.donor.pose.center_in_world();
    let sample = |(x, y): (i32, i32)| {
        let (_, point) = photos.visible_point(tested, x as u32, y as u32)?;
        let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        Some((point - eye, tested.tints.brightness(px, 0)?))
    };
    square
        .intersection(&PixelRect::of_size(camera.width, camera.height))
        .pixels()
        .filter_map(sample)
        .collect()
}

/// Returns the largest correlation of samples with other photos over all distances, as the mean of the two photos that show them best at
/// one distance, because each photo has chance similarities of its own; `None` where no photo shows enough of them.
fn best_correlation(samples: &[(DVec3, f32)], eye: DVec3, others: &[&ReducedPhoto]) -> Option<f32> {
    if samples.len() < LEAST_SAMPLES {
        return None;
    }
    let distance = samples.iter().map(|(ray, _)| ray.length()).sum::<f64>() / samples.len() as f64;
    let away = |photo: &ReducedPhoto| photo.donor.pose.center_in_world().distance(eye) / distance;
    let mut others: Vec<(f64, &ReducedPhoto)> = others.iter().map(|photo| (away(photo), *photo)).collect();
    others.retain(|(away, _)| (BASELINE[0]..BASELINE[1]).contains(away));
    others.sort_by(|a, b| a.0.total_cmp(&b.0));
    let curve = |(_, other): (f64, &ReducedPhoto)| {
        let curve = INVERSE.map(|inverse| correlation(samples, eye, other, 1.0 / inverse));
        curve.iter().any(Option::is_some).then(|| curve.map(|value| value.unwrap_or(0.0)))
    };
    let curves: Vec<_> = others.into_iter().filter_map(curve).take(MOST_PHOTOS).collect();
    let at = |k: usize| {
        let mut values: Vec<f32> = curves.iter().map(|curve| curve[k]).collect();
        values.sort_by(|a, b| b.total_cmp(a));
        values.truncate(2);
        values.iter().sum::<f32>() / values.len().max(1) as f32
    };
    (!curves.is_empty()).then(|| (0..INVERSE.len()).map(at).fold(0.0, f32::max))
}

/// Returns the correlation of the brightness of samples, given by their rays from the eye, with what another photo shows where they are
/// this many times as far away; 0 without structure, `None` where it shows too few.
fn correlation(samples: &[(DVec3, f32)], eye: DVec3, other: &ReducedPhoto, times: f64) -> Option<f32> {
    let seen = |(ray, own): &(DVec3, f32)| {
        Some((*own, other.tints.brightness(other.place(eye + *ray * times)?, 0)?))
    };
    let pairs: Vec<(f32, f32)> = samples.iter().filter_map(seen).collect();
    if (pairs.len() as f64) < SHOWN * samples.len() as f64 {
        return None;
    }
    let mean = |value: &dyn Fn(&(f32, f32)) -> f32| pairs.iter().map(value).sum::<f32>() / pairs.len() as f32;
    let [a, b] = [mean(&|pair| pair.0), mean(&|pair| pair.1)];
    let [own, theirs] = [mean(&|pair| (pair.0 - a).powi(2)), mean(&|pair| (pair.1 - b).powi(2))];
    if own.min(theirs) < PLAIN {
        return Some(0.0);
    }
    Some(mean(&|pair| (pair.0 - a) * (pair.1 - b)) / (own * theirs).sqrt())
}
