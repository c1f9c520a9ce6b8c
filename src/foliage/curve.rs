//! Limbs: tubes around cubic Bezier curves, and their polygons.

use glam::{DMat3, DVec2, DVec3};

use super::primitive::{Corner, CurvePoint, Limb, TriangleList};

/// A place on a curve and the direction of the curve there; both with the radius and its change as the fourth number.
struct PlaceOnCurve {
    at: CurvePoint,
    change: CurvePoint,
}

/// Evaluates cubic pieces at `t`, from 0 to the number of pieces.
fn place(points: &[CurvePoint], t: f64) -> PlaceOnCurve {
    let pieces = (points.len() - 1) / 3;
    let piece = (t as usize).min(pieces - 1);
    let (t, controls) = (t - piece as f64, &points[3 * piece..3 * piece + 4]);
    let s = 1.0 - t;
    let at = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
    let change = [-3.0 * s * s, 3.0 * s * s - 6.0 * s * t, 6.0 * s * t - 3.0 * t * t, 3.0 * t * t];
    let sum = |weights: [f64; 4]| {
        let terms = || weights.iter().zip(controls);
        let position = terms().map(|(weight, point)| *weight * point.position).sum();
        CurvePoint { position, radius: terms().map(|(weight, point)| weight * point.radius).sum() }
    };
    PlaceOnCurve { at: sum(at), change: sum(change) }
}

/// The centre line of a limb's polygons: points with the direction of the curve there.
struct Rings {
    rings: Vec<(CurvePoint, DVec3)>,
}

impl Rings {
    fn new(limb: &Limb, segments: u32) -> Self {
        let ring = |ring: u32| limb.along(f64::from(ring) / f64::from(segments));
        Self { rings: (0..=segments).map(ring).collect() }
    }

    /// Returns the place at a share of the way, between two rings.
    fn at(&self, share: f64) -> CurvePoint {
        let last = self.rings.len() - 1;
        let ring = share * last as f64;
        let first = (ring as usize).min(last - 1);
        let ((a, _), (b, _), t) = (self.rings[first], self.rings[first + 1], ring - first as f64);
        CurvePoint { position: a.position.lerp(b.position, t), radius: a.radius + t * (b.radius - a.radius) }
    }

    /// Returns the most that rings lose in width because they do not look along the straight pieces that they end.
    fn narrowed(&self) -> f64 {
        let ends = self.rings.windows(2).flat_map(|two| {
            let along = (two[1].0.position - two[0].0.position).normalize_or_zero();
            [0, 1].map(|end| two[end].0.radius * (1.0 - two[end].1.dot(along).clamp(0.0, 1.0)))
        });
        ends.fold(0.0, f64::max)
    }
}

impl Limb {
    /// Returns the place and the direction (of length 1) on the centre line at a share of the way, 0..=1 in equal steps of
    /// the curve's parameter, with the radius, in the limb's own frame.
    pub fn along(&self, share: f64) -> (CurvePoint, DVec3) {
        let place = place(&self.points, share * ((self.points.len() - 1) / 3) as f64);
        (place.at, place.change.position.normalize_or(DVec3::Z))
    }

    /// Returns how far the surface of the limb with `segments` segments along is from its own at most, in the limb's own frame, and but for
    /// what its number of sides changes. Both are tubes around lines of straight pieces: counted are the distance of the lines and the
    /// difference of the radii at the same parameter, and what either tube loses in width where a ring leans against a piece, because its
    /// quadrangles are not flat there and depend on the number of sides.
    pub(super) fn apart_along(&self, segments: u32) -> f64 {
        let [given, fewer] = [self.segments, segments].map(|segments| Rings::new(self, segments));
        let at_ring = |of: &Rings, ring: usize| {
            let share = ring as f64 / (of.rings.len() - 1) as f64;
            let [a, b] = [given.at(share), fewer.at(share)];
            a.position.distance(b.position) + (a.radius - b.radius).abs()
        };
        // Lines of straight pieces are farthest apart at a ring of one of them.
        let at_rings = |of: &Rings| (0..of.rings.len()).map(|ring| at_ring(of, ring)).fold(0.0, f64::max);
        at_rings(&given).max(at_rings(&fewer)) + given.narrowed() + fewer.narrowed()
    }

    /// Makes the limb's polygons, each as two triangles, in the sub-object's frame: rings of `sides` corners, whose first
    /// corner is carried along without twist (parallel transport). Normals look outwards and lean with the taper; u runs
    /// around, v along.
    pub fn triangles(&self) -> TriangleList {
        let (sides, segments) = (self.sides, self.segments);
        let mut corners = Vec::with_capacity(((sides + 1) * (segments + 1)) as usize);
        let object_from_normal = self.object_from_limb.matrix3.inverse().transpose();
        let mut frame: Option<DMat3> = None;
        let pieces = ((self.points.len() - 1) / 3) as f64;
        for ring in 0..=segments {
            let v = f64::from(ring) / f64::from(segments);
            let place = place(&self.points, v * pieces);
            let tangent = place.change.position;
            let speed = tangent.length();
            let carried = carried(frame, tangent);
            frame = Some(carried);
            let lean = if speed > 0.0 { place.change.radius / speed } else { 0.0 };
            for side in 0..=sides {
                let u = f64::from(side) / f64::from(sides);
                // The last corner of a ring is the first one again, to the last bit.
                let (sin, cos) =
                    (std::f64::consts::TAU * f64::from(side % sides) / f64::from(sides)).sin_cos();
                let outwards = cos * carried.x_axis + sin * carried.y_axis;
                let position = place.at.position + place.at.radius * outwards;
                let normal = object_from_normal * (outwards - lean * carried.z_axis);
                corners.push(Corner {
                    position: self.object_from_limb.transform_point3(position),
                    normal: normal.normalize_or_zero(),
                    texture: DVec2::new(u, v),
                });
            }
        }
        TriangleList { corners, triangles: grid(sides, segments) }
    }
}

/// Returns the frame (across, across, along) for a tangent that is nearest to the last one.
fn carried(last: Option<DMat3>, tangent: DVec3) -> DMat3 {
    let Some(last) = last else {
        let along = tangent.normalize_or(DVec3::Z);
        let (x, y) = along.any_orthonormal_pair();
        return DMat3::from_cols(x, y, along);
    };
    let along = tangent.normalize_or(last.z_axis);
    let x = (last.x_axis - last.x_axis.dot(along) * along).try_normalize();
    let x = x.unwrap_or_else(|| along.any_orthonormal_vector());
    DMat3::from_cols(x, along.cross(x), along)
}

/// Returns two triangles for each cell of a grid whose rows have `sides + 1` corners.
fn grid(sides: u32, segments: u32) -> Vec<[u32; 3]> {
    let cells = (0..segments).flat_map(|row| (0..sides).map(move |column| row * (sides + 1) + column));
    cells
        .flat_map(|a| {
            let [b, c, d] = [a + 1, a + sides + 2, a + sides + 1];
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;

    fn point(x: f64, y: f64, z: f64, radius: f64) -> CurvePoint {
        CurvePoint { position: DVec3::new(x, y, z), radius }
    }

    fn limb(points: Vec<CurvePoint>, object_from_limb: DAffine3) -> Limb {
        Limb { points, sides: 7, segments: 5, object_from_limb }
    }

    #[test]
    fn a_straight_limb_is_a_cone_with_its_normals() {
        // Control points in equal steps make a line in equal steps.
        let points = (0..4).map(|i| point(0.0, 0.0, f64::from(i) / 3.0, 0.4 - 0.1 * f64::from(i))).collect();
        let list = limb(points, DAffine3::IDENTITY).triangles();
        assert_eq!((list.corners.len(), list.triangles.len()), (8 * 6, 2 * 7 * 5));
        for corner in &list.corners {
            let (across, along) = (corner.position.truncate(), corner.position.z);
            // Rounding of a few operations on numbers near 1.
            assert!((across.length() - (0.4 - 0.3 * along)).abs() < 1e-12, "{corner:?}");
            assert!((corner.normal.z - 0.3 / (1.0f64 + 0.09).sqrt()).abs() < 1e-12, "{corner:?}");
        }
        for [a, b, c] in list.triangles.iter().map(|t| t.map(|i| list.corners[i as usize])) {
            let normal = (b.position - a.position).cross(c.position - a.position);
            assert!(normal.dot(a.normal) > 0.0, "triangles are wound as their normals say");
        }
    }

    #[test]
    fn a_bent_limb_of_two_pieces_keeps_its_radius_and_does_not_twist() {
        let points = [
            (0., 0., 0.),
            (0., 0., 1.),
            (1., 0., 2.),
            (2., 0., 2.),
            (3., 0., 2.),
            (4., 1., 2.),
            (4., 2., 2.),
        ];
        let points: Vec<_> = points.into_iter().map(|(x, y, z)| point(x, y, z, 0.1)).collect();
        let limb = limb(points, DAffine3::IDENTITY);
        let list = limb.triangles();
        for (ring, corners) in list.corners.chunks(8).enumerate() {
            let (at, along) = limb.along(ring as f64 / 5.0);
            for corner in corners {
                let from = corner.position - at.position;
                assert!((from.length() - 0.1).abs() < 1e-12 && from.dot(along).abs() < 1e-12);
            }
        }
        let firsts: Vec<DVec3> = list.corners.iter().step_by(8).map(|corner| corner.normal).collect();
        // A ring turns by 90 degrees in three steps at the most here.
        assert!(firsts.windows(2).all(|pair| pair[0].dot(pair[1]) > 0.5), "{firsts:?}");
    }

    #[test]
    fn a_limb_without_length_has_finite_corners() {
        let list = limb(vec![point(1.0, 2.0, 3.0, 0.5); 4], DAffine3::IDENTITY).triangles();
        assert!(list.corners.iter().all(|corner| corner.position.is_finite() && corner.normal.is_finite()));
    }
}
