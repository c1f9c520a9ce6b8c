//! `ldi.json`: what is in the pictures of a folder.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::file::{LdiCamera, SurfaceEntry};
use crate::{Ldi, LdiReport};
use quadratura_base::geometry::PixelRect;
use quadratura_files::hash::hash_bytes;
use quadratura_files::json::to_json;

/// The file that describes the others.
pub(super) const JSON: &str = "ldi.json";

/// What `format` says.
pub const FORMAT: &str = "quadratura-ldi-layers";

/// The version that this program writes, and the only one that it reads.
pub(super) const VERSION: u32 = 1;

/// How a depth is made of a value; text for people, which readers need not understand.
pub(super) const MAPPING: &str = "inverse depth = far + (near - far) * value / 65535";

/// The largest number of layers.
pub(super) const MOST_LAYERS: usize = u8::MAX as usize;

/// The largest value of 16 bits, which stands for the nearest depth pixel.
pub(super) const NEAREST: f64 = u16::MAX as f64;

/// Errors of at most this, in pixels, are not seen: it is the twentieth of one.
const EXACT_ENOUGH: f64 = 0.05;

/// The file. `docs/formats.md` describes it for other programs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LayersFile {
    /// The name of the format, [`FORMAT`].
    pub format: String,
    /// The version of the format.
    pub version: u32,
    /// See [`Ldi::inputs`].
    pub inputs: String,
    /// The name of an [`crate::LdiKind`].
    pub kind: String,
    /// The reference camera with the frame's size, which all pictures have.
    pub camera: LdiCamera,
    /// Where the photo is in the frame, in pixels; left out where the camera is no photo's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub photo_rect: Option<PixelRect>,
    /// See [`Ldi::gain`].
    pub gain: [f64; 3],
    /// The inverse depth of value 65535, in 1/world unit: the largest one.
    pub near: f32,
    /// The inverse depth of value 0: the least one.
    pub far: f32,
    /// The formula between, for people.
    pub mapping: String,
    /// The error that 16 bits of depth make.
    pub error: DepthError,
    /// The layers, the nearest first.
    pub layers: Vec<LayerEntry>,
    /// The surfaces that depth pixels name: number i is `surfaces[i - 1]`.
    pub surfaces: Vec<SurfaceEntry>,
    /// The names of the photos or files that it was made from.
    pub sources: Vec<String>,
    /// What its making reported.
    pub report: LdiReport,
    /// The BLAKE3 of this file with this field empty: by it a changed folder is recognised.
    pub hash: String,
}

/// A layer of the folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LayerEntry {
    /// The number of depth pixels.
    pub depth_pixels: u64,
    /// The pictures with the BLAKE3 of each file as it was written. They may be changed: readers do not compare them.
    pub files: BTreeMap<String, String>,
}

/// The error that 16 bits of depth make in a picture of the same focal length, seen from a step aside.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct DepthError {
    /// The step: half the median distance of the depth pixels, in world units.
    pub step: f64,
    /// The largest error after that step, in pixels: |b| (near - far) / 131070, where b = f step.
    pub pixels: f64,
    /// Whether that is at most 0.05 pixels.
    pub exact_enough: bool,
}

impl DepthError {
    /// Computes the error of a layered depth image with these largest and least inverse depths.
    pub(super) fn of(ldi: &Ldi, near: f32, far: f32) -> Self {
        // A file does not know how far the site goes; the median distance stands for it.
        let step = ldi.report.quartiles[1] / 2.0;
        let b = ldi.camera.fx.max(ldi.camera.fy) * step;
        let pixels = b * (f64::from(near) - f64::from(far)) / (2.0 * NEAREST);
        Self { step, pixels, exact_enough: pixels <= EXACT_ENOUGH }
    }
}

impl LayersFile {
    /// Returns the bytes of the file, with its hash.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let bare = Self { hash: String::new(), ..self.clone() };
        to_json(&Self { hash: hash_bytes(&to_json(&bare)), ..bare })
    }
}
