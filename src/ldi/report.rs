//! What the making of a layered depth image reports.

use serde::{Deserialize, Serialize};

/// The figures of a layered depth image, as in its file.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct LdiReport {
    /// Depth pixels for each layered depth pixel that holds any.
    pub depth_complexity: f64,
    /// The largest number of depth pixels at one position.
    pub layers: u32,
    /// The samples that were collected before any were merged.
    pub samples: u64,
    /// The samples that became part of another one's depth pixel.
    pub merged: u64,
    /// The samples that were left out because of the largest number of layers.
    pub dropped: u64,
    /// The samples of surfaces that have no colour yet: room to paint.
    pub empty_needed: u64,
    /// The surfaces that became unknown because there were too many, and those in whose plane the camera is.
    pub unknown_surfaces: u64,
    /// The quartiles of the distances of the depth pixels from the reference camera, in world units: see
    /// [`super::spacing`].
    pub quartiles: [f64; 3],
    /// The options of the making, by their names on the command line.
    pub options: std::collections::BTreeMap<String, String>,
}
