//! New paint on the other photos: it is shown at once, the photos that matter for the present view first. The next
//! update writes it to the photos' files.

use std::path::Path;
use std::sync::Arc;

use crate::state::State;
use crate::state::notes::Note;
use crate::state::request::{Request, RoundTripRequest};
use crate::state::round_trip::Projected;
use crate::state::running::JobKind;
use crate::state::session::{PhotoStatus, stacks_of};
use crate::work::Work;
use crate::work::painter::PreviewChange;
use quadratura_base::error::Error;
use quadratura_base::scene::PhotoId;
use quadratura_document::paint::PaintBook;
use quadratura_io::paint_store::PaintStore;
use quadratura_stacks::fill::projected::{PaintProjection, nearest_first};

/// The number of photos to which new paint is projected before the first picture: nearly all of what a view shows of
/// a point comes from its three or four nearest photos.
const FIRST: usize = 4;

impl State {
    /// Records that the files of other photos may lack paint, which the next update adds.
    fn files_lack_paint(&mut self) {
        self.round_trip.is_behind = true;
        self.updating.want();
    }

    /// Shows stacks with other fillings; `photos` are the states of all photos.
    pub fn fillings_changed(
        &mut self,
        folder: &Path,
        photos: Vec<PhotoStatus>,
        notes: Vec<Note>,
    ) -> Vec<Request> {
        notes.into_iter().for_each(|note| self.notify(note));
        let is_of = |session: &&mut crate::state::session::Session| {
            session.folder == folder && session.opened.site.photos.len() == photos.len()
        };
        let Some(session) = self.session.as_mut().filter(is_of) else { return Vec::new() };
        let photos = session.newest(photos);
        let before = std::mem::replace(&mut session.photos, photos);
        self.keep_selection(&before);
        let is_all = !self.running.runs(JobKind::Update);
        self.quality.fill.forget_made(is_all);
        vec![RoundTripRequest::ShowFillings.into()]
    }
}

/// Starts projecting the paint of a book to all photos, those that matter for the present view first.
pub fn project_paint(state: &mut State, work: &mut Work, book: Arc<PaintBook>) {
    let Some(session) = &state.session else { return };
    state.round_trip.projection += 1;
    state.round_trip.book = Some(book.clone());
    // The files follow even where the paint cannot be shown.
    state.updating.want();
    if work.painter.is_none() {
        // There is no view to show it in.
        return state.files_lack_paint();
    }
    let view = &state.space.viewpoint;
    let photos = nearest_first(&session.opened.site, view.position(), view.pivot);
    project_to(state, work, book, photos);
}

/// Projects paint to the first of these photos; the others follow.
fn project_to(state: &mut State, work: &mut Work, book: Arc<PaintBook>, mut photos: Vec<PhotoId>) {
    let Some(session) = &state.session else { return };
    let later = photos.split_off(FIRST.min(photos.len()));
    let (folder, opened) = (session.folder.clone(), session.opened.clone());
    let stacks = stacks_of(&session.photos);
    let number = state.round_trip.projection;
    work.jobs.start(&mut state.running, JobKind::Projection, "Projecting paint", move |task| {
        let projection = PaintProjection::new(&folder, &opened.project, &opened.site, &stacks, task)?;
        let paint = match projection.project(&book, &photos, task) {
            // Files that only this book names may be gone; the paint that came after it is projected next.
            Err(_) if is_former(&folder, &book) => return Err(Error::Cancelled),
            paint => paint?,
        };
        let projected = Projected { number, photos, paint, later, book };
        Ok(Box::new(move |_| vec![RoundTripRequest::ShowProjected(Box::new(projected)).into()]))
    });
}

/// Returns whether the project's paint has changed since `book` was read.
fn is_former(folder: &Path, book: &PaintBook) -> bool {
    PaintStore::new(folder).read().is_ok_and(|now| now != *book)
}

/// Shows projected paint, unless newer paint came in the meantime.
pub fn show_projected(state: &mut State, work: &mut Work, projected: Projected) {
    let Projected { number, photos, paint, later, book } = projected;
    if number != state.round_trip.projection {
        return;
    }
    if let Some(painter) = &mut work.painter {
        painter.change(PreviewChange::Projected(photos, paint));
        state.space.redraw();
    }
    match later.is_empty() {
        true => state.files_lack_paint(),
        false => project_to(state, work, book, later),
    }
}

/// Shows the present files of fillings, instead of paint that they did not contain before.
pub fn show_fillings(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    if let Some(painter) = &mut work.painter {
        painter.change(PreviewChange::Fillings(stacks_of(&session.photos)));
        state.space.redraw();
    }
    // Paint that came in the meantime is not in these files.
    let newer = state.round_trip.book.clone().filter(|_| state.round_trip.is_behind);
    newer.into_iter().for_each(|book| project_paint(state, work, book));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paint_that_has_changed_on_disk_is_former() {
        let folder = tempfile::tempdir().unwrap();
        let store = PaintStore::new(folder.path());
        let before = store.read().unwrap();
        assert!(!is_former(folder.path(), &before));
        let mut after = before.clone();
        let import = r#"{"number":1,"time":0,"files":[],"photos":[],"pixels":0,"added":[],"replaced":[],"documents":{}}"#;
        after.imports.push(serde_json::from_str(import).unwrap());
        store.commit(&after, &before).unwrap();
        assert!(is_former(folder.path(), &before) && !is_former(folder.path(), &after));
    }
}
