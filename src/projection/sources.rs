//! What serves a face: the photos' cameras, their image layers ("sheets" here, flat), and which sheet
//! may texture which side of which face. A table made from the stacks once; it replaces every depth
//! test against a photo.

use std::ops::Range;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::geometry::{Pinhole, PixelRect, Pose};
use crate::scene::FaceId;

/// A photo's place in [`Sources::photos`], which is the site's order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct PhotoId(pub u32);

/// An image layer's place in [`Sources::sheets`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SheetId(pub u32);

/// A photo as a projector.
#[derive(Debug, Clone, PartialEq)]
pub struct Projector {
    /// Unique name.
    pub name: String,
    /// Size and K in pixels.
    pub camera: Pinhole,
    /// World to camera.
    pub pose: Pose,
}

/// An image layer.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// The photo it is a part of.
    pub photo: PhotoId,
    /// Its token in the stack.
    pub id: String,
    /// The layer's rectangle, moved to where it takes few tiles ([`super::tiles::in_few_tiles`]): photo pixels;
    /// may reach outside the photo; sides are powers of two.
    pub rect: PixelRect,
}

/// One sheet's service to one side of one face.
#[derive(Debug, Clone, PartialEq)]
pub struct Server {
    /// The sheet.
    pub sheet: SheetId,
    /// Its photo.
    pub photo: PhotoId,
    /// The photo sees the face from behind and serves that side of it.
    pub back: bool,
    /// The face is pinned to this photo: as far as it is trusted at a point, no other takes part there
    /// ([`super::weights::shares`]).
    pub pinned: bool,
    /// Where it serves.
    pub domain: Domain,
}

/// The part of a face that a server is for.
#[derive(Debug, Clone, PartialEq)]
pub enum Domain {
    /// All of it: the face has one sheet in this photo.
    Whole,
    /// A convex polygon in photo pixels: a piece of a cut face, one triangle of a face that is not
    /// planar, or the share of one of several sheets. Counter-clockwise with y down reversed: the
    /// inside is where every `normal . p >= offset`.
    Inside(Vec<HalfPlane>),
}

impl Domain {
    /// All of the face.
    pub fn is_whole(&self) -> bool {
        matches!(self, Self::Whole)
    }

    /// Whether a point, in photo pixels, is within.
    pub fn holds(&self, point_px: DVec2) -> bool {
        match self {
            Self::Whole => true,
            Self::Inside(sides) => sides.iter().all(|s| s.normal.dot(point_px) >= s.offset),
        }
    }
}

/// `normal . p >= offset`, p in photo pixels, the normal of length 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfPlane {
    /// Points inwards.
    pub normal: DVec2,
    /// In pixels.
    pub offset: f64,
}

/// All of it. Faces by the model's ids.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sources {
    /// In the site's order.
    pub photos: Vec<Projector>,
    /// By photo, then nearest first.
    pub sheets: Vec<Sheet>,
    /// By face, then photo.
    pub servers: Vec<Server>,
    /// For each face its range in `servers`.
    pub of_face: Vec<Range<u32>>,
}

impl Sources {
    /// The servers of a face.
    pub fn servers_of(&self, face: FaceId) -> &[Server] {
        let range = &self.of_face[face.0 as usize];
        &self.servers[range.start as usize..range.end as usize]
    }

    /// The photo with this id.
    pub fn photo(&self, id: PhotoId) -> &Projector {
        &self.photos[id.0 as usize]
    }

    /// The sheet with this id.
    pub fn sheet(&self, id: SheetId) -> &Sheet {
        &self.sheets[id.0 as usize]
    }
}

/// Some element of the layer covers the texel.
pub const COVERED: u8 = 1;

/// The texel holds nothing, but its colour is what the photo shows there, of another surface. Beside an
/// outline it is carried past it in place of a guess, because such pixels are mixtures of both.
pub const BESIDE: u8 = 2;

/// The texel is not the photo's: it was filled, and its alpha is how far it is trusted. Confidence falls
/// beside it as beside an empty one.
pub const FILLED: u8 = 4;

/// The texels of a sheet, as its files have them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SheetPixels {
    /// The part of the sheet's rectangle that holds anything, in photo pixels; all else is empty.
    pub rect: PixelRect,
    /// sRGB and alpha, 8 bits, `rect.w * rect.h * 4`, rows from the top, not premultiplied. Alpha 0:
    /// nothing there; else how far the texel is trusted.
    pub rgba: Vec<u8>,
    /// [`COVERED`], [`BESIDE`] and [`FILLED`], or 0; `rect.w * rect.h`.
    pub needed: Vec<u8>,
}

/// Where sheets' texels come from: files, or a test's own.
pub trait Texels: Send + Sync {
    /// The texels of a sheet, decoded.
    ///
    /// # Errors
    /// [`crate::Error::Input`] and [`crate::Error::Io`] for its files.
    fn sheet(&self, sheet: SheetId) -> Result<SheetPixels>;
}
