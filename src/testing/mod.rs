//! The rooms of the crate as its own tests, benchmarks and examples see them, and a tiny site to try the library on.
//! Names and signatures here may change in any version.

mod tiny_site;

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
