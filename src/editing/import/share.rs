//! Assignment of paint to surfaces: every painted pixel belongs to the surfaces that cover it in its image layer,
//! and paint outside of all outlines belongs to the nearest surface.

use std::collections::VecDeque;

use super::settle::SurfacePaint;
use quadratura_base::geometry::PixelRect;
use quadratura_base::raster::Image;
use quadratura_document::paint::{PaintColour, PaintPatch};
use quadratura_stacks::paint::parts::LayerParts;

/// The paint of one surface of an image layer.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceShare {
    /// The index among the layer's parts; for a surface in several pieces, that of the first one.
    pub part: usize,
    /// Whether the paint is outside of all outlines.
    pub beyond: bool,
    /// The paint.
    pub patch: PaintPatch,
}

/// Divides the paint of an image layer among its surfaces, as [`shared`] assigns it.
pub fn by_surface(paint: &PaintPatch, parts: &LayerParts) -> Vec<SurfacePaint> {
    let on_surface = |share: SurfaceShare| {
        let part = &parts.list[share.part];
        SurfacePaint {
            object: part.object.to_owned(),
            face: part.face,
            triangle: part.triangle,
            beyond: share.beyond,
            outline: part.outline.to_vec(),
            patch: share.patch,
        }
    };
    shared(paint, parts).into_iter().map(on_surface).collect()
}

/// Assigns the paint of an image layer to surfaces. Coplanar surfaces that cover the same pixel all get it, so that
/// it is visible whichever of them is drawn there.
pub fn shared(paint: &PaintPatch, parts: &LayerParts) -> Vec<SurfaceShare> {
    let mut shares = Vec::new();
    for (index, part) in parts.list.iter().enumerate() {
        let same = |other: &usize| {
            let other = &parts.list[*other];
            other.object == part.object && other.face == part.face && other.triangle == part.triangle
        };
        if (0..index).any(|other| same(&other)) {
            continue;
        }
        let pieces: Vec<usize> = (index..parts.list.len()).filter(same).collect();
        let covers = |x, y| pieces.iter().any(|&piece| parts.covered(&parts.list[piece]).holds(x, y));
        let patch = paint.picked(|x, y, _| covers(x, y));
        if !patch.is_empty() {
            shares.push(SurfaceShare { part: index, beyond: false, patch });
        }
    }
    let past = paint.picked(|x, y, _| parts.at(x, y).next().is_none());
    shares.extend(by_nearest(&past, parts));
    shares
}

/// Assigns paint outside of all outlines to the surface that is the fewest steps away.
fn by_nearest(past: &PaintPatch, parts: &LayerParts) -> Vec<SurfaceShare> {
    if past.is_empty() || parts.list.is_empty() {
        return Vec::new();
    }
    let nearest = NearestParts::around(past.rect(), parts);
    let mut pixels: Vec<Vec<(i32, i32, PaintColour)>> = vec![Vec::new(); parts.list.len()];
    past.iter().for_each(|(x, y, colour)| pixels[nearest.at(x, y)].push((x, y, colour)));
    let share = |(part, pixels): (usize, Vec<_>)| SurfaceShare {
        part,
        beyond: true,
        patch: PaintPatch::of_pixels(&pixels),
    };
    pixels.into_iter().enumerate().filter(|(_, pixels)| !pixels.is_empty()).map(share).collect()
}

/// The nearest part for each pixel of a rectangle, by the number of steps.
struct NearestParts {
    part: Image<u32>,
}

/// Marks a pixel without a part.
const NO_PART: u32 = u32::MAX;

impl NearestParts {
    /// Finds the nearest parts around and within the bounds of all parts.
    fn around(past: PixelRect, parts: &LayerParts) -> Self {
        let bounds = parts.list.iter().map(|part| parts.covered(part).bounds()).filter(|b| !b.is_empty());
        let rect = bounds.reduce(|a, b| a.union(&b)).map_or(past, |bounds| bounds.union(&past));
        let mut nearest = Self { part: Image::filled(rect, NO_PART) };
        for (index, part) in parts.list.iter().enumerate() {
            for (y, run) in parts.covered(part).iter() {
                let first = rect.offset(run.start, y);
                nearest.part.pixels_mut()[first..first + run.len()].fill(index as u32);
            }
        }
        nearest.propagate();
        nearest
    }

    /// Propagates part indices from all covered pixels at once (a breadth-first search).
    fn propagate(&mut self) {
        let covered = self.part.iter().filter(|(_, part)| **part != NO_PART);
        let mut front: VecDeque<(i32, i32)> = covered.map(|(position, _)| position).collect();
        while let Some((x, y)) = front.pop_front() {
            let part = *self.part.get(x, y).expect("only pixels of the rectangle are in the queue");
            for (x, y) in [(x, y - 1), (x - 1, y), (x + 1, y), (x, y + 1)] {
                if let Some(next) = self.part.get_mut(x, y).filter(|next| **next == NO_PART) {
                    *next = part;
                    front.push_back((x, y));
                }
            }
        }
    }

    /// Returns the nearest part of a pixel; the first part, if none covers any pixel.
    fn at(&self, x: i32, y: i32) -> usize {
        let part = self.part.get(x, y).filter(|part| **part != NO_PART);
        part.map_or(0, |part| *part as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::FaceIndex;
    use quadratura_document::Element;
    use quadratura_document::stack::{StackCamera, StackPhoto, StackSurface};
    use quadratura_stacks::paint::parts::PartSource;

    /// Makes squares of 4 x 4 pixels at these columns.
    fn with_parts(columns: &[f64], test: impl Fn(&LayerParts)) {
        let photo = StackPhoto { name: "a".into(), width: 30, height: 8 };
        let camera = StackCamera {
            K: [[10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 1.0]],
            R: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            t: [0.0; 3],
        };
        let square = |(face, x): (FaceIndex, &f64)| StackSurface {
            object: "o".into(),
            face,
            triangle: None,
            outline: [(0.0, 0.0), (0.0, 4.0), (4.0, 4.0), (4.0, 0.0)]
                .map(|(dx, dy)| [x + dx, dy, 10.0])
                .to_vec(),
        };
        let surfaces: Vec<StackSurface> = FaceIndex::all(columns.len()).zip(columns).map(square).collect();
        let scenery = PartSource { photo: &photo, camera: &camera, surfaces: &surfaces, pieces: &[] };
        let faces = FaceIndex::all(columns.len()).collect();
        let element =
            Element { object: "o".into(), faces, pieces: vec![], back: vec![], ..Element::default() };
        test(&scenery.parts(&[(&element, None)], PixelRect::of_size(16, 8)));
    }

    fn paint(pixels: &[(i32, i32)]) -> PaintPatch {
        PaintPatch::of_pixels(&pixels.iter().map(|&(x, y)| (x, y, [257; 4])).collect::<Vec<_>>())
    }

    fn summary(paint: &PaintPatch, parts: &LayerParts) -> Vec<(usize, bool, u64)> {
        shared(paint, parts).iter().map(|share| (share.part, share.beyond, share.patch.count())).collect()
    }

    #[test]
    fn a_pixel_goes_to_every_surface_that_covers_it() {
        with_parts(&[0.0, 2.0], |parts| {
            let found = summary(&paint(&[(0, 0), (3, 1), (5, 2)]), parts);
            assert_eq!(found, [(0, false, 2), (1, false, 2)]);
        });
    }

    #[test]
    fn what_is_past_all_outlines_goes_to_the_nearest_surface() {
        with_parts(&[0.0, 8.0], |parts| {
            let found = summary(&paint(&[(4, 0), (5, 1), (7, 2), (25, 7)]), parts);
            assert_eq!(found, [(0, true, 2), (1, true, 2)]);
        });
    }

    #[test]
    fn where_nothing_is_covered_the_first_surface_takes_all() {
        with_parts(&[500.0], |parts| {
            assert_eq!(summary(&paint(&[(4, 0)]), parts), [(0, true, 1)]);
            assert!(summary(&paint(&[]), parts).is_empty());
        });
    }
}
