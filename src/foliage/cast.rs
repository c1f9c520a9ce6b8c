//! What the shadows of trees leave of the light of faces: the CPU reference of `shaders/shadows.wgsl`, by casting the shadow
//! for many points of the sun one by one.

use glam::{DVec2, DVec3, Vec3};

use super::bounds::Ball;
use super::placed::PlacedTrees;
use super::shade::OutdoorLight;
use super::shadow::{Caster, Shadow};
use quadratura_base::error::Result;
use quadratura_base::task::Task;

/// The tangent of half the angle at which the sun is seen, 32 minutes of arc.
pub const SUN_TANGENT: f64 = 0.00465;

/// The number of points of the sun.
const POINTS: u32 = 16;

/// Returns what is left of the light of a face, per channel. In the photos it shows E(n) + v S max(0, n.l), what sky and ground
/// give and what the sun gives: of a trusted model, all of it (v = 1) or nothing. Trees that the photos do not show cover the share
/// c of the sun, and leave
///
/// ```text
/// (E(n) + (1 - c) v S max(0, n.l)) / (E(n) + v S max(0, n.l))
/// ```
///
/// `normal` has length 1 and looks to the viewer, `sunlit` is v, and `covered` is c.
pub fn left_in_shadow(light: &OutdoorLight, normal: DVec3, sunlit: f32, covered: f32) -> Vec3 {
    let facing = normal.dot(light.towards_sun).max(0.0) as f32;
    let (sun, around) = (sunlit * facing * light.sun, light.around(normal));
    // As in the shader: where nothing gives light, nothing changes.
    (around + (1.0 - covered) * sun + 1e-6) / (around + sun + 1e-6)
}

/// The shadows of the trees of a site that cast any.
#[derive(Debug, Clone, PartialEq)]
pub struct CastShadows {
    light: OutdoorLight,
    /// For each point of the sun.
    shadows: Vec<Shadow>,
}

impl CastShadows {
    /// Casts the shadows on what is in a ball, in the world.
    ///
    /// # Errors
    /// Those of [`super::draw`].
    pub fn new(placed: &PlacedTrees, ball: &Ball, task: &Task) -> Result<Self> {
        let casters = placed.trees.iter().filter(|tree| tree.casts).map(|tree| {
            let plant = &*placed.species[tree.species].plant;
            Caster { plant, frame_from_plant: tree.world_from_plant }
        });
        let casters: Vec<Caster<'_>> = casters.collect();
        let towards_sun = placed.light.towards_sun;
        let right = towards_sun.any_orthonormal_vector();
        let down = right.cross(towards_sun);
        let shadow = |point: u32| {
            let at = SUN_TANGENT * on_disc(point);
            let direction = (towards_sun + at.x * right + at.y * down).normalize();
            Shadow::cast(&casters, ball, direction, task)
        };
        Ok(Self { light: placed.light, shadows: (0..POINTS).map(shadow).collect::<Result<_>>()? })
    }

    /// Returns the share of the sun, 0 to 1, that trees cover at a point of a face, in the world.
    pub fn covered(&self, point: DVec3) -> f32 {
        let lit = |shadow: &Shadow| shadow.lit(shadow.sun_from_frame().transform_point3(point), 1.0);
        1.0 - self.shadows.iter().map(lit).sum::<f32>() / self.shadows.len() as f32
    }

    /// Returns what is left of the light of a point of a face ([`left_in_shadow`]), in the world; `sunlit` is the share of the sun
    /// that no face covers.
    pub fn left(&self, point: DVec3, normal: DVec3, sunlit: f32) -> Vec3 {
        left_in_shadow(&self.light, normal, sunlit, self.covered(point))
    }
}

/// Returns a point of a disc of radius 1, evenly distributed (Vogel 1979).
fn on_disc(point: u32) -> DVec2 {
    const GOLDEN_ANGLE: f64 = 2.399_963;
    let distance = ((f64::from(point) + 0.5) / f64::from(POINTS)).sqrt();
    distance * DVec2::from_angle(GOLDEN_ANGLE * f64::from(point))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shadow_leaves_the_light_of_the_sky_and_nothing_changes_where_no_sun_was() {
        let light = OutdoorLight {
            towards_sun: DVec3::new(0.0, 0.6, 0.8),
            up: DVec3::Z,
            sun: Vec3::new(1.0, 0.5, 0.25),
            sky: Vec3::new(0.2, 0.4, 0.8),
            ground: Vec3::splat(0.1),
        };
        let near =
            |found: Vec3, expected: Vec3| assert!((found - expected).abs().max_element() < 1e-4, "{found}");
        let left = |normal, sunlit, covered| left_in_shadow(&light, normal, sunlit, covered);
        near(left(DVec3::Z, 1.0, 1.0), light.sky / (light.sky + 0.8 * light.sun));
        near(left(DVec3::Z, 1.0, 0.5), (light.sky + 0.4 * light.sun) / (light.sky + 0.8 * light.sun));
        for (normal, sunlit, covered) in [(DVec3::Z, 1.0, 0.0), (DVec3::Z, 0.0, 1.0), (-DVec3::Y, 1.0, 1.0)] {
            near(left(normal, sunlit, covered), Vec3::ONE);
        }
        let night = OutdoorLight { sun: Vec3::ZERO, sky: Vec3::ZERO, ground: Vec3::ZERO, ..light };
        near(left_in_shadow(&night, DVec3::Z, 1.0, 1.0), Vec3::ONE);
    }
}
