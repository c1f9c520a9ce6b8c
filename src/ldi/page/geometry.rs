//! The meshes of a page as a stream of whole numbers, which the viewer reads in the same order.
//!
//! Seven bits a byte, the lowest first, the eighth tells that more follow; signed ones alternate: 0, -1, 1, -2, 2. A part: 1
//! and the bits of two f32 (least inverse depth, step) where its segment begins, else 0; its atlas; what is added to columns
//! and rows of the frame to get texels; the number of corners; their column, row and inverse depth in steps, each less that
//! of the corner before; the number of triangles; their corners, each less the one before.

use crate::segments::{Segments, TexturedPart};

/// Inverse depths of a segment are whole numbers of steps, from 0 to this: exact to a part in a million of its range.
const STEPS: f64 = (1 << 20) as f64;

/// Returns the meshes as bytes.
pub fn geometry(segments: &Segments) -> Vec<u8> {
    let mut out = Stream::default();
    for group in segments.parts.chunk_by(|a, b| a.segment == b.segment) {
        let depths = DepthSteps::new(group);
        for (i, part) in group.iter().enumerate() {
            out.number(u32::from(i == 0));
            if i == 0 {
                out.number(depths.low.to_bits());
                out.number(depths.step.to_bits());
            }
            out.part(part, &depths);
        }
    }
    out.bytes
}

/// How the inverse depths of a segment are written: the corners that its parts share have the same bits.
struct DepthSteps {
    low: f32,
    step: f32,
}

impl DepthSteps {
    fn new(parts: &[TexturedPart]) -> Self {
        let depths = || parts.iter().flat_map(|part| &part.vertices).map(|vertex| vertex.inverse_depth);
        let (low, high) = (depths().fold(f32::INFINITY, f32::min), depths().fold(0.0, f32::max));
        Self { low, step: (f64::from(high - low) / STEPS) as f32 }
    }

    fn steps(&self, inverse_depth: f32) -> i64 {
        match self.step {
            0.0 => 0,
            step => ((f64::from(inverse_depth) - f64::from(self.low)) / f64::from(step)).round() as i64,
        }
    }
}

#[derive(Default)]
struct Stream {
    bytes: Vec<u8>,
}

impl Stream {
    fn number(&mut self, value: u32) {
        let mut rest = value;
        while rest > 127 {
            self.bytes.push((rest & 127) as u8 | 128);
            rest >>= 7;
        }
        self.bytes.push(rest as u8);
    }

    fn signed(&mut self, value: i64) {
        self.number(if value < 0 { -2 * value - 1 } else { 2 * value } as u32);
    }

    fn part(&mut self, part: &TexturedPart, depths: &DepthSteps) {
        self.number(part.atlas as u32);
        (0..2).for_each(|axis| self.signed(i64::from(part.at[axis]) - i64::from(part.origin[axis])));
        self.number(part.vertices.len() as u32);
        let mut last = [0; 3];
        for vertex in &part.vertices {
            let now = [vertex.x.into(), vertex.y.into(), depths.steps(vertex.inverse_depth)];
            (0..3).for_each(|i| self.signed(now[i] - last[i]));
            last = now;
        }
        self.number(part.triangles.len() as u32);
        let mut last = 0;
        for &corner in part.triangles.as_flattened() {
            self.signed(i64::from(corner) - last);
            last = corner.into();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_take_seven_bits_a_byte_and_signed_ones_alternate() {
        let mut out = Stream::default();
        [0, 127, 128, 300].iter().for_each(|&value| out.number(value));
        assert_eq!(out.bytes, [0, 127, 128, 1, 0xac, 2]);
        let mut out = Stream::default();
        [0, -1, 1, -2, 2].iter().for_each(|&value| out.signed(value));
        assert_eq!(out.bytes, [0, 1, 2, 3, 4]);
    }
}
