//! The tools that draw masks.

/// A tool that draws masks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MaskTool {
    /// A round brush.
    Brush,
    /// A closed outline.
    Lasso,
}

impl MaskTool {
    /// Returns the tool's name, for use in a sentence.
    pub fn name(self) -> &'static str {
        match self {
            Self::Brush => "brush",
            Self::Lasso => "lasso",
        }
    }
}
