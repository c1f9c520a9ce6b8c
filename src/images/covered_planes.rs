//! The surfaces of a stack with the pixels that they cover, arranged by image layer and row.

use super::planes::SurfacePlanes;
use quadratura_base::geometry::{PixelRect, Spans};
use quadratura_document::stack::{Element, Stack};
use quadratura_layers::LayerIndex;
use quadratura_stacks::paint::parts::{LayerParts, PartSource};
use quadratura_stacks::paint::parts_of_layer;

/// A flat surface, or a piece of one; or the surroundings.
#[derive(Debug)]
pub struct CoveredPlane {
    /// The number of its plane.
    pub plane: u32,
    /// The place in the model's order; of level surfaces the last one is shown.
    pub rank: u32,
    /// The pixels that it covers.
    pub covered: Spans,
}

/// The surfaces of an image layer, or the leftovers.
#[derive(Debug)]
pub struct CoveredPlanes {
    /// The surfaces in the model's order.
    pub list: Vec<CoveredPlane>,
    /// The first row of `rows`.
    top: i32,
    /// The surfaces that have pixels in each row, as indices of `list`, ascending.
    rows: Vec<Vec<u32>>,
}

impl CoveredPlanes {
    fn new(parts: &LayerParts, photo: PixelRect, planes: &mut SurfacePlanes) -> Self {
        let mut list = Vec::with_capacity(parts.list.len());
        for part in &parts.list {
            let outline = if part.outline.is_empty() { part.own_outline() } else { part.outline };
            let plane = planes.number(part.object, part.face, part.triangle, outline);
            list.push(CoveredPlane { plane, rank: part.rank as u32, covered: parts.covered(part).clone() });
        }
        let within = |surface: &CoveredPlane| {
            let rows = surface.covered.rows();
            rows.start.max(photo.y)..rows.end.min(photo.bottom())
        };
        let filled = || list.iter().map(within).filter(|rows| !rows.is_empty());
        let top = filled().map(|rows| rows.start).min().unwrap_or(0);
        let bottom = filled().map(|rows| rows.end).max().unwrap_or(0);
        let mut rows = vec![Vec::new(); (bottom - top) as usize];
        for (surface, index) in list.iter().zip(0u32..) {
            within(surface).for_each(|y| rows[(y - top) as usize].push(index));
        }
        Self { list, top, rows }
    }

    /// Returns the surfaces of an image layer.
    pub fn of_layer(stack: &Stack, layer: LayerIndex, planes: &mut SurfacePlanes) -> Self {
        let photo = PixelRect::of_size(stack.photo.width, stack.photo.height);
        Self::new(&parts_of_layer(stack, layer), photo, planes)
    }

    /// Returns the surfaces that are in no image layer, because the photo barely shows them.
    pub fn of_leftovers(stack: &Stack, planes: &mut SurfacePlanes) -> Self {
        let photo = PixelRect::of_size(stack.photo.width, stack.photo.height);
        let left_over = |element: &Element| Element {
            faces: element.leftovers.clone(),
            pieces: element.leftover_pieces.clone(),
            ..element.clone()
        };
        let elements: Vec<Element> = stack
            .visibility_layers
            .iter()
            .flatten()
            .filter(|element| !element.leftovers.is_empty() || !element.leftover_pieces.is_empty())
            .map(left_over)
            .collect();
        let elements: Vec<(&Element, Option<PixelRect>)> =
            elements.iter().map(|element| (element, None)).collect();
        let Stack { photo: name, camera, surfaces, pieces, .. } = stack;
        let scenery = PartSource { photo: name, camera, surfaces, pieces };
        Self::new(&scenery.parts(&elements, photo), photo, planes)
    }

    /// Iterates over the surfaces that have pixels in a row, in the model's order.
    pub fn in_row(&self, y: i32) -> impl Iterator<Item = &CoveredPlane> {
        let row = usize::try_from(y - self.top).ok().and_then(|row| self.rows.get(row));
        row.into_iter().flatten().map(|&index| &self.list[index as usize])
    }

    /// Returns the last surface in the model's order that covers a pixel next to this one, the nearest pixels first. Outlines
    /// are rounded to pixels here and by the rasteriser in other ways, so that a pixel at the rim can be without a surface.
    pub fn beside(&self, x: i32, y: i32) -> Option<&CoveredPlane> {
        let around = (1..=REACH).flat_map(|r| {
            (-r..=r)
                .flat_map(move |dy| (-r..=r).map(move |dx| (dx, dy)))
                .filter(move |(dx, dy)| dx.abs().max(dy.abs()) == r)
        });
        around
            .map(|(dx, dy)| {
                self.in_row(y + dy).filter(|surface| surface.covered.holds(x + dx, y + dy)).last()
            })
            .find_map(|surface| surface)
    }
}

/// How far the surface of a pixel at the rim of an outline is looked for, in pixels along both sides.
const REACH: i32 = 2;
