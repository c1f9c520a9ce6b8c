//! A change of the model's file by this program.

use std::path::PathBuf;
use std::sync::Arc;

/// A change of the model's file, from one content to another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelChange {
    /// The file.
    pub file: PathBuf,
    /// What it held before.
    pub before: Arc<Vec<u8>>,
    /// What it holds after.
    pub after: Arc<Vec<u8>>,
}

impl ModelChange {
    /// Returns the change that undoes this one.
    pub fn reversed(&self) -> Self {
        Self { file: self.file.clone(), before: self.after.clone(), after: self.before.clone() }
    }
}
