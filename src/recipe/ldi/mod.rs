//! Layered depth images of a project: made of the stacks of its photos, kept in `cache/ldi/` or written to a file, and
//! rendered.

mod build;
mod cover;
mod figures;
mod inputs;
mod of_stack;
mod planes;
mod shapes;
mod site;
#[cfg(test)]
mod tests;
mod texels;
pub mod view;

pub use self::build::{BuildRequest, BuiltLdi, LdiState, build_ldis, cached_file, ldi_state};
pub use self::of_stack::ldi_of_stack;
pub use self::site::LdiSite;

/// The options of a layered depth image of a stack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StackLdiOptions {
    /// Whether points are moved to the relief that the photos tell; otherwise they lie on the model's faces.
    pub relief: bool,
    /// Whether fillings of hidden texels are in it.
    pub filled: bool,
    /// Whether what the photo shows where no face is, is in it, infinitely far away.
    pub surroundings: bool,
}

impl Default for StackLdiOptions {
    fn default() -> Self {
        Self { relief: true, filled: true, surroundings: true }
    }
}
