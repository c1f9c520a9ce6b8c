//! Requests about trees.

use super::hand::Hold;
use crate::state::space::view_pixel::ViewPixel;
use quadratura_document::trees::{PlacedTree, TreeLight};

/// Requests about trees.
pub enum TreeRequest {
    /// Replaces a tree.
    Set {
        /// Its name.
        name: String,
        /// The tree after it.
        tree: Box<PlacedTree>,
        /// What is changed, for undo: `height`.
        what: &'static str,
        /// Whether the gesture continues.
        goes_on: bool,
    },
    /// Places a copy of a tree beside it, by name.
    Duplicate(String),
    /// Removes a tree, by name.
    Remove(String),
    /// Opens or closes the eyes of trees, by name.
    Show(Vec<String>, bool),
    /// Opens all eyes.
    ShowAll,
    /// Sets the light on all trees.
    Light {
        /// The light.
        light: TreeLight,
        /// Whether the gesture continues.
        goes_on: bool,
    },
    /// Masks the real trees in all photos, where trees of the project stand.
    Mask,
    /// Removes the masks of trees.
    ClearMasks,
    /// Reads or grows the plants of species whose figures are not known.
    WantFigures,
    /// Takes up the tool that places trees, or puts it away.
    Hand,
    /// Sets the species of trees that are placed.
    Choose(String),
    /// Presses the button of the mouse: takes the tree under the pointer, or places one.
    Press(ViewPixel),
    /// Drags the tree that is held.
    Drag(ViewPixel, Hold),
    /// Lets go of the tree.
    Release,
    /// Gives up what was done since the button was pressed.
    GiveUp,
}
