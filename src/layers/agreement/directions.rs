//! Agreement of photos about their surroundings. These are taken to be infinitely far away, so a direction is
//! compared rather than a surface point. What is near, such as the outline of a roof that the model lacks, lies in
//! another direction in every photo: there the other photos, which show the sky, outvote it.

use std::sync::{Arc, OnceLock};

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::shown::ShownPixels;
use super::tints::TintLevels;
use super::votes::{MOST_VOTES, Votes, agrees, largest_set};
use quadratura_base::error::Result;
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::raster::steps::steps_inside;
use quadratura_base::task::Task;
use quadratura_projection::exposure::surroundings::SurroundingsFactors;
use quadratura_projection::exposure::white::clipped;
use quadratura_projection::surroundings::pixels_per_angle;
use quadratura_view::agreement::{ContradictedPixel, NO_FACE, PhotoAgreement};
use quadratura_view::optics::Optics;
use quadratura_view::optics::squared_radius;

/// The distance from what is not surroundings, in reduced pixels, within which a photo has no vote: outlines are
/// wrong by some pixels.
const INSIDE_PX: u16 = 3;

/// Half the side of the square over which agreement is averaged, in reduced pixels.
const SMOOTHING: i32 = 2;

/// The least distance of two cameras, against the scale of the votes, from which one confirms what the other shows.
pub(super) const AFAR: f64 = 0.25;

/// The surroundings that a reduced photo shows.
#[derive(Clone, Serialize, Deserialize)]
pub struct DirectionPhoto {
    /// The reduced photo's camera.
    pub camera: Pinhole,
    /// The pose, world to camera.
    pub pose: Pose,
    /// The pixels that show surroundings; what follows is kept of these alone.
    shown: ShownPixels,
    /// Linear light (full range 1) in the photo's own exposure.
    light: Vec<[f32; 3]>,
    /// The same in the common exposure.
    exposed: Vec<[f32; 3]>,
    /// The distance from what is not surroundings, in reduced pixels; the edge of the photo is none.
    inside_px: Vec<u16>,
    /// How far others confirm them, 0 to 1; empty as long as nothing was compared, which counts as 1.
    agreement: Vec<f32>,
    /// The colours in the present exposure, prepared for comparison, once they were needed.
    #[serde(skip)]
    tints: OnceLock<TintLevels>,
}

/// The bytes of a pixel that shows surroundings: its light twice, its distance from others, its agreement, and its colours with
/// their levels.
const SHOWN_BYTES: u64 = 12 + 12 + 2 + 4 + 24;

/// Photos prepared for comparison, which may be elsewhere than in memory until they are asked for.
pub trait DirectionPhotos: Sync {
    /// Returns the number of photos.
    fn count(&self) -> usize;

    /// Returns one of them.
    ///
    /// # Errors
    /// Those of reading it back.
    fn photo(&self, number: usize) -> Result<Arc<DirectionPhoto>>;
}

impl DirectionPhotos for Vec<Arc<DirectionPhoto>> {
    fn count(&self) -> usize {
        self.len()
    }

    fn photo(&self, number: usize) -> Result<Arc<DirectionPhoto>> {
        Ok(self[number].clone())
    }
}

impl DirectionPhoto {
    /// Prepares a photo from linear light (full range 1), row by row; `None` where it shows no surroundings.
    pub fn new(camera: Pinhole, pose: Pose, light: Vec<Option<[f32; 3]>>) -> Self {
        let size = [camera.width as usize, camera.height as usize];
        let is_shown: Vec<bool> = light.iter().map(Option::is_some).collect();
        let shown = ShownPixels::new(is_shown.iter().copied());
        let steps = steps_inside(&is_shown, size);
        let inside_px = shown.iter().map(|at| steps[at]).collect();
        let kept: Vec<[f32; 3]> = light.iter().flatten().copied().collect();
        let (agreement, tints) = (Vec::new(), OnceLock::new());
        Self { camera, pose, shown, exposed: kept.clone(), light: kept, inside_px, agreement, tints }
    }

    /// Returns the memory that it takes, in bytes, once its colours are prepared for comparison.
    pub fn bytes(&self) -> u64 {
        self.light.len() as u64 * SHOWN_BYTES + self.pixels() as u64
    }

    /// Brings the photo to the common exposure: `gain` is its own relative to that (natural logarithms).
    pub fn set_exposure(&mut self, gain: [f64; 3], optics: &Optics) {
        let exposed = |(at, light): (usize, &[f32; 3])| {
            let undone = optics.undone(light.map(f64::from), squared_radius(&self.camera, self.centre(at)));
            [0, 1, 2].map(|c| (undone[c] * (-gain[c]).exp()) as f32)
        };
        let places: Vec<usize> = self.shown.iter().collect();
        self.exposed = places.into_par_iter().zip(&self.light).map(exposed).collect();
        self.tints.take();
    }

    /// Multiplies the light in the common exposure by slowly varying factors.
    pub fn multiply(&mut self, factors: &SurroundingsFactors) {
        let (camera, width) = (self.camera, self.camera.width as usize);
        let places: Vec<usize> = self.shown.iter().collect();
        self.exposed.par_iter_mut().zip(places).for_each(|(light, at)| {
            let log = factors.at(&camera, centre(width, at));
            *light = [0, 1, 2].map(|c| light[c] * log[c].exp());
        });
        self.tints.take();
    }

    /// Keeps how far others confirm the pixels that show surroundings, from the values of all pixels, row by row; of no pixel for
    /// photos that were not compared.
    pub fn set_agreement(&mut self, values: &[f32]) {
        self.agreement = match values.is_empty() {
            true => Vec::new(),
            false => self.shown.iter().map(|at| values[at]).collect(),
        };
    }

    /// Returns how far others confirm each pixel, row by row; 1 where it shows no surroundings.
    pub fn agreement_of_pixels(&self) -> Vec<f32> {
        let mut values = vec![1.0; self.pixels()];
        self.shown.iter().zip(&self.agreement).for_each(|(at, value)| values[at] = *value);
        values
    }

    /// Returns how far others confirm the pixel at a place among those that show surroundings.
    pub fn agreement(&self, place: usize) -> f32 {
        self.agreement.get(place).copied().unwrap_or(1.0)
    }

    /// Returns the colours in the present exposure, prepared for comparison.
    pub(super) fn tints(&self) -> &TintLevels {
        let size = [self.camera.width as usize, self.camera.height as usize];
        let light = || (0..self.pixels()).map(|at| self.exposed(at)).collect();
        self.tints.get_or_init(|| TintLevels::new(size, light()))
    }

    /// Returns the number of pixels, those that show no surroundings included.
    pub fn pixels(&self) -> usize {
        self.shown.count()
    }

    /// Returns the place of a pixel among those that show surroundings; `None` where it shows none.
    pub fn place(&self, at: usize) -> Option<usize> {
        self.shown.place(at)
    }

    /// Returns a pixel's linear light (full range 1) in the common exposure; `None` where it shows no surroundings.
    pub fn exposed(&self, at: usize) -> Option<[f32; 3]> {
        self.shown.place(at).map(|place| self.exposed[place])
    }

    /// Returns the distance of a pixel from what is not surroundings, in reduced pixels; the edge of the photo is none.
    pub fn inside_px(&self, at: usize) -> u16 {
        self.shown.place(at).map_or(0, |place| self.inside_px[place])
    }

    /// Returns how far each channel of a pixel's light is known: 0 where it is clipped.
    pub fn known(&self, at: usize) -> [f32; 3] {
        self.shown
            .place(at)
            .map_or([0.0; 3], |place| self.light[place].map(|light| 1.0 - clipped(f64::from(light)) as f32))
    }

    /// Returns the position of a direction (world) in the photo; `None` outside of it.
    pub fn position(&self, direction: DVec3) -> Option<DVec2> {
        let px = self.camera.image_from_camera(self.pose.rotation * direction)?;
        self.camera.rect().contains_position(px).then_some(px)
    }

    /// Returns the index of the pixel at a position within the photo.
    pub fn index(&self, px: DVec2) -> usize {
        px.y as usize * self.camera.width as usize + px.x as usize
    }

    /// Returns the distance of a pixel's colour, as a natural logarithm, from those around another one.
    pub(super) fn distance(&self, at: usize, other: usize) -> f32 {
        self.tints().distance(self.tints().tint(self.centre(at), 0), self.centre(other), 0)
    }

    /// Returns the direction (world) of a pixel's centre.
    fn direction(&self, at: usize) -> DVec3 {
        self.pose.rotation.transpose() * self.camera.ray_in_camera(self.centre(at))
    }

    /// Returns the centre of a pixel.
    pub(super) fn centre(&self, at: usize) -> DVec2 {
        centre(self.camera.width as usize, at)
    }
}

/// Returns the centre of a pixel of an image of this width.
fn centre(width: usize, at: usize) -> DVec2 {
    DVec2::new((at % width) as f64 + 0.5, (at / width) as f64 + 0.5)
}

/// Returns the agreement of each pixel of a photo's surroundings, row by row, 1 where it shows none or where no
/// other photo shows the direction. Votes fall with the distance of two cameras beyond `scale` (world units): what is near
/// shifts between them. `others` are the photos with a vote, and whether
/// they are of the same group of light: one of another group confirms what agrees and contradicts nothing.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn direction_agreement(
    tested: &DirectionPhoto,
    others: &[(&DirectionPhoto, bool)],
    scale: f64,
    task: &Task,
) -> Result<Vec<f32>> {
    task.check_cancelled()?;
    let here = tested.pose.center_in_world();
    let away = |photo: &DirectionPhoto| photo.pose.center_in_world().distance(here);
    let weight = |other: &DirectionPhoto| (scale / away(other).max(scale).max(f64::MIN_POSITIVE)) as f32;
    let mut others: Vec<(&DirectionPhoto, bool, f32)> =
        others.iter().map(|&(other, same_light)| (other, same_light, weight(other))).collect();
    others.sort_by(|a, b| b.1.cmp(&a.1).then(away(a.0).total_cmp(&away(b.0))));
    others.truncate(MOST_VOTES);
    let poll = |at: usize| tested.exposed(at).map_or(1.0, |_| polled(tested, at, &others));
    let values: Vec<f32> = (0..tested.pixels()).into_par_iter().map(poll).collect();
    Ok(smoothed(tested, &values))
}

/// Returns the agreement of one pixel.
fn polled(tested: &DirectionPhoto, at: usize, others: &[(&DirectionPhoto, bool, f32)]) -> f32 {
    let direction = tested.direction(at);
    let own = Voter::new(tested, tested.centre(at), direction);
    let (mut voters, mut weights) = (Vec::new(), Vec::new());
    let mut agreeing = 1.0;
    for &(photo, same_light, weight) in others {
        let Some(px) = photo.position(direction) else { continue };
        if photo.inside_px(photo.index(px)) < INSIDE_PX {
            continue;
        }
        let voter = Voter::new(photo, px, direction);
        let agrees = agrees(own.distance(&voter));
        agreeing += weight * agrees;
        if agrees < 1.0 && same_light {
            voters.push(voter);
            weights.push(weight * (1.0 - agrees));
        }
    }
    if weights.iter().sum::<f32>() <= agreeing {
        return 1.0;
    }
    let count = voters.len();
    let mut mutual = vec![1.0f32; count * count];
    for (i, k) in (0..count).flat_map(|i| (0..i).map(move |k| (i, k))) {
        let apart = voters[i].distance(&voters[k]).max(voters[k].distance(&voters[i]));
        (mutual[i * count + k], mutual[k * count + i]) = (agrees(apart), agrees(apart));
    }
    let against = largest_set(&mutual, &weights);
    Votes { own: agreeing, against, distance: 0.0, expected: None }.agreement()
}

/// What a photo shows in a direction.
#[derive(Clone, Copy)]
struct Voter<'a> {
    photo: &'a DirectionPhoto,
    px: DVec2,
    /// Reduced pixels per radian, as a logarithm to base 2.
    detail: f64,
}

impl<'a> Voter<'a> {
    fn new(photo: &'a DirectionPhoto, px: DVec2, direction: DVec3) -> Self {
        Self { photo, px, detail: detail(&photo.camera, &photo.pose, direction) }
    }

    /// Returns the distance of this photo's colour from those of another around the direction, at the coarser of
    /// their footprints.
    fn distance(&self, other: &Voter) -> f32 {
        let finer = (self.detail - other.detail).round();
        let (own, others) = (finer.max(0.0) as usize, (-finer).max(0.0) as usize);
        other.photo.tints().distance(self.photo.tints().tint(self.px, own), other.px, others)
    }
}

/// Returns the reduced pixels per radian in a direction (world), as a logarithm to base 2.
pub(super) fn detail(camera: &Pinhole, pose: &Pose, direction: DVec3) -> f64 {
    pixels_per_angle(camera, pose.rotation * direction).log2()
}

/// Returns the mean over the neighbourhood in the surroundings: single pixels are noise.
fn smoothed(photo: &DirectionPhoto, values: &[f32]) -> Vec<f32> {
    let [width, height] = [photo.camera.width as i32, photo.camera.height as i32];
    let mean = |at: usize| {
        let (x, y) = (at as i32 % width, at as i32 / width);
        let rows = (y - SMOOTHING).max(0)..(y + SMOOTHING + 1).min(height);
        let columns = (x - SMOOTHING).max(0)..(x + SMOOTHING + 1).min(width);
        let around = rows.flat_map(|y| columns.clone().map(move |x| (y * width + x) as usize));
        let shown = around.filter(|at| photo.exposed(*at).is_some());
        let (sum, count) = shown.fold((0.0, 0.0f32), |(sum, count), at| (sum + values[at], count + 1.0));
        sum / count
    };
    let value = |at: usize| if photo.exposed(at).is_some() { mean(at) } else { 1.0 };
    (0..values.len()).into_par_iter().map(value).collect()
}

/// Converts the agreement of each pixel to that of the photo. It is extended by one pixel past the outline, so that
/// interpolation does not mix it with that of what is not surroundings.
pub fn surroundings_agreement(photo: &DirectionPhoto, values: &[f32]) -> PhotoAgreement {
    let [width, height] = [photo.camera.width, photo.camera.height];
    let around = |x: u32, y: u32| {
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        rows.flat_map(move |v| {
            (x.saturating_sub(1)..(x + 2).min(width)).map(move |u| (v * width + u) as usize)
        })
    };
    let pixel = |at: u32| {
        let (x, y) = (at % width, at / width);
        let value = match photo.exposed(at as usize) {
            Some(_) => values[at as usize],
            None => {
                let shown = around(x, y).filter(|at| photo.exposed(*at).is_some());
                shown.map(|at| values[at]).fold(1.0, f32::min)
            }
        };
        let agreement = (value * 255.0).round() as u8;
        let at = [x as u16, y as u16];
        (agreement < u8::MAX).then_some(ContradictedPixel { at, face: NO_FACE, agreement })
    };
    let contradicted = (0..width * height).filter_map(pixel).collect();
    PhotoAgreement { size: [width, height], contradicted, beside: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;

    const CAMERA: Pinhole = Pinhole { width: 60, height: 40, fx: 50.0, fy: 50.0, cx: 30.0, cy: 20.0 };

    /// A photo of a grey sky from a place, with something dark between these columns.
    fn photo(x: f64, dark: std::ops::Range<usize>) -> DirectionPhoto {
        let pose = Pose { rotation: DMat3::IDENTITY, translation: -DVec3::X * x };
        let light = (0..60 * 40).map(|at| Some([if dark.contains(&(at % 60)) { 0.05 } else { 0.5 }; 3]));
        DirectionPhoto::new(CAMERA, pose, light.collect())
    }

    #[test]
    fn what_one_photo_shows_before_a_sky_that_three_others_show_counts_least() {
        let tested = photo(0.0, 20..30);
        let others: Vec<DirectionPhoto> =
            (1..4).map(|i| photo(0.1 * i as f64, 40 + 4 * i..42 + 4 * i)).collect();
        let voted = |count: usize, same_light: bool, scale: f64| {
            let others: Vec<_> = others[..count].iter().map(|other| (other, same_light)).collect();
            direction_agreement(&tested, &others, scale, &Task::silent()).unwrap()
        };
        let with = |count: usize, scale: f64| voted(count, true, scale);
        let (at, sky) = (20 * 60 + 25, 20 * 60 + 36);
        assert_eq!(voted(3, false, 1.0)[at], 1.0, "another light contradicts nothing");
        assert!((with(3, 1.0)[at] - 0.1).abs() < 1e-6 && with(3, 1.0)[sky] == 1.0);
        assert_eq!(with(1, 1.0)[at], 1.0, "one photo never overrules another");
        assert!(with(2, 1.0)[at] < 0.6, "two do a little");
        assert_eq!(with(3, 0.01)[at], 1.0, "photos from elsewhere say little");
        let agreement = surroundings_agreement(&tested, &with(3, 1.0));
        assert!(agreement.contradicted.iter().all(|pixel| (18..32).contains(&pixel.at[0])));
        assert!(agreement.contradicted.len() >= 10 * 40);
    }
}
