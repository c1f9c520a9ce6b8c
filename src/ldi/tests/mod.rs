//! The invariants of layered depth images, on scenes whose depth pixels are found by rays.

mod blending;
mod combining;
mod farmyard;
mod merging;
mod ordering;
mod positions;
mod scenes;
mod several;
mod showing;
mod stretching;
mod warping;

use glam::DVec3;
use quadratura_base::scene::synthetic::{Modeller, camera_is_world, centred};

use super::Ldi;
pub use super::synthetic::{floor, from_above, of_model, slow, step_aside, with_level};

/// Returns an image of the front of a tower and of its right side, which the front hides as far as its edge: seen from straight
/// ahead, surface 2 is a little behind surface 1 there.
pub fn tower() -> Ldi {
    let mut model = Modeller::new();
    model.object("front").quad(DVec3::new(-0.5, -2.0, 4.0), DVec3::X * 1.5, DVec3::Y * 4.0);
    model.object("side").quad(DVec3::new(1.0, -2.0, 4.0), DVec3::Z * 1.5, DVec3::Y * 4.0);
    of_model(&model.finish(), centred(400, 160, 320.0), camera_is_world(), |face, _| {
        if face == 0 { [200, 180, 150, 255] } else { [40, 30, 20, 255] }
    })
}
