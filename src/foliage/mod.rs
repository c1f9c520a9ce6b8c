//! Plants as graphs of sub-objects, their generator, and the pictures that are drawn of all their polygons.
//!
//! A [`Plant`] is what Max 1996 (*Hierarchical Rendering of Trees from Precomputed Multi-Layer Z-Buffers*) makes trees
//! from: sub-objects that use each other, from leaf to tree. [`Draft`]s become a plant by [`assemble`], which counts and
//! bounds each sub-object once; [`grow`] makes plants from numbers; [`draw`] draws every polygon of every instance. [`files`] reads
//! and writes plants, their images and lists of trees.
//!
//! | modules | contents |
//! |---|---|
//! | `stretch`, `order`, `seed`, `directions`, `normal`, `pixels`, `raster`, `shade`, `ratio`, `species`, `similarity`, `jump` | what knows no plant: maps, numbers and pictures; fragments of triangles; light on a surface; how like two pictures are |
//! | `primitive`, `curve`, `detail`, `bounds`, `leaves`, `plant`, `mesh`, `view`, `facet`, `mbuffer`, `images`, `paint` | a plant as data: its graph, its triangles, views of it, its images and its paint |
//! | `assemble`, `leaf_picture`, `grow`, `stature`, `balls`, `synthetic` | plants are put together, grown and measured |
//! | `clip`, `stipple`, `drawer`, `bands` | polygons are drawn onto a canvas |
//! | `depths`, `shadow`, `openness`, `sunlit`, `shades`, `brute` | what keeps light from a plant, and pictures of all its polygons |
//! | `walk`, `pace`, `listed`, `lighting`, `place`, `reproject`, `planes`, `flake`, `texels`, `layered`, `flakes`, `in_view` | pictures from the images of its sub-objects |
//! | `gains`, `bake` | these images are made |
//! | `placed`, `cast`, `sun_views` | the trees of a site, and their shadows |
//! | `files` | files of plants, of their images, and of lists of trees |
//!
//! A module uses only modules of its own row and of rows above it in this table.

mod assemble;
mod bake;
mod balls;
mod bands;
mod bounds;
mod brute;
mod cast;
mod clip;
mod curve;
mod depths;
mod detail;
pub mod directions;
mod drawer;
mod facet;
pub mod files;
mod flake;
mod flakes;
mod gains;
mod grow;
mod images;
mod in_view;
mod jump;
mod layered;
mod leaf_picture;
mod leaves;
mod lighting;
mod listed;
mod mbuffer;
mod mesh;
mod normal;
mod openness;
mod order;
mod pace;
mod paint;
mod pixels;
mod place;
mod placed;
mod planes;
mod plant;
mod primitive;
pub mod raster;
mod ratio;
mod reproject;
mod seed;
mod shade;
mod shades;
mod shadow;
mod similarity;
mod species;
mod stature;
mod stipple;
mod stretch;
mod sun_views;
mod sunlit;
pub mod synthetic;
mod texels;
mod view;
mod walk;

#[cfg(test)]
#[path = "../../tests/common/mutations.rs"]
mod mutations;
#[cfg(test)]
mod tests;

pub use assemble::{Draft, DraftUse, PlantFlaw, assemble};
pub use bake::{BakeOptions, bake, finest_copy};
pub use balls::balls;
pub use bands::MOST_TRIANGLES;
pub use bounds::{Ball, BoundingBox, Bounds};
pub use brute::{Drawing, InLights, draw, draw_in_lights, draw_shaded, silhouette};
pub use cast::{CastShadows, SUN_TANGENT, left_in_shadow};
pub use directions::Directions;
pub use flakes::{FlakeOptions, TexelGeometry, draw_flakes};
pub use grow::grow;
pub use images::{
    ImageCopy, LightCorrection, MBuffer, MSample, ObjectImages, PlantImages, depth_from_stored,
};
pub use in_view::{ImageInView, InView, PolygonsInView, in_view};
pub use jump::{Jump, jump};
pub use layered::{LayeredOptions, draw_layered};
pub use listed::ImageCost;
pub use mesh::Mesh;
pub use normal::NormalCode;
pub use openness::Openness;
pub use pace::{TreeCost, TreePace};
pub use paint::{
    BesidePixel, Change, DIRECTION_NAMES, PaintAt, PaintField, PaintPoint, PaintedPlant, PaintedSlab,
    SlabFrame, SlabTally, painted, painted_slabs, slab_pictures,
};
pub use pixels::{Pixels, Wrap};
pub use placed::{PlacedSpecies, PlacedTrees, Placing, Tree};
pub use plant::{Counts, MOST_CORNERS, MOST_LEVELS, MOST_USES, Plant, SubObject, Use};
pub use primitive::{Corner, CurvePoint, Limb, Material, Primitive, Shape, TriangleList};
pub use ratio::{MOST_RATIOS, RATIO_CELLS, RatioImage, RatioInView, RatiosInView};
pub use shade::{LightReach, LitSurface, OutdoorLight, shade};
pub use shades::{Shades, SunShade};
pub use shadow::{Caster, Shadow};
pub use similarity::{PictureSimilarity, similarity};
pub use species::{Bark, Blade, LeafShape, LimbLevel, Profile, Species};
pub use stature::{Stature, level_axes};
pub use stipple::Stipple;
pub use stretch::largest_stretch;
pub use sun_views::{MOST_SUN_VIEWS, SunScene, SunView, TAKES_OVER, sun_views};
pub use sunlit::{SUNLIT_CELLS, Sunlit};
pub use view::{Projection, View, sees};
pub use walk::{DISSOLVE, Drawn, Part, WalkOptions, walk};
