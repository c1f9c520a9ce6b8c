//! The occluded parts of a photo's image layers, surface by surface, as spans of photo pixels.

use std::collections::BTreeMap;

use glam::DVec3;

use super::surfaces::FillSurfaceId;
use crate::LayerIndex;
use crate::content::PixelSpan;
use crate::projected_model::{ProjectedModel, clip_from_camera};
use crate::software::TriangleFootprint;
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};

/// A span of occluded pixels of a row, in one image layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct HiddenSpan {
    /// The pixels, in photo coordinates.
    pub span: PixelSpan,
    /// Index of the image layer in the stack.
    pub layer: LayerIndex,
    /// Index of the span's first texel among the texels of the region.
    pub first: u32,
}

/// The occluded texels of one surface.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Region {
    /// The surface.
    pub surface: FillSurfaceId,
    /// The spans, rising by row and column.
    pub spans: Vec<HiddenSpan>,
}

impl Region {
    /// Returns the number of texels.
    pub fn texels(&self) -> usize {
        self.spans.last().map_or(0, |last| (last.first + last.span.x1 - last.span.x0) as usize)
    }

    /// Iterates over the texels as (column, row), in the order of the spans.
    pub fn pixels(&self) -> impl Iterator<Item = (u32, u32)> + Clone {
        self.spans.iter().flat_map(|s| (s.span.x0..s.span.x1).map(move |x| (x, s.span.y)))
    }

    /// Returns the region of only those texels, given by their index, for which `keep` is true; `None` where
    /// there is none.
    pub fn part(&self, keep: impl Fn(usize) -> bool) -> Option<Self> {
        let mut spans: Vec<HiddenSpan> = Vec::new();
        let mut first = 0;
        for whole in &self.spans {
            let kept = |x: &u32| keep((whole.first + x - whole.span.x0) as usize);
            let mut x0 = whole.span.x0;
            while let Some(from) = (x0..whole.span.x1).find(|x| kept(x)) {
                x0 = (from..whole.span.x1).find(|x| !kept(x)).unwrap_or(whole.span.x1);
                spans.push(HiddenSpan {
                    span: PixelSpan { x0: from, x1: x0, ..whole.span },
                    first,
                    ..*whole
                });
                first += x0 - from;
            }
        }
        (!spans.is_empty()).then_some(Self { surface: self.surface, spans })
    }

    /// Returns the bounding box of the spans.
    pub fn rect(&self) -> PixelRect {
        let of_span = |s: &HiddenSpan| {
            PixelRect::from_edges(s.span.x0 as i32, s.span.y as i32, s.span.x1 as i32, s.span.y as i32 + 1)
        };
        self.spans.iter().map(of_span).reduce(|a, b| a.union(&b)).expect("a region holds a span at least")
    }
}

/// A builder of regions, to which occluded pixels are added image layer by image layer.
#[derive(Debug, Default)]
pub struct Regions {
    of_surface: BTreeMap<FillSurfaceId, Vec<(PixelSpan, LayerIndex)>>,
}

impl Regions {
    /// Adds the occluded pixels of an image layer. `surfaces` and `hidden` hold one value per pixel of
    /// `rect`, row by row. An occluded pixel without a surface takes that of its neighbour, because the
    /// outlines of different rasterisers may differ by a pixel.
    pub fn add(
        &mut self,
        layer: LayerIndex,
        rect: PixelRect,
        surfaces: &[Option<FillSurfaceId>],
        hidden: &[bool],
    ) {
        let width = rect.w as usize;
        for (row, y) in (rect.y..rect.bottom()).enumerate() {
            let columns = row * width..(row + 1) * width;
            let surface_of_hidden = surface_of_hidden(&surfaces[columns.clone()], &hidden[columns]);
            let mut x = 0;
            while x < width {
                let Some(surface) = surface_of_hidden[x] else {
                    x += 1;
                    continue;
                };
                let end = (x..width).find(|&x| surface_of_hidden[x] != Some(surface)).unwrap_or(width);
                let [x0, x1] = [x, end].map(|x| (rect.x + x as i32) as u32);
                let spans = self.of_surface.entry(surface).or_default();
                spans.push((PixelSpan { y: y as u32, x0, x1 }, layer));
                x = end;
            }
        }
    }

    /// Returns the regions, one per surface.
    pub fn finish(self) -> Vec<Region> {
        let region = |(surface, mut spans): (FillSurfaceId, Vec<(PixelSpan, LayerIndex)>)| {
            spans.sort_unstable();
            let mut first = 0;
            let counted = spans.into_iter().map(|(span, layer)| {
                let counted = HiddenSpan { span, layer, first };
                first += span.x1 - span.x0;
                counted
            });
            Region { surface, spans: counted.collect() }
        };
        self.of_surface.into_iter().map(region).collect()
    }
}

/// Returns the surface of each occluded pixel of a row; `None` where the pixel is not occluded, or the row
/// has no surface.
fn surface_of_hidden(surfaces: &[Option<FillSurfaceId>], hidden: &[bool]) -> Vec<Option<FillSurfaceId>> {
    let mut last = surfaces.iter().zip(hidden).find_map(|(surface, hidden)| surface.filter(|_| *hidden));
    let name = |(surface, hidden): (&Option<FillSurfaceId>, &bool)| {
        last = surface.or(last);
        last.filter(|_| *hidden)
    };
    surfaces.iter().zip(hidden).map(name).collect()
}

/// The footprint of an outline that an image layer holds: a whole surface, or a piece of one.
pub struct RegionShape {
    /// The surface that the outline belongs to.
    pub surface: FillSurfaceId,
    footprints: Vec<TriangleFootprint>,
}

impl RegionShape {
    /// Builds the shape of a whole item of a view.
    pub fn of_item(surface: FillSurfaceId, view: &ProjectedModel, item: u32) -> Self {
        let first = view.triangle_items.partition_point(|i| *i < item);
        let of_item = view.triangle_items[first..].iter().take_while(|i| **i == item);
        let corners = of_item.zip(&view.corners[first..]).map(|(_, corners)| *corners);
        Self { surface, footprints: footprints(corners, view) }
    }

    /// Builds the shape of triangles in world coordinates.
    pub fn from_triangles(
        surface: FillSurfaceId,
        triangles: &[[DVec3; 3]],
        camera: &Pinhole,
        pose: &Pose,
        view: &ProjectedModel,
    ) -> Self {
        let clip = |corner: DVec3| clip_from_camera(pose.camera_from_world(corner), camera);
        Self { surface, footprints: footprints(triangles.iter().map(|t| t.map(clip)), view) }
    }
}

fn footprints(corners: impl Iterator<Item = [[f32; 3]; 3]>, view: &ProjectedModel) -> Vec<TriangleFootprint> {
    corners.filter_map(|corners| TriangleFootprint::new(&corners, view.width, view.height)).collect()
}

/// Returns the surface at each pixel of `rect`, row by row: that of the last shape that covers the pixel.
pub fn painted(shapes: &[RegionShape], rect: PixelRect) -> Vec<Option<FillSurfaceId>> {
    let mut painted = vec![None; rect.area() as usize];
    for shape in shapes {
        for footprint in &shape.footprints {
            let rows = footprint.rows();
            for y in (rows.start as i32).max(rect.y)..(rows.end as i32).min(rect.bottom()) {
                let columns = footprint.columns(y as u32);
                let [x0, x1] = [columns.start, columns.end]
                    .map(|x| (x as i32).clamp(rect.x, rect.right()) as usize - rect.x as usize);
                let row = (y - rect.y) as usize * rect.w as usize;
                painted[row + x0..row + x1.max(x0)].fill(Some(shape.surface));
            }
        }
    }
    painted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_pixels_become_spans_by_surface_and_those_without_one_take_their_neighbours() {
        let rect = PixelRect { x: 10, y: 5, w: 6, h: 1 };
        let [a, b] = [0, 1].map(|id| Some(FillSurfaceId(id)));
        let mut regions = Regions::default();
        let hidden = [true, true, false, true, true, true];
        regions.add(LayerIndex(3), rect, &[None, a, a, a, b, None], &hidden);
        let found = regions.finish();
        let spans: Vec<_> = found
            .iter()
            .flat_map(|r| r.spans.iter().map(|s| (r.surface.0, s.span.x0, s.span.x1, s.layer.0, s.first)))
            .collect();
        assert_eq!(spans, [(0, 10, 12, 3, 0), (0, 13, 14, 3, 2), (1, 14, 16, 3, 0)]);
        assert_eq!(found[0].texels(), 3);
        assert_eq!(found[0].rect(), PixelRect { x: 10, y: 5, w: 4, h: 1 });
        assert_eq!(found[0].pixels().map(|(x, _)| x).collect::<Vec<_>>(), [10, 11, 13]);
        let part = found[0].part(|index| index != 1).unwrap();
        let spans: Vec<_> = part.spans.iter().map(|s| (s.span.x0, s.span.x1, s.layer.0, s.first)).collect();
        assert_eq!(spans, [(10, 11, 3, 0), (13, 14, 3, 1)]);
        assert_eq!(found[0].part(|_| false), None);
    }
}
