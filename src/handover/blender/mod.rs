//! A site for Blender: `scene.json`, and the script `scene.py`, which makes a scene of it.
//!
//! Blender triangulates what it reads from other formats and has no lens shift there, and only Blender writes `.blend` files: so a
//! small generic script builds the scene from data. Coordinates are those of the world less the origin; matrices are by rows;
//! paths are relative to the folder of `scene.json`.

pub mod scene;

/// The script, Blender 4.2 or newer.
pub const SCRIPT: &str = include_str!("scene.py");
