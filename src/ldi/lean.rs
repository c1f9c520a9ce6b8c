//! Leaning: the views that a viewer of a layered depth image sees through its frame, as through a window, and the region
//! within which they have no large holes.

use glam::DVec3;
use rayon::prelude::*;

use super::layout::{Ldi, ResolutionLevel};
use super::segments::reach::{pivot, reach};
use super::warp::{WarpOptions, warp};
use quadratura_base::error::Result;
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_base::task::Task;
use quadratura_view::Shot;

/// A window through which an image is seen: the view keeps its direction, and things at the distance of the pivot keep their
/// place when the viewpoint moves aside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// The distance along the axis of what keeps its place, in world units.
    pub pivot: f64,
    /// The magnification about the middle of what is seen; 1 shows it to its sides.
    pub zoom: f64,
    /// What is seen of the frame from the reference camera: the photo, without the guard band about it, or the whole frame.
    pub seen: PixelRect,
}

impl Window {
    /// Makes the window of an image, with the pivot at the distance that is nearer than a share of the first layer.
    pub fn new(ldi: &Ldi, zoom: f64, share: f64) -> Self {
        Self { pivot: pivot(ldi, share), zoom, seen: seen(ldi) }
    }

    /// Finds the pivot with which one can go farthest, and the region for it.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`].
    pub fn with_widest_region(ldi: &Ldi, zoom: f64, task: &Task) -> Result<(Self, SafeRegion)> {
        let mut best: Option<(Self, SafeRegion)> = None;
        for (share, done) in PIVOTS.into_iter().zip(0..) {
            task.step("safe region", done, PIVOTS.len() as u64)?;
            let window = Self::new(ldi, zoom, share);
            let region = SafeRegion::new(ldi, &window, task)?;
            if best.as_ref().is_none_or(|(_, widest)| region.width() > widest.width()) {
                best = Some((window, region));
            }
        }
        Ok(best.expect("there is a share"))
    }

    /// Returns the view from a viewpoint: its offset from the reference camera, along the camera's axes (right, down, ahead) in
    /// world units. The picture has `size` pixels; the width of what is seen fills its width.
    pub fn shot(&self, ldi: &Ldi, offset: DVec3, size: [u32; 2]) -> Shot {
        let Pinhole { fx, fy, cx, cy, .. } = ldi.camera;
        let scale = self.zoom * f64::from(size[0]) / f64::from(self.seen.w);
        let centred = |c: f64, first: i32, side: u32, picture: u32| {
            (c - f64::from(first) - f64::from(side) / 2.0) * scale + f64::from(picture) / 2.0
        };
        let camera = Pinhole {
            width: size[0],
            height: size[1],
            fx: fx * scale,
            fy: fy * scale,
            cx: centred(cx, self.seen.x, self.seen.w, size[0]) + fx * scale * offset.x / self.pivot,
            cy: centred(cy, self.seen.y, self.seen.h, size[1]) + fy * scale * offset.y / self.pivot,
        };
        let pose = Pose { translation: ldi.pose.translation - offset, ..ldi.pose };
        Shot { backs: false, ..Shot::new(camera, pose) }
    }
}

/// Returns what is seen of an image's frame from its camera.
pub fn seen(ldi: &Ldi) -> PixelRect {
    ldi.photo_rect.unwrap_or_else(|| ldi.camera.rect())
}

/// The shares of the first layer that are tried as pivots: what is there keeps its place, what is nearer or farther leaves room
/// at the sides.
const PIVOTS: [f64; 4] = [0.25, 0.5, 0.7, 0.85];

/// The number of directions in which the region is measured, to the right first, then towards below.
pub const DIRECTIONS: usize = 16;
/// The share of what the reference camera's own view shows that a view in the region shows, at least.
pub const COVERED: f64 = 0.98;
/// Views are tried up to this many times the reach.
const FARTHEST: f64 = 1.0;
/// The steps in which they are tried.
const STEPS: u32 = 16;
/// How often the last step is halved to find the limit.
const HALVINGS: u32 = 4;
/// The longer side of the pictures in which holes are counted, in pixels.
const SIDE: u32 = 256;

/// The viewpoints from which an image shows nearly everything: a double cone about the reference camera. The offset (x, y, z) is
/// within it when the length of (x, y) is at most that of its direction times 1 - |z| / z's limit.
#[derive(Debug, Clone, PartialEq)]
pub struct SafeRegion {
    /// By direction, the farthest offset across the axis, in world units.
    pub across: [f64; DIRECTIONS],
    /// The farthest offset back and ahead, in world units, both >= 0.
    pub along: [f64; 2],
}

impl SafeRegion {
    /// Finds the region by drawing small views on a grid of viewpoints.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Cancelled`].
    pub fn new(ldi: &Ldi, window: &Window, task: &Task) -> Result<Self> {
        let probe = Probe::new(ldi, window, task)?;
        let farthest = FARTHEST * reach(ldi);
        let of_direction = |direction: usize| probe.farthest(unit(direction), farthest);
        let across = (0..DIRECTIONS).into_par_iter().map(of_direction).collect::<Result<Vec<_>>>()?;
        let along = [probe.farthest(-DVec3::Z, farthest)?, probe.farthest(DVec3::Z, farthest)?];
        let mut region = Self { across: across.try_into().expect("a length for each direction"), along };
        // What is between the axes was not seen yet: the cone shrinks until that is covered, too.
        for _ in 0..STEPS {
            let inside = region.between();
            let safe =
                inside.par_iter().map(|offset| probe.is_covered(*offset)).collect::<Result<Vec<_>>>()?;
            if !safe.contains(&false) {
                break;
            }
            region.across.iter_mut().chain(&mut region.along).for_each(|limit| *limit *= 0.9);
        }
        Ok(region)
    }

    /// Returns how far one can go to the sides: the mean of the least two of the four axes and of all directions, so that no
    /// side is closed in favour of another.
    pub fn width(&self) -> f64 {
        let quarter = DIRECTIONS / 4;
        let mut axes: Vec<f64> = (0..4).map(|axis| self.across[axis * quarter]).collect();
        axes.sort_by(f64::total_cmp);
        let mean = self.across.iter().sum::<f64>() / DIRECTIONS as f64;
        axes[0] + axes[1] + mean
    }

    /// Returns viewpoints on and within the cone, between the axes on which it was measured.
    fn between(&self) -> Vec<DVec3> {
        let mut out = Vec::new();
        for direction in 0..DIRECTIONS {
            let next = (direction + 1) % DIRECTIONS;
            let reach = self.across[direction].min(self.across[next]);
            let middle = (unit(direction) + unit(next)).normalize();
            out.extend([1.0, 0.5].map(|share| middle * reach * share));
            for (sign, limit) in [(-1.0, self.along[0]), (1.0, self.along[1])] {
                out.push(unit(direction) * self.across[direction] * 0.5 + DVec3::Z * sign * limit * 0.5);
            }
        }
        out
    }
}

/// Returns the direction of a number, in the camera's axes.
fn unit(direction: usize) -> DVec3 {
    let (sin, cos) = (std::f64::consts::TAU * direction as f64 / DIRECTIONS as f64).sin_cos();
    DVec3::new(cos, sin, 0.0)
}

/// The share of the sky's pixels that is taken for stray ones in gaps of the model, of those that are lowest.
const STRAY: f64 = 0.01;

/// Returns the first row of a level that is below nearly all that the reference camera sees of the surroundings.
fn below_sky(level: &ResolutionLevel) -> u32 {
    let sky = |y: u32| {
        let first = level.layered_pixels(y).filter_map(|pixel| level.inverse_depths.get(pixel.start));
        first.filter(|inverse_depth| **inverse_depth == 0.0).count()
    };
    let of_rows: Vec<usize> = (0..level.camera.height).map(sky).collect();
    let mut left = (STRAY * of_rows.iter().sum::<usize>() as f64) as usize;
    let below = of_rows.iter().rposition(|count| {
        let is_stray = *count <= left;
        left -= (*count).min(left);
        !is_stray
    });
    below.map_or(0, |row| row as u32 + 1)
}

/// Counts holes in small views.
struct Probe<'a> {
    ldi: Ldi,
    window: &'a Window,
    size: [u32; 2],
    /// What the own view covers, in pixels.
    own: f64,
    task: &'a Task,
}

impl<'a> Probe<'a> {
    fn new(ldi: &'a Ldi, window: &'a Window, task: &'a Task) -> Result<Self> {
        let (width, height) = (window.seen.w, window.seen.h);
        let scale = (f64::from(SIDE) / f64::from(width.max(height))).min(1.0);
        let size = [width, height].map(|side| ((f64::from(side) * scale).round() as u32).max(1));
        // Below the sky that the camera sees, ground hides the surroundings. Where none of it is left, they are no picture of it.
        let ldi = ldi.without_surroundings_from(ldi.levels.first().map_or(0, below_sky));
        let mut probe = Self { ldi, window, size, own: 0.0, task };
        probe.own = probe.covered(DVec3::ZERO)?;
        Ok(probe)
    }

    fn covered(&self, offset: DVec3) -> Result<f64> {
        let shot = self.window.shot(&self.ldi, offset, self.size);
        let picture = warp(&self.ldi, &shot, &WarpOptions::default(), self.task)?.picture;
        Ok(picture.pixels().iter().map(|pixel| f64::from(pixel[3]) / 255.0).sum())
    }

    fn is_covered(&self, offset: DVec3) -> Result<bool> {
        Ok(self.covered(offset)? >= COVERED * self.own)
    }

    /// Returns how far one can go in a direction.
    fn farthest(&self, direction: DVec3, farthest: f64) -> Result<f64> {
        let mut reached = 0.0;
        for step in 1..=STEPS {
            let next = farthest * f64::from(step) / f64::from(STEPS);
            if self.is_covered(direction * next)? {
                reached = next;
                continue;
            }
            let mut beyond = next;
            for _ in 0..HALVINGS {
                let middle = f64::midpoint(reached, beyond);
                *(if self.is_covered(direction * middle)? { &mut reached } else { &mut beyond }) = middle;
            }
            break;
        }
        Ok(reached)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{DepthPixel, Splat};

    #[test]
    fn the_sky_ends_above_the_ground_and_stray_pixels_of_it_do_not_count() {
        let pixel =
            |inverse_depth| DepthPixel { inverse_depth, colour: [9; 4], surface: 0, splat: Splat::default() };
        let camera = Pinhole { width: 300, height: 4, fx: 300.0, fy: 300.0, cx: 150.0, cy: 2.0 };
        let row =
            |sky: u16| (0..300).map(|x| (x, pixel(if x < sky { 0.0 } else { 1.0 }))).collect::<Vec<_>>();
        // Behind the ground the surroundings go on; the camera does not see them there.
        let hidden = |mut row: Vec<(u16, DepthPixel)>| {
            row.push((299, pixel(0.0)));
            row
        };
        let level = |rows: [u16; 4]| ResolutionLevel::of_rows(camera, rows.map(|sky| hidden(row(sky))));
        assert_eq!(below_sky(&level([300, 250, 0, 0])), 2);
        assert_eq!(below_sky(&level([300, 250, 0, 3])), 2, "one in a hundred is stray");
        assert_eq!(below_sky(&level([300, 250, 0, 60])), 4);
        assert_eq!(below_sky(&level([0; 4])), 0);
    }
}
