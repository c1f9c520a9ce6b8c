//! The removal of an object from the model waits for confirmation.

use super::PendingRemoval;
use crate::state::State;
use crate::state::session::Session;
use quadratura_document::Stack;
use quadratura_document::stack::Element;

impl PendingRemoval {
    fn new(session: &Session, object: &str) -> Option<Self> {
        let model = session.model();
        let faces = model.object(model.object_named(object)?).faces.len();
        let photos = || session.opened.site.photos.iter().zip(&session.photos);
        let names = |is_listed: &dyn Fn(&Stack) -> bool| -> Vec<String> {
            let of_stack =
                |(photo, status): (&quadratura_base::scene::Photo, &crate::state::session::PhotoStatus)| {
                    status.stack.as_ref().filter(|stack| is_listed(stack)).map(|_| photo.name.clone())
                };
            photos().filter_map(of_stack).collect()
        };
        let has = |element: &Element| element.object == object;
        // The whole model is an input of each stack.
        let (stale, showing) =
            (names(&|_| true), names(&|stack| stack.visibility_layers.iter().flatten().any(has)));
        Some(Self { object: object.to_owned(), faces, stale, showing })
    }
}

impl State {
    /// Asks whether to remove an object from the model, by name.
    pub fn request_to_remove(&mut self, object: &str) {
        let Some(session) = &self.session else { return };
        self.lists.removing = PendingRemoval::new(session, object);
    }

    /// Removes the object that was asked about, or keeps it.
    pub fn confirm_removal(&mut self, confirmed: bool) {
        if let Some(pending) = self.lists.removing.take().filter(|_| confirmed) {
            self.switch_object(&pending.object, false);
        }
    }
}
