//! The texels of an instance's image are drawn into a view.

use glam::{Mat3, Vec2, Vec3};

use super::flake::{Flake, FlakeBuffer, key};
use super::images::{MBuffer, MSample, depth_from_stored};
use super::place::{ImagePlacement, Instance};
use super::planes::DepthPlanes;
use super::stipple::Stipples;
use quadratura_base::geometry::PixelRect;

/// A sample of an image that is drawn.
#[derive(Clone, Copy)]
struct TexelSample<'a> {
    /// Where the depth 0 of its texel is in the view.
    base: Vec3,
    sample: &'a MSample,
    /// Its index among all that is drawn.
    index: u32,
}

/// Draws an image of an instance into some rows of a view.
pub(super) struct TexelDrawer<'a> {
    place: &'a ImagePlacement,
    /// The planes that texels are drawn on, if they are.
    planes: Option<DepthPlanes>,
    /// The same as in the place, in sub-pixels from the band's corner.
    focal: Vec2,
    centre: Vec2,
    /// The steps to the right, down and away by a side of a texel.
    steps: Mat3,
    /// How far from its middle a texel reaches at most, in sub-pixels.
    reach: f32,
    /// The middle of the first texel, at the depth that is stored as 0.
    origin: Vec3,
    depth_step: Vec3,
    side: usize,
    delta: f32,
    radius: f32,
    rect: PixelRect,
}

impl<'a> TexelDrawer<'a> {
    /// Prepares the drawing into the rows in `rect`.
    pub fn new(
        instance: &Instance,
        place: &'a ImagePlacement,
        planes: Option<DepthPlanes>,
        rect: PixelRect,
    ) -> Self {
        let [step, first_depth] = depth_from_stored(instance.bounds.ball.radius).map(|value| value as f32);
        let (delta, radius) = (instance.copy.delta as f32, instance.bounds.ball.radius as f32);
        let (linear, half) = (place.linear, 0.5 * instance.copy.side as f32);
        let first = Vec3::new((0.5 - half) * delta, (0.5 - half) * delta, first_depth);
        let corner = Vec2::new(rect.x as f32, rect.y as f32);
        let focal = 4.0 * place.focal;
        let stretch = [linear.x_axis, linear.y_axis, linear.z_axis].map(Vec3::length).iter().sum::<f32>();
        let nearest = place.origin.z - stretch * radius;
        let per_unit = match place.perspective {
            true if nearest > 0.0 => focal.max_element() / nearest,
            true => f32::INFINITY,
            false => focal.max_element(),
        };
        Self {
            place,
            planes,
            focal,
            centre: 4.0 * (place.centre_px - corner),
            steps: linear * delta,
            // Half a texel across and down, each leaning by 3 at most, perspective included.
            reach: 8.0 * per_unit * delta * stretch,
            origin: linear * first + place.origin,
            depth_step: linear.z_axis * step,
            side: instance.copy.side as usize,
            delta,
            radius,
            rect,
        }
    }

    /// Draws the samples of an image, the first of which has the index `first`; returns how many.
    pub fn draw(
        &self,
        image: &MBuffer,
        first: u32,
        stipples: Option<&Stipples>,
        buffer: &mut FlakeBuffer,
    ) -> u64 {
        let half = 0.5 * self.side as f32;
        let (mut next, mut drawn) = (0, 0);
        for (row, counts) in image.counts.chunks_exact(self.side).enumerate() {
            let samples: usize = counts.iter().map(|count| usize::from(*count)).sum();
            let y = (row as f32 + 0.5 - half) * self.delta;
            if samples == 0 || !self.place.row_meets(y, self.radius, self.delta, &self.rect) {
                next += samples;
                continue;
            }
            drawn += samples as u64;
            let row_origin = self.origin + row as f32 * self.steps.y_axis;
            for (column, &count) in counts.iter().enumerate() {
                if count == 0 {
                    continue;
                }
                let base = row_origin + column as f32 * self.steps.x_axis;
                for sample in &image.samples[next..next + usize::from(count)] {
                    let index = first + next as u32;
                    let texel = TexelSample { base, sample, index };
                    match &self.planes {
                        None => {
                            let depth = f32::from(sample.depth);
                            self.flake(texel, depth, sample.normal.slope(), stipples, buffer);
                        }
                        Some(planes) => planes.each_near(sample, |depth| {
                            self.flake(texel, depth, Vec2::ZERO, stipples, buffer);
                        }),
                    }
                    next += 1;
                }
            }
        }
        drawn
    }

    /// Draws a sample at a stored depth, leaning by a slope.
    #[inline(always)]
    fn flake(
        &self,
        TexelSample { base, sample, index }: TexelSample,
        depth: f32,
        slope: Vec2,
        stipples: Option<&Stipples>,
        buffer: &mut FlakeBuffer,
    ) {
        let place = self.place;
        let at = base + self.depth_step * depth;
        let (mut scale, mut shrink, mut nearness) = (self.focal, 0.0, -at.z);
        if place.perspective {
            nearness = at.z.recip();
            (scale, shrink) = (self.focal * nearness, nearness);
        }
        let from_centre = scale * at.truncate();
        let px = from_centre + self.centre;
        let size = buffer.size();
        // Comparisons that also fail for what is no number.
        let is_near = px.x > -self.reach
            && px.y > -self.reach
            && px.x < size[0] as f32 + self.reach
            && px.y < size[1] as f32 + self.reach
            && (nearness > 0.0 || !place.perspective);
        if !is_near {
            return;
        }
        if !sample.normal.is_leaf() {
            let normal = place.view_from_normal * sample.normal.normal();
            let looks_away = if place.perspective { normal.dot(at) > 0.0 } else { normal.z > 0.0 };
            if looks_away {
                return;
            }
        }
        let change = |step: Vec3| scale * step.truncate() - from_centre * (step.z * shrink);
        let along = change(self.steps.z_axis);
        let across = change(self.steps.x_axis) + slope.x * along;
        let down = change(self.steps.y_axis) + slope.y * along;
        // The depth is that of the middle of the covered parts: the texel's own middle lies elsewhere on the surface.
        let middle = match sample.mask {
            u16::MAX => px,
            _ => px - slope.dot(sample.middle()) * along,
        };
        let key = key(nearness, index);
        let flake = Flake { middle, across, down, mask: sample.mask };
        match stipples {
            None => flake.cover(size, |x, y, is_covered| buffer.put(x, y, if is_covered { key } else { 0 })),
            Some(stipples) => {
                let rect = self.rect;
                flake.cover(size, |x, y, is_covered| {
                    let open = stipples.open_at(rect.x + x / 4, rect.y + y / 4);
                    if is_covered && open >> (4 * (y & 3) + (x & 3)) & 1 != 0 {
                        buffer.put(x, y, key);
                    }
                });
            }
        }
    }
}
