//! The stack file `stack.json`: the derived stack of one photo, field by field (see `docs/formats.md`).

mod filling;
mod untextured;

use serde::{Deserialize, Serialize};

pub use self::filling::{
    FillBasis, FilledPaint, LayerFill, PropagationEntry, StackFill, SurfaceName, origins,
};
pub use self::untextured::{Untextured, UntexturedFaces, UntexturedReason};

use super::in_use::FilesInUse;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::FaceIndex;
use quadratura_base::scene::builder::SURROUNDINGS;
use quadratura_layers::{ElementIndex, Faces, LayerIndex, Method};

/// The version of the format that this program writes, and the only one that it reads.
pub const STACK_VERSION: u32 = 2;

/// All image layers of one photo, nearest first, and the data that they were made from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stack {
    /// The format's version, [`STACK_VERSION`].
    pub version: u32,
    /// The method that found the visibility layers.
    pub method: Method,
    /// The hash of everything that the stack was made from; while it matches, the stack is not rebuilt. Decisions
    /// about this photo's layers have a hash of their own, after a `-`.
    pub inputs: String,
    /// The photo.
    pub photo: StackPhoto,
    /// The photo's camera.
    pub camera: StackCamera,
    /// The elements of each visibility layer, nearest layer first. Occlusions number the elements in this order.
    pub visibility_layers: Vec<Vec<Element>>,
    /// The flat surfaces that elements consist of, as they were in the model, in its order.
    pub surfaces: Vec<StackSurface>,
    /// Pieces of faces that were cut, and triangles of faces that are not planar.
    pub pieces: Vec<FacePiece>,
    /// The occlusions between elements, which are numbered in reading order of `visibility_layers`.
    pub occlusions: Vec<Support>,
    /// Occlusions against the order that were ignored as contact noise.
    pub forgiven: Vec<Support>,
    /// Occlusions against the order that are more than noise and could not be resolved by a cut. The two elements
    /// are in separate image layers, and `notes` names them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unresolved: Vec<Support>,
    /// The image layers, nearest first: `order` never decreases.
    pub image_layers: Vec<ImageLayer>,
    /// The number of texels of all rectangles.
    pub texels: u64,
    /// The number of texels that at least one element covers.
    pub texels_used: u64,
    /// The number of texels if each face and piece had its own rectangle.
    pub texels_unmerged: u64,
    /// The size of the layer files in bytes.
    pub bytes: u64,
    /// The summary of the filling, once hidden texels were filled.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fill: Option<StackFill>,
    /// The faces that this photo does not texture, with the reasons.
    pub untextured: UntexturedFaces,
    /// Messages for the user: cuts that failed, violations of the published method.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Decisions about the photo's layers that could not be satisfied, with the reasons.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[serde(rename = "unmet")]
    pub unsatisfied: Vec<String>,
    /// The pixels at which the photo shows leftovers and nothing that is in an image layer: `[y, x0, x1]` for columns
    /// x0 to x1 - 1 of row y, rising. With the photo's colours there, in front of all image layers, the stack
    /// reproduces the photo.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub leftovers: Vec<[u32; 3]>,
    /// Faces that are as little visible as leftovers, but keep their image layers because of paint, a pin or a merge.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spared: Vec<Faces>,
    /// Whether the photo shows the surroundings at so few pixels that they have no image layer; these pixels are among
    /// `leftovers`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub surroundings_left_over: bool,
    /// Overlaps of faces of one object that are in one element all the same: where the photo shows the nearer one, or
    /// covers both, it does not texture the farther one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tolerated: Vec<ToleratedOverlap>,
    /// Image layers of one object that a merge links because they cannot be one: their tokens, nearest first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub linked: Vec<Vec<String>>,
    /// Counts for reports.
    pub counts: StackCounts,
    /// The hold on the files of this version, where it was read from disk.
    #[serde(skip)]
    pub in_use: FilesInUse,
}

/// The largest permitted side of a rectangle in pixels, from the number of levels of a texture pyramid.
const LARGEST_SIDE: u32 = 1 << (quadratura_projection::tiles::MOST_LEVELS - 1);

impl Stack {
    /// Returns the hash of the inputs other than decisions about its layers: photo, camera, model, options.
    pub fn inputs(&self) -> &str {
        self.inputs.split('-').next().unwrap_or_default()
    }

    /// Returns the elements with their indices, in reading order of the visibility layers.
    pub fn numbered_elements(&self) -> impl Iterator<Item = (ElementIndex, &Element)> + Clone {
        (0..).map(ElementIndex).zip(self.visibility_layers.iter().flatten())
    }

    /// Returns the image layer with this index.
    pub fn layer(&self, index: LayerIndex) -> &ImageLayer {
        &self.image_layers[index.index()]
    }

    /// Returns the index of the element of the surroundings, which is the last one; `None` where there is none.
    pub fn surroundings(&self) -> Option<ElementIndex> {
        let (index, last) = self.numbered_elements().last()?;
        last.is_surroundings().then_some(index)
    }

    /// Returns true when an image layer shows the surroundings.
    pub fn is_of_surroundings(&self, layer: &ImageLayer) -> bool {
        self.surroundings().is_some_and(|index| layer.elements.contains(&index))
    }

    /// Returns true when an image layer shows some object, and none but those for which `is_one` is true.
    pub fn shows_only(&self, layer: &ImageLayer, is_one: impl Fn(&str) -> bool) -> bool {
        let mut held =
            self.numbered_elements().filter(|(index, _)| layer.elements.contains(index)).peekable();
        held.peek().is_some() && held.all(|(_, element)| is_one(&element.object))
    }

    /// Returns the image layers that show faces, which are all but those of the surroundings.
    pub fn layers_of_faces(&self) -> impl Iterator<Item = &ImageLayer> {
        let surroundings = self.surroundings();
        let is_of_faces =
            move |layer: &&ImageLayer| surroundings.is_none_or(|i| !layer.elements.contains(&i));
        self.image_layers.iter().filter(is_of_faces)
    }

    /// Returns the indices of all image layers, nearest first.
    pub fn layer_indices(
        &self,
    ) -> impl ExactSizeIterator<Item = LayerIndex> + DoubleEndedIterator + Clone + use<> {
        LayerIndex::all(self.image_layers.len())
    }

    /// Returns all image layers with their indices, nearest first.
    pub fn numbered_layers(&self) -> impl ExactSizeIterator<Item = (LayerIndex, &ImageLayer)> + Clone {
        self.layer_indices().zip(&self.image_layers)
    }

    /// Returns the index of the image layer with this token.
    pub fn layer_with_token(&self, token: &str) -> Option<LayerIndex> {
        self.image_layers.iter().position(|layer| layer.id == token).map(LayerIndex::new)
    }

    /// Returns the other image layers that are linked with this one, nearest first.
    pub fn linked_with(&self, layer: LayerIndex) -> Vec<LayerIndex> {
        let Some(token) = self.image_layers.get(layer.index()).map(|layer| &layer.id) else {
            return Vec::new();
        };
        let linked = self.linked.iter().find(|linked| linked.contains(token));
        let others = linked.into_iter().flatten().filter(|other| *other != token);
        others.filter_map(|other| self.layer_with_token(other)).collect()
    }

    /// Returns true when the other stack differs at most in the names of its layers.
    pub fn differs_in_names_only(&self, other: &Self) -> bool {
        if self.image_layers.len() != other.image_layers.len() {
            return false;
        }
        let mut renamed = self.clone();
        for (layer, other) in renamed.image_layers.iter_mut().zip(&other.image_layers) {
            (layer.name, layer.own_name) = (other.name.clone(), other.own_name.clone());
        }
        renamed == *other
    }

    /// Returns whether another stack has image layers in the same places, see-through ones in those of see-through ones, so
    /// that its files can be shown in their stead.
    pub fn is_placed_like(&self, other: &Self) -> bool {
        let place = |layer: &ImageLayer| {
            let sees_through = layer.fill.as_ref().is_some_and(|fill| fill.matte_file.is_some());
            (layer.rect, layer.needed_rect, sees_through)
        };
        self.image_layers.iter().map(place).eq(other.image_layers.iter().map(place))
    }

    /// Checks the image layers: their elements have to exist, and their sides to have a valid number of pixels.
    /// Returns where the first problem is and what was found. Readers of stack files call this once; all other code
    /// relies on it.
    pub fn flaw(&self) -> Option<(String, String)> {
        let elements = self.visibility_layers.iter().map(Vec::len).sum::<usize>();
        self.image_layers.iter().find_map(|layer| {
            let PixelRect { w, h, .. } = layer.rect;
            let missing = layer.elements.iter().find(|element| element.index() >= elements);
            let found = match missing {
                Some(element) => format!("element {element}, of {elements} that are numbered from 0"),
                None if [w, h].iter().all(|side| (1..=LARGEST_SIDE).contains(side)) => return None,
                None => format!("a rectangle of {w} x {h} pixels; sides have 1 to {LARGEST_SIDE}"),
            };
            Some((format!("image layer {:?}", layer.id), found))
        })
    }
}

/// The photo of a stack.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StackPhoto {
    /// The unique name.
    pub name: String,
    /// The width in pixels.
    pub width: u32,
    /// The height in pixels.
    pub height: u32,
}

/// A camera as in `stack.json`: K in pixels; R and t from world to camera; each matrix by rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case)]
pub struct StackCamera {
    /// The 3 x 3 camera matrix in pixels.
    pub K: [[f64; 3]; 3],
    /// The 3 x 3 rotation matrix.
    pub R: [[f64; 3]; 3],
    /// The translation in world units.
    pub t: [f64; 3],
}

/// An element: faces (or pieces) of one object that do not occlude each other; or the surroundings, what the photo
/// shows where no face is, which are called `[surroundings]` and have no faces.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Element {
    /// The unique name of the object.
    pub object: String,
    /// The faces that are contained as a whole: their indices within the object as in the model file, ascending.
    pub faces: Vec<FaceIndex>,
    /// The contained pieces of faces as `[face, piece]`, ascending.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pieces: Vec<(FaceIndex, u32)>,
    /// The faces that the photo sees from behind; it textures only that side of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub back: Vec<FaceIndex>,
    /// The faces of which no piece is in an image layer, because the photo barely shows them, ascending. They are not
    /// in `faces`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub leftovers: Vec<FaceIndex>,
    /// The pieces of such faces as `[face, piece]`, ascending. They are not in `pieces`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub leftover_pieces: Vec<(FaceIndex, u32)>,
    /// Whether the object is an impostor: face 0 is the rectangle that faces the photo, in place of all its faces.
    #[serde(default, skip_serializing_if = "is_false")]
    pub impostor: bool,
    /// Whether one may see through the faces in places, where that is not the same as `impostor`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub see_through: Option<bool>,
}

fn is_false(value: &bool) -> bool {
    !value
}

impl Element {
    /// Makes the element of the surroundings.
    pub fn surroundings() -> Self {
        Self { object: SURROUNDINGS.to_owned(), ..Self::default() }
    }

    /// Returns whether one may see through its faces in places.
    pub fn sees_through(&self) -> bool {
        self.see_through.unwrap_or(self.impostor)
    }

    /// Returns true for the surroundings.
    pub fn is_surroundings(&self) -> bool {
        self.object == SURROUNDINGS
    }

    /// Returns the faces by which decisions identify the element: those that it contains as a whole or, if there
    /// are none, those of its pieces, or else its leftovers.
    pub fn known_by(&self) -> Faces {
        let lists = [self.faces.clone(), self.textured_faces(), self.all_faces()];
        let faces = lists.into_iter().find(|faces| !faces.is_empty()).unwrap_or_default();
        Faces { object: self.object.clone(), faces }
    }

    /// Returns all faces of which it contains at least a piece, ascending.
    pub fn all_faces(&self) -> Vec<FaceIndex> {
        let left_over = self.leftover_pieces.iter().map(|(face, _)| *face);
        sorted(self.textured_faces().into_iter().chain(self.leftovers.iter().copied()).chain(left_over))
    }

    /// Returns the faces of which it has at least a piece in an image layer, ascending.
    pub fn textured_faces(&self) -> Vec<FaceIndex> {
        sorted(self.faces.iter().copied().chain(self.pieces.iter().map(|(face, _)| *face)))
    }
}

/// Returns the faces without repetition, ascending.
fn sorted(faces: impl Iterator<Item = FaceIndex>) -> Vec<FaceIndex> {
    let mut faces: Vec<FaceIndex> = faces.collect();
    faces.sort_unstable();
    faces.dedup();
    faces
}

/// A flat surface: a planar face, or one triangle of a face that is not planar.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StackSurface {
    /// The unique name of the object.
    pub object: String,
    /// The face's index within the object.
    pub face: FaceIndex,
    /// The triangle's index within the face, for a face that is not planar.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub triangle: Option<u32>,
    /// The outline: one ring in world coordinates with bridged holes, wound like the face.
    pub outline: Vec<[f64; 3]>,
}

/// A piece of a face that was cut.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FacePiece {
    /// The unique name of the object.
    pub object: String,
    /// The face's index within the object.
    pub face: FaceIndex,
    /// The piece's index within the face.
    pub piece: u32,
    /// The triangle to which the piece belongs, for a face that is not planar.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub triangle: Option<u32>,
    /// The outline: one simple ring in world coordinates with bridged holes, wound like the face; it may be
    /// concave.
    pub polygon: Vec<[f64; 3]>,
}

/// An occlusion: `front` is nearer than `back` at `px` pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Support {
    /// The nearer element.
    pub front: ElementIndex,
    /// The farther element.
    pub back: ElementIndex,
    /// The support: the number of pixels.
    pub px: u32,
}

/// A face that is behind a face of its own object, in one element with it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ToleratedOverlap {
    /// The unique name of the object.
    pub object: String,
    /// The index of the farther face within the object.
    pub face: FaceIndex,
    /// The index of the nearer face.
    pub by: FaceIndex,
    /// The number of pixels at which the photo gives the farther face no texture.
    pub px: u64,
}

/// An image layer: a rectangle of the photo with the elements that it textures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ImageLayer {
    /// The permanent token of this image layer of this stack: a short hash of photo, elements and rectangle, in
    /// lower-case letters and digits.
    pub id: String,
    /// The readable name.
    pub name: String,
    /// The automatic name, where the layer was given another one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own_name: Option<String>,
    /// The order in the stack: the longest path in the graph of clusters, 0 nearest.
    pub order: u32,
    /// The rectangle in photo pixels; it may extend beyond the photo.
    pub rect: PixelRect,
    /// The elements, numbered in reading order of [`Stack::visibility_layers`].
    pub elements: Vec<ElementIndex>,
    /// The file of the layer, an RGBA PNG of the rectangle: the photo's colour, opaque, where visible; transparent
    /// elsewhere.
    pub file: String,
    /// The file of the needed area, a 1-bit PNG of the rectangle: white where at least one element covers it.
    pub needed_file: String,
    /// The bounding box of the covered pixels, in photo pixels.
    pub needed_rect: PixelRect,
    /// The number of covered texels.
    pub texels_used: u64,
    /// The number of covered texels that are visible.
    pub texels_visible: u64,
    /// The filling, where there is any.
    #[serde(flatten)]
    pub fill: Option<LayerFill>,
    /// The texture matrix of 3 rows by 4: (u q, v q, q) = rows * (x, y, z, 1), with u and v in 0..1 of the
    /// rectangle, v down.
    pub uv_from_world: [[f64; 4]; 3],
}

/// What a stack was made of and consists of, counted for reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct StackCounts {
    /// The number of fragments of the working set.
    pub fragments: u64,
    /// The number of faces in the working set.
    pub faces: u32,
    /// The number of elements.
    pub elements: u32,
    /// The number of objects with exactly one element.
    pub whole_objects: u32,
    /// The number of visibility layers.
    pub visibility_layers: u32,
    /// The number of cuts.
    pub cuts: u32,
    /// The number of cuts of which one piece left the working set.
    pub free_cuts: u32,
    /// The number of pairs (of faces or pieces) whose occlusion was ignored as contact noise.
    pub forgiven: u32,
    /// The number of pairs that contradict the order; for the `stencil` method.
    pub violations: u32,
    /// The number of pixels of `violations`.
    pub violation_px: u64,
}
