//! Heavy scenes for benchmarks: many faces, many of them one behind the other.

use glam::{DMat3, DVec3, dvec3};

use super::{Modeller, Rng, Scene, Truth, camera_is_world, centred, look_at};

/// The number of faces of a house in the street.
const STREET_HOUSE_FACES: u32 = 16;
/// The number of faces of a house in the town.
const TOWN_HOUSE_FACES: u32 = 40;

/// Makes a street of about `faces` faces, seen from its middle at the height of a first floor, in 480 x 360 pixels.
/// All the houses before it cover a house's gable except for a strip, so where there are houses more than five
/// surfaces lie one behind the other.
pub fn street(face_count: u32) -> Scene {
    let mut rng = Rng::new(1);
    let mut m = Modeller::new();
    m.object("ground").quad(dvec3(-80.0, -20.0, 0.0), DVec3::X * 160.0, DVec3::Y * 1000.0);
    for house in 0..(face_count / STREET_HOUSE_FACES).max(1) {
        let row = f64::from(house / 2);
        m.object(format!("house {house}"));
        StreetHouse {
            side: if house % 2 == 0 { -1.0 } else { 1.0 },
            y: 4.0 + 5.0 * row,
            inner: rng.between(2.6, 3.4),
            eaves: 6.0 + 0.25 * row,
        }
        .draw(&mut m, rng.between(0.4, 1.4));
    }
    Scene {
        name: format!("a street of {face_count} faces"),
        model: m.finish(),
        camera: centred(480, 360, 420.0),
        pose: look_at(dvec3(0.0, -6.0, 4.5), dvec3(0.0, 20.0, 6.0)),
        truth: Truth::Unknown,
    }
}

/// The position and size of a house in the street.
struct StreetHouse {
    /// The side of the street: -1 for left, 1 for right.
    side: f64,
    /// The position of the near gable along the street.
    y: f64,
    /// The distance from the middle of the street to the front.
    inner: f64,
    /// The height of the front.
    eaves: f64,
}

/// The distance from the middle of the street to the houses' backs.
const STREET_BACK: f64 = 18.0;
/// The distance between a house's gables.
const STREET_HOUSE_DEPTH: f64 = 4.0;
/// The height of the ridge above the eaves.
const STREET_ROOF: f64 = 3.0;

impl StreetHouse {
    /// Returns a point of the world: `outwards` from the middle of the street, `along` it from the near gable, at
    /// height `z`.
    fn at(&self, outwards: f64, along: f64, z: f64) -> DVec3 {
        dvec3(self.side * outwards, self.y + along, z)
    }

    fn to_street(&self) -> DVec3 {
        DVec3::X * -self.side
    }

    fn draw(&self, m: &mut Modeller, sign_width: f64) {
        self.gables(m);
        self.walls_and_roof(m);
        self.openings(m);
        self.awning_and_sign(m, sign_width);
    }

    fn gables(&self, m: &mut Modeller) {
        let (middle, ridge) = (0.5 * (self.inner + STREET_BACK), self.eaves + STREET_ROOF);
        for along in [0.0, STREET_HOUSE_DEPTH] {
            let mut gable = [
                self.at(self.inner, along, 0.0),
                self.at(STREET_BACK, along, 0.0),
                self.at(STREET_BACK, along, self.eaves),
                self.at(middle, along, ridge),
                self.at(self.inner, along, self.eaves),
            ];
            // Counter-clockwise as it is for the near gable on the right; the others are reversed as needed.
            if (self.side > 0.0) != (along == 0.0) {
                gable.reverse();
            }
            m.polygon(&gable);
        }
    }

    fn walls_and_roof(&self, m: &mut Modeller) {
        let (long, up) = (DVec3::Y * STREET_HOUSE_DEPTH, DVec3::Z * self.eaves);
        let ridge = self.at(0.5 * (self.inner + STREET_BACK), 0.0, self.eaves + STREET_ROOF);
        for (outwards, out) in [(self.inner, self.to_street()), (STREET_BACK, -self.to_street())] {
            let eaves = self.at(outwards, 0.0, self.eaves);
            m.quad_facing(out, self.at(outwards, 0.0, 0.0), long, up);
            m.quad_facing(DVec3::Z, eaves, long, ridge - eaves);
        }
    }

    fn openings(&self, m: &mut Modeller) {
        for [along, z] in [[0.4, 2.8], [2.4, 2.8], [0.4, 4.6], [2.4, 4.6], [1.4, 0.0]] {
            let corner = self.at(self.inner, along, z);
            m.quad_facing(self.to_street(), corner, DVec3::Y * 1.2, DVec3::Z * 1.3);
        }
        for column in [1.0, 4.0] {
            let corner = self.at(self.inner + column, 0.0, 2.0);
            m.quad_facing(-DVec3::Y, corner, DVec3::X * self.side * 1.5, DVec3::Z * 2.0);
        }
    }

    /// Adds an awning, and a sign that is drawn once for each side.
    fn awning_and_sign(&self, m: &mut Modeller, sign_width: f64) {
        let reach = self.to_street() * sign_width;
        let corner = self.at(self.inner, 0.2, 2.6);
        m.quad_facing(DVec3::Z, corner, reach - DVec3::Z * 0.4, DVec3::Y * 3.6);
        for towards in [DVec3::Y, -DVec3::Y] {
            m.quad_facing(towards, self.at(self.inner, 2.0, 3.2), reach, DVec3::Z * 0.8);
        }
    }
}

/// Makes `panes` panes like a fan of cards, in 480 x 360 pixels: each pane stands a little farther right and
/// farther back, and half of them lie one behind the other at a pixel in the middle.
pub fn fan(panes: u32) -> Scene {
    let mut m = Modeller::new();
    for pane in 0..panes {
        let share = f64::from(pane) / f64::from(panes);
        // All panes have the same size in the image, whatever their depth.
        let z = 10.0 + 10.0 * share;
        let left = 0.55 * (share - 1.0) * z;
        m.object(format!("pane {pane}")).screen(z, [left, -0.4 * z, left + 0.55 * z, 0.4 * z]);
    }
    Scene {
        name: format!("a fan of {panes} panes"),
        model: m.finish(),
        camera: centred(480, 360, 420.0),
        pose: camera_is_world(),
        truth: Truth::Unknown,
    }
}

/// Makes a town of about `faces` faces on a square grid, seen from a tower, in 480 x 360 pixels: boxes with
/// chimneys and with seven windows on every wall.
pub fn town(face_count: u32) -> Scene {
    let mut rng = Rng::new(2);
    let houses = (face_count / TOWN_HOUSE_FACES).max(1);
    let side = f64::from(houses).sqrt().ceil() as u32;
    let mut m = Modeller::new();
    let span = f64::from(side) * 12.0;
    m.object("ground").quad(dvec3(-span, -span, 0.0), DVec3::X * span * 2.0, DVec3::Y * span * 2.0);
    for house in 0..houses {
        let position = |i: u32| (f64::from(i) + 0.5) * 12.0 - 0.5 * span;
        m.object(format!("house {house}"));
        town_house(&mut rng, &mut m, position(house % side), position(house / side));
    }
    Scene {
        name: format!("a town of {face_count} faces"),
        model: m.finish(),
        camera: centred(480, 360, 420.0),
        pose: look_at(dvec3(0.1 * span, -0.75 * span, 0.35 * span), dvec3(0.0, -0.05 * span, 0.0)),
        truth: Truth::Unknown,
    }
}

fn town_house(rng: &mut Rng, m: &mut Modeller, x: f64, y: f64) {
    let half = dvec3(rng.between(2.0, 5.0), rng.between(2.0, 5.0), rng.between(2.0, 8.0));
    let centre = dvec3(x, y, half.z);
    let axes = DMat3::from_rotation_z(rng.between(-0.2, 0.2));
    m.cuboid(centre, half, axes);
    m.cuboid(centre + axes * dvec3(0.5 * half.x, 0.0, half.z + 0.6), DVec3::splat(0.6), axes);
    for (out, along) in [
        (axes.x_axis * half.x, axes.y_axis * half.y),
        (axes.x_axis * -half.x, axes.y_axis * half.y),
        (axes.y_axis * half.y, axes.x_axis * half.x),
        (axes.y_axis * -half.y, axes.x_axis * half.x),
    ] {
        let up = axes.z_axis * half.z;
        for window in 0..7 {
            let share = -0.9 + 1.8 * f64::from(window) / 7.0;
            m.quad_facing(out, centre + out + share * along - 0.3 * up, 0.17 * along, 0.6 * up);
        }
    }
}
