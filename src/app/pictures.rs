//! Pictures of photos on the window's device: small ones for lists, larger ones for looking.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use eframe::egui::{ColorImage, Context, TextureHandle, TextureOptions};

use crate::app::state::running::Running;
use crate::app::state::running::{JobId, Kind};
use crate::app::work::jobs::{Jobs, arrival};
use crate::projection::Picture;
use crate::recipe::open::Opened;
use crate::recipe::thumbnail::{cached_thumbnail, thumbnail};

/// The longer side of a small picture, in pixels: a list shows it at half of that on a dense display.
const SMALL: u32 = 256;
/// The longer side of a picture to look at over the view, in pixels: windows are seldom larger.
const LARGE: u32 = 2048;
/// So many large pictures are kept: the photo one looks through and its neighbours.
const MOST_LARGE: usize = 3;

struct Made {
    photo: usize,
    longest: u32,
    image: ColorImage,
}

/// The pictures of one project's photos.
pub struct Pictures {
    small: BTreeMap<usize, TextureHandle>,
    /// The one used last at the end.
    large: Vec<(usize, TextureHandle)>,
    making: Option<(usize, JobId)>,
    /// Photos of which no large picture could be made; why has been told.
    failed: BTreeSet<usize>,
    send: Sender<Made>,
    receive: Receiver<Made>,
}

impl Default for Pictures {
    fn default() -> Self {
        let (send, receive) = channel();
        Self {
            small: BTreeMap::new(),
            large: Vec::new(),
            making: None,
            failed: BTreeSet::new(),
            send,
            receive,
        }
    }
}

impl Pictures {
    /// Starts to make small pictures of all photos of the project in `folder`, or to read those that it keeps.
    pub fn start(&mut self, folder: &Path, opened: &Arc<Opened>, jobs: &mut Jobs, running: &mut Running) {
        let (folder, opened, send) = (folder.to_path_buf(), opened.clone(), self.send.clone());
        jobs.start(running, Kind::Thumbnails, "Looking at photos", move |task| {
            let photos = &opened.site.photos;
            for (place, photo) in photos.iter().enumerate() {
                task.step("thumbnails", place as u64, photos.len() as u64)?;
                // A photo that cannot be read is told of where it is needed.
                if let Ok(picture) = cached_thumbnail(&folder, photo, SMALL) {
                    let made = Made { photo: place, longest: SMALL, image: image(&picture) };
                    if send.send(made).is_err() {
                        break;
                    }
                }
            }
            Ok(arrival(|_| ()))
        });
    }

    /// Takes in what was made.
    pub fn take_in(&mut self, context: &Context) {
        // One in a frame: handing pictures to the device takes its time, and several may have been made in one.
        if let Ok(Made { photo, longest, image }) = self.receive.try_recv() {
            context.request_repaint();
            let texture =
                context.load_texture(format!("photo {photo} at {longest}"), image, TextureOptions::LINEAR);
            if longest == SMALL {
                self.small.insert(photo, texture);
            } else {
                self.making = None;
                self.large.push((photo, texture));
                if self.large.len() > MOST_LARGE {
                    drop(self.large.remove(0));
                }
            }
        }
    }

    /// The small picture of a photo, when it is made.
    pub fn small(&self, photo: usize) -> Option<&TextureHandle> {
        self.small.get(&photo)
    }

    /// The large picture of a photo; when it is not there, it is being made, and the small one has to do.
    pub fn large(
        &mut self,
        photo: usize,
        opened: &Arc<Opened>,
        jobs: &mut Jobs,
        running: &mut Running,
    ) -> Option<&TextureHandle> {
        if let Some(place) = self.large.iter().position(|(other, _)| *other == photo) {
            let used = self.large.remove(place);
            self.large.push(used);
            return self.large.last().map(|(_, texture)| texture);
        }
        if let Some((photo, _)) = self.making.take_if(|(_, job)| !running.is_running(*job)) {
            self.failed.insert(photo);
        }
        if self.making.is_none() && !self.failed.contains(&photo) {
            let (opened, send) = (opened.clone(), self.send.clone());
            let job = jobs.start(running, Kind::PhotoView, "Reading a photo", move |_| {
                let picture = thumbnail(&opened.site.photos[photo], LARGE)?;
                // Nobody waits for it any more where this fails.
                let _ = send.send(Made { photo, longest: LARGE, image: image(&picture) });
                Ok(arrival(|_| ()))
            });
            self.making = Some((photo, job));
        }
        self.small.get(&photo)
    }
}

/// A picture as egui holds it.
pub fn image(picture: &Picture) -> ColorImage {
    let size = [picture.width as usize, picture.height as usize];
    ColorImage::from_rgba_unmultiplied(size, &picture.rgba)
}
