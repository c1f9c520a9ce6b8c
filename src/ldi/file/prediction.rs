//! What a depth pixel is expected to be from those before it, so that deflate finds little that is new. Both ways compute
//! the same predictions, in f64 and in one order of operations. `docs/formats.md` has the formulas.

use glam::DVec3;

use super::chunk_pixels::Places;
use crate::{LdiSurface, Splat};

/// The planes of the surfaces, at the resolution of a level.
#[derive(Debug, Clone, Copy)]
pub(super) struct LevelPlanes<'a> {
    pub surfaces: &'a [LdiSurface],
    /// The side of a pixel of the level in those of the frame: 2 to the power of the level.
    pub pixel_size: f64,
}

impl LevelPlanes<'_> {
    /// Returns the inverse depth of a surface at the centre of a pixel; `None` where the surface is unknown or that is no
    /// finite number.
    fn at(&self, surface: u16, x: u16, y: u32) -> Option<f32> {
        let DVec3 { x: by_x, y: by_y, z: at_corner } =
            self.surfaces.get(usize::from(surface).checked_sub(1)?)?.nu;
        let x = (f64::from(x) + 0.5) * self.pixel_size;
        let y = (f64::from(y) + 0.5) * self.pixel_size;
        let depth = ((by_x * x + by_y * y) + at_corner) as f32;
        depth.is_finite().then_some(depth)
    }
}

/// Calls `visit` with the index of each depth pixel, its row, and the index of the one before it in the row.
fn each(places: &Places, mut visit: impl FnMut(usize, u32, Option<usize>)) {
    for (y, row) in (places.first_row..).zip(&places.rows) {
        for index in row.clone() {
            visit(index, y, (index > row.start).then(|| index - 1));
        }
    }
}

/// Returns the bytes of 32-bit numbers in planes: all highest bytes, then all of the next, ...
fn to_planes(numbers: &[u32]) -> Vec<u8> {
    [24, 16, 8, 0]
        .iter()
        .flat_map(|shift| numbers.iter().map(move |number| (number >> shift) as u8))
        .collect()
}

/// Returns number `index` of what [`to_planes`] made.
fn from_planes(bytes: &[u8], index: usize) -> u32 {
    let plane = bytes.len() / 4;
    u32::from_be_bytes([0, 1, 2, 3].map(|number| bytes[number * plane + index]))
}

/// Calls `visit` with the index of each depth pixel and the bits that its inverse depth is expected to have, a sum of two
/// parts: those of its plane, and how far the bits of the one before are from those of its own plane, if that is of the same
/// surface. Relief is smooth. Without a plane they are the bits of the one before. `visit` returns the bits that it has.
fn each_depth(
    places: &Places,
    surfaces: &[u16],
    planes: &LevelPlanes,
    mut visit: impl FnMut(usize, u32) -> u32,
) {
    let (mut bits_before, mut off_before) = (0u32, 0u32);
    each(places, |index, y, before| {
        let surface = surfaces[index];
        let plane = planes.at(surface, places.columns[index], y).map(f32::to_bits);
        let same = before.is_some_and(|before| surfaces[before] == surface);
        let expected = match plane {
            Some(plane) => plane.wrapping_add(if same { off_before } else { 0 }),
            None => before.map_or(0, |_| bits_before),
        };
        bits_before = visit(index, expected);
        off_before = plane.map_or(0, |plane| bits_before.wrapping_sub(plane));
    });
}

/// Returns the stream of inverse depths.
pub(super) fn depth_bytes(
    places: &Places,
    surfaces: &[u16],
    planes: &LevelPlanes,
    depths: &[f32],
) -> Vec<u8> {
    let mut differences = vec![0; depths.len()];
    each_depth(places, surfaces, planes, |index, expected| {
        let bits = depths[index].to_bits();
        differences[index] = bits.wrapping_sub(expected);
        bits
    });
    to_planes(&differences)
}

/// Returns the inverse depths of their stream.
pub(super) fn depths(places: &Places, surfaces: &[u16], planes: &LevelPlanes, bytes: &[u8]) -> Vec<f32> {
    let mut depths = vec![0f32; surfaces.len()];
    each_depth(places, surfaces, planes, |index, expected| {
        let bits = from_planes(bytes, index).wrapping_add(expected);
        depths[index] = f32::from_bits(bits);
        bits
    });
    depths
}

/// Calls `visit` with the index of each depth pixel and that of the one whose colour it is expected to have: the same
/// surface's in the same column of the row above, else the one before it in the row.
fn each_colour(places: &Places, surfaces: &[u16], mut visit: impl FnMut(usize, Option<usize>)) {
    let mut above: std::ops::Range<usize> = 0..0;
    for row in &places.rows {
        let mut cursor = above.start;
        for index in row.clone() {
            let column = places.columns[index];
            while cursor < above.end && places.columns[cursor] < column {
                cursor += 1;
            }
            let mut same_column = (cursor..above.end).take_while(|other| places.columns[*other] == column);
            let expected = same_column.find(|other| surfaces[*other] == surfaces[index]);
            visit(index, expected.or((index > row.start).then(|| index.wrapping_sub(1))));
        }
        above = row.clone();
    }
}

/// Returns the stream of colours. Red and blue change as green does, so their differences are stored without green's.
pub(super) fn colour_bytes(places: &Places, surfaces: &[u16], colours: &[[u8; 4]]) -> Vec<u8> {
    let mut differences = vec![0; colours.len()];
    each_colour(places, surfaces, |index, expected| {
        let expected = expected.map_or([0; 4], |expected| colours[expected]);
        let [r, g, b, a] =
            [0, 1, 2, 3].map(|channel| colours[index][channel].wrapping_sub(expected[channel]));
        differences[index] = u32::from_be_bytes([r.wrapping_sub(g), g, b.wrapping_sub(g), a]);
    });
    to_planes(&differences)
}

/// Returns the colours of their stream.
pub(super) fn colours(places: &Places, surfaces: &[u16], bytes: &[u8]) -> Vec<[u8; 4]> {
    let mut colours = vec![[0; 4]; surfaces.len()];
    each_colour(places, surfaces, |index, expected| {
        let expected: [u8; 4] = expected.map_or([0; 4], |expected| colours[expected]);
        let [r, g, b, a] = from_planes(bytes, index).to_be_bytes();
        let difference = [r.wrapping_add(g), g, b.wrapping_add(g), a];
        colours[index] = [0, 1, 2, 3].map(|channel| difference[channel].wrapping_add(expected[channel]));
    });
    colours
}

/// Returns the stream of surfaces: all high bytes, then all low ones.
pub(super) fn surface_bytes(places: &Places, surfaces: &[u16]) -> Vec<u8> {
    let mut bytes = vec![0; 2 * surfaces.len()];
    let (high, low) = bytes.split_at_mut(surfaces.len());
    each(places, |index, _, before| {
        let difference = surfaces[index].wrapping_sub(before.map_or(0, |before| surfaces[before]));
        [high[index], low[index]] = difference.to_be_bytes();
    });
    bytes
}

/// Returns the surfaces of their stream.
pub(super) fn surfaces(places: &Places, bytes: &[u8]) -> Vec<u16> {
    let (high, low) = bytes.split_at(bytes.len() / 2);
    let mut surfaces = vec![0u16; low.len()];
    each(places, |index, _, before| {
        let expected = before.map_or(0, |before| surfaces[before]);
        surfaces[index] = u16::from_be_bytes([high[index], low[index]]).wrapping_add(expected);
    });
    surfaces
}

/// Returns the stream of splat indices.
pub(super) fn splat_bytes(places: &Places, splats: &[Splat]) -> Vec<u8> {
    let mut bytes = vec![0; splats.len()];
    each(places, |index, _, before| {
        bytes[index] = splats[index].0.wrapping_sub(before.map_or(0, |before| splats[before].0));
    });
    bytes
}

/// Returns the splat indices of their stream.
pub(super) fn splats(places: &Places, bytes: &[u8]) -> Vec<Splat> {
    let mut splats = vec![Splat(0); bytes.len()];
    each(places, |index, _, before| {
        let expected = before.map_or(0, |before| splats[before].0);
        splats[index] = Splat(bytes[index].wrapping_add(expected));
    });
    splats
}
