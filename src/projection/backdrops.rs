//! The part of a model that one wants to see at once: everything but backdrops, which stand around it.

use glam::DVec3;

/// The least reach of a backdrop, as a multiple of that of the next object: skies modelled around castle, fountain and entry
/// have 1.7 to 2.1, the farthest buildings and grounds of castle, fountain and piazza 1.0 to 1.4.
const BACKDROP: f64 = 1.5;

/// Returns the points of a model's objects without backdrops: the farthest object is left out as long as it reaches 1.5
/// times as far from the middle of the objects as the next one.
pub fn without_backdrops(objects: &[Vec<DVec3>]) -> Vec<DVec3> {
    let mean = |points: &Vec<DVec3>| points.iter().sum::<DVec3>() / points.len() as f64;
    let mut objects: Vec<&Vec<DVec3>> = objects.iter().filter(|points| !points.is_empty()).collect();
    let median = |axis: usize| {
        let mut values: Vec<f64> = objects.iter().map(|points| mean(points)[axis]).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    let middle = DVec3::new(median(0), median(1), median(2));
    let reach = |points: &Vec<DVec3>| points.iter().map(|point| point.distance(middle)).fold(0.0, f64::max);
    objects.sort_by(|a, b| reach(a).total_cmp(&reach(b)));
    while let [.., before, last] = objects[..]
        && reach(last) > BACKDROP * reach(before)
    {
        objects.pop();
    }
    objects.into_iter().flatten().copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::navigation::SceneFrame;

    #[test]
    fn a_backdrop_is_no_part_of_what_is_framed_and_the_largest_building_is() {
        let cube = |center: DVec3, half: f64| vec![center - DVec3::splat(half), center + DVec3::splat(half)];
        let near: Vec<Vec<DVec3>> = (0..5).map(|i| cube(DVec3::X * f64::from(i), 0.5)).collect();
        let with = |more: Vec<DVec3>| {
            let objects: Vec<Vec<DVec3>> = near.iter().cloned().chain([more]).collect();
            SceneFrame::new(&without_backdrops(&objects), DVec3::Z).radius
        };
        let none = SceneFrame::new(&without_backdrops(&near), DVec3::Z).radius;
        assert_eq!(with(cube(DVec3::ZERO, 50.0)), none);
        assert!(with(cube(DVec3::X * 5.0, 0.5)) > none);
        let sky = vec![cube(DVec3::ZERO, 50.0)];
        assert_eq!(without_backdrops(&sky).len(), 2, "a single object is no backdrop");
    }
}
