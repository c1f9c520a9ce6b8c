//! The disagreement of one photo with the consensus of the others, pixel by pixel.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::TransientOptions;
use super::reduced_photo::{ReducedPhoto, Tint, length};
use crate::error::Result;
use crate::layers::fill::{SurfaceId, Surfaces};
use crate::projection::relief::Relief;
use crate::raster::robust::{median, of_rank};
use crate::scene::PhotoId;
use crate::task::Task;

/// The largest number of photos that a photo is compared with, the nearest ones.
const MOST_OBSERVERS: usize = 24;

/// The least number of other photos that have to show a point.
const LEAST_OBSERVERS: usize = 2;

/// The sine of the least angle, about two degrees, under which a surface is compared. The ground of a square
/// is seen under three degrees from its far side, where people stand.
const GRAZING: f64 = 0.03;

/// The data that the comparisons of all photos of a site share.
pub struct ReducedPhotos<'a> {
    /// The reduced photos, in the site's order; `None` where a photo cannot be read.
    pub looks: &'a [Option<ReducedPhoto>],
    /// The surfaces of the model in world coordinates.
    pub surfaces: &'a Surfaces,
    /// The heights of the true surface over the model's.
    pub relief: &'a Relief,
}

/// Measures, for each pixel of a reduced photo, how far it is from what the others show there: a natural
/// logarithm, row by row; NaN where too few others show the point. `photo` is an index in the site's order.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub fn disagreement(
    observers: &ReducedPhotos,
    photo: PhotoId,
    options: &TransientOptions,
    task: &Task,
) -> Result<Vec<f32>> {
    let Some(tested) = &observers.looks[photo.index()] else { return Ok(Vec::new()) };
    let consensus = Consensus { observers, tested, others: nearest(observers.looks, photo), options };
    let (width, height) = (tested.donor.camera.width, tested.donor.camera.height);
    let row = |y: u32| {
        task.go_on()?;
        Ok((0..width).map(|x| consensus.pixel(x, y).unwrap_or(f32::NAN)).collect::<Vec<f32>>())
    };
    let rows: Vec<Vec<f32>> = (0..height).into_par_iter().map(row).collect::<Result<_>>()?;
    Ok(rows.concat())
}

/// Returns the other photos, nearest first.
fn nearest(looks: &[Option<ReducedPhoto>], photo: PhotoId) -> Vec<&ReducedPhoto> {
    let eye = |look: &ReducedPhoto| look.donor.pose.center_in_world();
    let own = looks[photo.index()].as_ref().map_or(DVec3::ZERO, eye);
    let others = PhotoId::all(looks.len()).zip(looks).filter(|(other, _)| *other != photo);
    let mut others: Vec<&ReducedPhoto> = others.filter_map(|(_, look)| look.as_ref()).collect();
    others.sort_by(|a, b| eye(a).distance(own).total_cmp(&eye(b).distance(own)));
    others.truncate(MOST_OBSERVERS);
    others
}

struct Consensus<'a> {
    observers: &'a ReducedPhotos<'a>,
    tested: &'a ReducedPhoto,
    others: Vec<&'a ReducedPhoto>,
    options: &'a TransientOptions,
}

impl Consensus<'_> {
    /// Computes the disagreement at a pixel; `None` where fewer than two other photos show the point.
    fn pixel(&self, x: u32, y: u32) -> Option<f32> {
        let (id, point) = self.visible_point(x, y)?;
        let tint = self.tested.tint(x, y);
        let (mut distances, mut tints) = ([0.0; MOST_OBSERVERS], [[0.0; 3]; MOST_OBSERVERS]);
        let mut count = 0;
        for look in &self.others {
            let Some(px) = self.seen(look, id, point) else { continue };
            distances[count] = look.distance(tint, px, self.options.reach);
            tints[count] = look.tint(px.x as u32, px.y as u32);
            count += 1;
        }
        if count < LEAST_OBSERVERS {
            return None;
        }
        let others_disagreement = deviation(&tints[..count]) / self.options.dispute;
        // One photo in four may be wrong like the tested one, because it shows the same object or is out of
        // register.
        Some(of_rank(&mut distances[..count], count / 4)? / (1.0 + others_disagreement * others_disagreement))
    }

    /// Returns the surface that the tested photo shows at a pixel, and the point in world coordinates.
    fn visible_point(&self, x: u32, y: u32) -> Option<(SurfaceId, DVec3)> {
        let donor = &self.tested.donor;
        let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let item = donor.owner(x, y)?;
        let seen = donor.seen(item);
        let id = self.observers.surfaces.id(seen.face, seen.triangle);
        let surface = self.observers.surfaces.get(id);
        if surface.billboard || !donor.shows(item, px) {
            return None;
        }
        let eye = donor.pose.center_in_world();
        let ray = (donor.pose.rotation.transpose() * donor.camera.ray_in_camera(px)).normalize();
        let slope = surface.plane.normal.dot(ray);
        if slope.abs() < GRAZING {
            return None;
        }
        let on_plane = eye - ray * (surface.plane.signed_distance(eye) / slope);
        let relief = self.observers.relief.of(surface.face);
        let point = relief.map_or(on_plane, |relief| relief.meet(eye, on_plane, surface.plane.normal));
        Some((id, point))
    }

    /// Returns the pixel position at which another photo shows a surface point, well inside what it shows of
    /// the surface.
    fn seen(&self, look: &ReducedPhoto, id: SurfaceId, point: DVec3) -> Option<DVec2> {
        let item = look.donor.item(id)?;
        let normal = self.observers.surfaces.get(id).plane.normal;
        let ray = (point - look.donor.pose.center_in_world()).normalize();
        if normal.dot(ray).abs() < GRAZING {
            return None;
        }
        look.place(point).filter(|px| look.donor.shows(item, *px))
    }
}

/// Computes the median distance of colours from their median.
fn deviation(tints: &[Tint]) -> f32 {
    const COUNTED: &str = "several witnesses say something";
    let middle = [0, 1, 2].map(|c| {
        let mut values = [0.0; MOST_OBSERVERS];
        tints.iter().zip(&mut values).for_each(|(tint, value)| *value = tint[c]);
        median(&mut values[..tints.len()]).expect(COUNTED)
    });
    let mut values = [0.0; MOST_OBSERVERS];
    for (tint, value) in tints.iter().zip(&mut values) {
        *value = length([0, 1, 2].map(|c| tint[c] - middle[c]));
    }
    median(&mut values[..tints.len()]).expect(COUNTED)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn witnesses_that_quarrel_are_spread_and_one_stray_among_them_is_not() {
        let grey = |l: f32| [l, 0.0, 0.0];
        assert!(deviation(&[grey(-1.0), grey(-1.1), grey(-1.05), grey(-4.0)]) < 0.06);
        assert!(deviation(&[grey(-1.0), grey(-2.0), grey(-3.0), grey(-4.0)]) > 0.9);
    }
}
