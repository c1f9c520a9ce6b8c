//! The seam between the pixels that the photo shows of a surface and the filling of the rest: a smooth factor
//! on the filling makes the two match there. The gradients of the filling remain, its level is adapted to the
//! photo (Perez, Gangnet and Blake, *Poisson Image Editing*, 2003, in the form of a membrane over logarithms,
//! see [`super::push_pull`]). Pixels of the photo never change.

use super::cells::{RegionCells, SmoothField};
use quadratura_base::raster::robust::upper_median;

/// The deviation from the median difference, as a natural logarithm, at which a difference loses most of its
/// weight: it is then not due to light but to an object that the model lacks, in front of one of the two.
const STRAY: f32 = 0.25;

/// The largest factor on the filling in either direction, as a natural logarithm.
const MOST: f32 = 1.0;

/// Computes the logarithm of the factor on the filling from differences: the index of a cell, and the
/// logarithm of the photo over the filling there. Returns `None` when there is no difference.
pub fn seam(cells: &RegionCells, differences: &[(usize, [f32; 3])]) -> Option<SmoothField> {
    if differences.is_empty() {
        return None;
    }
    let usual = [0, 1, 2].map(|c| {
        let mut values: Vec<f32> = differences.iter().map(|(_, value)| value[c]).collect();
        upper_median(&mut values).expect("there is a difference at least")
    });
    cells.propagated(differences.iter().map(|(index, value)| {
        let off = (0..3).map(|c| (value[c] - usual[c]).abs()).fold(0.0, f32::max);
        let weight = 1.0 / (1.0 + (off / STRAY).powi(2)).powi(2);
        (*index, value.map(|v| v.clamp(-MOST, MOST)), weight)
    }))
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::LayerIndex;
    use crate::content::PixelSpan;
    use crate::fill::{FillSurfaceId, HiddenSpan, Region};
    use quadratura_base::geometry::PixelRect;

    #[test]
    fn the_factor_leads_from_one_side_to_the_other_and_a_stray_has_little_say() {
        let span = |y: u32| HiddenSpan {
            span: PixelSpan { y, x0: 40, x1: 80 },
            layer: LayerIndex(0),
            first: (y - 20) * 40,
        };
        let region = Region { surface: FillSurfaceId(0), spans: (20..60).map(span).collect() };
        let cells = RegionCells::around(&region, PixelRect::of_size(200, 100));
        let outside: Vec<(usize, DVec2)> =
            cells.near().filter(|(_, px)| px.x < 38.0 || px.x > 82.0).collect();
        let differences: Vec<(usize, [f32; 3])> = outside
            .iter()
            .enumerate()
            .map(|(i, (index, px))| {
                let value = if px.x < 60.0 { 0.1 } else { -0.1 };
                (*index, [if i == 7 { 5.0 } else { value }; 3])
            })
            .collect();
        let seam = seam(&cells, &differences).unwrap();
        let log = |x: u32| seam.at(x, 40)[0];
        assert!((log(40) - 0.1).abs() < 0.04 && (log(79) + 0.1).abs() < 0.04, "{} {}", log(40), log(79));
        assert!(log(60).abs() < 0.05 && log(50) > log(70));
    }
}
