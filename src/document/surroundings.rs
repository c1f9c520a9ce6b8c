//! The user's picture of what is around the site.

use serde::{Deserialize, Serialize};

/// An equirectangular picture of all directions, which takes the place of the dome that is made of photos.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurroundingsPicture {
    /// The file, relative to the project's folder as other paths of the project.
    pub picture: String,
    /// The direction of the picture's middle in the cameras' world; it is made level.
    pub middle: [f64; 3],
}
