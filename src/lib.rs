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
//! # Features
//!
//! `gui` is the window ([`app`]), `cli` the command line ([`cli`]) and with it the program; both are on by default.
//! Programs that embed the library leave them out with `default-features = false`; all other modules stay.
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

pub mod error;
pub mod task;

pub mod geometry;
pub mod raster;
pub mod scene;

pub mod projection;

pub mod layers;

pub mod document;

pub mod gpu;
pub mod io;

pub mod recipe;

#[cfg(feature = "gui")]
pub mod app;

#[cfg(feature = "cli")]
pub mod cli;

pub use error::{Error, Result};

#[cfg(test)]
#[path = "../tests/common/left_out.rs"]
mod left_out;
