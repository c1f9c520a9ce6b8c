//! The site in the formats of other programs, for those who go on with it there: scenes, models with textures, cameras.
//!
//! It knows formats and their conventions, and is given plain data: cameras, faces, image layers. It does not know
//! projects, devices or how a picture is blended. Coordinates are those of the world less one `origin`, so that programs that
//! compute in f32 lose no pixels.

pub mod atlas;
pub mod blender;
pub mod camera;
pub mod cameras_json;
pub mod colmap;
pub mod nuke;
pub mod textured;
pub mod transforms;
