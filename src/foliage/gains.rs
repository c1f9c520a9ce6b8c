//! The gains of images: how much brighter the polygons of a sub-object are than its samples, as measured when images are made.

use std::f64::consts::TAU;

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::brute::sums_of_light;
use super::directions::Directions;
use super::flakes::light_of_flakes;
use super::images::{ObjectImages, PlantImages};
use super::plant::Plant;
use super::shade::OutdoorLight;
use super::view::{Projection, View};
use super::walk::WalkOptions;
use quadratura_base::error::Result;
use quadratura_base::task::Task;

/// The number of views all around in which light is measured.
const VIEWS: u32 = 12;
/// The number of suns in each of them.
const SUNS: usize = 8;
/// How many pixels are across a sub-object when its polygons are drawn.
const ACROSS: f64 = 64.0;
/// Gains are within this factor of 1: what is farther off shows something else than the mean of normals.
const MOST: f32 = 1.5;

/// Measures the gains of all copies of a sub-object's images: the light of its polygons over that of the copy as flakes, each as large as it
/// is drawn at most, in the mean over views all around and suns. With the images of its parts, their light stands for that of the polygons.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub(super) fn measured(
    plant: &Plant,
    object: usize,
    images: ObjectImages,
    directions: Directions,
    parts: Option<&PlantImages>,
    task: &Task,
) -> Result<ObjectImages> {
    let plant = match parts {
        None => plant.part(object),
        // The images of parts have the places of the plant's sub-objects.
        Some(_) => Plant { root: object, objects: plant.objects[..=object].to_vec(), ..*plant },
    };
    let quiet = Task::silent().with_stop_flag(task.stop_flag());
    let ball = plant.whole().bounds.ball;
    let view = |number: u32, scale: f64| {
        let side = (2.0 * scale * ball.radius).ceil() as u32 + 2;
        let centre_px = DVec2::splat(0.5 * f64::from(side));
        let rotation = looking_from(around(number, VIEWS));
        View {
            projection: Projection::Parallel { width: side, height: side, scale, centre_px },
            view_from_plant: DAffine3::from_mat3_translation(rotation, -(rotation * ball.middle)),
            light_from_view: rotation.transpose(),
        }
    };
    let mean = |(sums, covered): ([Vec3; SUNS], u32)| sums.map(|sum| sum / covered.max(1) as f32);
    let sum = |lights: Vec<[Vec3; SUNS]>| lights.into_iter().flatten().sum::<Vec3>();
    let truth = (0..VIEWS).into_par_iter().map(|number| {
        let (view, suns) = (view(number, ACROSS / (2.0 * ball.radius)), suns(number, plant.up));
        match parts {
            Some(parts) => light_of_flakes(&plant, parts, &view, suns, &quiet).map(mean),
            None => sums_of_light(&plant, &view, suns, &quiet).map(mean),
        }
    });
    let truth = sum(truth.collect::<Result<_>>()?);
    let mut all = PlantImages { directions, from_parts: false, objects: vec![None; plant.objects.len()] };
    let deltas: Vec<f64> = images.copies.iter().map(|copy| copy.delta).collect();
    all.objects[plant.root] = Some(images);
    // As large as the copy is where nothing else is drawn of the sub-object.
    let largest = WalkOptions::PREVIEW.alone();
    let gain = |delta: f64| {
        let drawn = (0..VIEWS).into_par_iter().map(|number| {
            let view = view(number, largest / delta);
            light_of_flakes(&plant, &all, &view, suns(number, plant.up), &quiet).map(mean)
        });
        let drawn = sum(drawn.collect::<Result<_>>()?);
        let ratio = truth / drawn.max(Vec3::splat(f32::MIN_POSITIVE));
        Ok(Vec3::from_array(ratio.to_array().map(|gain| gain.clamp(MOST.recip(), MOST))))
    };
    let gains = deltas.into_iter().map(gain).collect::<Result<Vec<Vec3>>>()?;
    let mut images = all.objects[plant.root].take().expect("they are those of this sub-object");
    for (copy, gain) in images.copies.iter_mut().zip(gains) {
        copy.correction.gain = gain;
    }
    Ok(images)
}

/// Returns the suns of a view: all around, because parts of a plant are turned in any direction; other ones in each view.
fn suns(view: u32, up: DVec3) -> [OutdoorLight; SUNS] {
    let day = OutdoorLight::day(up);
    let around_all = 0.5 * (day.sky + day.ground);
    let turn = DMat3::from_rotation_z(TAU * f64::from(view) / f64::from(VIEWS));
    std::array::from_fn(|sun| OutdoorLight {
        towards_sun: turn * around(sun as u32, SUNS as u32),
        sky: around_all,
        ground: around_all,
        ..day
    })
}

/// Returns one of `count` directions that are spread evenly: a spiral by the golden angle.
fn around(number: u32, count: u32) -> DVec3 {
    let z = 1.0 - (2.0 * f64::from(number) + 1.0) / f64::from(count);
    let turn = DVec2::from_angle(f64::from(number) * 137.508f64.to_radians());
    ((1.0 - z * z).sqrt() * turn).extend(z)
}

/// Returns the rotation to the frame of a view from a direction.
fn looking_from(towards: DVec3) -> DMat3 {
    let (down, right) = towards.any_orthonormal_pair();
    DMat3::from_cols(right, down, -towards).transpose()
}
