//! The textures of the window, which panels draw.

use eframe::egui::Context;

use crate::panel::check::CheckTextures;
use crate::panel::flat::FlatTextures;
use crate::panel::orthophoto::OrthoTexture;
use crate::panel::paint::PaintTextures;
use crate::panel::photo::masked::MaskMeshes;
use crate::panel::photo::picture::SelectedHidden;
use crate::panel::pictures::PhotoTextures;
use crate::panel::space::SpaceTextures;
use crate::work::pictures::{PhotoPictures, PicturesId};

/// The textures of the window.
#[derive(Default)]
pub struct Textures {
    /// The pictures of photos.
    pub photos: PhotoTextures,
    /// The reading of the site that `photos` are of.
    photos_of: PicturesId,
    /// The pictures of the flat views.
    pub flat: FlatTextures,
    /// The masks of the photo view.
    pub masks: MaskMeshes,
    /// The areas of the selection that are hidden in the photo of the photo view.
    pub selected_hidden: Option<SelectedHidden>,
    /// The overlay of the check.
    pub check: CheckTextures,
    /// The changes of the last import.
    pub paint: PaintTextures,
    /// The 3D view.
    pub space: SpaceTextures,
    /// The preview of an orthophoto.
    pub orthophoto: OrthoTexture,
}

impl Textures {
    /// Uploads pictures of photos that were made.
    pub fn take_in(&mut self, context: &Context, pictures: &mut PhotoPictures) {
        self.flat.pictures.drop_gone();
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
