//! How far the sparse points are from the faces, by object: where the model is drawn beside what the photos show.

use std::collections::BTreeMap;

use glam::DVec3;

use super::faces::CheckedSurface;
use super::report::ObjectDistances;
use quadratura_base::raster::robust::{quantile, upper_median};
use quadratura_base::scene::{Model, ObjectId, Site, SparsePoint};

/// A point farther from the model than this share of its distance from the nearest camera that observed it belongs to
/// something that is not modelled, such as a tree. Five times what counts as a match, so that errors are in the list.
const BELONGS: f64 = 0.05;

/// The least number of points by which an object is judged: of fewer, a few outliers would be the largest distances.
const ENOUGH: usize = 20;

/// Returns the distances of the sparse points from the faces nearest to them, for each object with enough points; the
/// objects with the largest distances first.
pub fn distances(site: &Site, surface: &CheckedSurface, points: &[SparsePoint]) -> Vec<ObjectDistances> {
    let model = &site.model;
    let eyes: Vec<DVec3> = site.photos.iter().map(|photo| photo.pose.center_in_world()).collect();
    let mut of_object: BTreeMap<ObjectId, Vec<f64>> = BTreeMap::new();
    for point in points.iter().filter(|point| point.position.is_finite()) {
        let eyes = point.observations.iter().filter_map(|&(photo, _)| eyes.get(photo as usize));
        let ray = eyes.map(|eye| eye.distance(point.position)).min_by(f64::total_cmp);
        let (Some(ray), Some((triangle, foot))) = (ray, surface.tree.nearest(point.position)) else {
            continue;
        };
        let distance = foot.distance(point.position);
        if distance <= BELONGS * ray {
            let object = model.face(surface.faces[triangle as usize]).object;
            of_object.entry(object).or_default().push(distance);
        }
    }
    let enough = of_object.into_iter().filter(|(_, distances)| distances.len() >= ENOUGH);
    let mut found: Vec<ObjectDistances> = enough.map(|(object, all)| of_one(model, object, all)).collect();
    found.sort_by(|a, b| b.most.total_cmp(&a.most).then_with(|| a.object.cmp(&b.object)));
    found
}

fn of_one(model: &Model, object: ObjectId, mut distances: Vec<f64>) -> ObjectDistances {
    ObjectDistances {
        object: model.object(object).name.clone(),
        points: distances.len(),
        median: upper_median(&mut distances).unwrap_or(0.0),
        most: quantile(&mut distances, 0.95).unwrap_or(0.0),
        largest: distances.iter().copied().fold(0.0, f64::max),
    }
}
