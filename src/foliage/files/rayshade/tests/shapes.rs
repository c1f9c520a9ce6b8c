//! Primitives as polygons.

use super::*;

#[test]
fn polygons_keep_their_corners_and_phong_triangles_their_normals() {
    let plant = plant(
        "poly 0 0 0 1 0 0 1 1 0 0 1 0\ntriangle 0 0 0 0 0 2 1 0 0 0 0 1 0 1 0 0 1 0 scale 1 1 2\n\
         triangleuv 0 0 0 0 0 1 0 0 1 0 0 0 0 1 1 0 0 1 0 0 0 1 .5 1\n",
    );
    let whole = plant.whole();
    assert_eq!((whole.counts.polygons, corners(whole, 0).len()), (3, 4));
    let normals: Vec<DVec3> = corners(whole, 1).iter().map(|corner| corner.normal).collect();
    assert_eq!(normals, [DVec3::Z, DVec3::Z, DVec3::Y]);
    let textures: Vec<[f64; 2]> = corners(whole, 2).iter().map(|corner| corner.texture.to_array()).collect();
    assert_eq!(textures, [[0.0, 1.0], [1.0, 1.0], [0.5, 0.0]]);
}

#[test]
fn cylinders_and_cones_are_limbs_that_discs_close() {
    let plant = plant(
        "cylinder .5 0 0 0 0 3 4 disc .5 0 3 4 0 3 4 disc .5 0 0 0 0 -3 -4 cone 1 0 0 0 .5 0 0 2 cone 0 0 0 0 0 1 1 1",
    );
    let whole = plant.whole();
    assert_eq!(whole.primitives.len(), 4);
    let Shape::Limb(limb) = &whole.primitives[0].shape else { panic!("{whole:?}") };
    let rings = limb.triangles().corners;
    for (disc, ring) in [(1, &rings[9..]), (2, &rings[..9])] {
        for corner in corners(whole, disc) {
            let near = |other: &Corner| other.position.distance(corner.position) < 1e-12;
            assert!(ring.iter().any(near), "{corner:?}");
        }
    }
    let Shape::Limb(cone) = &whole.primitives[3].shape else { panic!("{whole:?}") };
    let radii: Vec<f64> =
        cone.triangles().corners.iter().map(|corner| corner.position.truncate().length()).collect();
    assert!(radii[..9].iter().all(|radius| (radius - 1.0).abs() < 1e-12), "{radii:?}");
    assert!(radii[9..].iter().all(|radius| (radius - 0.5).abs() < 1e-12), "{radii:?}");
}

#[test]
fn a_sphere_is_one_sub_object_however_many_there_are_and_faces_look_outwards() {
    let plant = plant("sphere 2 1 0 0 sphere 1 0 0 0 translate 0 0 5 box 0 0 0 -1 -2 -3");
    let whole = plant.whole();
    assert_eq!((plant.objects.len(), whole.uses.len(), plant.objects[0].name.as_str()), (2, 2, "sphere"));
    assert_eq!(plant.objects[0].counts.polygons, 12 * 2 + 12 * 4 * 2);
    for mesh in Mesh::of(&plant.objects[0]) {
        for triangle in mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.corners[i as usize].position);
            assert!((b - a).cross(c - a).dot(a + b + c) > 0.0, "{a} {b} {c}");
        }
    }
    let middle = DVec3::new(-0.5, -1.0, -1.5);
    assert_eq!(whole.primitives.len(), 6);
    for mesh in Mesh::of(whole) {
        for corner in &mesh.corners {
            assert!(corner.normal.dot(corner.position - middle) > 0.0, "{corner:?}");
        }
    }
    assert_eq!(whole.bounds.space.low, DVec3::new(-1.0, -2.0, -3.0));
}
