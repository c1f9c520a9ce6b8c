//! The texels that a stroke covers: pixels of image layers, each of the photo with most weight where the view shows it.

use std::collections::BTreeMap;

use glam::DVec2;
use rayon::prelude::*;

use super::dabs::Dabs;
use super::grid::{ViewGrid, centre};
use quadratura_base::geometry::{PixelRect, Plane};
use quadratura_base::scene::{FaceId, PhotoId};
use quadratura_document::Stack;
use quadratura_layers::LayerIndex;
use quadratura_projection::twin::{ProbedPoint, ReferenceRenderer};
use quadratura_projection::{LayerTextureId, Projector};
use quadratura_stacks::paint::parts::LayerParts;
use quadratura_stacks::paint::parts_of_layer;
use quadratura_view::Shot;

/// A pixel of an image layer under the brush.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BrushedTexel {
    /// Its place, in pixels of the photo.
    pub x: i32,
    pub y: i32,
    /// The face that the photo shows there.
    pub face: FaceId,
    /// Where the view shows it, in pixels of the view.
    pub in_view: DVec2,
    /// The effect of the brush, above 0 to 1.
    pub effect: f64,
}

/// The pixels of one image layer under the brush, row by row.
pub struct BrushedLayer {
    pub photo: PhotoId,
    pub layer: LayerIndex,
    pub texels: Vec<BrushedTexel>,
    /// The number of its texels per pixel of the view, along a side.
    pub texels_per_px: f64,
}

/// A face, or a triangle of one that is not planar, as one layer texture shows it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct TexturedSurface {
    texture: LayerTextureId,
    face: FaceId,
    triangle: u32,
}

/// What texels are found from.
pub struct TexelSearch<'a> {
    pub renderer: &'a ReferenceRenderer,
    pub shot: &'a Shot,
    pub dabs: &'a Dabs,
    pub grid: &'a ViewGrid,
    /// The stacks of the site's photos that textures belong to.
    pub stacks: &'a BTreeMap<PhotoId, Stack>,
}

/// The part of a textured surface that the stroke may cover.
struct SurfaceArea {
    plane: Plane,
    /// In pixels of the photo.
    rect: PixelRect,
    texels_per_px: f64,
}

impl TexelSearch<'_> {
    /// Returns the layers that the stroke covers, in the order of the sources.
    pub fn layers(&self) -> Vec<BrushedLayer> {
        let mut by_texture: BTreeMap<LayerTextureId, Vec<(TexturedSurface, SurfaceArea)>> = BTreeMap::new();
        for (surface, area) in self.areas() {
            by_texture.entry(surface.texture).or_default().push((surface, area));
        }
        let layer = |(texture, areas): (&LayerTextureId, &Vec<(TexturedSurface, SurfaceArea)>)| {
            let of_sources = self.renderer.sources().layer_texture(*texture);
            let stack = self.stacks.get(&of_sources.photo)?;
            let layer = stack.layer_with_token(&of_sources.id)?;
            let parts = parts_of_layer(stack, layer);
            let found = areas
                .iter()
                .flat_map(|(surface, area)| self.texels(*surface, area, &parts, stack.layer(layer).rect));
            let mut texels: Vec<BrushedTexel> = found.collect();
            texels.sort_by_key(|texel| (texel.y, texel.x));
            texels.dedup_by_key(|texel| (texel.y, texel.x));
            let texels_per_px = areas.iter().map(|(_, area)| area.texels_per_px).fold(0.0, f64::max);
            let photo = of_sources.photo;
            (!texels.is_empty()).then_some(BrushedLayer { photo, layer, texels, texels_per_px })
        };
        let textures: Vec<_> = by_texture.iter().collect();
        textures.into_par_iter().filter_map(layer).collect()
    }

    /// Returns the surfaces that the stroke covers, by the layer texture of most weight, and where they may be painted.
    fn areas(&self) -> BTreeMap<TexturedSurface, SurfaceArea> {
        let mut areas: BTreeMap<TexturedSurface, SurfaceArea> = BTreeMap::new();
        for (point, texel) in self.grid.seen() {
            let Some(texture) = texel.texture else { continue };
            let photo = self.photo_of(texture);
            let of_texture = self.renderer.sources().layer_texture(texture).photo;
            let pose = self.renderer.pose_on_face(self.shot, of_texture, point.hit.face);
            let in_photo = pose.camera_from_world(point.point);
            let Some(px) = photo.camera.image_from_camera(in_photo) else { continue };
            let depth = self.shot.pose.camera_from_world(point.point).z;
            let texels_per_px = photo.camera.fx * depth / (self.shot.camera.fx * in_photo.z);
            // A pixel of the view may be long on a surface that it sees at a grazing angle.
            let margin = (2.0 * texels_per_px / facing(self.shot, point)).ceil().min(1e4) as u32 + 2;
            let rect = PixelRect::of_pixel(px.x.floor() as i32, px.y.floor() as i32).grown(margin);
            let surface =
                TexturedSurface { texture, face: point.hit.face, triangle: self.triangle_of(point) };
            let area =
                areas.entry(surface).or_insert(SurfaceArea { plane: point.plane, rect, texels_per_px });
            area.rect = area.rect.union(&rect);
            area.texels_per_px = area.texels_per_px.max(texels_per_px);
        }
        areas
    }

    /// Returns the texels of a surface that the stroke covers and that the view shows with this texture.
    fn texels(
        &self,
        surface: TexturedSurface,
        area: &SurfaceArea,
        parts: &LayerParts,
        rect: PixelRect,
    ) -> Vec<BrushedTexel> {
        let TexturedSurface { texture, face, triangle } = surface;
        let model = self.renderer.model();
        let object = &model.object(model.face(face).object).name;
        let is_surface = |part: &&quadratura_stacks::paint::parts::SurfacePart| {
            let same_face = part.object == object && part.face == Some(model.face(face).index);
            same_face && part.triangle.is_none_or(|of_part| of_part == triangle)
        };
        let covered: Vec<_> = parts.list.iter().filter(is_surface).map(|part| parts.covered(part)).collect();
        let photo = self.renderer.sources().layer_texture(texture).photo;
        let same = |point: &ProbedPoint| point.hit.face == face && self.triangle_of(point) == triangle;
        let pixels = area.rect.intersection(&rect).pixels();
        let texel = |(x, y): (i32, i32)| {
            let is_covered = covered.iter().any(|spans| spans.holds(x, y));
            let px = centre((x, y));
            let on_face = || self.renderer.point_in_photo(self.shot, photo, px, face, &area.plane);
            let point = is_covered.then(on_face)??;
            let effect = Some(self.dabs.effect(point)).filter(|effect| *effect > 0.0)?;
            let in_view = self.shot.camera.image_from_camera(self.shot.pose.camera_from_world(point))?;
            let is_strongest = self.grid.texture_at(in_view, same) == Some(texture);
            is_strongest.then_some(BrushedTexel { x, y, face, in_view, effect })
        };
        pixels.filter_map(texel).collect()
    }

    fn photo_of(&self, texture: LayerTextureId) -> &Projector {
        let sources = self.renderer.sources();
        sources.photo(sources.layer_texture(texture).photo)
    }

    /// Returns the triangle of a point on a face that is not planar; 0 on a planar one.
    fn triangle_of(&self, point: &ProbedPoint) -> u32 {
        if self.renderer.model().face(point.hit.face).planar { 0 } else { point.hit.triangle }
    }
}

/// Returns the cosine of the angle between the viewing direction and the surface's normal, at least a hundredth.
fn facing(shot: &Shot, point: &ProbedPoint) -> f64 {
    let ray = (point.point - shot.viewpoint()).normalize();
    point.plane.normal.dot(ray).abs().max(0.01)
}
