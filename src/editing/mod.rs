//! Layers on their way to image editors and back: export, import, and strokes in views of the model.
//!
//! | module | what it does |
//! |---|---|
//! | `export` | layered files, one for each photo |
//! | `import` | what was painted in them, as paint of surfaces |
//! | `stroke`, `tree_paint` | paint from views of the model, and on trees |
//! | `layer_view`, `peel`, `exploded` | layers to look at |
//! | `editing`, `watch` | documents that are open in an image editor |

pub mod editing;
pub mod exploded;
pub mod export;
pub mod import;
pub mod layer_view;
pub mod peel;
pub mod stroke;
pub mod tree_paint;
pub mod watch;
