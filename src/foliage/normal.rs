//! Normals in 15 bits, with a bit that tells leaves from bark (Max 1996).

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use glam::{DVec2, Vec2, Vec3};

/// Steps of latitude from pole to pole.
const LATITUDES: f64 = 127.0;
/// Steps of longitude around.
const LONGITUDES: f64 = 256.0;
/// The bit of leaves.
const LEAF: u16 = 1 << 15;

/// A normal's latitude in bits 0 to 6, its longitude in bits 7 to 14, and in bit 15 whether the surface is a leaf. It is off by
/// one degree at most.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct NormalCode(pub u16);

/// The steepest surface that a normal is taken for, as a slope.
const STEEPEST: f32 = 3.0;

/// What the latitudes and longitudes of codes stand for: few numbers, which stay near the processor.
struct Meanings {
    /// The cosine and the sine of each latitude, and how steep a surface of this normal is in an image that shows it.
    latitudes: [[f32; 3]; 128],
    /// The cosine and the sine of each longitude.
    longitudes: [Vec2; 256],
}

static MEANINGS: LazyLock<Meanings> = LazyLock::new(|| Meanings {
    latitudes: std::array::from_fn(|code| {
        let (sin, cos) = ((code as f64 / LATITUDES - 0.5) * PI).sin_cos();
        // What an image shows looks to its viewer: z is negative.
        [cos as f32, sin as f32, (cos / (-sin).max(1.0 / 64.0)) as f32]
    }),
    longitudes: std::array::from_fn(|code| DVec2::from_angle(code as f64 / LONGITUDES * TAU).as_vec2()),
});

impl NormalCode {
    /// Returns the code of a normal, of any length but 0.
    pub fn new(normal: Vec3, is_leaf: bool) -> Self {
        let normal = normal.as_dvec3();
        let latitude = normal.z.atan2(normal.truncate().length());
        let longitude = normal.y.atan2(normal.x);
        let latitude = ((latitude / PI + 0.5) * LATITUDES).round() as u16;
        let longitude = (longitude / TAU * LONGITUDES).round().rem_euclid(LONGITUDES) as u16;
        Self(latitude | longitude << 7 | u16::from(is_leaf) << 15)
    }

    #[inline]
    fn meaning(self) -> ([f32; 3], Vec2) {
        let meanings = &*MEANINGS;
        (meanings.latitudes[usize::from(self.0 & 127)], meanings.longitudes[usize::from(self.0 >> 7 & 255)])
    }

    /// Returns the normal, of length 1.
    #[inline]
    pub fn normal(self) -> Vec3 {
        let ([across, along, _], longitude) = self.meaning();
        (across * longitude).extend(along)
    }

    /// Returns how steep the surface is in the frame of the image that shows it: the change of depth for a step across and down,
    /// held to 3.
    #[inline]
    pub fn slope(self) -> Vec2 {
        let ([.., steep], longitude) = self.meaning();
        (steep * longitude).clamp(Vec2::splat(-STEEPEST), Vec2::splat(STEEPEST))
    }

    /// Returns true for leaves.
    #[inline]
    pub fn is_leaf(self) -> bool {
        self.0 & LEAF != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;

    #[test]
    fn every_code_is_the_code_of_its_normal() {
        for code in 0..=u16::MAX {
            let code = NormalCode(code);
            let (again, is_leaf) = (NormalCode::new(code.normal(), code.is_leaf()), code.is_leaf());
            // At a pole all longitudes are one direction.
            let is_pole = matches!(code.0 & 127, 0 | 127);
            assert!(is_pole || again == code, "{code:?} became {again:?}");
            assert!(code.normal().distance(again.normal()) < 1e-6 && again.is_leaf() == is_leaf);
        }
    }

    #[test]
    fn a_coded_normal_is_off_by_a_degree_at_most() {
        let mut rng = Rng::new(12);
        let mut worst = 0.0f32;
        for _ in 0..20_000 {
            let mut axis = || rng.between(-1.0, 1.0) as f32;
            let normal = Vec3::new(axis(), axis(), axis());
            let Some(normal) = normal.try_normalize() else { continue };
            worst = worst.max(normal.angle_between(NormalCode::new(7.0 * normal, true).normal()));
        }
        // Half a step of latitude is 0.71 degrees, of longitude 0.70: together 0.995.
        assert!(worst.to_degrees() < 1.0, "{}", worst.to_degrees());
        assert!(worst.to_degrees() > 0.8, "random normals meet corners of steps: {}", worst.to_degrees());
    }
}
