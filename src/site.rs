//! A site is photos with their cameras, and a coarse model, all in one world.
//!
//! # Match photos with their cameras
//!
//! [`import_photos`] finds the file of each photo and checks its size. A photo with lens distortion is resampled once,
//! into a cache folder; from then on every photo is a pinhole image.
//!
//! ```
//! use quadratura::cameras::read_cameras;
//! use quadratura::site::{Site, import_photos, read_model};
//! use quadratura::task::Task;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let folder = temporary.path();
//! # quadratura::testing::tiny_site(folder)?;
//! let task = Task::silent();
//! let cameras = read_cameras(&folder.join("sparse"), &task)?;
//! let import = import_photos(&cameras, &folder.join("photos"), &folder.join("cache"), &task)?;
//! for (photo, problem) in import.left_out.iter().zip(&import.problems) {
//!     println!("{photo} is left out: {problem}");
//! }
//! let (model, notes) = read_model(&folder.join("model.obj"), &task)?;
//! notes.iter().for_each(|note| println!("{note}"));
//!
//! let site = Site { photos: import.photos, model: model.into() };
//! assert_eq!((site.photos.len(), site.model.faces.len()), (2, 2));
//! # Ok(())
//! # }
//! ```
//!
//! # Make a model in code
//!
//! ```
//! use quadratura::glam::DVec3;
//! use quadratura::site::ModelBuilder;
//! use quadratura::task::Task;
//!
//! # fn main() -> quadratura::Result<()> {
//! let mut builder = ModelBuilder::new();
//! let wall = builder.object("wall");
//! let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]];
//! let ring = corners.map(|[x, z]| builder.vertex(DVec3::new(x, 0.0, z)));
//! // The outline is counter-clockwise seen from the side that is visible.
//! builder.face(wall, &ring);
//!
//! let (model, flaws) = builder.finish(&Task::silent())?;
//! assert!(flaws.is_empty());
//! let face = model.face_ids().next().expect("a face was added");
//! assert_eq!(model.face_name(face), "wall[0]");
//! assert_eq!(model.face(face).plane.signed_distance(DVec3::new(1.0, -2.0, 1.0)), 2.0);
//! # Ok(())
//! # }
//! ```
//!
//! # Check that the model is aligned with the photos
//!
//! ```
//! use quadratura::project::open;
//! use quadratura::site::{CheckOptions, check_site};
//! use quadratura::sort::SoftwareRasteriser;
//! use quadratura::task::Task;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let (project, _) = quadratura::testing::tiny_project(temporary.path())?;
//! let task = Task::silent();
//! let opened = open(&project, &task)?;
//! let options = CheckOptions {
//!     world_from_model: opened.project.world_from_model,
//!     pictures: Some(project.join("check")), // each photo with the model's edges
//!     ..CheckOptions::default()
//! };
//! let report = check_site(&opened.site, &opened.points, &options, &SoftwareRasteriser, &task)?;
//! println!("{:?}: the model covers {:.0} % of the photos", report.verdict, 100.0 * report.covered);
//! assert_eq!(report.faces.unseen.count, 0);
//! assert!(report.photos[0].picture.as_ref().is_some_and(|picture| picture.is_file()));
//! # Ok(())
//! # }
//! ```

#[doc(inline)]
pub use quadratura_base::geometry::Plane;
#[doc(inline)]
pub use quadratura_base::geometry::polygon::OutlineFlaw;
#[doc(inline)]
pub use quadratura_base::scene::{
    CameraExposure, Face, FaceFlaw, FaceId, FaceIndex, Model, ModelBuilder, Object, ObjectId, Photo, PhotoId,
    PhotoPixels, Samples, Site,
};
#[doc(inline)]
pub use quadratura_import::models::read_model;
#[doc(inline)]
pub use quadratura_import::photo::read_photo;
#[doc(inline)]
pub use quadratura_io::unmasked::read_unmasked;
#[doc(inline)]
pub use quadratura_sites::check::{
    AlignmentSuggestion, AlternativeTransform, CheckOptions, CheckReport, FaceReport, Intersection,
    Names as FaceNames, PhotoReport, SearchOutcome, Verdict, check_site,
};
#[doc(inline)]
pub use quadratura_sites::named::{index_of_photo, photos_named};
#[doc(inline)]
pub use quadratura_sites::photos::{PhotoImport, import_photos};
#[doc(inline)]
pub use quadratura_stacks::survey::face_named;
