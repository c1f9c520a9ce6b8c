//! Novel views without sources: what is asked of a view and what it gives back, the weights of photos, the colours of
//! diagnostic views, image metrics, flights and navigation. Plants, layered depth images and layers know views by these.

pub mod agreement;
pub mod flight;
pub mod hidden;
pub mod legend;
pub mod linear;
pub mod metrics;
pub mod navigation;
pub mod optics;
pub mod shot;
pub mod srgb;
pub mod weights;

pub use linear::LinearPicture;
pub use shot::{
    Blend, DisplayMode, Exposure, Mode, ParallelRays, Picture, PicturePlane, Quality, Shot, TreeMethod,
    Unseen,
};
