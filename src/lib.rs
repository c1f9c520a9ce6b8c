//! Quadratura turns calibrated photos of a site and a coarse polygon model into editable image
//! layers: for every photo it proves which surface hides which, gives every surface pixels of its
//! own, and writes the result as a layered file that an artist can paint on.
//!
//! The modules, bottom to top. An arrow may only point down this list; `tests/architecture.rs`
//! holds it.
//!
//! | module | what lives there |
//! |---|---|
//! | [`error`], [`task`] | whose fault; progress and stop |
//! | [`geometry`] | camera, lens, plane, polygon, rectangle: pure mathematics |
//! | [`scene`] | photo, model, site: what was photographed; immutable |
//! | [`projection`] | novel views: sheared frusta, which image layers serve a face, weights |
//! | [`layers`] | the method: occlusion graph, cycles, parts, visibility layers, clusters, content, filling |
//! | [`document`] | what is saved: the authored project, the derived stack |
//! | [`io`], [`gpu`] | files and passes; they do not know each other |
//! | [`recipe`] | open, sort, cluster, extract, fill, save: the program without a face |
//! | [`app`] | the editor window: shows and asks, never computes |
//! | [`cli`] | what was typed, what it means, run |
//!
//! # A program without a command line
//!
//! What `quadratura build` does, in six lines: a project becomes a site, a rasteriser is made, and every
//! photo gets its stack.
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
pub mod scene;

pub mod projection;

pub mod layers;

pub mod document;

pub mod gpu;
pub mod io;

pub mod recipe;

pub mod app;

pub mod cli;

pub use error::{Error, Result};

#[cfg(test)]
#[path = "../tests/common/left_out.rs"]
mod left_out;
