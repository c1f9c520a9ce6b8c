//! The part of a model that one wants to see at once: everything but backdrops, which stand around it, and wide ground.

use glam::DVec3;

/// The least reach of a backdrop, as a multiple of that of the next object: skies modelled around castle, fountain and entry
/// have 1.7 to 2.1, the farthest buildings and grounds of castle, fountain and piazza 1.0 to 1.4.
const BACKDROP: f64 = 1.5;
/// The least reach of wide ground, as a multiple of that of everything that stands: 1.2 around the piazza, 1.3 around the
/// fountain. The yard before a building of the castle ends with it (1.0).
const GROUND: f64 = 1.05;
/// The greatest height of flat ground, as a share of its length: 0.01 of the fountain's.
const FLAT: f64 = 0.03;
/// The greatest slope of ground, as a tangent.
const SLOPE: f64 = 0.4;
/// The least width of ground, as a share of its length: eaves and cornices are narrower.
const WIDE: f64 = 0.25;

/// Returns the points of a model's objects without backdrops and wide ground: the farthest object is left out as long as it
/// reaches 1.5 times as far from the middle of the objects as the next one, or is flat ground that reaches farther than all
/// that stands on it. `up` has length 1.
pub fn without_backdrops(objects: &[Vec<DVec3>], up: DVec3) -> Vec<DVec3> {
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
    while let [.., before, last] = objects[..] {
        let standing = objects.iter().rev().find(|points| !is_ground(points, up));
        let is_wide = is_ground(last, up) && standing.is_some_and(|it| reach(last) > GROUND * reach(it));
        if !is_wide && reach(last) <= BACKDROP * reach(before) {
            break;
        }
        objects.pop();
    }
    objects.into_iter().flatten().copied().collect()
}

/// Returns whether an object is flat, wide and about level: the mean direction of cameras is not quite that of the world's up.
fn is_ground(points: &[DVec3], up: DVec3) -> bool {
    let side = up.any_orthonormal_vector();
    let across = up.cross(side);
    let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let from_middle = points.iter().map(|point| *point - middle);
    let local: Vec<DVec3> =
        from_middle.map(|it| DVec3::new(it.dot(side), it.dot(across), it.dot(up))).collect();
    // The plane that fits best: its height is a x + b y.
    let sum = |of: fn(&DVec3) -> f64| local.iter().map(of).sum::<f64>();
    let (xx, xy, yy) = (sum(|p| p.x * p.x), sum(|p| p.x * p.y), sum(|p| p.y * p.y));
    let (xz, yz) = (sum(|p| p.x * p.z), sum(|p| p.y * p.z));
    let determinant = xx * yy - xy * xy;
    if determinant <= f64::EPSILON * (xx + yy).powi(2) {
        return false;
    }
    let slope = [(xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant];
    let extent = |of: &dyn Fn(&DVec3) -> f64| {
        let (low, high) = local
            .iter()
            .map(of)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), it| (low.min(it), high.max(it)));
        high - low
    };
    let (one, other) = (extent(&|p| p.x), extent(&|p| p.y));
    let height = extent(&|p| p.z - slope[0] * p.x - slope[1] * p.y);
    let length = one.max(other);
    slope[0].hypot(slope[1]) <= SLOPE && height <= FLAT * length && one.min(other) >= WIDE * length
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_view::navigation::SceneFrame;

    fn boxed(center: DVec3, half: DVec3) -> Vec<DVec3> {
        (0..8)
            .map(|corner| {
                let sign = |bit: u32| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
                center + half * DVec3::new(sign(0), sign(1), sign(2))
            })
            .collect()
    }

    fn houses() -> Vec<Vec<DVec3>> {
        (0..5).map(|i| boxed(DVec3::X * f64::from(i), DVec3::splat(0.5))).collect()
    }

    /// The radius of the frame of houses and something else.
    fn with(more: &[Vec<DVec3>], up: DVec3) -> f64 {
        let objects: Vec<Vec<DVec3>> = houses().into_iter().chain(more.iter().cloned()).collect();
        SceneFrame::new(&without_backdrops(&objects, up), up).radius
    }

    #[test]
    fn a_backdrop_is_no_part_of_what_is_framed_and_the_largest_building_is() {
        let none = with(&[], DVec3::Z);
        let cube = |center: DVec3, half: f64| boxed(center, DVec3::splat(half));
        assert_eq!(with(&[cube(DVec3::ZERO, 50.0)], DVec3::Z), none);
        assert!(with(&[cube(DVec3::X * 5.0, 0.5)], DVec3::Z) > none);
        let sky = vec![cube(DVec3::ZERO, 50.0)];
        assert_eq!(without_backdrops(&sky, DVec3::Z).len(), 8, "a single object is no backdrop");
    }

    #[test]
    fn wide_ground_is_no_part_of_what_is_framed_whichever_way_is_up_and_a_wall_is() {
        for up in [DVec3::Z, DVec3::NEG_Y] {
            // It reaches 1.3 times as far as the houses: no backdrop.
            let half = DVec3::splat(2.4) - 2.38 * up.abs();
            let [one, other] = [2.0, 1.8].map(|x| boxed(DVec3::X * x, half));
            assert_eq!(with(&[one, other], up), with(&[], up), "{up}");
            let tilted = (up + 0.2 * DVec3::X).normalize();
            assert!(is_ground(&boxed(DVec3::ZERO, half), tilted), "cameras look down a little");
        }
        let wall = boxed(DVec3::X * 2.0, DVec3::new(2.4, 0.02, 2.4));
        assert!(with(&[wall], DVec3::Z) > with(&[], DVec3::Z), "it is flat, and stands");
        let plates: Vec<Vec<DVec3>> =
            (1..4).map(|i| boxed(DVec3::ZERO, DVec3::new(f64::from(i), f64::from(i), 0.0))).collect();
        assert!(
            !without_backdrops(&plates, DVec3::Z).is_empty(),
            "where there is nothing else, ground is framed"
        );
    }
}
