//! Choices of the round trip: the installed programs, the layer to paint on, the folder of documents.

use std::path::PathBuf;

use crate::state::State;
use crate::state::selection::Selection;
use crate::state::session::Session;
use quadratura_base::scene::PhotoId;
use quadratura_document::ImageLayer;
use quadratura_editing::editing::folder as folder_of_documents;
use quadratura_io::programs::{ImageEditor, image_editors};

impl State {
    /// Returns the installed image editors; they are looked up once.
    pub fn editors_found(&mut self) -> &[(ImageEditor, PathBuf)] {
        self.round_trip.found.get_or_insert_with(image_editors)
    }

    /// Returns the selected layer of a photo.
    pub fn paintable_layer(&self, of: PhotoId) -> Option<&ImageLayer> {
        let Selection::Layer { photo, layer } = self.selection.main else { return None };
        let stack = self.session.as_ref()?.stack_of(photo)?;
        stack.image_layers.get(layer.index()).filter(|_| photo == of)
    }
}

impl Session {
    /// Returns the folder of documents that are being edited, where there is one.
    pub fn editing_folder(&self) -> Option<PathBuf> {
        let folder = folder_of_documents(&self.folder);
        folder.is_dir().then_some(folder)
    }
}
