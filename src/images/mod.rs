//! Layered depth images of a project: made of the stacks of its photos, kept in `cache/ldi/` or written to a file, and
//! rendered.

mod build;
mod choice;
mod cover;
mod covered_planes;
mod depth_fit;
#[cfg(test)]
mod depth_tests;
pub mod export;
mod exposed_shot;
mod face_depths;
mod figures;
mod inputs;
mod kept;
pub mod live;
mod maker;
mod nearest;
mod of_cube;
mod of_depth;
mod of_photos;
mod of_site;
mod of_stack;
mod options;
mod place;
mod planes;
mod reference_camera;
pub mod set;
mod site;
mod site_origins;
pub mod site_view;
mod standing;
mod stereo;
#[cfg(test)]
mod tests;
mod texels;
pub mod view;
pub mod viewer;

pub use self::build::{
    BuildRequest, BuiltLdi, DepthRequest, LdiState, build_ldis, build_of_depth_images, ldi_state,
};
pub use self::maker::{BuildCamera, Maker};
pub use self::of_cube::{CubeRequest, build_cube};
pub use self::of_depth::{DepthImageOptions, depth_images};
pub use self::of_photos::ldi_of_photos;
pub use self::of_stack::ldi_of_stack;
pub use self::options::{BuildFrom, PhotosOptions, SiteLdiOptions, StackLdiOptions};
pub use self::place::cached_file;
pub use self::reference_camera::ReferenceCamera;
pub use self::set::{BuiltSet, ImageOfSet, SetRequest, build_set};
pub use self::site::LdiSite;
pub use self::stereo::COMFORTABLE;
