//! Filling gives colour to texels that a photo does not show: from other photos, from paint in them, or by inpainting.
//!
//! ```
//! use quadratura::fill::{FillOptions, FillRequest, FillShares, Invent, fill};
//! use quadratura::project::open;
//! use quadratura::task::Task;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let (project, _) = quadratura::testing::tiny_stacks(temporary.path())?;
//! let task = Task::silent();
//! let opened = open(&project, &task)?;
//! let request = FillRequest {
//!     options: FillOptions { invent: Invent::Diffusion, ..FillOptions::default() },
//!     ..FillRequest::default()
//! };
//! for filled in fill(&project, &opened.project, &opened.site, &request, &task)? {
//!     let shares = FillShares::from_stack(&filled.stack?);
//!     println!("{}: {:.0} % of the hidden texels", filled.photo, 100.0 * shares.from_photos);
//!     assert!(shares.from_photos > 0.0, "the other photo shows what this one does not");
//!     assert_eq!(shares.empty, 0.0);
//! }
//! # Ok(())
//! # }
//! ```

#[doc(inline)]
pub use quadratura_layers::fill::{FillOptions, Invent};
#[doc(inline)]
pub use quadratura_stacks::fill::{FillRequest, FillShares, FilledPhoto, fill, tell as preview_propagation};
