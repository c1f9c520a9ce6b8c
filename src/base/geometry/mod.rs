//! Pure mathematics in f64 without files or pixel colours: cameras, lenses, planes, polygons, rectangles.

pub mod axes;
pub mod bvh;
pub mod camera;
pub mod clip;
pub mod drawn;
pub mod grid;
pub mod inverse_depth;
pub mod lens;
pub mod lens_range;
pub mod plane;
pub mod polygon;
pub mod rect;
pub mod rolling_shutter;
pub mod similarity;
pub mod spans;
pub mod triangle;
pub mod undistortion;

pub use camera::{Pinhole, Pose};
pub use inverse_depth::InverseDepth;
pub use lens::Lens;
pub use lens_range::RangedLens;
pub use plane::Plane;
pub use rect::PixelRect;
pub use rolling_shutter::RollingShutter;
pub use similarity::Similarity;
pub use spans::Spans;
pub use undistortion::Undistortion;
