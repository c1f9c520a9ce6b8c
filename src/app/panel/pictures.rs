//! Textures of photos: thumbnails for lists, and larger pictures to show over the view.

use std::collections::BTreeMap;

use eframe::egui::{ColorImage, Context, TextureHandle, TextureOptions};

use quadratura_base::scene::PhotoId;
use quadratura_view::Picture;

/// The pictures of one project's photos, as textures.
#[derive(Default)]
pub struct PhotoTextures {
    small: BTreeMap<PhotoId, TextureHandle>,
    large: BTreeMap<PhotoId, TextureHandle>,
}

impl PhotoTextures {
    /// Uploads a picture of a photo, the large one or the thumbnail.
    pub fn upload(&mut self, context: &Context, photo: PhotoId, is_large: bool, picture: &Picture) {
        let (size, textures) = match is_large {
            true => ("large", &mut self.large),
            false => ("small", &mut self.small),
        };
        let name = format!("{size} photo {}", photo.0);
        // Photos are opaque: their pixels are copied as they are, which this thread has the time for.
        let sides = [picture.width as usize, picture.height as usize];
        let image = ColorImage::from_rgba_premultiplied(sides, &picture.rgba);
        textures.insert(photo, context.load_texture(name, image, TextureOptions::LINEAR));
    }

    /// Drops the large pictures that are not kept.
    pub fn keep_large(&mut self, is_kept: impl Fn(PhotoId) -> bool) {
        self.large.retain(|photo, _| is_kept(*photo));
    }

    /// Returns the thumbnail of a photo, once it is made.
    pub fn small(&self, photo: PhotoId) -> Option<&TextureHandle> {
        self.small.get(&photo)
    }

    /// Returns the large picture of a photo, or its thumbnail until that is made.
    pub fn large(&self, photo: PhotoId) -> Option<&TextureHandle> {
        self.large.get(&photo).or_else(|| self.small.get(&photo))
    }
}

/// Converts a picture to the type of egui.
pub fn image(picture: &Picture) -> ColorImage {
    let size = [picture.width as usize, picture.height as usize];
    ColorImage::from_rgba_unmultiplied(size, &picture.rgba)
}
