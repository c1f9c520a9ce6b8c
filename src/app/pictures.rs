//! Pictures of photos as textures: thumbnails for lists, and larger ones to show over the view.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use eframe::egui::{ColorImage, Context, TextureHandle, TextureOptions};

use crate::app::state::running::Running;
use crate::app::state::running::{JobId, JobKind};
use crate::app::work::jobs::{Jobs, arrival};
use crate::projection::Picture;
use crate::recipe::open::Opened;
use crate::recipe::thumbnail::{cached_thumbnail, thumbnail};

/// The longer side of a thumbnail, in pixels: a list shows it at half of that on a dense display.
const SMALL: u32 = 256;
/// The longer side of a large picture, in pixels: windows are seldom larger.
const LARGE: u32 = 2048;
/// The number of large pictures that are kept: the photo in use and its neighbours.
const MOST_LARGE: usize = 3;

struct MadePicture {
    photo: usize,
    longest: u32,
    image: ColorImage,
}

/// The pictures of one project's photos.
pub struct Pictures {
    small: BTreeMap<usize, TextureHandle>,
    /// The large pictures by photo, the one used last at the end.
    large: Vec<(usize, TextureHandle)>,
    making: Option<(usize, JobId)>,
    /// Photos whose large picture failed; the error has been reported.
    failed: BTreeSet<usize>,
    send: Sender<MadePicture>,
    receive: Receiver<MadePicture>,
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
    /// Starts the job that makes the thumbnails of the project in `folder`, or loads cached ones.
    pub fn start(&mut self, folder: &Path, opened: &Arc<Opened>, jobs: &mut Jobs, running: &mut Running) {
        let (folder, opened, send) = (folder.to_path_buf(), opened.clone(), self.send.clone());
        jobs.start(running, JobKind::Thumbnails, "Looking at photos", move |task| {
            let photos = &opened.site.photos;
            for (index, photo) in photos.iter().enumerate() {
                task.step("thumbnails", index as u64, photos.len() as u64)?;
                // The error of an unreadable photo is reported where the photo is needed.
                if let Ok(picture) = cached_thumbnail(&folder, photo, SMALL) {
                    let made = MadePicture { photo: index, longest: SMALL, image: image(&picture) };
                    if send.send(made).is_err() {
                        break;
                    }
                }
            }
            Ok(arrival(|_| ()))
        });
    }

    /// Uploads pictures that were made.
    pub fn take_in(&mut self, context: &Context) {
        // One picture is uploaded in a frame, as uploads take time and several may be ready.
        if let Ok(MadePicture { photo, longest, image }) = self.receive.try_recv() {
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

    /// Returns the thumbnail of a photo, once it is made.
    pub fn small(&self, photo: usize) -> Option<&TextureHandle> {
        self.small.get(&photo)
    }

    /// Returns the largest picture of a photo that is there.
    pub fn known(&self, photo: usize) -> Option<&TextureHandle> {
        let large = self.large.iter().find(|(other, _)| *other == photo).map(|(_, texture)| texture);
        large.or_else(|| self.small(photo))
    }

    /// Returns the large picture of a photo; the thumbnail replaces it while a job makes it.
    pub fn large(
        &mut self,
        photo: usize,
        opened: &Arc<Opened>,
        jobs: &mut Jobs,
        running: &mut Running,
    ) -> Option<&TextureHandle> {
        if let Some(index) = self.large.iter().position(|(other, _)| *other == photo) {
            let used = self.large.remove(index);
            self.large.push(used);
            return self.large.last().map(|(_, texture)| texture);
        }
        if let Some((photo, _)) = self.making.take_if(|(_, job)| !running.is_running(*job)) {
            self.failed.insert(photo);
        }
        if self.making.is_none() && !self.failed.contains(&photo) {
            let (opened, send) = (opened.clone(), self.send.clone());
            let job = jobs.start(running, JobKind::PhotoView, "Reading a photo", move |_| {
                let picture = thumbnail(&opened.site.photos[photo], LARGE)?;
                // Sending fails only where the receiver is gone: nothing needs the picture then.
                let _ = send.send(MadePicture { photo, longest: LARGE, image: image(&picture) });
                Ok(arrival(|_| ()))
            });
            self.making = Some((photo, job));
        }
        self.small.get(&photo)
    }
}

/// Converts a picture to the type of egui.
pub fn image(picture: &Picture) -> ColorImage {
    let size = [picture.width as usize, picture.height as usize];
    ColorImage::from_rgba_unmultiplied(size, &picture.rgba)
}
