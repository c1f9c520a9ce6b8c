//! Agreement of photos: how far the others confirm what a photo shows of a surface (`docs/method.md`, section 7).
//!
//! Every photo that shows a surface point has a vote ([`votes()`]). Where two or more votes outweigh a photo's own, the
//! photo counts less there, smoothly. Things with an outline, which three or more photos contradict, are taken as a whole
//! ([`regions`]): a person, a car, a pigeon that one photo alone shows and the model lacks. Such things, as far as they go and without
//! haze, glare and what the others show at about the same distance (`parallax`), are also suggested as masks ([`things()`]).

mod connected;
pub mod directions;
pub mod far_colours;
mod outline;
mod parallax;
pub mod reduced_photo;
pub mod regions;
mod shown;
pub mod suspects;
mod thin;
pub mod things;
mod tints;
pub mod votes;

pub use outline::outlines;
pub use reduced_photo::{ReducedPhoto, ReducedPhotos};
pub use regions::{ContradictedRegion, contradicted_regions};
pub use things::{Thing, things};
pub use votes::{MOST_VOTES, Votes, undecided_share, voters, votes};

use rayon::prelude::*;

use crate::fill::Donor;
use quadratura_base::scene::FaceId;
use quadratura_view::agreement::{ContradictedPixel, PhotoAgreement};

/// What the other photos say of one photo.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct PhotoEvidence {
    /// The agreement of the photo's pixels.
    pub agreement: PhotoAgreement,
    /// How much of each pixel shows its face rather than the sky within the outlines of the model ([`outlines()`]).
    pub outlines: PhotoAgreement,
    /// The things that it alone shows, from the top, and the light that it alone has.
    pub things: Vec<Thing>,
    /// The share of the pixels that other photos show, too, of which as many photos contradict what this one shows as
    /// confirm it, 0 to 1.
    pub undecided: f64,
}

/// Options of the comparison of photos. Sizes are in pixels of the reduced photos.
#[derive(Debug, Clone, PartialEq)]
pub struct AgreementOptions {
    /// The longer side of the reduced photos: models are wrong by a few pixels of a photo three thousand pixels wide, and
    /// one reduced pixel is three of these.
    pub longest_side: u32,
    /// The least number of votes against each pixel of a region: half a vote less than three, because votes are fractions
    /// where colours are neither equal nor different.
    pub least_against: f32,
    /// The lead of the votes against a pixel that a region reaches in at least half of its pixels.
    pub clear_lead: f32,
    /// Half the width of the gaps between parts of a region that are closed.
    pub gap: i32,
    /// The same where no other photo was asked: as far as pixels beside a depth discontinuity are not compared, to both of
    /// its sides.
    pub unknown_gap: i32,
    /// Half the side of a square that fits into every region: errors of the model leave narrow strips along edges.
    pub core: i32,
    /// The least number of pixels of a region.
    pub least_pixels: u64,
    /// The least mean distance of a region from the colours of the other photos, as a natural logarithm; light that changes
    /// on a surface rarely reaches it.
    pub least_distance: f32,
    /// The largest share of the photo that a region may take; larger ones come from errors of the model.
    pub most_share: f64,
    /// Half the side of the square over which agreement is averaged, because single pixels are noise.
    pub smoothing: u32,
    /// The width over which agreement rises around a region, in pixels of the photo.
    pub ramp_px: f64,
}

impl Default for AgreementOptions {
    fn default() -> Self {
        Self {
            longest_side: 1024,
            least_against: 2.5,
            clear_lead: 1.5,
            gap: 2,
            unknown_gap: 5,
            core: 4,
            least_pixels: 150,
            least_distance: 0.5,
            most_share: 0.1,
            smoothing: 2,
            ramp_px: 8.0,
        }
    }
}

/// Returns the agreement of a reduced photo from its votes and its contradicted regions. `reduction` is the number of
/// photo pixels along a reduced one.
pub fn photo_agreement(
    photo: &ReducedPhoto,
    votes: &[Votes],
    regions: &[ContradictedRegion],
    reduction: f64,
    options: &AgreementOptions,
) -> PhotoAgreement {
    let (width, height) = (photo.donor.camera.width, photo.donor.camera.height);
    let mut values = smoothed(photo, votes, options.smoothing);
    for region in regions {
        region.lower(&mut values, [width, height], options.ramp_px / reduction);
    }
    let pixel = |(at, value): (u32, &f32)| {
        let agreement = (value * 255.0).round() as u8;
        let (x, y) = (at % width, at / width);
        let face = photo.donor.seen(photo.donor.owner(x, y).filter(|_| agreement < u8::MAX)?).face;
        Some(ContradictedPixel { at: [x as u16, y as u16], face, agreement })
    };
    let contradicted = (0..).zip(&values).filter_map(pixel).collect();
    PhotoAgreement { size: [width, height], contradicted, beside: beside(&photo.donor, &values) }
}

/// Returns the agreement of each pixel by votes, as the mean over its neighbourhood on the same face: single pixels are
/// noise.
fn smoothed(photo: &ReducedPhoto, votes: &[Votes], radius: u32) -> Vec<f32> {
    let (width, height) = (photo.donor.camera.width, photo.donor.camera.height);
    let face = |x: u32, y: u32| photo.donor.owner(x, y).map(|item| photo.donor.seen(item).face);
    let mean = |(x, y): (u32, u32)| {
        let own = face(x, y);
        let rows = y.saturating_sub(radius)..(y + radius + 1).min(height);
        let around =
            rows.flat_map(|v| (x.saturating_sub(radius)..(x + radius + 1).min(width)).map(move |u| (u, v)));
        let same = around.filter(|(u, v)| face(*u, *v) == own);
        let (sum, count) = same.fold((0.0, 0.0f32), |(sum, count), (u, v)| {
            (sum + votes[(v * width + u) as usize].agreement(), count + 1.0)
        });
        sum / count.max(1.0)
    };
    let pixels: Vec<(u32, u32)> = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).collect();
    pixels.into_par_iter().map(mean).collect()
}

/// Extends the agreement of each face by one pixel past its outline: the mean of the neighbouring pixels that show it.
fn beside(donor: &Donor, values: &[f32]) -> Vec<ContradictedPixel> {
    let (width, height) = (donor.camera.width, donor.camera.height);
    let face = |x: u32, y: u32| donor.owner(x, y).map(|item| donor.seen(item).face);
    let value = |x: u32, y: u32| values[(y * width + x) as usize];
    let around = |x: u32, y: u32| {
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        rows.flat_map(move |v| (x.saturating_sub(1)..(x + 2).min(width)).map(move |u| (u, v)))
    };
    let mut found = Vec::new();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        if around(x, y).all(|(u, v)| value(u, v) >= 1.0) {
            continue;
        }
        let own = face(x, y);
        let mut sums: Vec<(FaceId, f32, f32)> = Vec::new();
        for (u, v) in around(x, y) {
            let Some(other) = face(u, v).filter(|other| Some(*other) != own) else { continue };
            match sums.iter_mut().find(|(face, ..)| *face == other) {
                Some((_, sum, count)) => (*sum, *count) = (*sum + value(u, v), *count + 1.0),
                None => sums.push((other, value(u, v), 1.0)),
            }
        }
        let at = [x as u16, y as u16];
        // Faces of one layer share its grid: the pixel's own face comes last and has its own value.
        found.extend(sums.iter().filter_map(|&(face, sum, count)| {
            let agreement = (sum / count * 255.0).round() as u8;
            (agreement < u8::MAX).then_some(ContradictedPixel { at, face, agreement })
        }));
        if let Some(face) = own {
            found.push(ContradictedPixel { at, face, agreement: (value(x, y) * 255.0).round() as u8 });
        }
    }
    found
}

#[cfg(test)]
mod tests;
