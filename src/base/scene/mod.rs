//! The photographed site: photos with their cameras, and the model. All of it is immutable and shared.

pub mod alike;
pub mod builder;
pub mod edges;
pub mod impostor;
pub mod light;
pub mod model;
pub mod photo;
pub mod pixels;
pub mod resample;
pub mod synthetic;

pub use builder::{FaceFlaw, ModelBuilder};
pub use edges::Edges;
pub use model::{Face, FaceId, FaceIndex, Model, Object, ObjectId};
pub use photo::{CameraExposure, Photo, PhotoId, Site, SparsePoint, up, up_of};
pub use pixels::{PhotoPixels, Samples};
