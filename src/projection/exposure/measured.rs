//! The colours that photos have at common surface points: what everything about exposure is estimated from.

use glam::DVec2;
use rayon::prelude::*;

use super::options::ExposureOptions;
use super::patch::PatchColour;
use super::points::{PointPatch, SharedPoint, Visibility, shared_points, typical_distance};
use super::surface_gains::JoinedFaces;
use super::whole::{PhotoPlace, places_of_photos};
use crate::Projector;
use quadratura_base::error::Result;
use quadratura_base::scene::PhotoId;
use quadratura_base::task::Task;

/// Common surface points with the colours that the photos have there.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredColours {
    /// The points, in the order of the photos on whose grids they lie.
    pub points: Vec<SharedPoint>,
    /// The colour of each patch of each point.
    pub colours: Vec<Vec<PatchColour>>,
    /// The faces that share edges.
    pub joined: Vec<JoinedFaces>,
    /// Places all over the photos, from which whole photos are predicted.
    pub places: Vec<PhotoPlace>,
    /// The colour of each patch of each place.
    pub place_colours: Vec<Vec<PatchColour>>,
    /// The exposure that each photo's camera wrote down, as a natural logarithm; `None` where it did not.
    pub camera_logs: Vec<Option<f64>>,
}

impl MeasuredColours {
    /// Finds common points of `photos`, and places all over them, and measures their colours. `colours` measures patches of one photo, given their
    /// centres in its pixels, in the same order; it is called once per photo, for several photos in parallel. The result
    /// does not depend on the number of threads.
    ///
    /// # Errors
    /// The errors of `colours`, and [`quadratura_base::Error::Cancelled`].
    pub fn measure(
        photos: &[Projector],
        visibility: &impl Visibility,
        colours: &(impl Fn(PhotoId, &[DVec2]) -> Result<Vec<PatchColour>> + Sync),
        options: &ExposureOptions,
        task: &Task,
    ) -> Result<Self> {
        let points = shared_points(photos, visibility, options, task)?;
        let places = places_of_photos(photos, visibility, typical_distance(&points), options);
        let patches: Vec<&[PointPatch]> = points.iter().map(|point| &point.patches[..]).collect();
        let of_places = places.iter().map(|place| &place.patches[..]);
        let patches: Vec<&[PointPatch]> = patches.into_iter().chain(of_places).collect();
        let mut colours = task.timed("measure colours", || measure(photos.len(), &patches, colours))?;
        task.check_cancelled()?;
        let place_colours = colours.split_off(points.len());
        let camera_logs = vec![None; photos.len()];
        Ok(Self { points, colours, joined: visibility.joined(), places, place_colours, camera_logs })
    }

    /// Returns what is measured where only these photos (in rising order) exist, which are numbered anew.
    pub(super) fn of_photos(&self, kept: &[PhotoId]) -> Self {
        let number = |photo: PhotoId| kept.binary_search(&photo).ok().map(PhotoId::new);
        // Two patches at least: there is nothing to compare with where one photo alone is left.
        let left = |own: PhotoId, patches: &[PointPatch], measured: &[PatchColour]| {
            let own = number(own)?;
            let of_photo = patches.iter().zip(measured).filter_map(|(patch, colour)| {
                let mut patch = *patch;
                patch.photo = number(patch.photo)?;
                Some((patch, *colour))
            });
            let (patches, measured): (Vec<_>, Vec<_>) = of_photo.unzip();
            (patches.len() >= 2).then_some((own, patches, measured))
        };
        let of_point = |(point, measured): (&SharedPoint, &Vec<PatchColour>)| {
            let (own, patches, measured) = left(point.own, &point.patches, measured)?;
            let SharedPoint { face, position, normal, .. } = *point;
            Some((SharedPoint { own, face, position, normal, patches }, measured))
        };
        let of_place = |(place, measured): (&PhotoPlace, &Vec<PatchColour>)| {
            let (own, patches, measured) = left(place.own, &place.patches, measured)?;
            Some((PhotoPlace { own, face: place.face, patches }, measured))
        };
        let (points, colours) = self.points.iter().zip(&self.colours).filter_map(of_point).unzip();
        let (places, place_colours) =
            self.places.iter().zip(&self.place_colours).filter_map(of_place).unzip();
        let camera_logs = kept.iter().map(|photo| self.camera_logs[photo.index()]).collect();
        Self { points, colours, joined: self.joined.clone(), places, place_colours, camera_logs }
    }
}

/// Measures the colours of all patches, per point.
fn measure(
    photo_count: usize,
    points: &[&[PointPatch]],
    colours: &(impl Fn(PhotoId, &[DVec2]) -> Result<Vec<PatchColour>> + Sync),
) -> Result<Vec<Vec<PatchColour>>> {
    // Grouped by photo, so that each photo is read once: (point, index among its patches, centre).
    let mut wanted: Vec<Vec<(usize, usize, DVec2)>> = vec![Vec::new(); photo_count];
    for (p, point) in points.iter().enumerate() {
        for (k, patch) in point.iter().enumerate() {
            wanted[patch.photo.index()].push((p, k, patch.center_px));
        }
    }
    let of_photo = |(photo, wanted): (usize, &Vec<(usize, usize, DVec2)>)| {
        let centers: Vec<DVec2> = wanted.iter().map(|(_, _, center)| *center).collect();
        if centers.is_empty() { Ok(Vec::new()) } else { colours(PhotoId::new(photo), &centers) }
    };
    let found: Vec<Vec<PatchColour>> = wanted.par_iter().enumerate().map(of_photo).collect::<Result<_>>()?;
    let mut measured: Vec<Vec<PatchColour>> =
        points.iter().map(|patches| vec![None; patches.len()]).collect();
    for (wanted, found) in wanted.iter().zip(found) {
        for ((p, k, _), colour) in wanted.iter().zip(found) {
            measured[*p][*k] = colour;
        }
    }
    Ok(measured)
}
