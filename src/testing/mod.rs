//! The rooms of the crate as its own tests, benchmarks and examples see them, a tiny site to try the library on, and a model that
//! one photo shows.
//! Names and signatures here may change in any version.

mod one_photo;
mod tiny_site;

pub use one_photo::one_photo;
pub use tiny_site::{tiny_project, tiny_site, tiny_stacks};

macro_rules! rooms {
    ($($room:ident),*) => {
        $(pub mod $room {
            pub use crate::$room::*;
        })*
    };
}

rooms!(geometry, raster, scene, projection, foliage, ldi, layers, document, io, gpu, recipe);
#[cfg(feature = "gui")]
rooms!(app);
