//! What a preview shows where no photo shows what is there, and how much of a view that is.

use glam::DVec2;

use super::Preview;
use super::estimates::shown_gains;
use crate::continuation::SiteContinuation;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_projection::framing::scaled;
use quadratura_projection::{LayerTextureId, Renders};
use quadratura_stacks::layer_textures::KNOWN;
use quadratura_view::{DisplayMode, Quality, Shot, Unseen};

/// The longer side of the picture by which it is found how much of a view continues, in pixels.
const SHARE_PX: f64 = 192.0;

impl Preview {
    /// Prepares what is shown where no photo shows what is there.
    pub(super) fn show_unseen(&mut self, unseen: Unseen, task: &Task) -> Result<()> {
        self.show_known_dome(unseen == Unseen::Empty, task)?;
        match unseen {
            Unseen::Marked | Unseen::Empty => Ok(()),
            Unseen::Continued => self.continue_surfaces(task),
        }
    }

    /// Shows the dome in all directions, or only in those that photos show.
    fn show_known_dome(&mut self, known: bool, task: &Task) -> Result<()> {
        if self.files.has_known_dome() == known {
            return Ok(());
        }
        let sides: Vec<LayerTextureId> = self.sources.dome_textures().collect();
        self.renew(self.files.clone().with_known_dome(known), &sides, task).map(drop)
    }

    /// Puts the colours with which surfaces continue on the device, if they are not there.
    fn continue_surfaces(&mut self, task: &Task) -> Result<()> {
        if self.continues {
            return Ok(());
        }
        let continuation = match self.continuation.take() {
            Some(continuation) => continuation,
            None => {
                task.timed("continue surfaces", || SiteContinuation::new(&self.folder, &self.site, task))?
            }
        };
        let gains = shown_gains(&self.gains_in_use, self.shows_gains, &self.around);
        let colours = task.timed("continue surfaces", || continuation.without(&self.without, &gains));
        self.continuation = Some(continuation);
        self.renderer.set_continuation(colours)?;
        self.continues = true;
        Ok(())
    }

    /// Returns the share of a view in which final pictures continue what no photo shows: surfaces, and the surroundings. It is
    /// found from a small picture of the view.
    ///
    /// # Errors
    /// As [`Renders::picture`].
    pub fn continued_share(&mut self, shot: &Shot, task: &Task) -> Result<f64> {
        let (width, height) = (shot.camera.width, shot.camera.height);
        let by = SHARE_PX / f64::from(width.max(height)).max(SHARE_PX);
        let shot = Shot {
            camera: scaled(&shot.camera, by),
            quality: Quality::Preview,
            display: DisplayMode::Colour,
            supersampled: false,
            linear: false,
            unseen: Unseen::Marked,
            ..shot.clone()
        };
        let (picture, faces) = (self.picture(&shot, task)?, self.seen_faces(&shot, task)?);
        let dome = self.around.dome.clone().filter(|_| shot.surroundings);
        let of_pixel = |(((x, y), pixel), face): (((i32, i32), &[u8; 4]), &u32)| match (&dome, face) {
            (Some(dome), 0) => {
                let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let direction = shot.pose.rotation.transpose() * shot.camera.ray_in_camera(px);
                f64::from(u8::from(dome.known(direction) < KNOWN))
            }
            (None, 0) if !shot.surroundings => 0.0,
            _ => 1.0 - f64::from(pixel[3]) / 255.0,
        };
        let pixels = picture.rect().pixels().zip(picture.pixels()).zip(&faces);
        Ok(pixels.map(of_pixel).sum::<f64>() / faces.len().max(1) as f64)
    }
}
