//! Quadratura turns calibrated photos of a site and a coarse polygon model into editable image
//! layers: for every photo it proves which surface occludes which, gives every surface pixels of its
//! own, and writes the result as a layered file that an artist can paint on.
//!
//! This is the library of the program of the same name, for programs that embed it.
//!
//! | module | what people do with it |
//! |---|---|
//! | [`cameras`] | read cameras, project points |
//! | [`site`] | match photos, read and make models, check that both are aligned |
//! | [`project`] | create and open projects |
//! | [`sort`] | sort the faces that one photo sees, on the CPU or the GPU |
//! | [`stack`] | build the image layers of all photos and walk them |
//! | [`fill`] | fill what a photo does not show |
//! | [`layered`] | write PSD, XCF and OpenRaster, and import them once they were painted on |
//! | [`render`] | render novel views as pictures and videos, and score them |
//! | [`edit`] | merge, split, name, exclude and pin |
//! | [`task`], [`error`] | progress and cancellation; errors with their causes and remedies |
//!
//! # Features
//!
//! `gui` is the window, `cli` the command line and with it the program; both are on by default. Programs that embed the
//! library leave them out with `default-features = false`; all of the above stays.
//!
//! # From photos to layers
//!
//! The following makes a project, builds the stack of every photo, and writes each as a PSD.
//!
//! ```
//! use quadratura::layered::{ExportOptions, export};
//! use quadratura::project::{NewProject, create_project};
//! use quadratura::sort::SoftwareRasteriser;
//! use quadratura::stack::{BuildOptions, StackStore, build};
//! use quadratura::task::Task;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let folder = temporary.path();
//! # quadratura::testing::tiny_site(folder)?;
//! let new = NewProject {
//!     photos: folder.join("photos"),
//!     cameras: folder.join("sparse"), // COLMAP, Bundler, or transforms.json
//!     model: folder.join("model.obj"),
//!     ..NewProject::default()
//! };
//! let (project, task) = (folder.join("project"), Task::silent());
//! let opened = create_project(&project, &new, &task)?;
//!
//! let store = StackStore::new(&project);
//! for built in build(&opened.site, &store, &SoftwareRasteriser, &BuildOptions::default(), &task)? {
//!     match built.stack {
//!         Ok(stack) => println!("{}: {} image layers", built.photo, stack.image_layers.len()),
//!         Err(error) => println!("{}: {error}", built.photo),
//!     }
//! }
//!
//! let photos = opened.photos_named(&[])?; // all
//! let exported = export(&project, &photos, &folder.join("layers"), &ExportOptions::default(), &task)?;
//! assert_eq!(exported.done.len(), 2);
//! assert!(folder.join("layers/left.png.psd").is_file());
//! # Ok(())
//! # }
//! ```
//!
//! # Errors
//!
//! [`Error::Input`] says which file is wrong, where, what was found, and what to do. What concerns one photo or file of
//! many is in the result and does not stop the others.
//!
//! ```
//! use std::path::Path;
//!
//! use quadratura::Error;
//! use quadratura::cameras::read_cameras;
//! use quadratura::task::Task;
//!
//! match read_cameras(Path::new("no-such-folder"), &Task::silent()) {
//!     Err(Error::Input { file, found, remedy, .. }) => println!("{}: {found}; {remedy}", file.display()),
//!     Err(error) => println!("{error}"),
//!     Ok(_) => unreachable!("there is no such folder"),
//! }
//! ```
//!
//! # Conventions
//!
//! Pixel (0, 0) is the top-left one and its centre is (0.5, 0.5); x points right, y down. A camera looks along z. Poses
//! map the world to the camera. Coordinates are `f64` with the types of [`glam`]. Colours are sRGB with straight alpha
//! unless something else is said. The same input gives the same bytes, for any number of threads.
//!
//! # For contributors
//!
//! The program is a workspace of packages, one in each folder of `src`, named `quadratura-base`, `quadratura-projection` and so on.
//! They are listed bottom to top. Each may use only the packages above it in this table, which `tests/architecture.rs`
//! verifies in their manifests; `files`, `view` and `align` do not use each other, nor do `import`, `suggest` and `page`, `projection`, `foliage` and `ldi`, nor `images`,
//! `exports` and `gpu`. The public modules above only name items of them.
//!
//! | package | contents |
//! |---|---|
//! | `base` | errors and progress; mathematics; pixels on a grid; photos, model and site: the photographed scene |
//! | `files` | what every reader and writer needs: files that are replaced in one step, JSON, text, hashes, locks |
//! | `view` | what is asked of a novel view and what it gives back; weights of photos, legends, metrics, flights |
//! | `align` | the rotation, scale and shift that lay a model on sparse points |
//! | `import` | what other programs made of a site: cameras, models and photos |
//! | `suggest` | a first model from photos and sparse points |
//! | `page` | folders that a browser opens |
//! | `projection` | novel views of layers: sheared frusta, the image layers that serve a face, exposure, relief |
//! | `foliage` | plants: graphs of sub-objects, their generator, pictures of all their polygons, and their files |
//! | `ldi` | layered depth images: layout, order, splats, warp, and their files |
//! | `layers` | the method: occlusion graph, cycles, parts, visibility layers, clusters, content, filling |
//! | `document` | what is saved: the authored project and the derived stacks |
//! | `layered_files` | the files that image editors read and write: PSD, XCF, OpenRaster, folders |
//! | `io` | files of a project |
//! | `handover` | the site in the formats of other programs |
//! | `sites` | whole tasks, without a user interface and without a device; first those on a site: find, open, check, mask |
//! | `stacks` | build, decide, fill, update; the estimates that all photos share |
//! | `trees` | place, draw and light trees |
//! | `views` | preview, render, score, orthophotos |
//! | `editing` | export to image editors, import, strokes |
//! | `images` | layered depth images of a site |
//! | `exports` | hand-over to other programs, and the page |
//! | `gpu` | GPU passes: what `layers` and `ldi` ask of a device |
//! | `app` | the editor window: it shows and asks, and computes nothing itself |
//! | `cli` | the command line: parse, interpret, run |

#![warn(missing_docs)]

pub mod cameras;
pub mod edit;
pub mod error;
pub mod fill;
pub mod layered;
pub mod project;
pub mod render;
pub mod site;
pub mod sort;
pub mod stack;
pub mod task;

pub use error::{Error, Result};
pub use glam;
#[cfg(feature = "cli")]
pub use quadratura_cli::run;
#[doc(inline)]
pub use quadratura_gpu::Gpu;

#[doc(hidden)]
pub mod testing;
