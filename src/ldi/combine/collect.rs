//! The samples of a source in the pixels of the common camera.

use glam::{DMat3, DVec2, DVec3};

use crate::ldi::layout::{DepthPixel, DepthPixelOrigin, LdiSurface, Level, Splat};
use crate::ldi::merge::Sample;
use crate::ldi::splat::{Canvas, Dot};
use crate::ldi::transfer::Transfer;
use crate::projection::srgb::Srgb;

/// The length of the longest side of a source pixel in the common camera that is sampled without gaps, in pixels. There are about
/// as many samples as pixels that the source covers.
const LONGEST: f64 = 32.0;
/// How much longer than a pixel of the common camera the side of a source pixel may be to give one sample: the same camera
/// gives 1 with a rounding error.
const ONE_PIXEL: f64 = 1.001;
/// The share by which inverse depths of neighbours of an unknown surface may differ to be on one plane.
const SAME_SURFACE: f64 = 0.03;

/// A source as it is warped into the common camera.
pub struct Collected<'a> {
    /// The level of the source that is warped.
    pub level: &'a Level,
    /// The source's surfaces.
    pub surfaces: &'a [LdiSurface],
    /// The side of a pixel of the level, in pixels of the source's frame, in which the surfaces' planes are.
    pub pixel_size: f64,
    /// The number that its samples carry.
    pub source: u16,
    /// The number of each of its surfaces in the common list.
    pub numbers: &'a [u16],
    /// The transfer of the level to the common camera.
    pub transfer: Transfer,
    /// Stored values at the common exposure by stored value: R, G, B.
    pub exposed: &'a [[u8; 256]; 3],
    /// Whether it is the reference camera's own photo.
    pub is_own: bool,
    /// Whether each source pixel gives one sample, however large it is in the common camera.
    pub single: bool,
}

/// A band of the common camera in which samples are collected: the index of the pixel in the band, and the sample.
pub struct CollectCanvas<'a> {
    of: &'a Collected<'a>,
    size: [u32; 2],
    top: f64,
    /// The inverse of A, which takes a position of what is infinitely far away back to the source.
    from_infinity: DMat3,
    /// The samples in no particular order.
    pub samples: Vec<(u32, Sample)>,
}

impl<'a> CollectCanvas<'a> {
    /// Makes a band of `rows` rows from row `top` on, which goes on with the samples of other sources.
    pub fn new(of: &'a Collected, width: u32, rows: u32, top: u32, samples: Vec<(u32, Sample)>) -> Self {
        let from_infinity = of.transfer.a.inverse();
        Self { of, size: [width, rows], top: f64::from(top), from_infinity, samples }
    }

    /// Returns the index of the pixel at a position of the band; `None` outside.
    fn pixel(&self, u: f64, v: f64) -> Option<u32> {
        let [width, rows] = self.size;
        let within = u >= 0.0 && u < f64::from(width) && v >= 0.0 && v < f64::from(rows);
        within.then(|| v as u32 * width + u as u32)
    }

    fn add(&mut self, pixel: u32, (dot, longest): (&Dot, f64), (inverse_depth, colour): (f32, [u8; 4])) {
        let Collected { level, numbers, exposed, .. } = self.of;
        let [r, g, b, a] = colour;
        let stored = |c: usize, byte: u8| exposed[c][usize::from(byte)];
        let [r, g, b] = [stored(0, r), stored(1, g), stored(2, b)];
        let origin = match level.splats[dot.index].origin() {
            DepthPixelOrigin::Photo if !self.of.is_own => DepthPixelOrigin::OtherPhotos,
            origin => origin,
        };
        let pixel_of_camera = DepthPixel {
            inverse_depth,
            colour: [r, g, b, a],
            surface: numbers[usize::from(level.surfaces[dot.index])],
            splat: Splat::new(0, origin),
        };
        // A source counts by the pixel's area that its sample stands for, and less where it resolves less in either direction.
        let area = f64::from(dot.s * dot.s);
        let weight = area.min(1.0 / (longest * longest)) as f32;
        let sample = Sample {
            pixel: pixel_of_camera,
            source: self.of.source,
            place: dot.index as u32,
            weight: weight.max(f32::MIN_POSITIVE),
            hidden: level.is_hidden(dot.index),
        };
        self.samples.push((pixel, sample));
    }

    /// Returns the lengths of a source pixel's sides in the common camera, along its rows and its columns, in pixels: the columns
    /// of the derivative of H = A + b nu^T, the homography of its plane, (H_i - (u, v) H_3i) / omega.
    fn sides(&self, dot: &Dot) -> [f64; 2] {
        let Collected { level, surfaces, pixel_size, transfer, .. } = self.of;
        let surface = usize::from(level.surfaces[dot.index]).checked_sub(1);
        let slope = surface.map_or(DVec3::ZERO, |surface| *pixel_size * surfaces[surface].nu);
        let (u, v) = (f64::from(dot.u), f64::from(dot.v) + self.top);
        let depth = f64::from(level.inverse_depths[dot.index]);
        let omega = if dot.q > 0.0 {
            depth / f64::from(dot.q)
        } else {
            1.0 / (self.from_infinity * DVec3::new(u, v, 1.0)).z
        };
        let side = |column: DVec3, slope: f64| {
            let moved = column + slope * transfer.b;
            DVec2::new(moved.x - u * moved.z, moved.y - v * moved.z).length() / omega
        };
        [side(transfer.a.x_axis, slope.x), side(transfer.a.y_axis, slope.y)]
    }

    /// Adds several samples of a source pixel that is larger than a pixel of the common camera, on its plane.
    fn add_many(&mut self, dot: &Dot, [columns, rows]: [u32; 2], longest: f64) {
        let around = Neighbourhood::new(self.of, dot.index);
        let offset = |k: u32, count: u32| (f64::from(k) + 0.5) / f64::from(count) - 0.5;
        for i in 0..columns * rows {
            let by = DVec2::new(offset(i % columns, columns), offset(i / columns, rows));
            let inverse_depth = (around.inverse_depth + around.gradient.dot(by)).max(0.0);
            let Some((position, omega)) = self.of.transfer.position(around.centre + by, inverse_depth) else {
                continue;
            };
            let Some(pixel) = self.pixel(position.x, position.y - self.top) else { continue };
            let there = (inverse_depth / omega) as f32;
            self.add(pixel, (dot, longest), (there, around.colour(by)));
        }
    }
}

impl Canvas for CollectCanvas<'_> {
    const SPACED: bool = true;
    const REACH: f32 = 0.5 * LONGEST as f32;

    fn reach(_largest_spacing: f32) -> f32 {
        // Also a pixel of little area may be long.
        Self::REACH
    }

    fn draw(&mut self, dot: &Dot) {
        let sides = if self.of.single { [f64::from(dot.s); 2] } else { self.sides(dot) };
        let longest = sides[0].max(sides[1]);
        if !self.of.single && longest > ONE_PIXEL {
            self.add_many(dot, samples(sides), longest);
        } else if let Some(pixel) = self.pixel(f64::from(dot.u), f64::from(dot.v)) {
            self.add(pixel, (dot, longest), (dot.q, dot.colour));
        }
    }
}

/// Returns how many samples of a source pixel with sides of these lengths are taken along its rows and its columns, so that they
/// are no farther apart than pixels of the common camera.
fn samples(sides: [f64; 2]) -> [u32; 2] {
    sides.map(|side| (side.min(LONGEST) / ONE_PIXEL).ceil().max(1.0) as u32)
}

/// A source pixel with the neighbours of its surface.
struct Neighbourhood {
    centre: DVec2,
    inverse_depth: f64,
    /// The change of inverse depth a pixel.
    gradient: DVec2,
    /// Colours of the 3 x 3 pixels around it, row by row; those of other surfaces have its own.
    colours: [[u8; 4]; 9],
}

impl Neighbourhood {
    fn new(of: &Collected, index: usize) -> Self {
        let level = of.level;
        let x = u32::from(level.columns[index]);
        let y = level.rows.partition_point(|first| *first as usize <= index) as u32 - 1;
        let own = level.pixel(index);
        let here = f64::from(own.inverse_depth);
        let nu =
            usize::from(own.surface).checked_sub(1).map(|surface| of.pixel_size * of.surfaces[surface].nu);
        let slope = nu.map_or(DVec2::ZERO, DVec3::truncate);
        let mut colours = [own.colour; 9];
        let mut beside: [Option<f64>; 9] = [None; 9];
        for (i, (colour, depth)) in colours.iter_mut().zip(&mut beside).enumerate().filter(|(i, _)| *i != 4) {
            let by = [i as i64 % 3 - 1, i as i64 / 3 - 1];
            let [at_x, at_y] = [i64::from(x) + by[0], i64::from(y) + by[1]];
            let within = (0..i64::from(level.camera.width)).contains(&at_x)
                && (0..i64::from(level.camera.height)).contains(&at_y);
            if !within {
                continue;
            }
            let expected = here + slope.dot(DVec2::new(by[0] as f64, by[1] as f64));
            let is_same = |other: &usize| {
                let depth = f64::from(level.inverse_depths[*other]);
                level.surfaces[*other] == own.surface && (depth - expected).abs() <= SAME_SURFACE * here
            };
            if let Some(other) = level.at(at_x as u32, at_y as u32).find(is_same) {
                *colour = level.colours[other];
                *depth = Some(f64::from(level.inverse_depths[other]));
            }
        }
        let gradient = match nu {
            Some(_) => slope,
            None => DVec2::new(
                slope_between(beside[3], here, beside[5]),
                slope_between(beside[1], here, beside[7]),
            ),
        };
        let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        Self { centre, inverse_depth: here, gradient, colours }
    }

    /// Interpolates the colour at an offset of up to half a pixel, in linear light.
    fn colour(&self, by: DVec2) -> [u8; 4] {
        let srgb = Srgb::tables();
        let (dx, dy) = (if by.x < 0.0 { -1i64 } else { 1 }, if by.y < 0.0 { -1i64 } else { 1 });
        let (sx, sy) = (by.x.abs(), by.y.abs());
        let corners = [
            (0, 0, (1.0 - sx) * (1.0 - sy)),
            (dx, 0, sx * (1.0 - sy)),
            (0, dy, (1.0 - sx) * sy),
            (dx, dy, sx * sy),
        ];
        let (mut light, mut opacity) = ([0.0f64; 3], 0.0);
        for (x, y, weight) in corners {
            let [r, g, b, a] = self.colours[((y + 1) * 3 + x + 1) as usize];
            let seen = weight * f64::from(a);
            light[0] += seen * f64::from(srgb.linear(r));
            light[1] += seen * f64::from(srgb.linear(g));
            light[2] += seen * f64::from(srgb.linear(b));
            opacity += seen;
        }
        let opaque = f64::max(opacity, f64::MIN_POSITIVE);
        let [r, g, b] = [light[0] / opaque, light[1] / opaque, light[2] / opaque];
        let [r, g, b] = [srgb.encoded(r as f32), srgb.encoded(g as f32), srgb.encoded(b as f32)];
        [r, g, b, opacity.round() as u8]
    }
}

/// Returns the change of a value from pixel to pixel where both neighbours, one or none are known: the smaller change, since
/// the larger one may be an edge.
fn slope_between(before: Option<f64>, here: f64, after: Option<f64>) -> f64 {
    match (before.map(|before| here - before), after.map(|after| after - here)) {
        (Some(a), Some(b)) => {
            if a.abs() < b.abs() {
                a
            } else {
                b
            }
        }
        (one, other) => one.or(other).unwrap_or(0.0),
    }
}
