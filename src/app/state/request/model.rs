//! Requests about what is suggested to complete the model.

use glam::DVec3;

use crate::state::model_suggestions::EdgeOfSuggestion;

/// Requests about what is suggested to complete the model.
pub enum ModelRequest {
    /// Finds what the model does not explain, or shows again what was found.
    Suggest,
    /// Finds it anew.
    SuggestAgain,
    /// Hides the suggestions; they stay.
    Hide,
    /// Rejects a suggestion, by its index: it is not offered again.
    Reject(usize),
    /// Moves an edge within its plane, so that its line passes a point of the world.
    MoveEdge(EdgeOfSuggestion, DVec3),
    /// Adds the suggestions that are wanted to the model.
    Add,
}
