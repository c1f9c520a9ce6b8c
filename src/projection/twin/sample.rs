//! The texel at a position of a sheet, between four of level 0.

use glam::DVec2;

use crate::geometry::PixelRect;
use crate::projection::pyramid::Level;
use crate::scene::light::LINEAR_OF_BYTE;

/// So near to a texel's centre, as a share of its width, it is taken as it is, and the shares between
/// are stretched to meet that (`DEAD` of `shaders/texels.wgsl`).
const DEAD: f64 = 0.02;

/// Linear colour and confidence at a photo position; `None` where the sheet has no tile: beyond its
/// rectangle by more than half a texel.
pub fn sample(level: &Level, rect: PixelRect, px: DVec2) -> Option<([f64; 3], f64)> {
    let size = DVec2::new(rect.w.into(), rect.h.into());
    let at = px - DVec2::new(rect.x.into(), rect.y.into());
    if at.min_element() <= -0.5 || (at - size).max_element() >= 0.5 {
        return None;
    }
    let at = at.clamp(DVec2::ZERO, size) - 0.5;
    let base = at.floor();
    let share = ((at - base - DEAD) / (1.0 - 2.0 * DEAD)).clamp(DVec2::ZERO, DVec2::ONE);
    let (x, y) = (base.x as i32, base.y as i32);
    let (mut colour, mut confidence) = ([0.0; 3], 0.0);
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let along = |step: i32, share: f64| if step == 1 { share } else { 1.0 - share };
        let weight = along(dx, share.x) * along(dy, share.y);
        let texel = texel(level, x + dx, y + dy);
        (0..3).for_each(|c| colour[c] += weight * f64::from(LINEAR_OF_BYTE[usize::from(texel[c])]));
        confidence += weight * f64::from(texel[3]) / 255.0;
    }
    Some((colour, confidence))
}

/// Beyond what is kept there is nothing.
fn texel(level: &Level, x: i32, y: i32) -> [u8; 4] {
    let kept = level.rect;
    if x < kept.x || y < kept.y || x >= kept.right() || y >= kept.bottom() {
        return [0; 4];
    }
    let at = level.index(x, y);
    [0, 1, 2, 3].map(|channel| level.rgba[at + channel])
}
