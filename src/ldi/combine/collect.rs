//! The samples of a source in the pixels of the common camera.

use glam::{DMat3, DVec2, DVec3};

use super::neighbourhood::Neighbourhood;
use crate::ldi::layout::{DepthPixel, DepthPixelOrigin, Ldi, Level, Splat};
use crate::ldi::merge::Sample;
use crate::ldi::splat::{Canvas, Dot};
use crate::ldi::transfer::Transfer;

/// The length of the longest side of a source pixel in the common camera that is sampled without gaps, in pixels.
const LONGEST: f64 = 32.0;
/// How much longer than a pixel of the common camera the side of a source pixel may be to give one sample: the same camera
/// gives 1 with a rounding error.
const ONE_PIXEL: f64 = 1.001;
/// How far from the middle of a pixel of the common camera a source pixel of the same size may be that is taken for it, in pixels:
/// positions in single precision err by less.
const IN_THE_MIDDLE: f32 = 1e-3;
/// The height of a source pixel over its longer side in the common camera, in pixels, from which on each pixel whose centre it covers
/// has a sample there. Narrower ones would often cover none: they have samples of their own points, which are averaged. Held-out
/// photos of four sites are predicted about as well with 0.3, and worse with 0.7 (docs/quality.md).
const LEAST_HEIGHT: f64 = 0.5;
/// By how much a source pixel counts as larger on each side, in its pixels: relief moves neighbours apart. Nearly all centres still have
/// one sample of a source.
const OVERLAP: f64 = 0.005;

/// A source as it is warped into the common camera.
pub struct Collected<'a> {
    /// The level of the source that is warped.
    level: &'a Level,
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
        (ldi, level): (&'a Ldi, &'a Level),
        source: u16,
        transfer: Transfer,
        (numbers, bytes): (&'a [u16], &'a [[u8; 256]; 3]),
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
    fn sample(&self, dot: &Dot, longest_squared: f64) -> Sample {
        let Collected { level, numbers, source, .. } = self;
        let origin = match level.splats[dot.index].origin() {
            DepthPixelOrigin::Photo if *source != 0 => DepthPixelOrigin::OtherPhotos,
            origin => origin,
        };
        // A source counts by the pixel's area that its sample stands for, and less where it resolves less in either direction.
        let weight = f64::from(dot.s * dot.s).min(1.0 / longest_squared) as f32;
        Sample {
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

/// A band of the common camera in which samples are collected: the index of the pixel in the band, and the sample.
pub struct CollectCanvas<'a> {
    of: &'a Collected<'a>,
    size: [u32; 2],
    top: f64,
    around: Neighbourhood,
    /// The samples in no particular order.
    pub samples: Vec<(u32, Sample)>,
}

impl<'a> CollectCanvas<'a> {
    /// Makes a band of `rows` rows from row `top` on, which goes on with the samples of other sources.
    pub fn new(of: &'a Collected, width: u32, rows: u32, top: u32, samples: Vec<(u32, Sample)>) -> Self {
        Self { of, size: [width, rows], top: f64::from(top), around: Neighbourhood::default(), samples }
    }

    /// Returns the index of the pixel at a position of the band; `None` outside.
    #[inline]
    fn pixel(&self, u: f64, v: f64) -> Option<u32> {
        let [width, rows] = self.size;
        let within = u >= 0.0 && u < f64::from(width) && v >= 0.0 && v < f64::from(rows);
        within.then(|| v as u32 * width + u as u32)
    }

    /// Returns what a source pixel covers in the common camera, where its plane has this gradient.
    #[inline]
    fn footprint(&self, dot: &Dot, gradient: DVec2) -> Footprint {
        let Collected { level, transfer, from_infinity, .. } = self.of;
        let (u, v, q) = (f64::from(dot.u), f64::from(dot.v) + self.top, f64::from(dot.q));
        let per_omega = match q > 0.0 {
            true => q / f64::from(level.inverse_depths[dot.index]),
            false => (*from_infinity * DVec3::new(u, v, 1.0)).z,
        };
        let side = |column: DVec3, slope: f64| {
            let moved = column + slope * transfer.b;
            let along = DVec2::new(moved.x - u * moved.z, moved.y - v * moved.z);
            (per_omega * along, per_omega * (slope - q * moved.z), per_omega * moved.z)
        };
        let (right, q_right, omega_right) = side(transfer.a.x_axis, gradient.x);
        let (down, q_down, omega_down) = side(transfer.a.y_axis, gradient.y);
        Footprint {
            right,
            down,
            gradient: DVec2::new(q_right, q_down),
            receding: DVec2::new(omega_right, omega_down),
            longest_squared: right.length_squared().max(down.length_squared()),
            area: right.perp_dot(down),
        }
    }

    /// Adds a sample for each pixel of the common camera whose centre a source pixel covers.
    fn add_covered(&mut self, dot: &Dot, footprint: &Footprint) {
        let Footprint { right, down, gradient, receding, longest_squared, area } = *footprint;
        let (u, v) = (f64::from(dot.u), f64::from(dot.v));
        let within = 0.5 + OVERLAP;
        // No point of it is farther from the middle than 1 / (1 - x) times as far as without w, which is less than 1 + 2 x up to 1/2.
        let farther = 1.0 + 2.0 * within * (receding.x.abs() + receding.y.abs());
        let [width, height] = self.size;
        let range = |at: f64, sides: f64, end: u32| {
            let reach = (within * farther * sides).min(0.5 * LONGEST);
            (at - reach + 0.5).max(0.0) as u32..(at + reach + 0.5).clamp(0.0, f64::from(end)) as u32
        };
        let rows = range(v, right.y.abs() + down.y.abs(), height);
        let columns = range(u, right.x.abs() + down.x.abs(), width);
        if rows.is_empty() || columns.is_empty() {
            return;
        }
        let per_area = 1.0 / area;
        // The rows of the inverse of J.
        let (to_right, to_down) = (-per_area * down.perp(), per_area * right.perp());
        let (of, mut made) = (self.of, None);
        for row in rows {
            for column in columns.clone() {
                let to = DVec2::new(f64::from(column) + 0.5 - u, f64::from(row) + 0.5 - v);
                // Inverse depths of a plane change as J^-1 does; the offset in the source is J^-1 t / (1 - w . J^-1 t).
                let even = DVec2::new(to_right.dot(to), to_down.dot(to));
                let by = even / (1.0 - receding.dot(even));
                if by.abs().max_element() > within {
                    continue;
                }
                let sample = made.get_or_insert_with(|| {
                    of.look_around(&mut self.around, dot);
                    of.sample(dot, longest_squared)
                });
                let inverse_depth = (f64::from(dot.q) + gradient.dot(even)).max(0.0) as f32;
                let colour = of.exposed(self.around.colour(of.level, by));
                let pixel = DepthPixel { inverse_depth, colour, ..sample.pixel };
                self.samples.push((row * width + column, Sample { pixel, ..*sample }));
            }
        }
    }

    /// Adds several samples of a source pixel, at points of its own, on its plane.
    fn add_many(&mut self, dot: &Dot, footprint: &Footprint) {
        let [columns, rows] = samples(footprint);
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
                let Some(pixel) = self.pixel(position.x, position.y - self.top) else { continue };
                let inverse_depth = (inverse_depth / omega) as f32;
                let colour = of.exposed(self.around.colour(of.level, by));
                let there = DepthPixel { inverse_depth, colour, ..sample.pixel };
                self.samples.push((pixel, Sample { pixel: there, ..sample }));
            }
        }
    }

    /// Adds a sample where the middle of a source pixel is.
    #[inline]
    fn add_middle(&mut self, dot: &Dot, longest_squared: f64) {
        if let Some(pixel) = self.pixel(f64::from(dot.u), f64::from(dot.v)) {
            self.samples.push((pixel, self.of.sample(dot, longest_squared)));
        }
    }
}

/// What a source pixel covers in the common camera: with the offset s from its middle, in its pixels, H moves a point to an offset of
/// J s / (1 + w . s) from its position, where J is the derivative of H and w how omega changes.
#[derive(Debug, Clone, Copy)]
struct Footprint {
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

impl Canvas for CollectCanvas<'_> {
    const SPACED: bool = true;
    const REACH: f32 = 0.5 * LONGEST as f32;

    fn reach(_largest_spacing: f32) -> f32 {
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
        let gradient = slopes[usize::from(level.surfaces[dot.index])].unwrap_or_else(|| {
            self.of.look_around(&mut self.around, dot);
            self.around.gradient
        });
        let footprint = self.footprint(dot, gradient);
        if footprint.is_pixel() && is_middle(dot.u) && is_middle(dot.v) {
            self.add_middle(dot, footprint.longest_squared);
        } else if footprint.is_high() {
            self.add_covered(dot, &footprint);
        } else if footprint.longest_squared > ONE_PIXEL * ONE_PIXEL {
            self.add_many(dot, &footprint);
        } else {
            self.add_middle(dot, footprint.longest_squared);
        }
    }
}

/// Returns whether a position along an axis, which is not negative, is in the middle of a pixel.
#[inline]
fn is_middle(at: f32) -> bool {
    (at - (at as i32) as f32 - 0.5).abs() < IN_THE_MIDDLE
}

impl Footprint {
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
}

/// Returns how many samples of a source pixel are taken along its rows and its columns, so that they are no farther apart than
/// pixels of the common camera.
fn samples(footprint: &Footprint) -> [u32; 2] {
    let of = |side: DVec2| (side.length().min(LONGEST) / ONE_PIXEL).ceil().max(1.0) as u32;
    [of(footprint.right), of(footprint.down)]
}
