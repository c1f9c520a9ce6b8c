//! How well a photo shows a face, and which photos of many are chosen for it.

use glam::DVec3;

use quadratura_base::scene::{FaceId, Model};

/// The number of points of a face at which photos are asked.
const POINTS: usize = 32;

/// A point of a face, with the area of the face that it stands for in square world units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacePoint {
    /// The position.
    pub position: DVec3,
    /// The area.
    pub area: f64,
}

/// Returns points that are spread evenly over a face: along its triangles by area, and in each by a low-discrepancy sequence (Roberts,
/// *The Unreasonable Effectiveness of Quasirandom Sequences*, 2018).
pub fn face_points(model: &Model, face: FaceId) -> Vec<FacePoint> {
    let triangles: Vec<[DVec3; 3]> =
        model.face_triangles(face).iter().map(|t| t.map(|vertex| model.vertices[vertex as usize])).collect();
    let area_of = |[a, b, c]: &[DVec3; 3]| (*b - *a).cross(*c - *a).length() / 2.0;
    let total: f64 = triangles.iter().map(area_of).sum();
    if total <= 0.0 {
        return Vec::new();
    }
    let mut points = Vec::with_capacity(POINTS);
    let (mut triangle, mut passed) = (0, 0.0);
    for number in 0..POINTS {
        let at = (number as f64 + 0.5) / POINTS as f64 * total;
        while triangle + 1 < triangles.len() && passed + area_of(&triangles[triangle]) < at {
            passed += area_of(&triangles[triangle]);
            triangle += 1;
        }
        let [mut s, mut t] =
            [0.754_877_666_246_693, 0.569_840_290_998_053].map(|step| (number as f64 * step).fract());
        if s + t > 1.0 {
            (s, t) = (1.0 - s, 1.0 - t);
        }
        let [a, b, c] = triangles[triangle];
        points.push(FacePoint { position: a + (b - a) * s + (c - a) * t, area: total / POINTS as f64 });
    }
    points
}

/// A photo for a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// How many pixels of the face it shows, each counted by its weight.
    pub pixels: f64,
    /// The unit direction from the face to its camera.
    pub direction: DVec3,
    /// Whether the user pinned the face to it.
    pub pinned: bool,
}

/// Chooses at most `most` of the candidates, and returns their places, ascending: a pinned one and the best first, then always the
/// one whose direction is farthest from those chosen, weighed with how well it shows the face.
pub fn chosen(candidates: &[Candidate], most: usize) -> Vec<usize> {
    let mut rest: Vec<usize> = (0..candidates.len()).collect();
    let best = candidates.iter().map(|candidate| candidate.pixels).fold(f64::MIN_POSITIVE, f64::max);
    let mut taken: Vec<usize> = Vec::new();
    while taken.len() < most && !rest.is_empty() {
        let worth = |place: usize| {
            let Candidate { pixels, direction, pinned } = candidates[place];
            let nearest = taken.iter().map(|&other| direction.distance(candidates[other].direction));
            // No two directions are farther from each other than 2.
            let apart = nearest.fold(2.0, f64::min);
            (pinned, apart * (pixels / best).sqrt())
        };
        let order = |a: &usize, b: &usize| {
            let ((pinned, worth_a), (other, worth_b)) = (worth(*a), worth(*b));
            pinned.cmp(&other).then(worth_a.total_cmp(&worth_b)).then(b.cmp(a))
        };
        let next = rest.iter().copied().max_by(order).expect("there are candidates left");
        rest.retain(|place| *place != next);
        taken.push(next);
    }
    taken.sort_unstable();
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(pixels: f64, degrees: f64) -> Candidate {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Candidate { pixels, direction: DVec3::new(cos, sin, 0.0), pinned: false }
    }

    #[test]
    fn the_best_is_chosen_first_and_then_directions_spread() {
        let candidates =
            [candidate(90.0, 2.0), candidate(100.0, 0.0), candidate(60.0, 70.0), candidate(0.1, 170.0)];
        assert_eq!(chosen(&candidates, 1), [1]);
        assert_eq!(chosen(&candidates, 2), [1, 2], "the one beside it adds nothing");
        assert_eq!(chosen(&candidates, 9), [0, 1, 2, 3]);
    }

    #[test]
    fn a_pinned_photo_is_chosen_before_better_ones() {
        let mut candidates = [candidate(100.0, 0.0), candidate(1.0, 40.0)];
        candidates[1].pinned = true;
        assert_eq!(chosen(&candidates, 1), [1]);
    }
}
