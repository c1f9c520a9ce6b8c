//! Pictures of photos, made by jobs: thumbnails for lists, and larger ones to show over the view. The window takes each
//! of them once and keeps it as a texture.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use super::jobs::{Jobs, arrival};
use crate::state::running::{JobId, JobKind, Running};
use quadratura_base::scene::PhotoId;
use quadratura_sites::open::Opened;
use quadratura_sites::thumbnail::{cached_thumbnail, thumbnail};
use quadratura_view::Picture;

/// The longer side of a thumbnail, in pixels: a list shows it at half of that on a dense display.
const SMALL: u32 = 256;
/// The longer side of a large picture, in pixels: windows are seldom larger.
const LARGE: u32 = 2048;
/// The number of large pictures that are kept: the photo in use and its neighbours.
const MOST_LARGE: usize = 3;

/// A picture that a job has made.
pub struct MadePicture {
    /// The photo, by its index.
    pub photo: PhotoId,
    /// Whether it is a large one; otherwise it is a thumbnail.
    pub is_large: bool,
    /// The pixels.
    pub picture: Picture,
}

/// Identifies the pictures of one reading of a site: textures of other ones are dropped.
#[derive(Debug, Clone, Default)]
pub struct PicturesId(Arc<()>);

impl PartialEq for PicturesId {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// The pictures of one project's photos.
pub struct PhotoPictures {
    /// Identifies these pictures.
    pub id: PicturesId,
    /// The photos whose large pictures are kept, the one used last at the end.
    large: Vec<PhotoId>,
    making: Option<(PhotoId, JobId)>,
    /// Photos whose large picture failed; the error has been reported.
    failed: BTreeSet<PhotoId>,
    send: Sender<MadePicture>,
    receive: Receiver<MadePicture>,
}

impl Default for PhotoPictures {
    fn default() -> Self {
        let (send, receive) = channel();
        let id = PicturesId::default();
        Self { id, large: Vec::new(), making: None, failed: BTreeSet::new(), send, receive }
    }
}

impl PhotoPictures {
    /// Starts the job that makes the thumbnails of the project in `folder`, or loads cached ones.
    pub fn start(&mut self, folder: &Path, opened: &Arc<Opened>, jobs: &mut Jobs, running: &mut Running) {
        let (folder, opened, send) = (folder.to_path_buf(), opened.clone(), self.send.clone());
        jobs.start(running, JobKind::Thumbnails, "Loading thumbnails", move |task| {
            let photos = opened.site.numbered_photos();
            for (id, photo) in photos.clone() {
                task.step("thumbnails", id.0.into(), photos.len() as u64)?;
                // The error of an unreadable photo is reported where the photo is needed.
                if let Ok(picture) = cached_thumbnail(&folder, photo, SMALL) {
                    let made = MadePicture { photo: id, is_large: false, picture };
                    if send.send(made).is_err() {
                        break;
                    }
                }
            }
            Ok(arrival(|_| ()))
        });
    }

    /// Returns a picture that was made, each once.
    pub fn next_made(&mut self) -> Option<MadePicture> {
        let made = self.receive.try_recv().ok()?;
        if made.is_large {
            self.making = None;
            self.large.push(made.photo);
            if self.large.len() > MOST_LARGE {
                self.large.remove(0);
            }
        }
        Some(made)
    }

    /// Returns whether the large picture of a photo is kept.
    pub fn keeps_large(&self, photo: PhotoId) -> bool {
        self.large.contains(&photo)
    }

    /// Marks the large picture of a photo as used last; returns whether it is kept.
    fn take_up(&mut self, photo: PhotoId) -> bool {
        let Some(index) = self.large.iter().position(|other| *other == photo) else { return false };
        let used = self.large.remove(index);
        self.large.push(used);
        true
    }

    /// Starts the job that makes the large picture of a photo, unless it is kept, being made, or has failed.
    pub fn want_large(
        &mut self,
        photo: PhotoId,
        opened: &Arc<Opened>,
        jobs: &mut Jobs,
        running: &mut Running,
    ) {
        if self.take_up(photo) {
            return;
        }
        if let Some((photo, _)) = self.making.take_if(|(_, job)| !running.is_running(*job)) {
            self.failed.insert(photo);
        }
        if self.making.is_some() || self.failed.contains(&photo) {
            return;
        }
        let (opened, send) = (opened.clone(), self.send.clone());
        let job = jobs.start(running, JobKind::PhotoView, "Reading a photo", move |_| {
            let picture = thumbnail(opened.site.photo(photo), LARGE)?;
            // Sending fails only where the receiver is gone: nothing needs the picture then.
            let _ = send.send(MadePicture { photo, is_large: true, picture });
            Ok(arrival(|_| ()))
        });
        self.making = Some((photo, job));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(photo: PhotoId, is_large: bool) -> MadePicture {
        MadePicture { photo, is_large, picture: Picture { width: 1, height: 1, rgba: vec![255; 4] } }
    }

    #[test]
    fn the_large_pictures_used_last_are_kept_and_each_picture_is_handed_out_once() {
        let mut pictures = PhotoPictures::default();
        for photo in PhotoId::all(MOST_LARGE + 1) {
            pictures.send.send(made(photo, true)).unwrap();
            pictures.send.send(made(photo, false)).unwrap();
        }
        let mut taken = 0;
        while pictures.next_made().is_some() {
            taken += 1;
        }
        assert_eq!(taken, 2 * (MOST_LARGE + 1));
        assert!(
            PhotoId::all(MOST_LARGE + 1).all(|photo| pictures.keeps_large(photo) == (photo != PhotoId(0)))
        );
    }

    #[test]
    fn a_large_picture_that_is_used_again_outlives_one_that_is_not() {
        let mut pictures = PhotoPictures::default();
        for photo in PhotoId::all(MOST_LARGE) {
            pictures.send.send(made(photo, true)).unwrap();
            pictures.next_made();
        }
        assert!(pictures.take_up(PhotoId(0)) && !pictures.take_up(PhotoId(9)));
        pictures.send.send(made(PhotoId(9), true)).unwrap();
        pictures.next_made();
        assert!(pictures.keeps_large(PhotoId(0)) && !pictures.keeps_large(PhotoId(1)));
    }

    #[test]
    fn pictures_of_another_reading_have_another_id() {
        let pictures = PhotoPictures::default();
        assert!(pictures.id == pictures.id.clone() && pictures.id != PhotoPictures::default().id);
    }
}
