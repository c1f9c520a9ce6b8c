//! Quadratura turns calibrated photos of a site and a coarse polygon model into editable image
//! layers: for every photo it proves which surface hides which, gives every surface pixels of its
//! own, and writes the result as a layered file that an artist can paint on.
//!
//! The modules are listed bottom to top. Each may use only the modules above it in this table, which
//! `tests/architecture.rs` verifies.
//!
//! | module | contents |
//! |---|---|
//! | [`error`], [`task`] | errors with their causes and remedies; progress and cancellation |
//! | [`geometry`] | cameras, lenses, planes, polygons, rectangles: pure mathematics |
//! | [`raster`] | pixels on a grid: image, sampling, halving, compositing, robust statistics |
//! | [`scene`] | photos, model and site: the photographed scene, immutable |
//! | [`projection`] | novel views: sheared frusta, the image layers that serve a face, blend weights |
//! | [`layers`] | the method: occlusion graph, cycles, parts, visibility layers, clusters, content, filling |
//! | [`document`] | what is saved: the authored project and the derived stacks |
//! | [`io`], [`gpu`] | files; GPU passes; neither uses the other |
//! | [`recipe`] | whole tasks: open, sort, cluster, extract, fill, save, without a user interface |
//! | [`app`] | the editor window: it shows and asks, and computes nothing itself |
//! | [`cli`] | the command line: parse, interpret, run |
//!
//! # Use as a library
//!
//! The following does what `quadratura build` does: it opens a project as a site, makes a rasteriser, and builds
//! the stack of every photo.
//!
//! ```no_run
//! use std::path::Path;
//!
//! use quadratura::gpu::{Gpu, GpuRasteriser};
//! use quadratura::io::stack_store::StackStore;
//! use quadratura::recipe::build::{BuildOptions, build};
//! use quadratura::recipe::open::open;
//! use quadratura::task::Task;
//!
//! # fn main() -> quadratura::Result<()> {
//! let folder = Path::new("project");
//! let task = Task::new(|event| println!("{event:?}"));
//! let opened = open(folder, &task)?;
//! let rasteriser = GpuRasteriser::new(&Gpu::headless()?)?;
//! let options = BuildOptions {
//!     layers: opened.project.options.clone(),
//!     decisions: opened.project.decisions.clone(),
//!     photos: Vec::new(), // all
//!     memory: 4 << 30,
//!     threads: 2,
//!     force: false,
//! };
//! for built in build(&opened.site, &StackStore::new(folder), &rasteriser, &options, &task)? {
//!     match built.stack {
//!         Ok(stack) => println!("{}: {} image layers", built.photo, stack.image_layers.len()),
//!         Err(error) => println!("{}: {error}", built.photo),
//!     }
//! }
//! # Ok(())
//! # }
//! ```

#![warn(missing_docs)]

pub mod error;
pub mod task;

mod geometry;
mod raster;
mod scene;

mod projection;

mod layers;

mod document;

mod gpu;
mod io;

mod recipe;

mod app;

mod cli;

pub use cli::run;
pub use error::{Error, Result};

#[doc(hidden)]
pub mod testing;

#[cfg(test)]
#[path = "../tests/common/left_out.rs"]
mod left_out;
