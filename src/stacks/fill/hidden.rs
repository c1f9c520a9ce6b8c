//! The hidden pixels of a stack's image layers, by surface.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use glam::DVec3;
use rayon::prelude::*;

use quadratura_base::error::Result;
use quadratura_base::geometry::PixelRect;
use quadratura_base::geometry::polygon::{fit_plane, triangulate};
use quadratura_base::raster::Image;
use quadratura_base::scene::builder::SURROUNDINGS;
use quadratura_base::scene::{FaceId, FaceIndex, Model};
use quadratura_document::stack::ImageLayer;
use quadratura_document::{Element, Stack};
use quadratura_io::layer_reader::{read_layer, read_mask};
use quadratura_layers::LayerIndex;
use quadratura_layers::fill::region::{Region, RegionShape, Regions, painted};
use quadratura_layers::fill::see_through::SeeThroughLayer;
use quadratura_layers::fill::{Donor, FillOptions, FillSurfaceId, FillSurfaces};

/// The pixels to be filled.
pub(super) struct PixelsToFill {
    /// The hidden pixels by surface.
    pub regions: Vec<Region>,
    /// The hidden pixels of the surroundings.
    pub surroundings: Option<Region>,
    /// The visible pixels of surfaces that may get paint of other photos.
    pub visible_regions: Vec<Region>,
    /// The number of hidden texels of faces, including those that stay empty.
    pub texels: u64,
    /// The image layers of see-through surfaces, nearest first.
    pub see_through: Vec<SeeThroughLayer>,
}

/// The pixels of an image layer within its needed rectangle.
pub(super) struct NeededPixels {
    /// The part of the layer that was read, in photo pixels.
    pub rect: PixelRect,
    /// Not 0 where some element covers the pixel.
    pub needed: Vec<u8>,
    /// Whether the photo shows the layer there.
    pub visible: Vec<bool>,
}

impl NeededPixels {
    /// Reads a layer's needed and visible pixels within `part` (photo pixels).
    pub fn read(layer: &ImageLayer, folder: &Path, part: PixelRect) -> Result<Self> {
        let rect = layer.needed_rect.intersection(&layer.rect).intersection(&part);
        if rect.is_empty() {
            return Ok(Self { rect, needed: Vec::new(), visible: Vec::new() });
        }
        let rgba = read_layer(&folder.join(&layer.file), layer.rect, rect)?;
        let needed = read_mask(&folder.join(&layer.needed_file), layer.rect, rect)?;
        let visible = rgba.as_chunks::<4>().0.iter().map(|texel| texel[3] != 0).collect();
        Ok(Self { rect, needed, visible })
    }

    /// Iterates over all pixels with their index and position in the photo.
    fn positions(&self) -> impl Iterator<Item = (usize, (i32, i32))> {
        self.rect.pixels().enumerate()
    }
}

/// Marks a pixel at which no layer is visible.
const NOTHING: u32 = u32::MAX;

/// Finds the hidden pixels of all image layers. A pixel that would cover what another layer shows is left out: that
/// happens where an overlap was ignored as noise, and the stack must still reproduce the photo. For the surfaces in
/// `propagated` the visible pixels are returned, too.
///
/// # Errors
/// Returns [`quadratura_base::Error::Input`] and [`quadratura_base::Error::Io`] for the stack's files.
pub(super) fn hidden_regions(
    stack: &Stack,
    folder: &Path,
    own: &Donor,
    model: &Model,
    surfaces: &FillSurfaces,
    options: &FillOptions,
    propagated: &BTreeSet<FillSurfaceId>,
) -> Result<PixelsToFill> {
    let read = |layer: &ImageLayer| NeededPixels::read(layer, folder, layer.rect);
    let layers: Vec<NeededPixels> = stack.image_layers.par_iter().map(read).collect::<Result<_>>()?;
    let front = front(stack, &layers);
    let shaper = Shaper::new(stack, own, model, surfaces);
    let elements: Vec<&Element> = stack.visibility_layers.iter().flatten().collect();
    let fills = |id: FillSurfaceId| {
        if id == FillSurfaceId::SURROUNDINGS {
            return options.fills(SURROUNDINGS);
        }
        let object = model.face(surfaces.get(id).face).object;
        options.fills(&model.object(object).name)
    };
    let of_layer = |(index, (layer, pixels)): (usize, (&ImageLayer, &NeededPixels))| {
        let of_layer: Vec<&Element> = layer.elements.iter().map(|e| elements[e.index()]).collect();
        let is_around = stack.is_of_surroundings(layer);
        let sees_through = !of_layer.is_empty() && of_layer.iter().all(|element| element.sees_through());
        let mut painted = match is_around {
            true => vec![Some(FillSurfaceId::SURROUNDINGS); pixels.rect.area() as usize],
            false => painted(&shaper.shapes(&of_layer), pixels.rect),
        };
        let see_through = sees_through.then(|| SeeThroughLayer {
            layer: LayerIndex::new(index),
            rect: pixels.rect,
            surfaces: painted.clone(),
            visible: pixels.visible.clone(),
        });
        let is_hidden = |i: usize| pixels.needed[i] != 0 && !pixels.visible[i];
        // The surroundings are no hidden part of the model.
        let counted = if is_around { 0 } else { painted.len() };
        let texels = (0..counted).filter(|i| is_hidden(*i)).count() as u64;
        let hidden: Vec<bool> = pixels
            .positions()
            .map(|(i, (x, y))| {
                is_hidden(i) && front.get(x, y).is_none_or(|&front| front == NOTHING || front < index as u32)
            })
            .collect();
        // Objects that are left unfilled keep their pixels, so that adjacent surfaces do not take them.
        let hidden: Vec<bool> =
            hidden.iter().zip(&painted).map(|(hidden, id)| *hidden && id.is_none_or(fills)).collect();
        painted.iter_mut().for_each(|id| *id = id.filter(|id| fills(*id)));
        let is_propagated = |id: &Option<FillSurfaceId>| id.is_some_and(|id| propagated.contains(&id));
        let visible: Vec<bool> =
            painted.iter().zip(&pixels.visible).map(|(id, visible)| *visible && is_propagated(id)).collect();
        (painted, hidden, visible, texels, see_through)
    };
    let found: Vec<_> = stack.image_layers.par_iter().zip(&layers).enumerate().map(of_layer).collect();
    let mut regions = Regions::default();
    let mut visible = Regions::default();
    let mut texels = 0;
    let mut see_through = Vec::new();
    for ((index, pixels), (painted, hidden, visible_here, count, sees_through)) in
        stack.layer_indices().zip(&layers).zip(found)
    {
        regions.add(index, pixels.rect, &painted, &hidden);
        visible.add(index, pixels.rect, &painted, &visible_here);
        texels += count;
        see_through.extend(sees_through);
    }
    let mut regions = regions.finish();
    let surroundings = regions.pop_if(|region| region.surface == FillSurfaceId::SURROUNDINGS);
    Ok(PixelsToFill { regions, surroundings, visible_regions: visible.finish(), texels, see_through })
}

/// Returns, for each pixel of the photo, the nearest image layer that shows it.
fn front(stack: &Stack, layers: &[NeededPixels]) -> Image<u32> {
    let mut front = Image::filled(PixelRect::of_size(stack.photo.width, stack.photo.height), NOTHING);
    for (index, pixels) in layers.iter().enumerate().rev() {
        for (_, (x, y)) in pixels.positions().filter(|(i, _)| pixels.visible[*i]) {
            front.get_mut(x, y).into_iter().for_each(|front| *front = index as u32);
        }
    }
    front
}

/// Returns the faces of each object by the object's name.
fn faces_by_name(model: &Model) -> BTreeMap<&str, &[FaceId]> {
    model.objects.iter().map(|object| (object.name.as_str(), &object.faces[..])).collect()
}

/// Converts the contents of elements to outlines in the photo.
pub(super) struct Shaper<'a> {
    stack: &'a Stack,
    own: &'a Donor,
    model: &'a Model,
    surfaces: &'a FillSurfaces,
    faces: BTreeMap<&'a str, &'a [FaceId]>,
}

impl<'a> Shaper<'a> {
    /// Prepares the outlines of a stack's elements in its photo, `own`.
    pub fn new(stack: &'a Stack, own: &'a Donor, model: &'a Model, surfaces: &'a FillSurfaces) -> Self {
        Self { stack, own, model, surfaces, faces: faces_by_name(model) }
    }

    /// Returns the outlines of elements in model order: where outlines share a pixel, the last one owns it. Cut
    /// faces are added as a whole at the beginning, for pixels that rounding leaves between their pieces.
    pub fn shapes(&self, elements: &[&Element]) -> Vec<RegionShape> {
        let mut behind: Vec<(FaceId, RegionShape)> = Vec::new();
        let mut shapes: Vec<(FaceId, RegionShape)> = Vec::new();
        for element in elements {
            let of_object = self.faces.get(element.object.as_str()).copied().unwrap_or_default();
            let face = |index: FaceIndex| of_object.get(index.index()).copied();
            for face in element.faces.iter().filter_map(|index| face(*index)) {
                shapes.extend(self.whole(face).into_iter().map(|shape| (face, shape)));
            }
            for &(index, piece) in &element.pieces {
                let Some(face) = face(index) else { continue };
                behind.extend(self.whole(face).into_iter().map(|shape| (face, shape)));
                shapes.extend(self.piece(&element.object, face, piece).map(|shape| (face, shape)));
            }
        }
        behind.sort_by_key(|(face, _)| *face);
        shapes.sort_by_key(|(face, _)| *face);
        behind.into_iter().chain(shapes).map(|(_, shape)| shape).collect()
    }

    /// Returns the outlines of a whole face: one, or one per triangle.
    fn whole(&self, face: FaceId) -> Vec<RegionShape> {
        let triangles = self.model.face_triangles(face).len() as u32;
        let parts: Vec<Option<u32>> =
            if self.surfaces.is_flat(face) { vec![None] } else { (0..triangles).map(Some).collect() };
        let shape = |part: Option<u32>| {
            let surface = self.surfaces.id(face, part);
            Some(RegionShape::of_item(surface, self.own.view(), self.own.item(surface)?))
        };
        parts.into_iter().filter_map(shape).collect()
    }

    /// Returns the outline of a piece.
    fn piece(&self, object: &str, face: FaceId, piece: u32) -> Option<RegionShape> {
        let index = self.model.face(face).index;
        let named = |p: &&quadratura_document::stack::FacePiece| {
            p.object == object && p.face == index && p.piece == piece
        };
        let ring = &self.stack.pieces.iter().find(named)?.polygon;
        let ring: Vec<DVec3> = ring.iter().map(|p| DVec3::from_array(*p)).collect();
        let triangulation = triangulate(&ring, &fit_plane(&ring)?);
        let corners = [&ring[..], &triangulation.crossings[..]].concat();
        let triangles: Vec<[DVec3; 3]> =
            triangulation.triangles.iter().map(|t| t.map(|i| corners[i as usize])).collect();
        let surface = self.surfaces.nearest_to_polygon(face, &ring);
        let (camera, pose) = (&self.own.camera, &self.own.pose);
        Some(RegionShape::from_triangles(surface, &triangles, camera, pose, self.own.view()))
    }
}
