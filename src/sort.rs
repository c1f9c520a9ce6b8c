//! The visibility sort finds for one photo which faces hide which, and the image layers that follow from it.
//!
//! Faces become *elements* (faces of one object that do not occlude each other), elements lie in *visibility layers*
//! (0 is hidden by nothing), and elements share *image layers*, rectangles of the photo. `docs/method.md` explains the
//! method. Fields of [`Sorted`] whose types are not listed here are intermediate results.
//!
//! # Sort a photo
//!
//! [`SoftwareRasteriser`] runs on the CPU and needs no graphics adapter.
//!
//! ```
//! use quadratura::project::open;
//! use quadratura::sort::{LayerConstraints, Options, SoftwareRasteriser, sort_photo};
//! use quadratura::task::Task;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let (project, _) = quadratura::testing::tiny_project(temporary.path())?;
//! let task = Task::silent();
//! let site = open(&project, &task)?.site;
//! let photo = &site.photos[0];
//! let sorted = sort_photo(
//!     &site.model,
//!     &photo.camera,
//!     &photo.pose,
//!     &SoftwareRasteriser,
//!     &Options::default(),
//!     &LayerConstraints::default(),
//!     &task,
//! )?;
//! for element in &sorted.layers.elements {
//!     println!("visibility layer {}: {}", element.visibility_layer, site.model.object(element.object).name);
//! }
//! let order: Vec<&str> =
//!     sorted.layers.elements.iter().map(|e| site.model.object(e.object).name.as_str()).collect();
//! assert_eq!(order, ["box", "wall"]);
//! # Ok(())
//! # }
//! ```
//!
//! # Sort on the GPU
//!
//! [`GpuRasteriser`] gives the same layers. It is made once and used for any number of photos.
//!
//! ```
//! use quadratura::Gpu;
//! use quadratura::sort::{LayerConstraints, GpuRasteriser, Options, sort_photo};
//! use quadratura::task::Task;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let (_, opened) = quadratura::testing::tiny_project(temporary.path())?;
//! # let site = opened.site;
//! let gpu = match Gpu::headless() {
//!     Ok(gpu) => gpu,
//!     Err(error) => {
//!         println!("{error}; the software rasteriser does the same on the CPU");
//!         return Ok(());
//!     }
//! };
//! let rasteriser = GpuRasteriser::new(&gpu)?;
//! let (options, constraints) = (Options::default(), LayerConstraints::default());
//! for photo in &site.photos {
//!     let (camera, pose, task) = (&photo.camera, &photo.pose, Task::silent());
//!     let sorted = sort_photo(&site.model, camera, pose, &rasteriser, &options, &constraints, &task)?;
//!     assert_eq!(sorted.layers.count(), 2);
//! }
//! # Ok(())
//! # }
//! ```

#[doc(inline)]
pub use quadratura_gpu::GpuRasteriser;
#[doc(inline)]
pub use quadratura_layers::cluster::{Cluster, Clusters, ElementPatch};
#[doc(inline)]
pub use quadratura_layers::content::{Content, PixelSpan};
#[doc(inline)]
pub use quadratura_layers::nodes::NodeId;
#[doc(inline)]
pub use quadratura_layers::parts::{Layers, SortedElement};
#[doc(inline)]
pub use quadratura_layers::projected_model::Absence;
#[doc(inline)]
pub use quadratura_layers::rasteriser::Presence;
#[doc(inline)]
pub use quadratura_layers::{
    BoxShape, ElementIndex, Item, ItemId, LayerConstraints, Method, Options, ProjectedModel, Rasteriser,
    SoftwareRasteriser, Sorted, sort_photo,
};
