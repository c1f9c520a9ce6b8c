//! `stack.json`: the derived stack of one photo, field by field (see `docs/formats.md`).

use serde::{Deserialize, Serialize};

use crate::geometry::PixelRect;
use crate::layers::{Faces, Method};

/// The version this program writes; it reads no other.
pub const STACK_VERSION: u32 = 2;

/// All image layers of one photo, nearest first, and what they were made of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stack {
    /// [`STACK_VERSION`].
    pub version: u32,
    /// How the visibility layers were found.
    pub method: Method,
    /// Hash of everything the stack was made of; when it still matches, nothing is rebuilt. What was decided
    /// about this photo's layers has a hash of its own, behind a `-`.
    pub inputs: String,
    /// The photo.
    pub photo: StackPhoto,
    /// Its camera.
    pub camera: StackCamera,
    /// Layer by layer, nearest first, the elements. Occlusions count through them in this order.
    pub visibility_layers: Vec<Vec<Element>>,
    /// The flat surfaces that elements are made of, as the model had them, in its order.
    pub surfaces: Vec<Surface>,
    /// Pieces of faces that were cut, and triangles of faces that are not planar.
    pub pieces: Vec<Piece>,
    /// Who hides whom, between elements numbered in reading order of `visibility_layers`.
    pub occlusions: Vec<Support>,
    /// Occlusions against the order that were forgiven as contact noise.
    pub forgiven: Vec<Support>,
    /// Occlusions against the order that are more than noise and could not be cut: the two are in
    /// separate image layers, and `notes` names them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unresolved: Vec<Support>,
    /// The image layers, by falling nearness: `order` never decreases.
    pub image_layers: Vec<ImageLayer>,
    /// Texels of all rectangles.
    pub texels: u64,
    /// Texels that some element covers.
    pub texels_used: u64,
    /// Texels if every face and piece had a rectangle of its own.
    pub texels_unmerged: u64,
    /// Bytes of the layer files.
    pub bytes: u64,
    /// What filled its hidden texels, once that was done.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fill: Option<StackFill>,
    /// Faces without texture from this photo, with the reason.
    pub untextured: Vec<Untextured>,
    /// What the user should know: cuts that failed, violations of the published method.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// What was decided about its layers and could not be done, with the reason.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unmet: Vec<String>,
    /// Counts for reports.
    pub counts: Counts,
}

/// Pyramids have 16 levels.
const LARGEST_SIDE: u32 = 1 << (crate::projection::tiles::MOST_LEVELS - 1);

impl Stack {
    /// Hash of what it was made of besides decisions about its layers: photo, camera, model, options.
    pub fn ground(&self) -> &str {
        self.inputs.split('-').next().unwrap_or_default()
    }

    /// Another stack is the same but for the names of its layers.
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

    /// The first image layer that cannot be, as place and finding: one of elements that are not there, or
    /// with a side of no pixels or of more than textures may have. Whoever reads a file asks; all else
    /// takes it for granted.
    pub fn flaw(&self) -> Option<(String, String)> {
        let elements = self.visibility_layers.iter().map(Vec::len).sum::<usize>();
        self.image_layers.iter().find_map(|layer| {
            let PixelRect { w, h, .. } = layer.rect;
            let missing = layer.elements.iter().find(|element| **element as usize >= elements);
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
    /// Unique name.
    pub name: String,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
}

/// K in pixels; R, t world to camera; each matrix as rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case)]
pub struct StackCamera {
    /// 3 x 3.
    pub K: [[f64; 3]; 3],
    /// 3 x 3.
    pub R: [[f64; 3]; 3],
    /// World units.
    pub t: [f64; 3],
}

/// Faces (or pieces) of one object that do not occlude each other.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Element {
    /// Unique name of the object.
    pub object: String,
    /// Whole faces: index within the object as in the model file, rising.
    pub faces: Vec<u32>,
    /// Pieces of faces: `[face, piece]`, rising.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pieces: Vec<[u32; 2]>,
    /// Those of its faces that the photo sees from behind; it serves only that side of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub back: Vec<u32>,
}

impl Element {
    /// The faces that it is known by: those that it holds whole; where it holds none, those of its pieces.
    pub fn known_by(&self) -> Faces {
        let faces = if self.faces.is_empty() { self.all_faces() } else { self.faces.clone() };
        Faces { object: self.object.clone(), faces }
    }

    /// Every face of which it holds anything, rising.
    pub fn all_faces(&self) -> Vec<u32> {
        let mut faces: Vec<u32> =
            self.faces.iter().copied().chain(self.pieces.iter().map(|p| p[0])).collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    }
}

/// A flat surface: a planar face, or one triangle of a face that is not planar.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Surface {
    /// Unique name of the object.
    pub object: String,
    /// Index within the object.
    pub face: u32,
    /// Which of its triangles, for a face that is not planar.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub triangle: Option<u32>,
    /// One ring in world coordinates, holes bridged, wound like the face.
    pub outline: Vec<[f64; 3]>,
}

/// A piece of a face.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Piece {
    /// Unique name of the object.
    pub object: String,
    /// Index within the object.
    pub face: u32,
    /// Index within the face.
    pub piece: u32,
    /// The triangle that it is of, for a face that is not planar.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub triangle: Option<u32>,
    /// One simple ring in world coordinates, holes bridged, wound like the face, may be concave.
    pub polygon: Vec<[f64; 3]>,
}

/// `front` is nearer than `back` at `px` pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Support {
    /// Element, counted in reading order of `visibility_layers`.
    pub front: u32,
    /// Element.
    pub back: u32,
    /// Pixels.
    pub px: u32,
}

/// A sub-rectangle of the photo with the elements that it textures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ImageLayer {
    /// Token that names this image layer of this stack for ever: short hash of photo, elements,
    /// rectangle; lower-case letters and digits.
    pub id: String,
    /// Readable name.
    pub name: String,
    /// The name that it has by itself, where it was given another.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own_name: Option<String>,
    /// Its place in the stack: longest path in the quotient, 0 nearest.
    pub order: u32,
    /// In photo pixels; may reach outside the photo.
    pub rect: PixelRect,
    /// Elements, counted in reading order of `visibility_layers`.
    pub elements: Vec<u32>,
    /// RGBA PNG of the rectangle: the photo's colour, opaque, where visible; else transparent.
    pub file: String,
    /// 1-bit PNG of the rectangle: white where some element covers.
    pub needed_file: String,
    /// Bounding box of the covered pixels, in photo pixels.
    pub needed_rect: PixelRect,
    /// Texels covered.
    pub texels_used: u64,
    /// Texels covered and visible.
    pub texels_visible: u64,
    /// The filling, where there is any.
    #[serde(flatten)]
    pub fill: Option<LayerFill>,
    /// 3 rows x 4: (u q, v q, q) = rows * (x, y, z, 1), u and v in 0..1 of the rectangle, v down.
    pub uv_from_world: [[f64; 4]; 3],
}

/// The filling of an image layer: files of its rectangle.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LayerFill {
    /// RGBA PNG: opaque where a hidden texel was filled, else transparent. It never holds a texel of `file`.
    pub filled_file: String,
    /// 8-bit PNG: how far the filling is trusted, in 255ths; 0 where nothing was filled.
    pub confidence_file: String,
    /// 8- or 16-bit PNG: the place in [`StackFill::origins`] of where a filled texel comes from; 0 elsewhere.
    pub provenance_file: String,
    /// RGBA PNG: opaque where paint of another photo is laid over what `file` shows, else transparent. It holds
    /// texels of `file` only; the two files above speak of them, too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread_file: Option<String>,
    /// Texels filled.
    pub texels_filled: u64,
}

impl LayerFill {
    /// All files.
    pub fn files_mut(&mut self) -> impl Iterator<Item = &mut String> {
        let three = [&mut self.filled_file, &mut self.confidence_file, &mut self.provenance_file];
        three.into_iter().chain(&mut self.spread_file)
    }
}

/// What filled the hidden texels of a stack.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct StackFill {
    /// Hash of everything it was made of; when it still matches, nothing is filled again.
    pub inputs: String,
    /// What the numbers of the provenance files mean; the first stands for no filling.
    pub origins: Vec<String>,
    /// Hidden texels.
    pub texels_hidden: u64,
    /// Of these: given by other photos.
    pub texels_from_photos: u64,
    /// Given by paint of other photos.
    #[serde(default)]
    pub texels_from_paint: u64,
    /// Made by example.
    pub texels_by_example: u64,
    /// Made by diffusion.
    pub texels_diffused: u64,
    /// What paint of other photos was laid over visible texels, or met paint of the photo's own: by face and photo.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spread: Vec<SpreadPaint>,
    /// Bytes of the filling's files.
    pub bytes: u64,
}

/// Paint of another photo that belongs on a face that this one shows.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct SpreadPaint {
    /// `object[index]`.
    pub face: String,
    /// The photo that it was painted in.
    pub from: String,
    /// Texels that it was laid over.
    pub texels: u64,
    /// Texels with paint of the photo's own, which stays.
    pub own: u64,
    /// Those of `own` whose paint clearly says something else.
    pub conflicts: u64,
    /// Those of `texels` where the paint of a third photo clearly says something else.
    pub dissents: u64,
}

/// Names in [`StackFill::origins`] that are no photos'. Photos' names hold no brackets at both ends.
pub mod origins {
    /// No filling.
    pub const NONE: &str = "[none]";
    /// An artist's hand in the photo itself.
    pub const PAINTED: &str = "[painted]";
    /// How names of an artist's hand in another photo begin: `[painted in NAME]`.
    const PAINTED_IN: &str = "[painted in ";
    /// Invented by example.
    pub const EXEMPLAR: &str = "[exemplar]";
    /// Invented by diffusion.
    pub const DIFFUSED: &str = "[diffused]";

    /// An artist's hand in the photo with this name.
    pub fn painted_in(photo: &str) -> String {
        format!("{PAINTED_IN}{photo}]")
    }

    /// The photo that a name of an artist's hand speaks of; none for other names.
    pub fn painter(origin: &str) -> Option<&str> {
        origin.strip_prefix(PAINTED_IN)?.strip_suffix(']')
    }
}

/// A face that this photo gives no texture.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Untextured {
    /// Unique name of the object.
    pub object: String,
    /// Index within the object.
    pub face: u32,
    /// Why.
    pub reason: Reason,
    /// For `hidden`: the face in front, as `object[index]`, at the first pixel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<String>,
    /// For `hidden`: that pixel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<[u32; 2]>,
}

impl Untextured {
    /// `hidden by tower[3] at pixel (812, 40)`.
    pub fn in_words(&self) -> String {
        let by = self.by.as_ref().map_or(String::new(), |by| format!(" by {by}"));
        let at = self.at.map_or(String::new(), |[x, y]| format!(" at pixel ({x}, {y})"));
        format!("{}{by}{at}", self.reason.word())
    }
}

/// Why a face gets no texture from a photo.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// In front of the camera, outside the photo.
    Outside,
    /// Behind the camera.
    Behind,
    /// Covers no pixel centre, or is seen exactly edge-on.
    TooSmall,
    /// Other faces are nearer everywhere.
    Hidden,
    /// Visible only where the photo is not valid.
    Masked,
    /// No area: nothing to texture.
    Degenerate,
    /// Somebody decided that this photo gives it none. It is in the stack, which shows what hides what; so
    /// the file never says this, but lists of reasons do.
    Excluded,
}

impl Reason {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Outside,
        Self::Behind,
        Self::TooSmall,
        Self::Hidden,
        Self::Masked,
        Self::Degenerate,
        Self::Excluded,
    ];

    /// For tables and messages.
    pub fn word(self) -> &'static str {
        match self {
            Self::Outside => "outside",
            Self::Behind => "behind",
            Self::TooSmall => "too small",
            Self::Hidden => "hidden",
            Self::Masked => "masked",
            Self::Degenerate => "no area",
            Self::Excluded => "excluded",
        }
    }
}

/// Counts for reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Counts {
    /// Fragments of the working set.
    pub fragments: u64,
    /// Faces in the working set.
    pub faces: u32,
    /// Elements.
    pub elements: u32,
    /// Objects with exactly one element.
    pub whole_objects: u32,
    /// Visibility layers.
    pub visibility_layers: u32,
    /// Cuts made.
    pub cuts: u32,
    /// Cuts of which one piece left the working set.
    pub free_cuts: u32,
    /// Forgiven pairs (of faces or pieces).
    pub forgiven: u32,
    /// For `stencil`: pairs that contradict the order, and their pixels.
    pub violations: u32,
    /// Pixels of `violations`.
    pub violation_px: u64,
}
