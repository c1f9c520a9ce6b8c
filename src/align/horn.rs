//! The similarity between two lists of places in closed form (Horn 1987, *Closed-form solution of absolute orientation
//! using unit quaternions*).

use glam::{DMat3, DQuat, DVec3};

use quadratura_base::geometry::Similarity;

use super::linear::eigen;

/// Returns the similarity that brings each first place to its second one with the least sum of squares; `None` for fewer than
/// three pairs, or where all first or all second places lie on one line.
pub fn similarity(pairs: &[(DVec3, DVec3)]) -> Option<Similarity> {
    let count = pairs.len() as f64;
    let from = pairs.iter().map(|(from, _)| *from).sum::<DVec3>() / count;
    let to = pairs.iter().map(|(_, to)| *to).sum::<DVec3>() / count;
    if pairs.len() < 3
        || is_on_a_line(pairs.iter().map(|p| p.0 - from))
        || is_on_a_line(pairs.iter().map(|p| p.1 - to))
    {
        return None;
    }
    // Sums of products, S in the paper, as columns.
    let (mut sums, mut size_from, mut size_to) = (DMat3::ZERO, 0.0, 0.0);
    for (a, b) in pairs {
        let (a, b) = (a - from, b - to);
        sums += DMat3::from_cols(a * b.x, a * b.y, a * b.z);
        size_from += a.length_squared();
        size_to += b.length_squared();
    }
    let s = |row: usize, column: usize| sums.col(column)[row];
    let [yz, zx, xy] = [s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0)];
    let matrix = [
        [s(0, 0) + s(1, 1) + s(2, 2), yz, zx, xy],
        [yz, s(0, 0) - s(1, 1) - s(2, 2), s(0, 1) + s(1, 0), s(2, 0) + s(0, 2)],
        [zx, s(0, 1) + s(1, 0), -s(0, 0) + s(1, 1) - s(2, 2), s(1, 2) + s(2, 1)],
        [xy, s(2, 0) + s(0, 2), s(1, 2) + s(2, 1), -s(0, 0) - s(1, 1) + s(2, 2)],
    ];
    let [w, x, y, z] = eigen(matrix)[3].1;
    let rotation = DMat3::from_quat(DQuat::from_xyzw(x, y, z, w).normalize());
    let scale = (size_to / size_from).sqrt();
    let found = Similarity { scale, rotation, translation: to - rotation * (from * scale) };
    (scale.is_finite() && scale > 0.0 && found.translation.is_finite()).then_some(found)
}

/// Whether places about their middle lie on one line, or all in one place.
fn is_on_a_line(places: impl Iterator<Item = DVec3>) -> bool {
    let mut sums = [[0.0; 3]; 3];
    for place in places {
        for i in 0..3 {
            for j in 0..3 {
                sums[i][j] += place[i] * place[j];
            }
        }
    }
    let [_, second, first] = eigen(sums);
    // A thousandth of the length across it holds no turn about the line.
    second.0 <= 1e-6 * first.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_places_give_the_similarity_exactly_and_a_line_gives_none() {
        let rotation = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 2.0);
        let right = Similarity { scale: 0.02, rotation, translation: DVec3::new(4e5, -5.0, 3.0) };
        let places = [DVec3::ZERO, DVec3::X * 100.0, DVec3::new(20.0, 50.0, 0.0)];
        let found = similarity(&places.map(|place| (place, right.apply(place)))).unwrap();
        for place in [DVec3::splat(70.0), DVec3::Z] {
            assert!(found.apply(place).distance(right.apply(place)) < 1e-9);
        }
        let line = [0.0, 1.0, 2.0, 5.0].map(|x| (DVec3::X * x, right.apply(DVec3::X * x)));
        assert_eq!(similarity(&line), None);
        assert_eq!(similarity(&line[..2]), None);
    }
}
