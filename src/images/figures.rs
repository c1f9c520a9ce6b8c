//! The surfaces that the depth pixels of a stack name.

use rayon::prelude::*;

use super::cover::FoundPixel;
use super::planes::SurfacePlane;
use quadratura_ldi::finish::Row;
use quadratura_ldi::layout::MOST_SURFACES;
use quadratura_ldi::{DepthPixel, LdiSurface, Splat};

/// Stands for the number of a plane where a depth pixel is on none.
pub const UNKNOWN_PLANE: u32 = u32::MAX;

/// Depth pixels with the surfaces that they name.
pub struct Named {
    /// The surfaces in the order of the planes.
    pub surfaces: Vec<LdiSurface>,
    /// The rows of depth pixels.
    pub rows: Vec<Row>,
    /// How many surfaces have no number, because there are too many.
    pub unknown: u64,
}

/// Numbers the surfaces of the planes that have depth pixels. Where there are too many, those with the fewest are unknown.
pub fn named(planes: &[SurfacePlane], rows: Vec<Vec<FoundPixel>>) -> Named {
    let mut pixels = vec![0u64; planes.len()];
    let named = rows.iter().flatten().filter(|found| found.plane != UNKNOWN_PLANE);
    named.for_each(|found| pixels[found.plane as usize] += 1);
    let mut used: Vec<usize> = (0..planes.len()).filter(|&plane| pixels[plane] > 0).collect();
    let unknown = used.len().saturating_sub(MOST_SURFACES);
    if unknown > 0 {
        used.sort_by_key(|&plane| (std::cmp::Reverse(pixels[plane]), plane));
        used.truncate(MOST_SURFACES);
        used.sort_unstable();
    }
    let mut numbers = vec![0; planes.len()];
    used.iter().zip(1..).for_each(|(&plane, number)| numbers[plane] = number);
    let surfaces = used.iter().map(|&plane| planes[plane].surface()).collect();
    let pixel = |found: FoundPixel| {
        let pixel = DepthPixel {
            inverse_depth: found.inverse_depth,
            colour: found.colour,
            surface: numbers.get(found.plane as usize).copied().unwrap_or(0),
            splat: Splat::new(0, found.origin),
        };
        (found.column, pixel)
    };
    let rows = rows.into_par_iter().map(|row| row.into_iter().map(pixel).collect()).collect();
    Named { surfaces, rows, unknown: unknown as u64 }
}
