//! How far a viewer of a layered depth image goes: the *reach*, from the distances of what it shows.

use crate::layout::Ldi;

/// The reach is this share of the distance of the nearest quarter of the depth pixels: a step of the reach turns the view of
/// a point there by 7 degrees, as when one leans to the side before a thing two arms away.
const SHARE: f64 = 0.125;

/// Returns the reach in world units: an eighth of the first quartile of the distances in the report, or of the third quartile of
/// the inverse depths where the report has none (images from elsewhere). Where everything is infinitely far, it is 1.
pub fn reach(ldi: &Ldi) -> f64 {
    let near = match ldi.report.quartiles[0] {
        quartile if quartile > 0.0 && quartile.is_finite() => quartile,
        _ => 1.0 / inverse_depth_at(ldi, 0.75).unwrap_or(SHARE),
    };
    near * SHARE
}

/// Returns the distance along the axis that is less than that of a share of the finite first layer: for a half, the median's.
/// Where everything is infinitely far, it is 1.
pub fn pivot(ldi: &Ldi, share: f64) -> f64 {
    inverse_depth_at(ldi, share).map_or(1.0, |depth| 1.0 / depth)
}

/// Returns the inverse depth below which a share of the first layer's finite depth pixels is.
fn inverse_depth_at(ldi: &Ldi, share: f64) -> Option<f64> {
    let level = &ldi.levels[0];
    // Each sixteenth pixel of each sixteenth row tells the share well enough, of any image larger than that.
    let step = if level.len() > 1 << 16 { 16 } else { 1 };
    let rows = (0..level.camera.height).step_by(step);
    let first = rows
        .flat_map(|y| level.layered_pixels(y).step_by(step).map(|pixel| level.inverse_depths[pixel.start]));
    let mut depths: Vec<f32> = first.filter(|depth| *depth > 0.0).collect();
    depths.sort_unstable_by(f32::total_cmp);
    let at = (depths.len().checked_sub(1)? as f64 * share) as usize;
    Some(f64::from(depths[at]))
}
