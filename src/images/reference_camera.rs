//! The camera in which photos' layered depth images are combined, and these images.

use std::sync::Arc;

use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::PhotoId;
use quadratura_ldi::layout::LONGEST_SIDE;
use quadratura_ldi::{CommonCamera, Ldi};

/// The layered depth image of a photo's stack.
pub type OfPhoto = (Arc<Ldi>, PhotoId);

/// The camera of a layered depth image of photos.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceCamera {
    /// The camera, before it is scaled and grown.
    pub camera: Pinhole,
    /// The pose, world to camera.
    pub pose: Pose,
    /// The photo whose camera it is.
    pub photo: Option<PhotoId>,
    /// See [`Ldi::gain`].
    pub gain: [f64; 3],
}

impl ReferenceCamera {
    /// Returns the frame of the layered depth image, with the factor of the resolution and the guard band.
    ///
    /// # Errors
    /// [`Error::Request`] for a frame that is too large.
    pub(super) fn frame(&self, scale: f64, guard: f64) -> Result<CommonCamera> {
        let camera = scaled(&self.camera, scale);
        let frame = CommonCamera::new(camera, self.pose, self.gain, guard, self.photo.is_some());
        let Pinhole { width, height, .. } = frame.camera;
        if width.max(height) > LONGEST_SIDE {
            return Err(Error::Request(format!(
                "the frame of the layered depth image would have {width} x {height} pixels; its sides have at most \
                 {LONGEST_SIDE}: give a smaller --ldi-scale or --guard"
            )));
        }
        Ok(frame)
    }
}

/// Returns a camera of another resolution.
fn scaled(camera: &Pinhole, scale: f64) -> Pinhole {
    let side = |side: u32| (f64::from(side) * scale).round().max(1.0) as u32;
    let (width, height) = (side(camera.width), side(camera.height));
    let (x, y) = (f64::from(width) / f64::from(camera.width), f64::from(height) / f64::from(camera.height));
    Pinhole { width, height, fx: camera.fx * x, fy: camera.fy * y, cx: camera.cx * x, cy: camera.cy * y }
}
