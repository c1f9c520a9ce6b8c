//! The contents of an image layer as outlines in the photo, which tell the surface of each pixel.

use std::cell::OnceCell;

use glam::{DMat3, DVec3};

use quadratura_base::geometry::{Pinhole, PixelRect, Pose, Spans};
use quadratura_base::scene::FaceIndex;
use quadratura_document::Element;
use quadratura_document::stack::{FacePiece, StackCamera, StackPhoto, StackSurface};
use quadratura_projection::footprint::footprint;

/// Returns the camera of a stack or of an export.
pub fn camera_of(photo: &StackPhoto, camera: &StackCamera) -> (Pinhole, Pose) {
    let [[fx, _, cx], [_, fy, cy], _] = camera.K;
    let pinhole = Pinhole { width: photo.width, height: photo.height, fx, fy, cx, cy };
    let rows = camera.R.map(DVec3::from_array);
    let rotation = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
    (pinhole, Pose { rotation, translation: camera.t.into() })
}

/// Converts an outline in world coordinates.
pub fn points(outline: &[[f64; 3]]) -> Vec<DVec3> {
    outline.iter().map(|&p| DVec3::from_array(p)).collect()
}

/// A surface, or a piece of one, in an image layer; or the surroundings.
#[derive(Debug)]
pub struct SurfacePart<'a> {
    /// The unique name of the object; `[surroundings]` for the surroundings.
    pub object: &'a str,
    /// The face's index within the object; `None` for the surroundings, which cover all of the layer.
    pub face: Option<FaceIndex>,
    /// The triangle's index within the face, for a face that is not planar.
    pub triangle: Option<u32>,
    /// The outline of the whole surface at the time of the build; empty where it is unknown, and for the
    /// surroundings.
    pub outline: &'a [[f64; 3]],
    /// Whether it is the rectangle of an impostor, which takes the place of all faces of the object.
    pub impostor: bool,
    /// The index in the model's order among the known surfaces; later ones are drawn on top.
    pub rank: usize,
    /// The piece that is in the layer; `None` for the whole surface.
    piece: Option<&'a [[f64; 3]]>,
    /// The part of the photo that belongs to the layer, where several layers contain the surface.
    tile: Option<PixelRect>,
    covered: OnceCell<Spans>,
}

/// All parts of an image layer, in the model's order.
pub struct LayerParts<'a> {
    camera: Pinhole,
    pose: Pose,
    /// The photo and the layer's rectangle, in photo pixels, outside of which nothing is covered.
    area: PixelRect,
    /// The parts.
    pub list: Vec<SurfacePart<'a>>,
}

/// The photo, camera and surfaces from which parts are made, for all image layers of a stack or of an export.
#[derive(Debug, Clone, Copy)]
pub struct PartSource<'a> {
    /// The photo.
    pub photo: &'a StackPhoto,
    /// The photo's camera.
    pub camera: &'a StackCamera,
    /// The surfaces, in the model's order; may be empty.
    pub surfaces: &'a [StackSurface],
    /// The pieces of cut faces and of faces that are not planar.
    pub pieces: &'a [FacePiece],
}

impl<'a> PartSource<'a> {
    /// Makes the parts of an image layer with these elements and this rectangle. Of an element that other layers
    /// contain, too, the layer has the part within `tile`.
    pub fn parts(&self, elements: &[(&'a Element, Option<PixelRect>)], rect: PixelRect) -> LayerParts<'a> {
        let (camera, pose) = camera_of(self.photo, self.camera);
        let photo = camera.rect();
        let mut list: Vec<SurfacePart> =
            elements.iter().flat_map(|(element, tile)| self.of_element(element, *tile)).collect();
        list.sort_by_key(|part| part.rank);
        LayerParts { camera, pose, area: rect.union(&photo), list }
    }

    /// Makes the parts of one element.
    fn of_element(&self, element: &'a Element, tile: Option<PixelRect>) -> Vec<SurfacePart<'a>> {
        let surroundings = element.is_surroundings().then(|| SurfacePart {
            object: &element.object,
            face: None,
            triangle: None,
            outline: &[],
            impostor: false,
            rank: self.surfaces.len(),
            piece: None,
            tile,
            covered: OnceCell::new(),
        });
        let whole = element.faces.iter().map(|&face| self.part(element, face, None, None, tile));
        let is_piece =
            |p: &&FacePiece| p.object == element.object && element.pieces.contains(&(p.face, p.piece));
        let pieces = self.pieces.iter().filter(is_piece);
        let pieces = pieces.map(|p| self.part(element, p.face, p.triangle, Some(&p.polygon[..]), tile));
        whole.chain(pieces).chain(surroundings).collect()
    }

    /// Makes a part, with its surface's outline and order.
    fn part(
        &self,
        element: &'a Element,
        face: FaceIndex,
        triangle: Option<u32>,
        piece: Option<&'a [[f64; 3]]>,
        tile: Option<PixelRect>,
    ) -> SurfacePart<'a> {
        let (object, impostor) = (element.object.as_str(), element.impostor);
        let same = |s: &StackSurface| s.object == object && s.face == face && s.triangle == triangle;
        let index = self.surfaces.iter().position(same);
        let outline = index.map_or(&[][..], |index| &self.surfaces[index].outline);
        let rank = index.unwrap_or(self.surfaces.len());
        let face = Some(face);
        SurfacePart { object, face, triangle, outline, impostor, rank, piece, tile, covered: OnceCell::new() }
    }
}

impl SurfacePart<'_> {
    /// Returns true for the surroundings.
    pub fn is_surroundings(&self) -> bool {
        self.face.is_none()
    }

    /// Returns the part's own outline in world coordinates: that of the piece, or of the whole surface.
    pub fn own_outline(&self) -> &[[f64; 3]] {
        self.piece.unwrap_or(self.outline)
    }

    /// Returns true when the part is a whole surface that no other image layer contains.
    pub fn is_whole(&self) -> bool {
        self.piece.is_none() && self.tile.is_none()
    }
}

impl LayerParts<'_> {
    /// Returns the pixels that a part covers, computed at the first call.
    pub fn covered<'p>(&self, part: &'p SurfacePart) -> &'p Spans {
        part.covered.get_or_init(|| {
            let area = part.tile.map_or(self.area, |tile| tile.intersection(&self.area));
            if part.is_surroundings() {
                return Spans::default().complement(area);
            }
            let outline = points(part.own_outline());
            footprint(&outline, &self.camera, &self.pose, area)
        })
    }

    /// Returns the indices of the parts that cover a pixel, in the model's order.
    pub fn at(&self, x: i32, y: i32) -> impl Iterator<Item = usize> {
        let covers = move |part: &SurfacePart| self.covered(part).holds(x, y);
        self.list.iter().enumerate().filter(move |(_, part)| covers(part)).map(|(index, _)| index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(object: &str, x: f64) -> StackSurface {
        let corner = |dx: f64, dy: f64| [x + dx, dy, 10.0];
        let outline = vec![corner(0.0, 0.0), corner(4.0, 0.0), corner(4.0, 4.0), corner(0.0, 4.0)];
        StackSurface { object: object.into(), face: FaceIndex(0), triangle: None, outline }
    }

    fn element(object: &str) -> Element {
        Element {
            object: object.into(),
            faces: vec![FaceIndex(0)],
            pieces: vec![],
            back: vec![],
            ..Element::default()
        }
    }

    #[test]
    fn a_pixel_belongs_to_every_surface_that_covers_it_the_last_of_the_model_last() {
        let photo = StackPhoto { name: "a".into(), width: 10, height: 8 };
        // One world unit is one pixel at a depth of ten.
        let camera = StackCamera {
            K: [[10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 1.0]],
            R: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            t: [0.0; 3],
        };
        let surfaces = [square("wall", 0.0), square("window", 2.0)];
        let scenery = PartSource { photo: &photo, camera: &camera, surfaces: &surfaces, pieces: &[] };
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
