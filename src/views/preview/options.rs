//! What is wanted of a project that is opened for rendering.

use quadratura_projection::TextureOptions;
use quadratura_trees::PlantParts;

/// Why a picture is coarser than photos are, and what to do.
pub const MORE_MEMORY: &str = "they do not fit into memory, even where little is drawn at a time; give the command more with `--memory`";

/// Options for showing a project.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PreviewOptions {
    /// The texture memory.
    pub textures: TextureOptions,
    /// Whether exposures are matched.
    pub gains: bool,
    /// Whether surfaces are shown with the depth detail estimated from the photos.
    pub relief: bool,
    /// Whether photos count less where others contradict them. They are compared on the relief, which is estimated for this
    /// even where it is not shown.
    pub agreement: bool,
    /// Whether fillings of hidden texels are shown.
    pub filled: bool,
    /// What is wanted of the plants of trees.
    pub tree_parts: PlantParts,
    /// Whether photos without a stack, and with one that is out of date, are not noted: the caller shows them.
    pub without_stack_notes: bool,
    /// Whether a plain sky takes the place of all that photos show around the model.
    pub modelled_sky: bool,
}

impl Default for PreviewOptions {
    fn default() -> Self {
        Self {
            textures: TextureOptions::default(),
            gains: true,
            relief: true,
            agreement: true,
            filled: true,
            tree_parts: PlantParts::default(),
            without_stack_notes: false,
            modelled_sky: false,
        }
    }
}
