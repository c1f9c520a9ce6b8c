//! Cameras say where photos were taken, and which pixel shows a point of the world.
//!
//! Lengths in images are in pixels: pixel (0, 0) is the top-left one and its centre is (0.5, 0.5); x points right, y
//! down. In a camera's frame z points forward. The world's unit and axes are those of the reconstruction.
//!
//! # Read cameras
//!
//! [`read_cameras`] reads a file or folder of any reconstruction that the program reads: those of COLMAP, Metashape, Meshroom,
//! OpenSfM, OpenMVG, nerfstudio, VisualSFM, Bundler, RealityScan, fSpy, Pix4D, MVE and Polycam.
//!
//! ```
//! use quadratura::cameras::read_cameras;
//! use quadratura::task::Task;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let temporary = tempfile::tempdir()?;
//! # let folder = temporary.path();
//! # quadratura::testing::tiny_site(folder)?;
//! let cameras = read_cameras(&folder.join("sparse"), &Task::silent())?;
//! for photo in &cameras.photos {
//!     let at = photo.pose.center_in_world();
//!     println!("{}: {} x {} pixels at {at}", photo.name, photo.camera.width, photo.camera.height);
//! }
//! // A camera that cannot be used is reported and leaves out only its own photo.
//! assert!(cameras.problems.is_empty());
//! assert_eq!(cameras.photos[0].name, "left.png");
//! # Ok(())
//! # }
//! ```
//!
//! # Project a point
//!
//! ```
//! use quadratura::cameras::{Pinhole, Pose};
//! use quadratura::glam::{DMat3, DVec2, DVec3};
//!
//! let camera = Pinhole { width: 640, height: 480, fx: 600.0, fy: 600.0, cx: 320.0, cy: 240.0 };
//! let pose = Pose { rotation: DMat3::IDENTITY, translation: DVec3::new(0.0, 0.0, 2.0) };
//!
//! let in_camera = pose.camera_from_world(DVec3::new(1.0, 0.0, 1.0));
//! assert_eq!(camera.image_from_camera(in_camera), Some(DVec2::new(520.0, 240.0)));
//!
//! // A point behind the camera has no image.
//! assert_eq!(camera.image_from_camera(DVec3::NEG_Z), None);
//! ```

#[doc(inline)]
pub use quadratura_base::geometry::{Lens, Pinhole, PixelRect, Pose, RollingShutter, Similarity};
#[doc(inline)]
pub use quadratura_base::scene::SparsePoint;
#[doc(inline)]
pub use quadratura_import::cameras::{
    CameraOptions, CameraPhoto, Cameras, Reprojection, read_cameras, read_cameras_as, read_cameras_of,
};
