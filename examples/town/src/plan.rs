//! The plan of the town: a lattice of streets, the blocks between them, and where photos are taken. Metres, x east, y north, z up.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3, dvec2};
use quadratura_base::geometry::Pose;
use quadratura_base::scene::synthetic::look_at;

/// From the middle of a street to the middle of the next one.
pub const PITCH: f64 = 44.0;
/// From the houses on one side of a street to those on the other.
pub const STREET: f64 = 12.0;
/// Between two stations along a street.
const STEP: f64 = 11.0;
/// The height of the camera above the ground.
const EYE: f64 = 1.7;

/// A photo to take.
#[derive(Debug, Clone)]
pub struct Station {
    /// The file's name.
    pub name: String,
    /// The pose, world to camera.
    pub pose: Pose,
    /// The position of the camera.
    pub eye: DVec3,
}

/// Where streets, blocks and stations are.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The stations, along the streets.
    pub stations: Vec<Station>,
    /// The blocks beside these streets, by column and row of the lattice.
    pub blocks: BTreeSet<[i32; 2]>,
}

/// A street from one crossing to the next: the crossing where it begins, and whether it goes east.
#[derive(Debug, Clone, Copy)]
struct Segment {
    crossing: [i32; 2],
    goes_east: bool,
}

impl Segment {
    fn from(self) -> DVec2 {
        dvec2(f64::from(self.crossing[0]), f64::from(self.crossing[1])) * PITCH
    }

    fn along(self) -> DVec2 {
        if self.goes_east { DVec2::X } else { DVec2::Y }
    }

    /// Returns the blocks on its two sides.
    fn blocks(self) -> [[i32; 2]; 2] {
        let [x, y] = self.crossing;
        [[x, y], if self.goes_east { [x, y - 1] } else { [x - 1, y] }]
    }
}

impl Plan {
    /// Plans a town of this number of photos. It grows in rings from one corner, so that it is compact for any number.
    pub fn new(photos: u32) -> Self {
        let mut plan = Self { stations: Vec::new(), blocks: BTreeSet::new() };
        for segment in (0..).flat_map(ring) {
            if plan.stations.len() == photos as usize {
                break;
            }
            plan.blocks.extend(segment.blocks());
            for (eye, looks) in stations(segment).take(photos as usize - plan.stations.len()) {
                let number = plan.stations.len() + 1;
                let pose = look_at(eye, eye + looks);
                plan.stations.push(Station { name: format!("{number:04}.jpg"), pose, eye });
            }
        }
        plan
    }
}

/// Returns the streets that make a town of `ring` x `ring` blocks one block larger on both sides.
fn ring(ring: i32) -> impl Iterator<Item = Segment> {
    let streets = move |goes_east: bool| {
        (0..=ring).map(move |other| {
            let crossing = if goes_east { [ring, other] } else { [other, ring] };
            Segment { crossing, goes_east }
        })
    };
    let across = move |goes_east: bool| {
        (0..ring).map(move |along| {
            let crossing = if goes_east { [along, ring] } else { [ring, along] };
            Segment { crossing, goes_east }
        })
    };
    streets(true).chain(streets(false)).chain(across(true)).chain(across(false))
}

/// Returns eye and direction of the photos along a street: at each station one to the left and one to the right, both a bit ahead,
/// and slightly up to the eaves.
fn stations(segment: Segment) -> impl Iterator<Item = (DVec3, DVec3)> {
    let (from, along) = (segment.from(), segment.along());
    let count = (PITCH / STEP) as u32;
    (0..count).flat_map(move |station| {
        [1.0, -1.0].map(move |side| {
            // Each photo is taken from the other side of the street, so that it sees more of the houses.
            let out = along.perp() * side;
            let at = from + along * (STEP * (f64::from(station) + 0.5)) - out * (0.25 * STREET);
            let looks = (along * 0.6 + out).normalize();
            (at.extend(EYE), looks.extend(0.14))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_larger_town_has_all_that_a_smaller_one_has() {
        let [small, large] = [25, 400].map(Plan::new);
        assert_eq!((small.stations.len(), large.stations.len()), (25, 400));
        for (one, other) in small.stations.iter().zip(&large.stations) {
            assert_eq!((&one.name, one.eye), (&other.name, other.eye));
        }
        assert!(small.blocks.is_subset(&large.blocks));
    }
}
