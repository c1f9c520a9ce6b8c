//! Small scenes whose layers are known in advance, each about one property of coarse models.
//!
//! Unless stated otherwise the camera frame is the world (x right, y down, z forward), the photo has 160 x 120
//! pixels, and one unit at depth 10 covers 12 pixels.

use glam::{DMat3, DVec3, dvec3};

use super::{Modeller, Scene, Truth, camera_is_world, centred, look_at};
use crate::geometry::{Pinhole, Pose};

/// Returns all scenes of this module.
pub fn all() -> Vec<Scene> {
    vec![
        two_quads(),
        stairs(),
        three_beams(),
        crossing_boxes(),
        windows_on_a_wall(),
        ground_behind_the_camera(),
        concave_and_holed(),
        far_from_the_origin(),
        two_sided_walls(),
        portrait(),
        tiles_with_t_junctions(),
        bent_quad(),
        stencil_trap(),
    ]
}

fn scene(name: &str, modeller: &mut Modeller, truth: Truth) -> Scene {
    Scene {
        name: name.into(),
        model: modeller.finish(),
        camera: centred(160, 120, 120.0),
        pose: camera_is_world(),
        truth,
    }
}

fn layers(layers: &[&[&'static str]]) -> Truth {
    Truth::Layers(layers.iter().map(|objects| objects.to_vec()).collect())
}

/// Makes two quads, one behind the other: two layers.
pub fn two_quads() -> Scene {
    let mut m = Modeller::new();
    m.object("far").screen(10.0, [-4.0, -3.0, 2.0, 3.0]);
    m.object("near").screen(8.0, [0.0, -2.0, 4.0, 2.0]);
    scene("two quads", &mut m, layers(&[&["near"], &["far"]]))
}

/// Makes five steps, each behind the one before: five layers, although each step overlaps only its neighbours.
pub fn stairs() -> Scene {
    let mut m = Modeller::new();
    for (step, name) in ["e", "d", "c", "b", "a"].into_iter().enumerate() {
        let (z, x) = (10.0 - step as f64, 3.0 - 1.5 * step as f64);
        m.object(name).screen(z, [x - 1.0, -2.0, x + 1.0, 2.0]);
    }
    scene("stairs", &mut m, layers(&[&["a"], &["b"], &["c"], &["d"], &["e"]]))
}

/// Makes three beams, each in front of the next, that do not touch: the cycle that Newell et al. cut.
pub fn three_beams() -> Scene {
    let mut m = Modeller::new();
    let turn = |i: usize| DMat3::from_rotation_z(i as f64 * std::f64::consts::TAU / 3.0);
    for i in 0..3 {
        // Each beam begins near and ends far, below the beginning of the next.
        let (from, to) = (turn(i) * dvec3(0.0, -3.0, 0.0), turn(i + 1) * dvec3(0.0, -3.0, 0.0));
        let (from, to) = (from + DVec3::Z * 9.0, to + DVec3::Z * 11.0);
        let along = to - from;
        let across = DVec3::Z.cross(along).normalize() * 0.6;
        let (start, length) = (from - 0.25 * along, 1.5 * along);
        m.object(format!("beam {i}")).quad(start - across, 2.0 * across, length);
    }
    scene("three beams, each over the next", &mut m, Truth::Cycle)
}

/// Makes two boxes that intersect each other.
pub fn crossing_boxes() -> Scene {
    let mut m = Modeller::new();
    let turned = |angle: f64| DMat3::from_rotation_y(angle) * DMat3::from_rotation_x(0.2);
    m.object("left").cuboid(dvec3(-0.3, 0.0, 10.0), dvec3(3.0, 1.0, 1.0), turned(0.5));
    m.object("right").cuboid(dvec3(0.3, 0.4, 10.0), dvec3(3.0, 1.0, 1.0), turned(-0.6));
    scene("crossing boxes", &mut m, Truth::Cycle)
}

/// Makes windows in the plane of their wall: they occlude nothing, and nothing occludes them.
pub fn windows_on_a_wall() -> Scene {
    let mut m = Modeller::new();
    // The wall is oblique, so that its depth changes from column to column.
    let along = dvec3(0.8, 0.0, 0.6);
    let corner = dvec3(-4.0, -3.0, 8.0);
    m.object("wall").quad(corner, DVec3::Y * 6.0, along * 9.0);
    m.object("windows");
    for column in 0..3 {
        let at = corner + along * (1.0 + 2.5 * f64::from(column)) + DVec3::Y * 1.5;
        m.quad(at, DVec3::Y * 2.0, along * 1.5);
    }
    m.object("lamp").screen(7.0, [-1.0, -1.0, 0.0, 1.0]);
    scene("windows on a wall", &mut m, layers(&[&["lamp"], &["wall", "windows"]]))
}

/// Makes a ground that begins far behind the camera, with a house on it (z up).
pub fn ground_behind_the_camera() -> Scene {
    let mut m = Modeller::new();
    m.object("ground").quad(dvec3(-500.0, -700.0, 0.0), DVec3::X * 1000.0, DVec3::Y * 1500.0);
    m.object("house").cuboid(dvec3(1.0, 8.0, 2.0), dvec3(2.5, 2.0, 2.0), DMat3::from_rotation_z(0.4));
    let pose = look_at(dvec3(0.0, -4.0, 1.7), dvec3(0.0, 8.0, 1.5));
    Scene {
        pose,
        ..scene("a ground that runs behind the camera", &mut m, layers(&[&["house"], &["ground"]]))
    }
}

/// Makes a frame with a hole (bridged by a doubled edge), an L in the hole, and a wall behind both.
pub fn concave_and_holed() -> Scene {
    let mut m = Modeller::new();
    let square = |half: f64, z: f64| {
        [(-half, -half), (-half, half), (half, half), (half, -half)].map(|(x, y)| dvec3(x, y, z))
    };
    let ([a, b, c, d], [e, f, g, h]) = (square(3.0, 8.0), square(1.8, 8.0));
    // The outline a b c d, a bridge to the hole at e, around it in the other direction, and back.
    let ring = [a, b, c, d, a, e, h, g, f, e];
    let strips = [[0, 1, 8], [0, 8, 5], [1, 2, 7], [1, 7, 8], [2, 3, 6], [2, 6, 7], [3, 4, 5], [3, 5, 6]];
    m.object("wall").screen(12.0, [-6.0, -4.5, 6.0, 4.5]);
    m.object("frame").shape(&ring, &strips);
    let ell = [(-2.8, -1.0), (-2.8, 1.6), (1.0, 1.6), (1.0, 0.6), (-1.0, 0.6), (-1.0, -1.0)];
    let ell = ell.map(|(x, y)| dvec3(x, y, 10.0));
    m.object("ell").shape(&ell, &[[0, 1, 4], [0, 4, 5], [1, 2, 4], [2, 3, 4]]);
    scene("concave and holed faces", &mut m, layers(&[&["frame"], &["ell"], &["wall"]]))
}

/// Makes the windows on their wall, five million metres from the origin.
pub fn far_from_the_origin() -> Scene {
    let near = windows_on_a_wall();
    let offset = dvec3(4_123_456.7, -2_765_432.1, 431.2);
    let mut model = (*near.model).clone();
    model.vertices.iter_mut().for_each(|vertex| *vertex += offset);
    model.faces.iter_mut().for_each(|face| face.plane.point += offset);
    let pose = Pose { rotation: near.pose.rotation, translation: -offset };
    Scene { name: "five million metres from the origin".into(), model: model.into(), pose, ..near }
}

/// Makes a wall drawn once for each side, a wall seen only from behind, one seen edge-on, and a post.
pub fn two_sided_walls() -> Scene {
    let mut m = Modeller::new();
    let (corner, down, right) = (dvec3(-4.0, -2.0, 9.0), DVec3::Y * 4.0, DVec3::X * 5.0);
    m.object("wall").quad(corner, down, right).quad(corner, right, down);
    m.object("back").quad(dvec3(0.0, -3.0, 11.0), DVec3::X * 5.0, DVec3::Y * 6.0);
    m.object("blade").quad(dvec3(0.0, -2.0, 5.0), DVec3::Y * 4.0, DVec3::Z * 3.0);
    m.object("post").screen(7.0, [-1.0, -3.0, 0.0, 3.0]);
    scene("two-sided walls", &mut m, layers(&[&["post"], &["wall"], &["back"]]))
}

/// Makes stairs in a portrait photo whose principal point lies outside of it and whose pixels are not square.
pub fn portrait() -> Scene {
    let camera = Pinhole { width: 90, height: 160, fx: 110.0, fy: 125.0, cx: 31.5, cy: 190.25 };
    let mut m = Modeller::new();
    for (step, name) in ["c", "b", "a"].into_iter().enumerate() {
        let (z, y) = (10.0 - step as f64, -6.0 - step as f64);
        m.object(name).screen(z, [-2.0, y - 1.2, 3.0, y + 1.2]);
    }
    Scene { camera, ..scene("portrait, off-centre", &mut m, layers(&[&["a"], &["b"], &["c"]])) }
}

/// Makes a floor of tiles that do not share their corners, under a table.
pub fn tiles_with_t_junctions() -> Scene {
    let mut m = Modeller::new();
    m.object("floor");
    for (row, tiles) in [3_u32, 4, 5].into_iter().enumerate() {
        let (y, width) = (row as f64 * 2.0, 9.0 / f64::from(tiles));
        for tile in 0..tiles {
            let corner = dvec3(-4.5 + width * f64::from(tile), y, 0.0);
            m.quad(corner, DVec3::X * width, DVec3::Y * 2.0);
        }
    }
    m.object("table").quad(dvec3(-1.0, 1.0, 1.0), DVec3::X * 2.0, DVec3::Y * 2.0);
    let pose = look_at(dvec3(0.3, -5.0, 5.0), dvec3(0.0, 2.5, 0.0));
    Scene { pose, ..scene("tiles with T-junctions", &mut m, layers(&[&["table"], &["floor"]])) }
}

/// Makes a non-planar quad in front of a planar one.
pub fn bent_quad() -> Scene {
    let mut m = Modeller::new();
    let corner = |x: f64, y: f64, z: f64| dvec3(x, y, z);
    m.object("bent").bent_quad([
        corner(-2.0, -2.0, 8.0),
        corner(-2.0, 2.0, 7.0),
        corner(2.0, 2.0, 8.0),
        corner(2.0, -2.0, 7.0),
    ]);
    m.object("flat").screen(10.0, [-3.0, -4.0, 3.0, 1.0]);
    scene("a bent quad", &mut m, layers(&[&["bent"], &["flat"]]))
}

/// Makes the counterexample for stencil peeling: A hides Y, Y hides X, and Z lies behind X where Y hides it. One
/// round takes out Y and Z together; then X looks free and gets a layer before Y, which hides it.
pub fn stencil_trap() -> Scene {
    let mut m = Modeller::new();
    m.object("a").screen(6.0, [-3.0, -1.0, -1.5, 1.0]);
    m.object("y").screen(8.0, [-3.0, -1.0, 0.5, 1.0]);
    m.object("x").screen(10.0, [-0.5, -1.0, 3.0, 1.0]);
    m.object("z").screen(12.0, [-0.7, -1.8, 3.6, 1.8]);
    scene("the trap of stencil peeling", &mut m, layers(&[&["a"], &["y"], &["x"], &["z"]]))
}
