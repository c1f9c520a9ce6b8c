//! Novel views: image layers are projected back onto the model and blended, for any viewpoint.
//!
//! # Render a view
//!
//! [`open_preview`] makes the renderer of a project on the GPU.
//!
//! ```
//! use quadratura::Gpu;
//! use quadratura::cameras::Pose;
//! use quadratura::glam::DVec3;
//! use quadratura::project::open;
//! use quadratura::render::{PreviewOptions, Renders, Shot, open_preview};
//! use quadratura::task::Task;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let (project, _) = quadratura::testing::tiny_stacks(temporary.path())?;
//! let task = Task::silent();
//! let opened = open(&project, &task)?;
//! let Ok(gpu) = Gpu::headless() else { return Ok(()) };
//! let mut renderer = open_preview(&project, &opened.project, &opened.site, &gpu, &PreviewOptions::default(), &task)?;
//!
//! // Between the two photos.
//! let (left, right) = (&opened.site.photos[0], &opened.site.photos[1]);
//! let translation = DVec3::midpoint(left.pose.translation, right.pose.translation);
//! let shot = Shot::new(left.camera, Pose { translation, ..left.pose });
//! let picture = renderer.picture(&shot, &task)?;
//! let textured = picture.pixels().iter().filter(|pixel| pixel[3] > 0).count();
//! println!("{textured} of {} pixels are textured", picture.rect().area());
//! assert!(renderer.problems().is_empty());
//! # assert!(textured > 0);
//! # Ok(())
//! # }
//! ```
//!
//! # Write pictures without a GPU
//!
//! [`open_reference`] makes a renderer on the CPU. It is slow, and it is the reference to which the GPU's is compared.
//!
//! ```
//! use quadratura::render::{
//!     Appearance, PreviewOptions, RenderOptions, Renders, RequestedView, Size, ViewRequest,
//!     open_reference, render,
//! };
//! use quadratura::task::Task;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let (project, opened) = quadratura::testing::tiny_stacks(temporary.path())?;
//! # let out = temporary.path().join("views");
//! let task = Task::silent();
//! let plain = PreviewOptions { gains: false, relief: false, agreement: false, ..PreviewOptions::default() };
//! let mut renderer = open_reference(&project, &opened.project, &opened.site, &plain, &task)?;
//!
//! let request = ViewRequest { size: Size::Scaled(0.5), ..ViewRequest::default() };
//! let views = opened.views(&request, &task)?;
//! let look = Appearance { without_backs: true, ..Appearance::default() };
//! let mut draw =
//!     |view: &RequestedView, task: &Task| renderer.picture(&look.shot(view.camera, view.pose), task).map(Into::into);
//! let report = render(&views.list, &mut draw, &RenderOptions { out, ..RenderOptions::default() }, &task)?;
//! for view in &report.done {
//!     println!("{}: {} x {}, {:.0} % textured", view.view, view.width, view.height, 100.0 * view.textured);
//! }
//! assert_eq!((report.done.len(), report.failed.len()), (2, 0));
//! # assert!(report.done[0].path.is_file());
//! # Ok(())
//! # }
//! ```
//!
//! # Score the photos against views of the others
//!
//! ```
//! use quadratura::render::{PreviewOptions, ScoreOptions, leave_one_out, open_reference, score};
//! use quadratura::task::Task;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let (project, opened) = quadratura::testing::tiny_stacks(temporary.path())?;
//! let task = Task::silent();
//! let plain = PreviewOptions { gains: false, relief: false, agreement: false, ..PreviewOptions::default() };
//! let mut renderer = open_reference(&project, &opened.project, &opened.site, &plain, &task)?;
//! let targets = leave_one_out(&opened.site);
//! let model = &opened.site.model;
//! let report = score(model, &targets, &mut renderer, &ScoreOptions::default(), &task)?;
//! let mean = report.mean.expect("there are photos");
//! println!("{:.0} % predicted, {:.1} dB with holes", 100.0 * mean.coverage, mean.with_holes.psnr);
//! assert!(mean.covered.is_some_and(|covered| covered.psnr > 20.0));
//! # Ok(())
//! # }
//! ```

#[doc(inline)]
pub use quadratura_base::scene::PhotoId;
#[doc(inline)]
pub use quadratura_projection::twin::ReferenceRenderer;
#[doc(inline)]
pub use quadratura_projection::{Renders, TextureOptions};
#[doc(inline)]
pub use quadratura_sites::views::{RequestedView, RequestedViews, Size, ViewRequest, ViewSource, views};
#[doc(inline)]
pub use quadratura_view::metrics::{ImageMetrics, ImagePair};
#[doc(inline)]
pub use quadratura_view::{Blend, DisplayMode, Exposure, LinearPicture, Mode, Picture, Quality, Shot};
#[doc(inline)]
pub use quadratura_views::preview::{Preview, PreviewOptions, open as open_preview, open_reference};
#[doc(inline)]
pub use quadratura_views::render::{
    Appearance, Draw, DrawnPicture, PictureFormat, RenderOptions, RenderReport, RenderedView, VideoOptions,
    render,
};
#[doc(inline)]
pub use quadratura_views::score::{
    MeanMetrics, MeanScore, ObjectScore, PredictionTarget, ScoreOptions, ScoreReport, ViewScore, held_out,
    leave_one_out, score,
};
