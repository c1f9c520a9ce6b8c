//! The rooms of the crate as its own tests, benchmarks and examples see them. Nothing here is promised to anybody else:
//! names and signatures change without a word.

macro_rules! rooms {
    ($($room:ident),*) => {
        $(pub mod $room {
            pub use crate::$room::*;
        })*
    };
}

rooms!(geometry, raster, scene, projection, layers, document, io, gpu, recipe, app);
