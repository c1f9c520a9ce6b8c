//! The colours that photos have at common surface points: what everything about exposure is estimated from.

use glam::DVec2;
use rayon::prelude::*;

use super::{ExposureOptions, JoinedFaces, PatchColour, SharedPoint, Visibility, shared_points};
use crate::error::Result;
use crate::projection::Projector;
use crate::scene::PhotoId;
use crate::task::Task;

/// Common surface points with the colours that the photos have there.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredColours {
    /// The points, in the order of the photos on whose grids they lie.
    pub points: Vec<SharedPoint>,
    /// The colour of each patch of each point.
    pub colours: Vec<Vec<PatchColour>>,
    /// The faces that share edges.
    pub joined: Vec<JoinedFaces>,
}

impl MeasuredColours {
    /// Finds common points of `photos` and measures their colours. `colours` measures patches of one photo, given their
    /// centres in its pixels, in the same order; it is called once per photo, for several photos in parallel. The result
    /// does not depend on the number of threads.
    ///
    /// # Errors
    /// The errors of `colours`, and [`crate::Error::Cancelled`].
    pub fn measure(
        photos: &[Projector],
        visibility: &impl Visibility,
        colours: &(impl Fn(PhotoId, &[DVec2]) -> Result<Vec<PatchColour>> + Sync),
        options: &ExposureOptions,
        task: &Task,
    ) -> Result<Self> {
        let points = shared_points(photos, visibility, options, task)?;
        let colours = task.timed("measure colours", || measure(photos.len(), &points, colours))?;
        task.go_on()?;
        Ok(Self { points, colours, joined: visibility.joined() })
    }

    /// Returns what is measured where only these photos (in rising order) exist, which are numbered anew.
    pub(super) fn of_photos(&self, kept: &[PhotoId]) -> Self {
        let number = |photo: PhotoId| kept.binary_search(&photo).ok().map(PhotoId::new);
        let (mut points, mut colours) = (Vec::new(), Vec::new());
        for (point, measured) in self.points.iter().zip(&self.colours) {
            let Some(own) = number(point.own) else { continue };
            let of_photo = point.patches.iter().zip(measured).filter_map(|(patch, colour)| {
                let mut patch = *patch;
                patch.photo = number(patch.photo)?;
                Some((patch, *colour))
            });
            let (patches, measured): (Vec<_>, Vec<_>) = of_photo.unzip();
            if patches.len() >= 2 {
                let SharedPoint { face, position, normal, .. } = *point;
                points.push(SharedPoint { own, face, position, normal, patches });
                colours.push(measured);
            }
        }
        Self { points, colours, joined: self.joined.clone() }
    }
}

/// Measures the colours of all patches, per point.
fn measure(
    photo_count: usize,
    points: &[SharedPoint],
    colours: &(impl Fn(PhotoId, &[DVec2]) -> Result<Vec<PatchColour>> + Sync),
) -> Result<Vec<Vec<PatchColour>>> {
    // Grouped by photo, so that each photo is read once: (point, index among its patches, centre).
    let mut wanted: Vec<Vec<(usize, usize, DVec2)>> = vec![Vec::new(); photo_count];
    for (p, point) in points.iter().enumerate() {
        for (k, patch) in point.patches.iter().enumerate() {
            wanted[patch.photo.index()].push((p, k, patch.center_px));
        }
    }
    let of_photo = |(photo, wanted): (usize, &Vec<(usize, usize, DVec2)>)| {
        let centers: Vec<DVec2> = wanted.iter().map(|(_, _, center)| *center).collect();
        if centers.is_empty() { Ok(Vec::new()) } else { colours(PhotoId::new(photo), &centers) }
    };
    let found: Vec<Vec<PatchColour>> = wanted.par_iter().enumerate().map(of_photo).collect::<Result<_>>()?;
    let mut measured: Vec<Vec<PatchColour>> = points.iter().map(|p| vec![None; p.patches.len()]).collect();
    for (wanted, found) in wanted.iter().zip(found) {
        for ((p, k, _), colour) in wanted.iter().zip(found) {
            measured[*p][*k] = colour;
        }
    }
    Ok(measured)
}
