//! What is known of a view before it is drawn.

/// What is drawn of a view's surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DrawnSurfaces {
    /// The nearest ones.
    Nearest,
    /// All, layer by layer.
    All,
}

/// What the tables of a view say about its passes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Prepared {
    /// Whether there are optics to undo.
    pub(super) undoes_optics: bool,
    /// Whether the surroundings may be seen.
    pub(super) has_surroundings: bool,
    /// The number of corners of skirts.
    pub(super) skirts: u32,
    /// The number of corners of see-through faces.
    pub(super) see_through: u32,
    /// The factor on linear colours in the common exposure.
    pub(super) of_common: [f64; 3],
    /// Whether see-through faces are left out.
    pub(super) opaque_alone: bool,
}
