//! The samples of a source in the pixels of the common camera.

use std::ops::Range;

use glam::{DMat3, DVec2, DVec3};

use super::neighbourhood::Neighbourhood;
use crate::layout::{DepthPixel, DepthPixelOrigin, Ldi, ResolutionLevel, Splat};
use crate::merge::SurfaceSample;
use crate::splat::{Canvas, Dot};
use crate::transfer::Transfer;

/// The rows of the common camera whose samples are merged together: in frames of moderate width their samples stay in the processor's cache.
pub const STRIP: u32 = 16;
/// How far from its middle a source pixel gives samples, in pixels of the common camera along either axis: one with sides of 32 pixels
/// along the axes is sampled without gaps.
const REACH: f64 = 16.0;
/// How much longer than a pixel of the common camera the side of a source pixel may be to give one sample: the same camera
/// gives 1 with a rounding error.
const ONE_PIXEL: f64 = 1.001;
/// How far from the middle of a pixel of the common camera a source pixel of the same size may be that is taken for it, in pixels:
/// positions in single precision err by less in frames of up to 8192 pixels.
const IN_THE_MIDDLE: f32 = 1e-3;
/// The height of a source pixel over its longer side in the common camera, in pixels, from which on each pixel whose centre it covers
/// has a sample there. Narrower ones would often cover none: they have samples of their own points, which are averaged. Held-out
/// photos of four sites are predicted about as well with 0.3, and worse with 0.7 (docs/quality.md). With a half, rounding would decide
/// in cameras of half the resolution, which are common.
const LEAST_HEIGHT: f64 = 0.45;
/// By how much a source pixel of a known plane counts as larger on each side, in its pixels. Neighbours on a plane meet exactly, and relief
/// moves them apart by little: held-out photos are predicted the better, the smaller it is (docs/quality.md).
const OVERLAP: f64 = 0.005;
/// The same where the plane is estimated from neighbours: errors of depth move neighbours apart by several hundredths of a pixel.
const OVERLAP_OF_UNKNOWN: f64 = 0.1;

/// A source as it is warped into the common camera.
pub struct Collected<'a> {
    /// The level of the source that is warped.
    level: &'a ResolutionLevel,
    /// The number that its samples carry.
    source: u16,
    /// The change of inverse depth from pixel to pixel, by number of surface; `None` for the unknown one.
    slopes: Vec<Option<DVec2>>,
    /// The number of each of its surfaces in the common list.
    numbers: &'a [u16],
    /// The transfer of the level to the common camera.
    transfer: Transfer,
    /// The inverse of A, which takes a position of what is infinitely far away back to the source.
    from_infinity: DMat3,
    /// Stored values at the common exposure by stored value: R, G, B.
    bytes: &'a [[u8; 256]; 3],
    /// Whether each source pixel gives one sample, however large it is in the common camera.
    single: bool,
}

impl<'a> Collected<'a> {
    /// Prepares a source, whose level has this transfer to the common camera. Its samples carry the number `source`, which is 0
    /// for the reference camera's own photo; `numbers` are those of its surfaces in the common list, and `bytes` are stored
    /// values at the common exposure by stored value: R, G, B. If `single`, each source pixel gives one sample.
    pub fn new(
        ldi: &'a Ldi,
        level: &'a ResolutionLevel,
        source: u16,
        transfer: Transfer,
        numbers: &'a [u16],
        bytes: &'a [[u8; 256]; 3],
        single: bool,
    ) -> Self {
        // The surfaces' planes are in pixels of the source's frame.
        let pixel_size = ldi.camera.fx / level.camera.fx;
        let known = ldi.surfaces.iter().map(|surface| Some(pixel_size * surface.nu.truncate()));
        let slopes = std::iter::once(None).chain(known).collect();
        let from_infinity = transfer.a.inverse();
        Self { level, source, slopes, numbers, transfer, from_infinity, bytes, single }
    }

    /// Moves a neighbourhood to a source pixel.
    fn look_around(&self, around: &mut Neighbourhood, dot: &Dot) {
        let slope = self.slopes[usize::from(self.level.surfaces[dot.index])];
        around.move_to(self.level, dot.index, slope);
    }

    /// Returns a stored colour at the common exposure.
    #[inline]
    fn exposed(&self, [r, g, b, a]: [u8; 4]) -> [u8; 4] {
        let [of_r, of_g, of_b] = self.bytes;
        [of_r[usize::from(r)], of_g[usize::from(g)], of_b[usize::from(b)], a]
    }

    /// Returns the sample at the middle of a source pixel, whose longest side has this square in the common camera.
    #[inline]
    fn sample(&self, dot: &Dot, longest_squared: f64) -> SurfaceSample {
        let Collected { level, numbers, source, .. } = self;
        let origin = match level.splats[dot.index].origin() {
            DepthPixelOrigin::Photo if *source != 0 => DepthPixelOrigin::OtherPhotos,
            origin => origin,
        };
        // A sample counts by the area that its source pixel covers, and less where it resolves less in either direction. The one at the
        // centre of a pixel shows as little of it: where it counted by the whole pixel, three of four sites were predicted worse
        // (docs/quality.md).
        let weight = f64::from(dot.s * dot.s).min(1.0 / longest_squared) as f32;
        SurfaceSample {
            pixel: DepthPixel {
                inverse_depth: dot.q,
                colour: self.exposed(dot.colour),
                surface: numbers[usize::from(level.surfaces[dot.index])],
                splat: Splat::new(0, origin),
            },
            source: *source,
            place: dot.index as u32,
            weight: weight.max(f32::MIN_POSITIVE),
            hidden: level.is_hidden(dot.index),
        }
    }
}

/// The samples of a strip of the common camera, [`STRIP`] rows: the index of the pixel in the strip, and the sample, in no particular
/// order.
pub type Strip = Vec<(u32, SurfaceSample)>;

/// Rows of the common camera in which samples are collected.
pub struct CollectCanvas<'a> {
    of: &'a Collected<'a>,
    size: [u32; 2],
    top: f64,
    around: Neighbourhood,
    /// The strips from the top.
    pub strips: Vec<Strip>,
}

impl<'a> CollectCanvas<'a> {
    /// Makes some rows of a camera of this width.
    pub fn new(of: &'a Collected, width: u32, rows: &Range<u32>) -> Self {
        let (top, rows) = (f64::from(rows.start), rows.end - rows.start);
        let strips = vec![Strip::new(); rows.div_ceil(STRIP) as usize];
        Self { of, size: [width, rows], top, around: Neighbourhood::new(), strips }
    }

    /// Adds a sample at a pixel.
    #[inline]
    fn add(&mut self, column: u32, row: u32, sample: SurfaceSample) {
        let [width, _] = self.size;
        self.strips[(row / STRIP) as usize].push((row % STRIP * width + column, sample));
    }

    /// Adds a sample at a position of the rows, unless it is outside.
    #[inline]
    fn add_at(&mut self, u: f64, v: f64, sample: SurfaceSample) {
        let [width, rows] = self.size;
        if u >= 0.0 && u < f64::from(width) && v >= 0.0 && v < f64::from(rows) {
            self.add(u as u32, v as u32, sample);
        }
    }

    /// Returns what a source pixel covers in the common camera, where its plane has this gradient.
    #[inline]
    fn footprint(&self, dot: &Dot, gradient: DVec2) -> PixelFootprint {
        let Collected { level, transfer, from_infinity, .. } = self.of;
        let (u, v, q) = (f64::from(dot.u), f64::from(dot.v) + self.top, f64::from(dot.q));
        let per_omega = match q > 0.0 {
            true => q / f64::from(level.inverse_depths[dot.index]),
            false => (*from_infinity * DVec3::new(u, v, 1.0)).z,
        };
        PixelFootprint::new(transfer, DVec2::new(u, v), q, per_omega, gradient)
    }

    /// Adds a sample for each pixel of the common camera whose centre a source pixel covers.
    fn add_covered(&mut self, dot: &Dot, footprint: &PixelFootprint, overlap: f64) {
        let (u, v) = (f64::from(dot.u), f64::from(dot.v));
        let within = 0.5 + overlap;
        let [width, height] = self.size;
        let reach = footprint.reach(within);
        let range = |at: f64, reach: f64, end: u32| {
            let reach = reach.min(REACH);
            (at - reach + 0.5).max(0.0) as u32..(at + reach + 0.5).clamp(0.0, f64::from(end)) as u32
        };
        let (rows, columns) = (range(v, reach.y, height), range(u, reach.x, width));
        if rows.is_empty() || columns.is_empty() {
            return;
        }
        let inverse = footprint.inverse();
        let (of, mut first) = (self.of, None);
        for row in rows {
            for column in columns.clone() {
                let offset_px = DVec2::new(f64::from(column) + 0.5 - u, f64::from(row) + 0.5 - v);
                let Some((affine, offset)) = footprint.offset(inverse, offset_px) else { continue };
                if offset.x.abs() > within || offset.y.abs() > within {
                    continue;
                }
                let sample = first.get_or_insert_with(|| {
                    of.look_around(&mut self.around, dot);
                    of.sample(dot, footprint.longest_squared)
                });
                let inverse_depth = (f64::from(dot.q) + footprint.gradient.dot(affine)).max(0.0) as f32;
                let colour = of.exposed(self.around.colour(of.level, offset));
                let pixel = DepthPixel { inverse_depth, colour, ..sample.pixel };
                let sample = SurfaceSample { pixel, ..*sample };
                self.add(column, row, sample);
            }
        }
    }

    /// Adds several samples of a source pixel, at points of its own, on its plane.
    fn add_many(&mut self, dot: &Dot, footprint: &PixelFootprint) {
        let [columns, rows] = footprint.samples();
        let of = self.of;
        of.look_around(&mut self.around, dot);
        let (inverse_depth, gradient) = (self.around.inverse_depth, self.around.gradient);
        let (centre, sample) = (self.around.centre(), of.sample(dot, footprint.longest_squared));
        let offset = |k: u32, count: u32| (f64::from(k) + 0.5) / f64::from(count) - 0.5;
        for row in 0..rows {
            for column in 0..columns {
                let by = DVec2::new(offset(column, columns), offset(row, rows));
                let inverse_depth = (inverse_depth + gradient.dot(by)).max(0.0);
                let Some((position, omega)) = of.transfer.position(centre + by, inverse_depth) else {
                    continue;
                };
                let at = DVec2::new(position.x, position.y - self.top);
                // Where other rows are drawn, source pixels farther away are left out.
                if (at - DVec2::new(f64::from(dot.u), f64::from(dot.v))).abs().max_element() > REACH {
                    continue;
                }
                let inverse_depth = (inverse_depth / omega) as f32;
                let colour = of.exposed(self.around.colour(of.level, by));
                let pixel = DepthPixel { inverse_depth, colour, ..sample.pixel };
                self.add_at(at.x, at.y, SurfaceSample { pixel, ..sample });
            }
        }
    }

    /// Adds a sample where the middle of a source pixel is.
    #[inline]
    fn add_middle(&mut self, dot: &Dot, longest_squared: f64) {
        self.add_at(dot.u.into(), dot.v.into(), self.of.sample(dot, longest_squared));
    }
}

/// What a source pixel covers in the common camera: with the offset s from its middle, in its pixels, H moves a point to an offset of
/// J s / (1 + w . s) from its position, where J is the derivative of H and w how omega changes.
#[derive(Debug, Clone, Copy)]
struct PixelFootprint {
    /// J: its sides along the rows and the columns of the source, in pixels. Those of the homography H = A + b nu^T are
    /// (H_i - (u, v) H_3i) / omega.
    right: DVec2,
    down: DVec2,
    /// The change of inverse depth in the common camera along the sides, in 1/world unit.
    gradient: DVec2,
    /// w: the change of omega from pixel to pixel of the source, as a share of omega.
    receding: DVec2,
    /// The square of the longer side.
    longest_squared: f64,
    /// Its area in pixels; negative where it is seen mirrored.
    area: f64,
}

impl PixelFootprint {
    /// Makes that of a source pixel whose middle is at this position, with this inverse depth and 1 / omega, on a plane with this
    /// gradient, in 1/world unit a pixel of the source.
    #[inline]
    fn new(transfer: &Transfer, at: DVec2, q: f64, per_omega: f64, gradient: DVec2) -> Self {
        let side = |column: DVec3, slope: f64| {
            let moved = column + slope * transfer.b;
            let along = moved.truncate() - at * moved.z;
            (per_omega * along, per_omega * (slope - q * moved.z), per_omega * moved.z)
        };
        let (right, q_right, omega_right) = side(transfer.a.x_axis, gradient.x);
        let (down, q_down, omega_down) = side(transfer.a.y_axis, gradient.y);
        Self {
            right,
            down,
            gradient: DVec2::new(q_right, q_down),
            receding: DVec2::new(omega_right, omega_down),
            longest_squared: right.length_squared().max(down.length_squared()),
            area: right.perp_dot(down),
        }
    }

    /// Returns whether it has the size of a pixel of the common camera.
    #[inline]
    fn is_pixel(&self) -> bool {
        self.longest_squared <= ONE_PIXEL * ONE_PIXEL && self.area.abs() * ONE_PIXEL * ONE_PIXEL >= 1.0
    }

    /// Returns whether its height over the longer side is [`LEAST_HEIGHT`] or more.
    #[inline]
    fn is_high(&self) -> bool {
        self.area * self.area >= LEAST_HEIGHT * LEAST_HEIGHT * self.longest_squared
    }

    /// Returns how far from the position along each axis its points are whose offsets are within this in the source. With
    /// x = within (|w_x| + |w_y|), they are at most 1 / (1 - x) times as far as without w, which is no more than 1 + 2 x for x up to
    /// a half. Beyond that, next to the plane of the camera's centre, it may be too short.
    #[inline]
    fn reach(&self, within: f64) -> DVec2 {
        let farther = 1.0 + 2.0 * within * (self.receding.x.abs() + self.receding.y.abs());
        within * farther * (self.right.abs() + self.down.abs())
    }

    /// Returns the rows of the inverse of J.
    #[inline]
    fn inverse(&self) -> [DVec2; 2] {
        let per_area = 1.0 / self.area;
        [-per_area * self.down.perp(), per_area * self.right.perp()]
    }

    /// Returns a = J^-1 t, along which inverse depths change as `gradient` says, and the offset in the source, a / (1 - w . a), of the
    /// point that is t pixels from the position; `None` behind the camera.
    #[inline]
    fn offset(&self, [to_right, to_down]: [DVec2; 2], t: DVec2) -> Option<(DVec2, DVec2)> {
        let a = DVec2::new(to_right.dot(t), to_down.dot(t));
        let rest = 1.0 - self.receding.dot(a);
        (rest > 0.0).then(|| (a, a / rest))
    }

    /// Returns how many samples of it are taken along the rows and the columns of the source, so that they are no farther apart than
    /// pixels of the common camera.
    fn samples(&self) -> [u32; 2] {
        let of = |side: DVec2| (side.length().min(2.0 * REACH) / ONE_PIXEL).ceil().max(1.0) as u32;
        [of(self.right), of(self.down)]
    }
}

impl Canvas for CollectCanvas<'_> {
    const SPACED: bool = true;
    const REACH: f32 = REACH as f32;

    fn reach(_largest_spacing: f32, _largest_stretch: f32) -> f32 {
        // Also a pixel of little area may be long.
        Self::REACH
    }

    fn draw(&mut self, dot: &Dot) {
        let Collected { level, slopes, single, .. } = self.of;
        if *single {
            self.add_middle(dot, f64::from(dot.s * dot.s));
            return;
        }
        // What is not to be seen has no position.
        if dot.u.is_nan() {
            return;
        }
        let (gradient, overlap) = match slopes[usize::from(level.surfaces[dot.index])] {
            Some(slope) => (slope, OVERLAP),
            None => {
                self.of.look_around(&mut self.around, dot);
                (self.around.gradient, OVERLAP_OF_UNKNOWN)
            }
        };
        let footprint = self.footprint(dot, gradient);
        if footprint.is_pixel() && is_middle(dot.u) && is_middle(dot.v) {
            self.add_middle(dot, footprint.longest_squared);
        } else if footprint.is_high() {
            self.add_covered(dot, &footprint, overlap);
        } else if footprint.longest_squared > ONE_PIXEL * ONE_PIXEL {
            self.add_many(dot, &footprint);
        } else {
            self.add_middle(dot, footprint.longest_squared);
        }
    }
}

/// Returns whether a position along an axis is in the middle of a pixel; false for negative ones, which are above or left of the rows.
#[inline]
fn is_middle(at: f32) -> bool {
    (at - (at as i32) as f32 - 0.5).abs() < IN_THE_MIDDLE
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::{Rng, centred, look_at};

    #[test]
    fn points_of_a_plane_are_found_by_their_offsets_in_the_picture_exactly() {
        let mut rng = Rng::new(71);
        let (source, common) = (centred(40, 30, 35.0), centred(100, 80, 90.0));
        for _ in 0..200 {
            let mut number = |size: f64| rng.between(-size, size);
            let mut eye = || DVec3::new(number(2.0), number(2.0), number(1.0));
            let poses = [eye(), eye()].map(|eye| look_at(eye, DVec3::new(0.3, -0.2, 9.0)));
            let transfer = Transfer::new(&source, &poses[0], &common, &poses[1]);
            let centre = DVec2::new(20.5 + number(15.0).floor(), 15.5 + number(10.0).floor());
            let (depth, gradient) = (0.12 + number(0.04), DVec2::new(number(0.01), number(0.01)));
            let (at, omega) = transfer.position(centre, depth).unwrap();
            let footprint = PixelFootprint::new(&transfer, at, depth / omega, 1.0 / omega, gradient);
            let inverse = footprint.inverse();
            for (x, y) in (-5..=5).flat_map(|y| (-5..=5).map(move |x| (x, y))) {
                let s = 0.1 * DVec2::new(f64::from(x), f64::from(y));
                let there = depth + gradient.dot(s);
                let (p, omega_there) = transfer.position(centre + s, there).unwrap();
                let (affine, offset) = footprint.offset(inverse, p - at).unwrap();
                // Only rounding in double precision, of numbers up to a hundred.
                assert!((offset - s).abs().max_element() < 1e-9, "{offset} and {s}");
                let q = depth / omega + footprint.gradient.dot(affine);
                assert!((q - there / omega_there).abs() < 1e-12, "{q}");
                let reach = footprint.reach(0.5) + 1e-9;
                assert!((p - at).abs().cmple(reach).all(), "{} and {reach}", p - at);
            }
        }
    }

    #[test]
    fn what_is_behind_the_camera_has_no_offset() {
        let footprint = PixelFootprint {
            right: DVec2::X,
            down: DVec2::Y,
            gradient: DVec2::ZERO,
            receding: DVec2::new(3.0, 0.0),
            longest_squared: 1.0,
            area: 1.0,
        };
        let offset = |x: f64| footprint.offset(footprint.inverse(), DVec2::new(x, 0.0));
        // An offset of -1/3 in the source is on the plane of the camera's centre: all positions before it are below 1/3.
        assert!(offset(0.34).is_none());
        let (affine, there) = offset(0.3).unwrap();
        assert!(affine == DVec2::new(0.3, 0.0) && (there.x - 3.0).abs() < 1e-12);
        assert!(offset(f64::NAN).is_none());
    }
}
