//! The textures of the window, which panels draw.

use eframe::egui::Context;

use crate::app::panel::pictures::PhotoTextures;
use crate::app::work::pictures::{Pictures, PicturesId};

/// The textures of the window.
#[derive(Default)]
pub struct Textures {
    /// The pictures of photos.
    pub photos: PhotoTextures,
    /// The reading of the site that `photos` are of.
    photos_of: PicturesId,
}

impl Textures {
    /// Uploads pictures of photos that were made.
    pub fn take_in(&mut self, context: &Context, pictures: &mut Pictures) {
        if self.photos_of != pictures.id {
            (self.photos, self.photos_of) = (PhotoTextures::default(), pictures.id.clone());
        }
        // One picture is uploaded in a frame, as uploads take time and several may be ready.
        if let Some(made) = pictures.next_made() {
            context.request_repaint();
            self.photos.upload(context, made.photo, made.is_large, &made.picture);
            self.photos.keep_large(|photo| pictures.keeps_large(photo));
        }
    }
}
