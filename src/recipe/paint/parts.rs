//! What an image layer textures, as outlines in the photo: which surface a pixel of the layer belongs to.

use std::cell::OnceCell;

use glam::{DMat3, DVec3};

use crate::document::Element;
use crate::document::stack::{Piece, StackCamera, StackPhoto, Surface};
use crate::geometry::{Pinhole, PixelRect, Pose, Spans};
use crate::projection::footprint::footprint;

/// The camera of a stack or of an export.
pub fn camera_of(photo: &StackPhoto, camera: &StackCamera) -> (Pinhole, Pose) {
    let [[fx, _, cx], [_, fy, cy], _] = camera.K;
    let pinhole = Pinhole { width: photo.width, height: photo.height, fx, fy, cx, cy };
    let rows = camera.R.map(DVec3::from_array);
    let rotation = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
    (pinhole, Pose { rotation, translation: camera.t.into() })
}

/// An outline in world coordinates.
pub fn points(outline: &[[f64; 3]]) -> Vec<DVec3> {
    outline.iter().map(|&p| DVec3::from_array(p)).collect()
}

/// A surface, or a piece of one, in an image layer.
#[derive(Debug)]
pub struct Part<'a> {
    /// Unique name of the object.
    pub object: &'a str,
    /// Index within the object.
    pub face: u32,
    /// Which triangle, of a face that is not planar.
    pub triangle: Option<u32>,
    /// All of the surface, as it was sorted; empty where nobody knows.
    pub outline: &'a [[f64; 3]],
    /// Its place in the model among the surfaces that are known: what comes later is drawn on top.
    pub place: usize,
    /// The piece of it that is in the layer; none: all of it.
    piece: Option<&'a [[f64; 3]]>,
    /// The share of the layer, where several have the surface.
    tile: Option<PixelRect>,
    covered: OnceCell<Spans>,
}

/// All parts of an image layer, in the model's order.
pub struct Parts<'a> {
    camera: Pinhole,
    pose: Pose,
    /// In photo pixels: where footprints are looked for.
    area: PixelRect,
    /// The parts.
    pub list: Vec<Part<'a>>,
}

/// What parts are made of, for all image layers of a stack or of an export.
#[derive(Debug, Clone, Copy)]
pub struct Scenery<'a> {
    /// The photo.
    pub photo: &'a StackPhoto,
    /// Its camera.
    pub camera: &'a StackCamera,
    /// In the model's order; may be empty.
    pub surfaces: &'a [Surface],
    /// Of cut faces and of faces that are not planar.
    pub pieces: &'a [Piece],
}

impl<'a> Scenery<'a> {
    /// The parts of an image layer with these elements and this rectangle. Of an element that other layers
    /// have, too, it has the share within `tile`.
    pub fn parts(&self, elements: &[(&'a Element, Option<PixelRect>)], rect: PixelRect) -> Parts<'a> {
        let (camera, pose) = camera_of(self.photo, self.camera);
        let photo = camera.rect();
        let mut list: Vec<Part> =
            elements.iter().flat_map(|(element, tile)| self.of_element(element, *tile)).collect();
        list.sort_by_key(|part| part.place);
        Parts { camera, pose, area: rect.union(&photo), list }
    }

    fn of_element(&self, element: &'a Element, tile: Option<PixelRect>) -> Vec<Part<'a>> {
        let whole = element.faces.iter().map(|&face| self.part(&element.object, face, None, None, tile));
        let is_piece = |p: &&Piece| p.object == element.object && element.pieces.contains(&[p.face, p.piece]);
        let pieces = self.pieces.iter().filter(is_piece);
        let pieces =
            pieces.map(|p| self.part(&element.object, p.face, p.triangle, Some(&p.polygon[..]), tile));
        whole.chain(pieces).collect()
    }

    fn part(
        &self,
        object: &'a str,
        face: u32,
        triangle: Option<u32>,
        piece: Option<&'a [[f64; 3]]>,
        tile: Option<PixelRect>,
    ) -> Part<'a> {
        let same = |s: &Surface| s.object == object && s.face == face && s.triangle == triangle;
        let place = self.surfaces.iter().position(same);
        let outline = place.map_or(&[][..], |place| &self.surfaces[place].outline);
        let place = place.unwrap_or(self.surfaces.len());
        Part { object, face, triangle, outline, place, piece, tile, covered: OnceCell::new() }
    }
}

impl Part<'_> {
    /// The part's own outline, in world coordinates: the surface's, or that of the piece.
    pub fn own_outline(&self) -> &[[f64; 3]] {
        self.piece.unwrap_or(self.outline)
    }

    /// All of a surface that no other image layer shares.
    pub fn is_whole(&self) -> bool {
        self.piece.is_none() && self.tile.is_none()
    }
}

impl Parts<'_> {
    /// The pixels that a part covers.
    pub fn covered<'p>(&self, part: &'p Part) -> &'p Spans {
        part.covered.get_or_init(|| {
            let outline = points(part.own_outline());
            let area = part.tile.map_or(self.area, |tile| tile.intersection(&self.area));
            footprint(&outline, &self.camera, &self.pose, area)
        })
    }

    /// The parts that cover a pixel, in the model's order.
    pub fn at(&self, x: i32, y: i32) -> impl Iterator<Item = usize> {
        let covers = move |part: &Part| holds(self.covered(part), x, y);
        self.list.iter().enumerate().filter(move |(_, part)| covers(part)).map(|(index, _)| index)
    }
}

/// Whether a set of pixels holds one.
pub fn holds(spans: &Spans, x: i32, y: i32) -> bool {
    let row = spans.row(y);
    let after = row.partition_point(|run| run.end <= x);
    row.get(after).is_some_and(|run| run.start <= x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(object: &str, x: f64) -> Surface {
        let corner = |dx: f64, dy: f64| [x + dx, dy, 10.0];
        let outline = vec![corner(0.0, 0.0), corner(4.0, 0.0), corner(4.0, 4.0), corner(0.0, 4.0)];
        Surface { object: object.into(), face: 0, triangle: None, outline }
    }

    fn element(object: &str) -> Element {
        Element { object: object.into(), faces: vec![0], pieces: vec![], back: vec![] }
    }

    #[test]
    fn a_pixel_belongs_to_every_surface_that_covers_it_the_last_of_the_model_last() {
        let photo = StackPhoto { name: "a".into(), width: 10, height: 8 };
        // One world unit is one pixel at the depth of ten.
        let camera = StackCamera {
            K: [[10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 1.0]],
            R: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            t: [0.0; 3],
        };
        let surfaces = [square("wall", 0.0), square("window", 2.0)];
        let scenery = Scenery { photo: &photo, camera: &camera, surfaces: &surfaces, pieces: &[] };
        let (window, wall) = (element("window"), element("wall"));
        let rect = PixelRect::of_size(8, 8);
        let parts = scenery.parts(&[(&window, None), (&wall, None)], rect);
        assert_eq!(parts.list.iter().map(|part| part.object).collect::<Vec<_>>(), ["wall", "window"]);
        let at = |x: i32, y: i32| parts.at(x, y).collect::<Vec<_>>();
        assert_eq!((at(1, 1), at(3, 3), at(5, 0), at(6, 0)), (vec![0], vec![0, 1], vec![1], vec![]));
        let tiled = scenery.parts(&[(&wall, Some(PixelRect::of_size(2, 2)))], rect);
        assert_eq!(tiled.at(1, 1).count() + tiled.at(3, 3).count(), 1);
    }
}
