//! Why pixels of a view are empty.
//!
//! What an empty pixel would show is not known, but it is about as far away as what is seen at its rims: the nearest pixels
//! to the left, to the right, above and below that show something. The points of the pixel's ray with these depths lie on a
//! segment in the reference camera's image.

use glam::{DVec2, DVec3};

use super::layout::{Ldi, ResolutionLevel};
use super::transfer::Transfer;
use super::warp::{WarpOptions, last_drawn, level_of};
use quadratura_base::error::Result;
use quadratura_base::geometry::Pinhole;
use quadratura_base::task::Task;
use quadratura_view::{Picture, Shot};

/// The share by which the inverse depth of a depth pixel may differ from that at a rim to be of the same surface: on
/// slanted surfaces depth changes across a gap.
const SAME_SURFACE: f64 = 0.05;

/// Why a pixel is empty. Later reasons are nearer to showing something.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Hole {
    /// The reference camera's frame ends before it.
    OutsideFrame,
    /// The frame has it, but no photo or no filling shows what is there.
    Empty,
    /// It is a gap between depth pixels of one surface that is magnified too much.
    TooNear,
}

impl Hole {
    /// All reasons.
    pub const ALL: [Self; 3] = [Self::OutsideFrame, Self::Empty, Self::TooNear];

    /// Returns the meaning for users.
    pub fn name(self) -> &'static str {
        match self {
            Self::OutsideFrame => "outside the frame",
            Self::Empty => "hidden or empty",
            Self::TooNear => "too near for what the image resolves",
        }
    }

    /// Returns the colour, sRGB.
    pub fn colour(self) -> [u8; 3] {
        match self {
            Self::OutsideFrame => [0x2a, 0x5c, 0xe4],
            Self::Empty => [0xd0, 0x1c, 0x8b],
            Self::TooNear => [0xf2, 0xb1, 0x34],
        }
    }
}

/// A pixel of a view as [`holes_of`] looks at it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HolePixel {
    /// It shows something.
    Full,
    /// What it would show is not known.
    Empty,
    /// It would show something of this inverse depth in the picture's camera.
    EmptyAt(f32),
}

/// Finds why pixels of a view of images are empty, row by row; `pixel` is asked by their index. Where the images have different
/// reasons, it is the one that is nearest to showing something. Options are those that the view was made with.
///
/// # Errors
/// [`quadratura_base::Error::Cancelled`].
pub fn holes_of<'a>(
    images: impl IntoIterator<Item = &'a Ldi>,
    shot: &Shot,
    options: &WarpOptions,
    pixel: &dyn Fn(usize) -> HolePixel,
    task: &Task,
) -> Result<Vec<Option<Hole>>> {
    let size = [shot.camera.width as usize, shot.camera.height as usize];
    let pixels: Vec<HolePixel> = (0..size[0] * size[1]).map(pixel).collect();
    let outside = |pixel: &HolePixel| (*pixel != HolePixel::Full).then_some(Hole::OutsideFrame);
    let mut found: Vec<Option<Hole>> = pixels.iter().map(outside).collect();
    for ldi in images {
        let level_index = level_of(ldi, shot, options);
        let level = &ldi.levels[level_index];
        let drawn = WarpOptions { level: Some(level_index as u8), ..*options };
        let to_shot = Transfer::new(&level.camera, &ldi.pose, &shot.camera, &shot.pose);
        let rims = match pixels.contains(&HolePixel::Empty) {
            true => rims_of(&depths_of(level, &to_shot, &last_drawn(ldi, shot, &drawn, task)?), size),
            false => Vec::new(),
        };
        task.check_cancelled()?;
        let to_level = Transfer::new(&shot.camera, &shot.pose, &level.camera, &ldi.pose);
        for (at, (found, pixel)) in found.iter_mut().zip(&pixels).enumerate() {
            let rims = match pixel {
                HolePixel::Full => continue,
                HolePixel::Empty => rims[at],
                HolePixel::EmptyAt(depth) => [*depth, f32::NAN, f32::NAN, f32::NAN],
            };
            let position = DVec2::new((at % size[0]) as f64 + 0.5, (at / size[0]) as f64 + 0.5);
            *found = (*found).max(Some(hole_at(level, &to_level, position, &rims)));
        }
    }
    Ok(found)
}

/// Puts the colours of the reasons behind a picture, which becomes opaque there.
pub fn paint_holes(picture: &mut Picture, holes: &[Option<Hole>]) {
    for (pixel, hole) in picture.rgba.as_chunks_mut::<4>().0.iter_mut().zip(holes) {
        let Some(hole) = hole else { continue };
        let [colour @ .., opacity] = pixel;
        let share = u32::from(*opacity);
        for (value, behind) in colour.iter_mut().zip(hole.colour()) {
            *value = ((u32::from(*value) * share + u32::from(behind) * (255 - share) + 127) / 255) as u8;
        }
        *opacity = u8::MAX;
    }
}

/// Returns the inverse depth in the picture's camera at each pixel, of the depth pixels that were drawn last; NaN where none was.
fn depths_of(level: &ResolutionLevel, transfer: &Transfer, drawn: &[u32]) -> Vec<f32> {
    let mut rows = vec![0u32; level.len()];
    for y in 0..level.camera.height {
        rows[level.row(y)].fill(y);
    }
    let depth = |drawn: &u32| {
        let Some(index) = (*drawn as usize).checked_sub(1) else { return f32::NAN };
        let position = DVec2::new(f64::from(level.columns[index]) + 0.5, f64::from(rows[index]) + 0.5);
        let depth = f64::from(level.inverse_depths[index]);
        (depth / transfer.homogeneous(position, depth).z) as f32
    };
    drawn.iter().map(depth).collect()
}

/// Returns the inverse depths at the rims of each pixel: to the left, to the right, above and below; NaN where nothing is
/// seen up to the border of the picture. Where nothing is seen on any side, they are those of the nearest pixel above, or
/// below, that has any.
fn rims_of(depths: &[f32], [width, height]: [usize; 2]) -> Vec<[f32; 4]> {
    let mut rims = vec![[f32::NAN; 4]; depths.len()];
    let mut carry = |side: usize, path: &mut dyn Iterator<Item = usize>| {
        let mut last = f32::NAN;
        for at in path {
            last = if depths[at].is_nan() { last } else { depths[at] };
            rims[at][side] = last;
        }
    };
    for y in 0..height {
        let row = y * width..(y + 1) * width;
        carry(0, &mut row.clone());
        carry(1, &mut row.rev());
    }
    for x in 0..width {
        let column = (0..height).map(|y| y * width + x);
        carry(2, &mut column.clone());
        carry(3, &mut column.rev());
    }
    let mut fill = |at: usize, from: usize| {
        if rims[at].iter().all(|rim| rim.is_nan()) {
            rims[at] = rims[from];
        }
    };
    (width..depths.len()).for_each(|at| fill(at, at - width));
    (0..depths.len().saturating_sub(width)).rev().for_each(|at| fill(at, at + width));
    rims
}

/// Finds why a pixel at `position` of the picture is empty. `to_level` is the transfer from the picture to the level.
fn hole_at(level: &ResolutionLevel, to_level: &Transfer, position: DVec2, rims: &[f32; 4]) -> Hole {
    let known = || rims.iter().filter(|rim| !rim.is_nan()).map(|rim| f64::from(*rim));
    if known().any(|rim| has_surface(level, to_level.homogeneous(position, rim), rim)) {
        return Hole::TooNear;
    }
    let (least, largest) = known()
        .fold((f64::INFINITY, 0.0), |(least, largest): (f64, f64), rim| (least.min(rim), largest.max(rim)));
    let ends = [least.min(largest), largest].map(|rim| to_level.homogeneous(position, rim));
    if meets_frame(ends, &level.camera) { Hole::Empty } else { Hole::OutsideFrame }
}

/// Returns whether there is a depth pixel about where a point is whose homogeneous position this is; `rim` is its inverse depth
/// in the picture's camera.
fn has_surface(level: &ResolutionLevel, point: DVec3, rim: f64) -> bool {
    let (x, y) = (point.x / point.z, point.y / point.z);
    let within = point.z > 0.0 && x >= 0.0 && y >= 0.0;
    if !(within && x < f64::from(level.camera.width) && y < f64::from(level.camera.height)) {
        return false;
    }
    let depth = rim / point.z;
    let is_there =
        |index: usize| (f64::from(level.inverse_depths[index]) - depth).abs() <= SAME_SURFACE * depth;
    level.at(x as u32, y as u32).any(is_there)
}

/// Returns whether a part of a segment between two homogeneous positions is in a camera's image.
fn meets_frame([from, to]: [DVec3; 2], camera: &Pinhole) -> bool {
    let (width, height) = (f64::from(camera.width), f64::from(camera.height));
    // Each side of the frame is where a linear function changes its sign; all are positive inside.
    let inside = |p: DVec3| [p.z, p.x, p.y, width * p.z - p.x, height * p.z - p.y];
    let (mut first, mut last) = (0.0f64, 1.0f64);
    for (a, b) in inside(from).into_iter().zip(inside(to)) {
        match (a > 0.0, b > 0.0) {
            (true, true) => {}
            (false, false) => return false,
            (false, true) => first = first.max(a / (a - b)),
            (true, false) => last = last.min(a / (a - b)),
        }
    }
    first <= last
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_segment_meets_the_frame_where_any_part_of_it_is_inside_and_before_the_camera() {
        let camera = Pinhole { width: 40, height: 30, fx: 40.0, fy: 40.0, cx: 20.0, cy: 15.0 };
        let at = |x: f64, y: f64, z: f64| DVec3::new(x * z, y * z, z);
        assert!(meets_frame([at(-10.0, 15.0, 1.0), at(50.0, 15.0, 3.0)], &camera), "through the frame");
        assert!(meets_frame([at(5.0, 5.0, 1.0), at(5.0, 5.0, 1.0)], &camera), "a point inside");
        assert!(!meets_frame([at(-10.0, 5.0, 1.0), at(-5.0, 90.0, 1.0)], &camera), "beside it");
        assert!(!meets_frame([at(-10.0, 25.0, 1.0), at(5.0, 60.0, 1.0)], &camera), "around a corner");
        assert!(!meets_frame([at(5.0, 5.0, -1.0), at(9.0, 5.0, -1.0)], &camera), "behind the camera");
    }

    #[test]
    fn the_rims_of_a_pixel_are_the_nearest_that_show_something_on_each_side() {
        const NONE: f32 = f32::NAN;
        let depths = [1.0, NONE, 2.0, NONE, NONE, 3.0];
        let rims = rims_of(&depths, [3, 2]);
        let bits = |rim: [f32; 4]| rim.map(f32::to_bits);
        assert_eq!(bits(rims[1]), bits([1.0, 2.0, NONE, NONE]));
        assert_eq!(bits(rims[3]), bits([NONE, 3.0, 1.0, NONE]));
        let rims = rims_of(&[NONE, NONE, NONE, NONE, 5.0, NONE], [2, 3]);
        assert_eq!(bits(rims[1]), bits([5.0, NONE, NONE, NONE]), "from below");
    }
}
