//! How the streams of a file are packed.

use serde::{Deserialize, Serialize};

/// How the streams of a file are packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Packing {
    /// As they are: fast, for the cache.
    None,
    /// Predicted, then deflated: small, to hand on.
    Deflate,
}
