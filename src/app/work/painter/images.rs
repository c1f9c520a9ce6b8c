//! The painter's layered depth images: they are built once pictures from them are requested.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use super::PainterQueue;
use crate::state::space::picture::PictureRequest;
use crate::work::priority::lower_own_priority;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_images::live::{LiveInputs, LivePicture, LiveStatus, LiveView, WarpOn};
use quadratura_sites::open::Opened;
use quadratura_view::Picture;
use quadratura_views::preview::Preview;

/// The layered depth images of a painter.
pub struct PainterImages {
    folder: PathBuf,
    /// The project with its present decisions.
    pub opened: Arc<Opened>,
    queue: Arc<PainterQueue>,
    /// Where they are drawn.
    on: WarpOn,
    /// The images, once they were asked for.
    live: Option<LiveView>,
    /// Whether the project has changed since.
    is_former: bool,
}

impl PainterImages {
    /// Has no images yet of the project in `folder`.
    pub fn new(folder: PathBuf, opened: Arc<Opened>, queue: Arc<PainterQueue>, on: WarpOn) -> Self {
        Self { folder, opened, queue, on, live: None, is_former: false }
    }

    /// Marks images as those of a former state of the project.
    pub fn changed(&mut self) {
        self.is_former = true;
    }

    /// Draws the requested picture, if it is to be drawn from layered depth images and there is one, and says what there is.
    /// What cannot be built is said, too; only faults of the device are errors.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::Cancelled`].
    pub fn drawn(
        &mut self,
        preview: &mut Preview,
        request: &PictureRequest,
        task: &Task,
    ) -> Result<(Option<Picture>, Option<LiveStatus>)> {
        let Some(options) = request.from.options() else { return Ok((None, None)) };
        let shown = self
            .live(preview, task)
            .and_then(|live| live.picture(preview, &request.shot, &options, Instant::now(), task));
        match shown {
            Ok(LivePicture { picture, status, changes }) => {
                self.queue.state().again |= changes && picture.is_some();
                Ok((picture, Some(status)))
            }
            Err(error @ (Error::Gpu(_) | Error::Cancelled)) => Err(error),
            Err(error) => {
                Ok((None, Some(LiveStatus { fault: Some(error.to_string()), ..LiveStatus::default() })))
            }
        }
    }

    /// Returns the images of the present state of the project; the first time their builder is started.
    fn live(&mut self, preview: &mut Preview, task: &Task) -> Result<&mut LiveView> {
        let inputs =
            |preview: &mut Preview| LiveInputs::new(self.folder.clone(), self.opened.clone(), preview, task);
        let is_former = std::mem::take(&mut self.is_former);
        match &mut self.live {
            Some(live) if is_former => live.renew(inputs(preview)?),
            Some(_) => (),
            None => {
                let queue = self.queue.clone();
                let notify = move || queue.draw_again();
                self.live =
                    Some(LiveView::new(inputs(preview)?, self.on.clone(), lower_own_priority, notify)?);
            }
        }
        self.live.as_mut().ok_or_else(super::failed)
    }
}

impl PainterQueue {
    /// Draws the last picture again, if that was drawn from layered depth images.
    fn draw_again(&self) {
        self.state().again = true;
        self.wake.notify_one();
    }
}
