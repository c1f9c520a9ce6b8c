//! Light on leaves and bark.

use glam::{DVec3, Vec3};

/// The light on plants, linear, in one frame: a plant's own, or the world. What each source gives is what a white surface reflects that faces
/// it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// The direction to the sun, of length 1.
    pub towards_sun: DVec3,
    /// What is up, of length 1.
    pub up: DVec3,
    /// What the sun gives, in R, G, B.
    pub sun: Vec3,
    /// What the sky gives to a surface that looks up.
    pub sky: Vec3,
    /// What the ground gives to a surface that looks down.
    pub ground: Vec3,
}

impl Light {
    /// Returns a clear day, with the sun halfway up in the direction of x and -y of a plant whose up is z: white in sun and
    /// sky is twice as bright as pictures go, so that leaves, which reflect little, are as bright as people expose them.
    pub fn day(up: DVec3) -> Self {
        // An upright frame around `up` that is the plant's own where up is z.
        let x = (DVec3::X - DVec3::X.dot(up) * up).try_normalize().unwrap_or(DVec3::Y);
        let towards_sun = (0.55 * x - 0.35 * up.cross(x) + 0.76 * up).normalize();
        Self {
            towards_sun,
            up,
            sun: Vec3::new(2.05, 1.93, 1.72),
            sky: Vec3::new(0.55, 0.64, 0.80),
            ground: Vec3::new(0.24, 0.22, 0.17),
        }
    }

    /// Returns what sky and ground give to a surface of this normal.
    pub(super) fn around(&self, normal: DVec3) -> Vec3 {
        let up = normal.dot(self.up) as f32;
        self.sky * (0.5 * (1.0 + up)) + self.ground * (0.5 * (1.0 - up))
    }
}

/// A surface at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// The normal of length 1 in the plant's frame; of a leaf it looks to the viewer.
    pub normal: DVec3,
    /// The share of light that it reflects.
    pub reflected: Vec3,
    /// The share that a leaf lets through; `None` for bark.
    pub through: Option<Vec3>,
}

/// The shares of the light that reach a point, 0 to 1: what casts shadows and what is around it keep the rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// That of the sun's light.
    pub sun: f32,
    /// That of what sky and ground give to the side to which the normal looks.
    pub front: f32,
    /// The same of the other side.
    pub back: f32,
}

impl Reach {
    /// All light arrives.
    pub const ALL: Self = Self { sun: 1.0, front: 1.0, back: 1.0 };
}

/// Returns the light that comes from a surface. With l to the sun, k up, S, K, G what sun, sky and ground give, E(n) =
/// K (1 + n.k)/2 + G (1 - n.k)/2, and v_s, v(n), v(-n) the shares of these that reach the point:
///
/// ```text
/// bark   C = reflected ( v_s S max(0, n.l) + v(n) E(n) )
/// leaf   C = reflected ( v_s S max(0, n.l) + v(n) E(n) ) + through ( v_s S max(0, -n.l) + v(-n) E(-n) )
/// ```
pub fn shade(surface: &Surface, light: &Light, reach: &Reach) -> Vec3 {
    let facing = surface.normal.dot(light.towards_sun) as f32;
    let sun = light.sun * reach.sun;
    let front = surface.reflected * (sun * facing.max(0.0) + light.around(surface.normal) * reach.front);
    match surface.through {
        None => front,
        Some(through) => {
            let behind = light.around(-surface.normal) * reach.back;
            front + through * (sun * (-facing).max(0.0) + behind)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sun_alone() -> Light {
        let (sun, none) = (Vec3::new(1.0, 0.5, 0.25), Vec3::ZERO);
        Light { towards_sun: DVec3::Y, up: DVec3::Z, sun, sky: none, ground: none }
    }

    #[test]
    fn a_white_leaf_lit_from_behind_is_what_it_lets_through_and_bark_is_black() {
        let through = Vec3::new(0.5, 0.25, 1.0);
        let leaf = Surface { normal: -DVec3::Y, reflected: Vec3::ONE, through: Some(through) };
        assert_eq!(shade(&leaf, &sun_alone(), &Reach::ALL), through * sun_alone().sun);
        assert_eq!(shade(&Surface { through: None, ..leaf }, &sun_alone(), &Reach::ALL), Vec3::ZERO);
        assert_eq!(shade(&Surface { normal: DVec3::Y, ..leaf }, &sun_alone(), &Reach::ALL), sun_alone().sun);
    }

    #[test]
    fn a_wall_gets_half_of_the_sky_and_half_of_the_ground() {
        let (sky, ground) = (Vec3::new(0.2, 0.4, 0.8), Vec3::new(0.4, 0.2, 0.0));
        let light = Light { sun: Vec3::ZERO, sky, ground, ..sun_alone() };
        let surface = |normal: DVec3| Surface { normal, reflected: Vec3::ONE, through: None };
        assert_eq!(shade(&surface(DVec3::X), &light, &Reach::ALL), 0.5 * (sky + ground));
        assert_eq!([DVec3::Z, -DVec3::Z].map(|n| shade(&surface(n), &light, &Reach::ALL)), [sky, ground]);
    }

    #[test]
    fn what_does_not_reach_a_leaf_is_missing_from_its_side() {
        let light = Light { sky: Vec3::new(0.2, 0.4, 0.8), ground: Vec3::splat(0.1), ..sun_alone() };
        let leaf = Surface {
            normal: DVec3::new(0.0, 0.6, 0.8),
            reflected: Vec3::splat(0.5),
            through: Some(Vec3::splat(0.25)),
        };
        let with = |sun, front, back| shade(&leaf, &light, &Reach { sun, front, back });
        let (sun, front, back) = (with(1.0, 0.0, 0.0), with(0.0, 1.0, 0.0), with(0.0, 0.0, 1.0));
        assert!((sun - 0.5 * 0.6 * light.sun).abs().max_element() < 1e-6);
        assert!((front - 0.5 * (0.9 * light.sky + 0.1 * light.ground)).abs().max_element() < 1e-6);
        assert!((back - 0.25 * (0.1 * light.sky + 0.9 * light.ground)).abs().max_element() < 1e-6);
        let all = shade(&leaf, &light, &Reach::ALL);
        assert!((sun + front + back - all).abs().max_element() < 1e-6);
    }

    #[test]
    fn day_has_the_sun_above_the_horizon_whatever_is_up() {
        for up in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(0.6, 0.0, -0.8)] {
            let light = Light::day(up);
            // The height of the sun is 0.76 of the length of (0.55, -0.35, 0.76), which rounds to 1.
            assert!((light.towards_sun.dot(up) - 0.76).abs() < 0.01 && light.towards_sun.is_normalized());
        }
    }
}
