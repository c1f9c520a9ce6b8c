//! Faces that impostors cross when they turn: those inside the upright cylinder that an impostor's rectangle sweeps.

use glam::{DVec2, DVec3};

use quadratura_base::geometry::Plane;
use quadratura_base::geometry::polygon::split_by_plane;
use quadratura_base::scene::impostor::Impostor;
use quadratura_base::scene::{FaceId, Model};

/// The share of the cylinder's radius and height by which faces may reach into it: a tree stands on the ground, and may
/// touch a wall.
const TOUCHING: f64 = 0.05;

/// Returns the faces that impostors of other objects cross, in model order.
pub fn crossed(model: &Model) -> Vec<FaceId> {
    let crossed = |face: &FaceId| {
        let own = model.face(*face).object;
        let others = model.objects.iter().enumerate().filter(|(object, _)| *object != own.index());
        others.filter_map(|(_, object)| object.impostor).any(|impostor| reaches_into(model, *face, &impostor))
    };
    model.face_ids().filter(crossed).collect()
}

/// Returns whether a face reaches into the cylinder of an impostor.
fn reaches_into(model: &Model, face: FaceId, impostor: &Impostor) -> bool {
    let Impostor { foot, axis, height, half_width } = *impostor;
    let level = |share: f64, normal: DVec3| Plane { normal, point: foot + axis * (share * height) };
    let radius = (1.0 - TOUCHING) * half_width;
    let across = axis.any_orthonormal_vector();
    let beside =
        |point: DVec3| DVec2::new((point - foot).dot(across), (point - foot).dot(across.cross(axis)));
    model.face_triangles(face).iter().any(|corners| {
        let corners = corners.map(|vertex| model.vertices[vertex as usize]);
        let above = split_by_plane(&corners, &level(TOUCHING, axis)).0;
        let within = above.iter().flat_map(|part| split_by_plane(part, &level(1.0 - TOUCHING, -axis)).0);
        within.into_iter().any(|part| {
            let flat: Vec<DVec2> = part.into_iter().map(beside).collect();
            distance_to_origin(&flat) < radius
        })
    })
}

/// Returns the distance of the origin from a convex polygon, 0 inside.
fn distance_to_origin(polygon: &[DVec2]) -> f64 {
    let edges = || (0..polygon.len()).map(|i| (polygon[i], polygon[(i + 1) % polygon.len()]));
    let sides = || edges().map(|(a, b)| (b - a).perp_dot(-a));
    let area: f64 = edges().map(|(a, b)| a.perp_dot(b)).sum();
    // An upright face is a line from above and holds nothing.
    if area != 0.0 && (sides().all(|side| side >= 0.0) || sides().all(|side| side <= 0.0)) {
        return 0.0;
    }
    let to_edge = |(a, b): (DVec2, DVec2)| {
        let along = (-a).dot(b - a) / (b - a).length_squared();
        (a + (b - a) * if along.is_finite() { along.clamp(0.0, 1.0) } else { 0.0 }).length()
    };
    edges().map(to_edge).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Modeller;

    #[test]
    fn a_wall_beside_the_trunk_is_crossed_and_the_ground_and_a_far_wall_are_not() {
        let mut m = Modeller::new();
        m.object("ground").quad(DVec3::new(-20.0, -20.0, 0.0), DVec3::X * 40.0, DVec3::Y * 40.0);
        m.object("tree.billboard").quad(DVec3::NEG_X * 3.0, DVec3::X * 6.0, DVec3::Z * 8.0);
        m.object("near").quad(DVec3::new(-10.0, 2.0, 0.0), DVec3::X * 20.0, DVec3::Z * 5.0);
        m.object("far").quad(DVec3::new(-10.0, 2.95, 0.0), DVec3::X * 20.0, DVec3::Z * 5.0);
        m.object("roof").quad(DVec3::new(-9.0, -9.0, 6.0), DVec3::X * 18.0, DVec3::Y * 18.0);
        m.object("cloud").quad(DVec3::new(-9.0, -9.0, 7.9), DVec3::X * 18.0, DVec3::Y * 18.0);
        let (model, _) =
            (*m.finish()).clone().with_impostors(DVec3::Z, |object| object.name.contains("tree"));
        let named: Vec<String> = crossed(&model).into_iter().map(|face| model.face_name(face)).collect();
        assert_eq!(named, ["near[0]", "roof[0]"]);
    }
}
