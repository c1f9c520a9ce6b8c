//! New paint on the other photos: it is shown at once, the photos that matter for the present view first, and then
//! written to the photos' files in the background.

use std::sync::Arc;

use crate::app::state::State;
use crate::app::state::ask::{Ask, RoundTripAsk};
use crate::app::state::notes::{Note, Weight};
use crate::app::state::numbers::counted;
use crate::app::state::round_trip::Projected;
use crate::app::state::running::JobKind;
use crate::app::state::session::{PhotoStatus, survey};
use crate::app::work::Work;
use crate::app::work::painter::Change;
use crate::document::paint::PaintBook;
use crate::error::Error;
use crate::io::stack_store::StackStore;
use crate::recipe::budget::default_memory;
use crate::recipe::fill::projected::{PaintProjection, nearest_first};
use crate::recipe::fill::{FillRequest, follow_paint};
use crate::scene::PhotoId;
use crate::task::Task;

/// The number of photos to which new paint is projected before the first picture: nearly all of what a view shows of
/// a point comes from its three or four nearest photos.
const FIRST: usize = 4;

impl State {
    /// Shows stacks with other fillings; `photos` are the states of all photos.
    pub fn fillings_changed(
        &mut self,
        folder: &std::path::Path,
        photos: Vec<PhotoStatus>,
        notes: Vec<Note>,
    ) -> Vec<Ask> {
        notes.into_iter().for_each(|note| self.tell(note));
        let is_of = |session: &&mut crate::app::state::session::Session| {
            session.folder == folder && session.opened.site.photos.len() == photos.len()
        };
        let Some(session) = self.session.as_mut().filter(is_of) else { return Vec::new() };
        let before = std::mem::replace(&mut session.photos, photos);
        self.keep_selection(&before);
        self.quality.fill.forget_stacks();
        vec![RoundTripAsk::ShowFillings.into()]
    }
}

/// Starts projecting the paint of a book to all photos, those that matter for the present view first.
pub fn project_paint(state: &mut State, work: &mut Work, book: Arc<PaintBook>) {
    let Some(session) = &state.session else { return };
    state.round_trip.projection += 1;
    state.round_trip.book = Some(book.clone());
    if work.painter.is_none() {
        // There is no view to show it in.
        state.round_trip.is_behind = true;
        return;
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
    let stacks: Vec<_> = session.photos.iter().map(|photo| photo.stack.clone()).collect();
    let number = state.round_trip.projection;
    work.jobs.start(&mut state.running, JobKind::Look, "Projecting paint", move |task| {
        let projection = PaintProjection::new(&folder, &opened, &stacks, task)?;
        let paint = projection.project(&book, &photos, task)?;
        let projected = Projected { number, photos, paint, later, book };
        Ok(Box::new(move |_| vec![RoundTripAsk::ShowProjected(Box::new(projected)).into()]))
    });
}

/// Shows projected paint, unless newer paint came in the meantime.
pub fn show_projected(state: &mut State, work: &mut Work, projected: Projected) {
    let Projected { number, photos, paint, later, book } = projected;
    if number != state.round_trip.projection {
        return;
    }
    if let Some(painter) = &mut work.painter {
        painter.change(Change::Projected(photos, paint));
        state.space.redraw();
    }
    match later.is_empty() {
        true => state.round_trip.is_behind = true,
        false => project_to(state, work, book, later),
    }
}

/// Shows the present files of fillings, instead of paint that they did not contain before.
pub fn show_fillings(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    if let Some(painter) = &mut work.painter {
        let stacks = session.photos.iter().map(|photo| photo.stack.clone()).collect();
        painter.change(Change::Fillings(stacks));
        state.space.redraw();
    }
    // Paint that came in the meantime is not in these files.
    let newer = state.round_trip.book.clone().filter(|_| state.round_trip.is_behind);
    newer.into_iter().for_each(|book| project_paint(state, work, book));
}

/// Starts writing new paint to the files of the other photos, where it waits for that and nothing else is being written.
pub fn follow(state: &mut State, work: &mut Work) {
    let writes = [JobKind::Build, JobKind::Fill, JobKind::Export, JobKind::Import, JobKind::Preview];
    if !state.round_trip.is_behind || state.running.runs_any(&writes) {
        return;
    }
    let Some(session) = &mut state.session else { return };
    state.round_trip.is_behind = false;
    // The painter has to read files that were superseded before as long as it does not know the new ones.
    let clears = session.has_former && work.painter.as_ref().is_none_or(|painter| painter.is_settled());
    session.has_former = true;
    let (folder, opened, lock) = (session.folder.clone(), session.opened.clone(), session.lock.clone());
    let known = session.photos.clone();
    work.jobs.start(&mut state.running, JobKind::Fill, "Updating other photos", move |task| {
        // The lock is held until the job ends, even if the project is closed in the meantime.
        let _lock = lock;
        if clears {
            StackStore::new(&folder).clear_former()?;
        }
        let request = FillRequest {
            options: opened.project.fill.clone(),
            photos: Vec::new(),
            memory: default_memory(),
            force: false,
            keep_former: true,
        };
        let (filled, mut notes) = match follow_paint(&folder, &opened, &request, task) {
            Ok(filled) => (filled, Vec::new()),
            Err(Error::Cancelled) => {
                let text = "Updating other photos was stopped; `Fill occluded areas` completes it";
                (Vec::new(), vec![Note::new(Weight::Info, text)])
            }
            Err(error) => (Vec::new(), vec![Note::new(Weight::Problem, error.message())]),
        };
        let failed = filled.iter().filter_map(|photo| Some((&photo.photo, photo.stack.as_ref().err()?)));
        notes.extend(failed.map(|(photo, error)| Note::about(Weight::Problem, photo, error.message())));
        let made = filled.iter().filter(|photo| photo.stack.is_ok() && !photo.up_to_date).count();
        if made > 0 {
            let text = format!("The paint is in the layers of {}", counted(made as u64, "other photo"));
            notes.push(Note::new(Weight::Info, text));
        }
        let photos = survey(&folder, &opened, &known, &Task::silent())?;
        Ok(Box::new(move |state| state.fillings_changed(&folder, photos, notes)))
    });
}
