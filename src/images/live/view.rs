//! The renderer: it draws the layered depth image that there is, and never waits for another one.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use super::billboards::Billboards;
use super::builder::{Builder, Made};
use super::fade::{FADE, mixed, share_after};
use super::making::make_all;
use super::request::{BuiltImage, ImageRequest, LiveInputs, LiveOptions, RequestStage};
use super::rows::{drawn_rows, rows_of};
use super::warper::{OnDevice, WarpOn, Warper};
use crate::StackLdiOptions;
use crate::choice::{add_beside, best_photos, better_photos};
use crate::exposed_shot::ExposedShot;
use crate::site_view::{halvings, over};
use quadratura_base::error::Result;
use quadratura_base::scene::{Model, PhotoId};
use quadratura_base::task::Task;
use quadratura_ldi::WarpOptions;
use quadratura_ldi::cracks::closed;
use quadratura_projection::exposure::Shares;
use quadratura_projection::{Renders, shown_face};
use quadratura_sites::budget::default_memory;
use quadratura_view::{Picture, Quality, Shot};
use quadratura_views::preview::Preview;

/// The number of photos of one image.
const BEST: usize = 3;

/// Of this many pixels of a row, one where an image is empty behind a billboard is a hole in a face; more are where no face is.
const HOLES: usize = 100;

/// An image that is drawn.
struct LiveImage {
    image: OnDevice,
    /// The photos that it was made of; its colours have the exposure of the first one.
    photos: Vec<PhotoId>,
    /// How much it has of what was requested.
    stage: RequestStage,
}

/// Draws views of a project from layered depth images.
pub struct LiveView {
    inputs: Arc<LiveInputs>,
    builder: Builder<ImageRequest, BuiltImage>,
    warper: Warper,
    images: Images,
}

/// The images of a view: the newest one, and the one that it fades from.
#[derive(Default)]
struct Images {
    newest: Option<LiveImage>,
    /// The image before, and when the newest one came.
    before: Option<(LiveImage, Instant)>,
    /// The newest request.
    request: Option<ImageRequest>,
    /// Why the newest request cannot be made.
    fault: Option<String>,
}

/// What is drawn, and what is about to be.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LiveStatus {
    /// The photos of the image that is drawn, the reference first; none where there is no image yet.
    pub photos: Vec<PhotoId>,
    /// Depth pixels for each layered depth pixel that holds any, of the image that is drawn.
    pub depth_complexity: f64,
    /// The largest number of depth pixels at one position of it, before any were left out.
    pub layers: u32,
    /// The photos of the image that is being built, the reference first; none where nothing is.
    pub building: Vec<PhotoId>,
    /// Why there is no image of the photos that the view needs.
    pub fault: Option<String>,
}

/// A view that was drawn.
pub struct LivePicture {
    /// The picture; none where there is no image yet, or no complete one.
    pub picture: Option<Picture>,
    /// What is drawn.
    pub status: LiveStatus,
    /// Whether the next picture of the same view will be another one, because this one fades.
    pub changes: bool,
}

impl LiveView {
    /// Starts the builder of a project's images, which are drawn `on` a device or the processor. It calls `begin` on its thread,
    /// which gives that a low priority, and `tell` whenever there is something new to draw.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Request`] when the system cannot start a thread.
    pub fn new(
        inputs: LiveInputs,
        on: WarpOn,
        begin: fn(),
        tell: impl Fn() + Send + Sync + 'static,
    ) -> Result<Self> {
        // The other half of the budget is for the texels of the model.
        let memory = default_memory() / 2;
        let builder = Builder::start(begin, tell, move |bench| make_all(bench, memory))?;
        Ok(Self { inputs: Arc::new(inputs), builder, warper: Warper::new(on), images: Images::default() })
    }

    /// Draws what the project has become from now on; images of the former state are drawn until there are others.
    pub fn renew(&mut self, inputs: LiveInputs) {
        self.inputs = Arc::new(inputs);
    }

    /// Draws a view from the image that there is at the time `now`, and requests another one where that shows clearly less
    /// than others would.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Gpu`], [`quadratura_base::Error::Cancelled`].
    pub fn picture(
        &mut self,
        preview: &mut Preview,
        shot: &Shot,
        options: &LiveOptions,
        now: Instant,
        task: &Task,
    ) -> Result<LivePicture> {
        let model = &self.inputs.opened.site.model.clone();
        let (mut shares, exposure) = preview.shares_and_exposure(shot, model);
        let best = best_photos(&shares, BEST);
        if !best.is_empty() && best.len() < BEST {
            let without = shot.without.iter().copied().chain(best).collect();
            add_beside(&mut shares, &preview.shares_and_exposure(&Shot { without, ..shot.clone() }, model).0);
        }
        let view = ExposedShot { shot, exposure: &exposure };
        let mut drawn = self.drawn(&shares, view, options, now, task)?;
        if let Some(picture) = drawn.picture.as_mut() {
            *picture = completed(picture, preview, model, view, options, task)?;
        }
        Ok(drawn)
    }

    /// Draws a view of which it is known how much each photo contributes to it, and its exposure.
    fn drawn(
        &mut self,
        shares: &Shares,
        view: ExposedShot,
        options: &LiveOptions,
        now: Instant,
        task: &Task,
    ) -> Result<LivePicture> {
        if let Some(request) = self.wanted(shares, view.shot, options) {
            self.images.request = Some(request.clone());
            self.images.fault = None;
            self.builder.request(request);
        }
        self.builder.take().into_iter().for_each(|made| self.images.take(made, now));
        let picture = match options.complete && self.builder.is_busy() {
            true => None,
            false => self.images.picture(&mut self.warper, view, now, task)?,
        };
        let building = match (&self.images.request, self.builder.is_busy()) {
            (Some(request), true) => request.photos.clone(),
            _ => Vec::new(),
        };
        let changes = self.images.before.is_some();
        let mut status = self.images.status(building);
        if picture.is_none() {
            status.photos.clear();
        }
        Ok(LivePicture { picture, status, changes })
    }

    /// Returns the request for what a view needs; none where it was requested already.
    fn wanted(&self, shares: &Shares, shot: &Shot, options: &LiveOptions) -> Option<ImageRequest> {
        let requested = self.images.request.as_ref();
        let present = requested.map_or(&[][..], |request| &request.photos);
        let photos = better_photos(shares, present, BEST).unwrap_or_else(|| present.to_vec());
        let camera = &self.inputs.opened.site.photo(*photos.first()?).camera;
        // Images are made while the view moves, and pictures at rest are made of the same ones.
        let needed = halvings(camera.fx / (shot.camera.fx * options.larger), Quality::Preview);
        // A finer image than is needed stays: its levels are coarser.
        let known =
            requested.filter(|request| request.photos == photos).map_or(u32::MAX, |request| request.halvings);
        let stack = StackLdiOptions { relief: shot.relief, filled: true, surroundings: false };
        let request = ImageRequest {
            inputs: self.inputs.clone(),
            photos,
            halvings: needed.min(known),
            peeled: options.peeled,
            stack,
        };
        requested.is_none_or(|requested| !requested.is_same(&request)).then_some(request)
    }
}

/// Completes a view of images with what the projective renderer has: the surroundings, which are one dome where several photos show
/// them, trees, and billboards that turn.
fn completed(
    picture: &Picture,
    preview: &mut Preview,
    model: &Model,
    view: ExposedShot,
    options: &LiveOptions,
    task: &Task,
) -> Result<Picture> {
    let ExposedShot { shot, exposure } = view;
    // Where layers are hidden, the images have their billboards, too.
    let has_billboards = options.peeled == 0 && model.has_impostors();
    if !(shot.surroundings || has_billboards) {
        return Ok(closed(picture, None));
    }
    let faces = preview.seen_faces(shot, task)?;
    let billboards = match has_billboards {
        true => Billboards::drawn(preview, model, view, &faces, task)?,
        false => None,
    };
    // Between leaves one sees past a face.
    let image = closed(picture, shot.surroundings.then_some(&faces));
    let behind = match shot.surroundings {
        true => {
            let around = Shot { hidden: model.face_ids().collect(), backs: false, ..shot.clone() };
            let is_empty = |row: Range<usize>| {
                let is_open = |at: &usize| {
                    let is_billboard = billboards.as_ref().is_some_and(|billboards| billboards.is_shown(*at));
                    is_billboard && image.pixels()[*at][3] < u8::MAX
                };
                row.clone().any(|at| shown_face(faces[at]).is_none())
                    || row.clone().filter(is_open).count() * HOLES > row.len()
            };
            let rows = rows_of(is_empty, [shot.camera.width, shot.camera.height]);
            Some(drawn_rows(preview, ExposedShot { shot: &around, exposure }, rows, task)?)
        }
        false => None,
    };
    let view = behind.as_ref().map(|behind| over(&image, behind, &faces));
    let view = view.unwrap_or(image);
    Ok(billboards.map(|billboards| billboards.over(&view, behind.as_ref())).unwrap_or(view))
}

impl Images {
    /// Takes what the builder has made.
    fn take(&mut self, made: Made<BuiltImage>, now: Instant) {
        let BuiltImage { ldi, photos, stage } = match made.result {
            Ok(built) => built,
            Err(error) => return self.fault = Some(error.to_string()),
        };
        // A draft is better than nothing, but not than what is there.
        if self.newest.as_ref().is_some_and(|newest| stage < newest.stage) {
            return;
        }
        let image = LiveImage { image: OnDevice::new(ldi), photos, stage };
        self.before = self.newest.replace(image).map(|before| (before, now));
    }

    /// Draws the newest image, mixed with the one before it for a moment.
    fn picture(
        &mut self,
        warper: &mut Warper,
        view: ExposedShot,
        now: Instant,
        task: &Task,
    ) -> Result<Option<Picture>> {
        self.before.take_if(|(_, since)| now.saturating_duration_since(*since) >= FADE);
        let Some(newest) = &mut self.newest else { return Ok(None) };
        let new = drawn(warper, newest, view, task)?;
        let Some((before, since)) = &mut self.before else { return Ok(Some(new)) };
        let old = drawn(warper, before, view, task)?;
        Ok(Some(mixed(&old, &new, share_after(now.saturating_duration_since(*since)))))
    }

    fn status(&self, building: Vec<PhotoId>) -> LiveStatus {
        let fault = self.fault.clone();
        match &self.newest {
            None => LiveStatus { building, fault, ..LiveStatus::default() },
            Some(LiveImage { image, photos, .. }) => LiveStatus {
                photos: photos.clone(),
                depth_complexity: image.ldi.report.depth_complexity,
                layers: image.ldi.report.layers,
                building,
                fault,
            },
        }
    }
}

fn drawn(warper: &mut Warper, image: &mut LiveImage, view: ExposedShot, task: &Task) -> Result<Picture> {
    let shot = Shot { backs: false, ..view.shot.clone() };
    let exposure = view.exposure.factor(image.photos[0]).map(f64::ln);
    let options = WarpOptions { exposure, ..WarpOptions::default() };
    warper.picture(&mut image.image, &shot, &options, task)
}

#[cfg(test)]
mod tests;
