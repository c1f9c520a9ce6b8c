//! Pictures of leaves that the generator draws. The stalk begins in the middle of the lower border, the tip is in the
//! middle of the upper one, and everything lies within the two triangles of a leaf.

use glam::DVec2;

use super::pixels::Pixels;
use super::species::LeafShape;
use quadratura_base::scene::light::srgb_from_linear;

/// The side of a picture in pixels.
const SIDE: u32 = 96;
/// Lookups across a pixel, for its alpha.
const LOOKUPS: u32 = 4;
/// The row, 0..=1, of the two outer corners of a leaf's triangles.
pub const OUTER: f64 = 0.45;
/// The row at which the blade begins.
const BLADE: f64 = 0.66;

/// Draws a leaf whose mean light is about `reflected`.
pub fn leaf_picture(shape: LeafShape, reflected: [f32; 3]) -> Pixels {
    let pixel = |index: u32| {
        let (x, y) = (f64::from(index % SIDE), f64::from(index / SIDE));
        let inside = |i: u32| {
            let (a, b) = (f64::from(i % LOOKUPS), f64::from(i / LOOKUPS));
            let step = DVec2::new(a + 0.5, b + 0.5) / f64::from(LOOKUPS);
            is_inside(shape, (DVec2::new(x, y) + step) / f64::from(SIDE))
        };
        let count = (0..LOOKUPS * LOOKUPS).filter(|i| inside(*i)).count() as u32;
        let middle = DVec2::new(x + 0.5, y + 0.5) / f64::from(SIDE);
        let factor = if is_vein(shape, middle) { 1.5 } else { 0.95 };
        let byte =
            |light: f32| (255.0 * srgb_from_linear((f64::from(light) * factor).min(1.0))).round() as u8;
        let [r, g, b] = reflected.map(byte);
        [r, g, b, (255 * count / (LOOKUPS * LOOKUPS)) as u8]
    };
    Pixels::new(SIDE, SIDE, (0..SIDE * SIDE).map(pixel).collect())
}

/// The lobes of a palmate leaf: angle to the rib in degrees, and length.
const LOBES: [(f64, f64); 5] = [(0.0, 0.63), (46.0, 0.51), (-46.0, 0.51), (86.0, 0.29), (-86.0, 0.29)];

/// Returns a point from the beginning of the blade: along a direction that leans by an angle, and across it.
fn from_blade(point: DVec2, angle: f64) -> DVec2 {
    let (sin, cos) = angle.to_radians().sin_cos();
    let (right, up) = (point.x - 0.5, BLADE - point.y);
    DVec2::new(up * cos + right * sin, (right * cos - up * sin).abs())
}

fn is_inside(shape: LeafShape, point: DVec2) -> bool {
    let from_rib = (point.x - 0.5).abs();
    if point.y >= BLADE {
        let in_stalk = from_rib < 0.014;
        return in_stalk || (shape == LeafShape::Palmate && in_palm(point));
    }
    match shape {
        LeafShape::Palmate => in_palm(point),
        LeafShape::Lobed => {
            let along = (BLADE + 0.04 - point.y) / (BLADE + 0.02);
            let waves = 1.0 + 0.30 * (std::f64::consts::TAU * 4.5 * along).cos();
            (0.0..1.0).contains(&along)
                && from_rib < 0.28 * (std::f64::consts::PI * along.powf(0.9)).sin() * waves
        }
    }
}

fn in_palm(point: DVec2) -> bool {
    LOBES.iter().any(|&(angle, length)| {
        let place = from_blade(point, angle) / length;
        // Lobes are widest at 0.45 of their length, pointed, and toothed.
        let along = place.x;
        let teeth = 0.035 * (1.0 - (2.0 * (along * 4.0).fract() - 1.0).abs());
        let width = 0.33 * (std::f64::consts::PI * along.clamp(0.0, 1.0).powf(0.85)).sin() + teeth;
        (0.0..1.0).contains(&along) && place.y < width * (1.0 - along).sqrt().min(0.9)
    })
}

fn is_vein(shape: LeafShape, point: DVec2) -> bool {
    const HALF: f64 = 0.011;
    match shape {
        LeafShape::Palmate => LOBES.iter().any(|&(angle, length)| {
            let place = from_blade(point, angle);
            (0.0..0.9 * length).contains(&place.x) && place.y < HALF
        }),
        LeafShape::Lobed => {
            let from_rib = (point.x - 0.5).abs();
            // Side veins run up and out.
            let side = ((point.y + 0.8 * from_rib) * 7.0).fract();
            from_rib < HALF || (point.y < BLADE && side < 0.12)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Wrap;

    #[test]
    fn leaves_have_a_blade_and_a_stalk_and_lie_within_their_triangles() {
        for (shape, low, high) in [(LeafShape::Palmate, 0.2, 0.45), (LeafShape::Lobed, 0.15, 0.4)] {
            let picture = leaf_picture(shape, [0.1, 0.2, 0.05]);
            let mut covered = 0;
            for (index, pixel) in (0..SIDE * SIDE).zip(picture.rgba()).filter(|(_, pixel)| pixel[3] >= 128) {
                let x = f64::from(index % SIDE) + 0.5 - 0.5 * f64::from(SIDE);
                let row = (f64::from(index / SIDE) + 0.5) / f64::from(SIDE);
                let half = if row < OUTER { row / OUTER } else { (1.0 - row) / (1.0 - OUTER) };
                // A pixel of the tip and of the lobes' ends may reach out by half of itself.
                assert!(x.abs() / f64::from(SIDE) <= 0.5 * half + 0.03, "{shape:?}: {x} in row {row}");
                covered += 1;
                assert!(pixel[1] > pixel[0] && pixel[0] > pixel[2], "{pixel:?} is not green");
            }
            let share = f64::from(covered) / f64::from(SIDE * SIDE);
            assert!((low..high).contains(&share), "{shape:?} covers {share}");
            let alpha = |x: f64, y: f64| picture.alpha(DVec2::new(x, y), [Wrap::Held; 2]);
            assert!(alpha(0.5, 0.97) > 0.0 && alpha(0.1, 0.9) == 0.0);
        }
    }
}
