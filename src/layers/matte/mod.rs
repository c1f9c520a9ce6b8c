//! Mattes: how much of a see-through surface each pixel of a photo shows.
//!
//! A pixel shows `alpha F + (1 - alpha) B` in linear light: the foreground F as far as the surface covers it, and the
//! background B behind. What is behind is predicted from other photos: a pixel that is as predicted shows the background, one
//! that is far from it and has the object's colours the object (`compare`); where that does not tell, the silhouettes that
//! other photos show do (`silhouette`). The band between is solved from the photo's colours (`closed_form`), and
//! the foreground's own colours follow (`foreground`).

pub mod closed_form;
mod colour_model;
pub mod compare;
pub mod find;
pub mod foreground;
pub mod piece;
pub mod silhouette;

pub use closed_form::{ClosedForm, closed_form};
pub use colour_model::{ColourModel, log_colour};
pub use compare::{CANDIDATES, Compared, Evidence, Predicted, object_model};
pub use find::{FindOptions, Likely, find_mattes};
pub use foreground::{Foreground, foreground};
pub use piece::{ExpectedPiece, FaceGrid, PieceSilhouette, SeenPiece};
pub use silhouette::{SeenImpostor, Silhouette};

use quadratura_base::raster::Image;

/// The matte of an object in a photo, or of one of its faces, and the object's own colours.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Matte {
    /// The unique name of an impostor's object; of other objects the name of the face, `object[index]`, and for a triangle of a
    /// face that is not planar `object[index].triangle`.
    pub object: String,
    /// For the part of the photo that the object covers, in photo pixels: its own colour (sRGB) and the matte, in 255ths.
    /// Where the matte is 255 the colour is the photo's.
    pub texels: Image<[u8; 4]>,
    /// What is known of each pixel of the same rectangle.
    pub known: Image<Known>,
}

/// What is known of a pixel of a matte. The matte of pixels of which nothing is known is 255.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[repr(u8)]
pub enum Known {
    /// The photo shows nothing of the object's surface here: something else is in front, or the photo is not valid.
    NotShown = 0,
    /// Nothing tells what belongs to the object.
    Unknown = 1,
    /// The matte is 0 or 1, since what is known of the colours and of the other photos decides it.
    Found = 2,
    /// The matte was solved from the pixels around, because that decides nothing.
    Solved = 3,
}

impl Known {
    /// Returns true when the matte is known.
    pub fn is_known(self) -> bool {
        matches!(self, Known::Found | Known::Solved)
    }
}

/// How many pixels of a matte are what, of those that show the object's surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MatteShares {
    /// The pixels that show the object alone.
    pub solid: u64,
    /// The pixels that show what is behind it alone.
    pub clear: u64,
    /// The pixels that show both.
    pub mixed: u64,
    /// The pixels of which nothing is known.
    pub unknown: u64,
}

impl MatteShares {
    /// Returns the counts of both.
    pub fn plus(self, other: Self) -> Self {
        Self {
            solid: self.solid + other.solid,
            clear: self.clear + other.clear,
            mixed: self.mixed + other.mixed,
            unknown: self.unknown + other.unknown,
        }
    }

    /// Returns the number of pixels that show the object's surface.
    pub fn pixels(&self) -> u64 {
        self.solid + self.clear + self.mixed + self.unknown
    }
}

impl Matte {
    /// Counts the pixels of the matte.
    pub fn shares(&self) -> MatteShares {
        let mut shares = MatteShares::default();
        for ([.., alpha], known) in self.texels.pixels().iter().zip(self.known.pixels()) {
            match (known, alpha) {
                (Known::NotShown, _) => (),
                (Known::Unknown, _) => shares.unknown += 1,
                (Known::Found | Known::Solved, 0) => shares.clear += 1,
                (Known::Found | Known::Solved, 255) => shares.solid += 1,
                (Known::Found | Known::Solved, _) => shares.mixed += 1,
            }
        }
        shares
    }
}
