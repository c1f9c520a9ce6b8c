//! The tools that draw in the photo view: masks, and mattes.

use quadratura_document::stroke::BrushMode;

/// A tool that draws in the photo view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MaskTool {
    /// A round brush that masks.
    Brush,
    /// A closed outline that masks.
    Lasso,
    /// A round brush that changes mattes, in one of its modes.
    Matte(BrushMode),
}

impl MaskTool {
    /// Returns the tool's name, for use in a sentence.
    pub fn name(self) -> &'static str {
        match self {
            Self::Brush => "brush",
            Self::Lasso => "lasso",
            Self::Matte(_) => "matte brush",
        }
    }

    /// Returns whether it covers the pixels along its path.
    pub fn is_brush(self) -> bool {
        self != Self::Lasso
    }
}
