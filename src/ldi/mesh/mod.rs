//! Writes layered depth images as geometry for other programs: textured meshes, and points.

mod glb;
mod ply;

pub use self::glb::{GlbContent, place_of_glb, write_glb};
pub use self::ply::{WrittenPly, write_ply};
