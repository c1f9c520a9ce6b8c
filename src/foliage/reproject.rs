//! Samples of a sub-object's images are brought into a view: each by itself, with its sub-pixels (Max 1996, section 4).

use glam::{Mat2, Vec2, Vec3};

use super::directions::Serving;
use super::images::{MBuffer, MSample, depth_from_stored};
use super::lighting::OfSamples;
use super::mbuffer::{LayerSample, LayeredPixels, Slabs};
use super::place::{ImagePlacement, Instance};
use super::stipple::{Stipple, Stipples};
use super::view::View;
use quadratura_base::geometry::PixelRect;

/// The rows of a view that samples are brought into.
pub(super) struct TargetRows<'a> {
    /// The rectangle of pixels.
    pub rect: PixelRect,
    /// Their layers.
    pub pixels: &'a mut LayeredPixels,
    /// The slabs into which they are cut.
    pub slabs: Slabs,
    /// Whether samples count as polygons do, by the sub-pixels that they cover; else by the weight of their direction, too.
    pub beside_polygons: bool,
}

impl TargetRows<'_> {
    /// Adds a sample to the pixel of a column and row, in the slab of its depth.
    #[inline]
    pub fn insert(&mut self, (x, y): (i32, i32), sample: &LayerSample, epsilon: f32) {
        let first = self.slabs.of(sample.depth) * self.rect.area() as usize;
        self.pixels.insert(first + self.rect.offset(x, y), sample, epsilon);
    }
}

/// Brings the samples of an instance's images into rows of a view: those of the directions around the viewpoint, weighed. What is
/// within `epsilon_px` pixels of depth is one surface. Returns how many samples were brought.
pub(super) fn reproject(instance: &Instance, view: &View, epsilon_px: f64, rows: &mut TargetRows) -> u64 {
    let (mut before, mut brought) = (0.0, 0);
    for Serving { direction, weight } in instance.serving(&view.projection) {
        let place = ImagePlacement::new(instance, &view.projection, direction);
        let of_direction = Stipple::between(before, before + weight, instance.path);
        let stipples = Stipples { of_direction, of_part: instance.stipple };
        before += weight;
        // The stipple leaves a direction its share of the sub-pixels already.
        let weight = if rows.beside_polygons { 1.0 } else { weight };
        let of_samples = instance.of_samples(&place, direction);
        let bringing = Bringing {
            place: &place,
            epsilon: epsilon_px as f32 / place.focal.max_element(),
            delta: instance.copy.delta as f32,
            of_samples: &of_samples,
            weight: weight as f32,
            stipples: &stipples,
        };
        brought += bringing.bring(&instance.copy.views[direction], instance, rows);
    }
    brought
}

/// How the samples of an image are brought.
struct Bringing<'a> {
    place: &'a ImagePlacement,
    /// The difference of depth within which all is one surface, times 1/z of a perspective view.
    epsilon: f32,
    /// The side of a pixel of the image.
    delta: f32,
    of_samples: &'a OfSamples,
    /// How much the direction of the image counts.
    weight: f32,
    stipples: &'a Stipples,
}

impl Bringing<'_> {
    fn bring(&self, image: &MBuffer, instance: &Instance, rows: &mut TargetRows) -> u64 {
        let (place, delta, side) = (self.place, self.delta, instance.copy.side as usize);
        let [step, first_depth] = depth_from_stored(instance.bounds.ball.radius).map(|value| value as f32);
        let half = 0.5 * side as f32;
        let depth_step = place.linear.z_axis * step;
        let (mut next, mut brought) = (0, 0);
        for (row, counts) in image.counts.chunks_exact(side).enumerate() {
            let samples: usize = counts.iter().map(|count| usize::from(*count)).sum();
            let y = (row as f32 + 0.5 - half) * delta;
            if samples == 0 || !place.row_meets(y, instance.bounds.ball.radius as f32, delta, &rows.rect) {
                next += samples;
                continue;
            }
            brought += samples as u64;
            // Written out: closures stay calls in builds that do not optimise across functions.
            for (column, &count) in counts.iter().enumerate() {
                let x = (column as f32 + 0.5 - half) * delta;
                let base = place.linear * Vec3::new(x, y, first_depth) + place.origin;
                for sample in &image.samples[next..next + usize::from(count)] {
                    let at = base + depth_step * f32::from(sample.depth);
                    self.scatter(at, sample, rows);
                }
                next += usize::from(count);
            }
        }
        brought
    }

    /// Brings a sample to where it is in the view, and adds what it covers of each pixel to its layers.
    #[inline]
    fn scatter(&self, at: Vec3, image: &MSample, rows: &mut TargetRows) {
        let Self { place, delta, of_samples, weight, stipples, .. } = *self;
        if place.perspective && at.z <= 0.0 {
            return;
        }
        let px = place.image(at);
        let rect = rows.rect;
        // Comparisons that also fail for what is no number.
        let is_near = px.x > rect.x as f32 - 2.0
            && px.x < rect.right() as f32 + 2.0
            && px.y > rect.y as f32 - 2.0
            && px.y < rect.bottom() as f32 + 2.0;
        if !is_near {
            return;
        }
        let is_leaf = image.normal.is_leaf();
        let normal = place.view_from_normal * image.normal.normal();
        let looks_away = if place.perspective { normal.dot(at) > 0.0 } else { normal.z > 0.0 };
        if looks_away && !is_leaf {
            return;
        }
        let slope = image.normal.slope();
        let along = place.change(at, px, place.linear.z_axis);
        let across = delta * (place.change(at, px, place.linear.x_axis) + slope.x * along);
        let down = delta * (place.change(at, px, place.linear.y_axis) + slope.y * along);
        // The depth is that of the middle of the covered sub-pixels: the pixel's centre lies elsewhere on the surface.
        let shift = -delta * slope.dot(image.middle()) * along;
        // Above -4, so that cutting off is rounding down.
        let (base_x, base_y) = ((px.x + 4.0) as i32 - 5, (px.y + 4.0) as i32 - 5);
        let from_base = px + shift - Vec2::new(base_x as f32, base_y as f32);
        let masks = gathered(from_base, Mat2::from_cols(across, down), image.mask);
        let reflected = of_samples.gain * image.reflected();
        // The mean normal of leaves as long as it is; what is brought to one pixel adds up to a mean again.
        let normal = if is_leaf { of_samples.length } else { 1.0 } * normal.normalize_or_zero();
        let sample = LayerSample {
            mask: 0,
            depth: at.z,
            weight: weight / 16.0,
            reflected,
            through: if is_leaf { reflected * of_samples.through } else { Vec3::ZERO },
            normal: if looks_away { -normal } else { normal },
            is_leaf,
        };
        let epsilon = if place.perspective { at.z * self.epsilon } else { self.epsilon };
        for (index, covered) in masks.into_iter().enumerate() {
            if covered == 0 {
                continue;
            }
            let (x, y) = (base_x + index as i32 % 3, base_y + index as i32 / 3);
            let is_inside = x >= rect.x && x < rect.right() && y >= rect.y && y < rect.bottom();
            let mask = if is_inside { covered & stipples.open_at(x, y) } else { 0 };
            if mask != 0 {
                let weight = sample.weight * mask.count_ones() as f32;
                rows.insert((x, y), &LayerSample { mask, weight, ..sample }, epsilon);
            }
        }
    }
}

/// Returns the sub-pixels of 3 x 3 pixels that a sample covers, whose image pixel is a parallelogram about `middle`, in pixels from the
/// first one's corner: those whose source is in the mask, so that fine parts are neither widened nor lost.
#[inline]
fn gathered(middle: Vec2, px_from_image: Mat2, mask: u16) -> [u16; 9] {
    let mut masks = [0u16; 9];
    let inverse = px_from_image.inverse();
    if !inverse.is_finite() {
        return masks;
    }
    let [across, down] = [px_from_image.x_axis, px_from_image.y_axis];
    let reach = 0.5 * (across.abs() + down.abs());
    // Sub-pixel i lies at (i + 1/2)/4. Rounded up and down without calls, which processors of the least kind need.
    let (low, high) = (4.0 * (middle - reach) - 0.5, 4.0 * (middle + reach) - 0.5);
    let up = |value: f32| {
        let value = value.max(0.0);
        value as i32 + i32::from(value > (value as i32) as f32)
    };
    let down = |value: f32| if value < 0.0 { -1 } else { value.min(11.0) as i32 };
    let (first_x, first_y) = (up(low.x), up(low.y));
    let (last_x, last_y) = (down(high.x), down(high.y));
    let step = 0.25 * inverse;
    let first = Vec2::new(first_x as f32 + 0.5, first_y as f32 + 0.5);
    let mut row = inverse * (0.25 * first - middle) + 0.5;
    let mut y = first_y;
    while y <= last_y {
        let (mut at, mut x) = (row, first_x);
        while x <= last_x {
            if at.x >= 0.0 && at.x < 1.0 && at.y >= 0.0 && at.y < 1.0 {
                let bit = 4 * (4.0 * at.y) as u32 + (4.0 * at.x) as u32;
                let covered = mask >> bit & 1;
                masks[(3 * (y / 4) + x / 4) as usize] |= covered << (4 * (y % 4) + x % 4);
            }
            at += step.x_axis;
            x += 1;
        }
        row += step.y_axis;
        y += 1;
    }
    masks
}
