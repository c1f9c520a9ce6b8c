//! The search for transient objects, which appear in one photo only: found by a job, masked or dismissed by the user.

use std::path::Path;
use std::sync::Arc;

use super::keeping::queue_mask;
use crate::state::State;
use crate::state::masking::keeping::MaskWork;
use crate::state::masking::suggested::{NOTHING, ShownSuggestion, TransientSearch};
use crate::state::notes::{Note, Weight};
use crate::state::panes::Pane;
use crate::state::running::JobKind;
use crate::work::Work;
use crate::work::jobs::arrival;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_sites::budget::default_memory;
use quadratura_stacks::masks::suggest::{
    MARGIN_PX, MaskSuggestion, UNSEEN, dismiss, pixels, suggest, suggestions,
};

impl State {
    fn transients_found(&mut self, folder: &Path, looked_at: &[String], mut list: Vec<ShownSuggestion>) {
        let Some(session) = self.session.as_ref().filter(|session| session.folder == folder) else { return };
        let is_new = |photo: &String| looked_at.is_empty() || looked_at.contains(photo);
        // These were dismissed while the search ran.
        let gone = std::mem::take(&mut self.masking.suggested.dismissed);
        list.retain(|shown| is_new(&shown.it.photo) || !gone.contains(&shown.it.number));
        self.masking.suggested.put(list);
        let list = self.masking.suggested.list.clone();
        let names = session.opened.site.photos.iter().map(|photo| &photo.name);
        let has_none = |name: &&String| list.iter().all(|shown| shown.it.photo != **name);
        let without = names.filter(|name| is_new(name)).filter(has_none).cloned().collect();
        let new = list.iter().filter(|shown| is_new(&shown.it.photo));
        let mut photos: Vec<&str> = new.map(|shown| shown.it.photo.as_str()).collect();
        let found = photos.len();
        photos.sort_unstable();
        photos.dedup();
        let text = match found {
            0 => NOTHING.to_owned(),
            1 => format!("One transient object was found in {}. A click on it masks it.", photos[0]),
            many => {
                format!("{many} transient objects were found {}. A click on one masks it.", in_short(&photos))
            }
        };
        let text = format!("{text} {UNSEEN}");
        self.masking.suggested.shown = true;
        self.masking.suggested.outcome = Some(TransientSearch { without });
        self.notify(Note::new(Weight::Info, text));
    }

    /// Dismisses suggestions, by number.
    pub fn dismiss_suggestions(&mut self, numbers: &[u32]) {
        let Some(session) = &self.session else { return };
        let dismissed = dismiss(&session.folder, numbers);
        self.masking.suggested.remove(numbers);
        if self.running.runs(JobKind::Suggest) {
            self.masking.suggested.dismissed.extend(numbers);
        }
        if let Err(error) = dismissed {
            self.notify(Note::new(Weight::Warning, error.to_string()));
        }
    }
}

/// Starts the search for transient objects in these photos, or in all where the list is empty.
pub fn look_for_transients(state: &mut State, work: &mut Work, photos: Vec<String>) {
    let Some(session) = &state.session else { return };
    let (folder, opened) = (session.folder.clone(), session.opened.clone());
    let job =
        work.jobs.start(&mut state.running, JobKind::Suggest, "Finding transient objects", move |task| {
            let found =
                suggest(&folder, &opened.project, &opened.site, &photos, MARGIN_PX, default_memory(), task)?;
            let list = shown(&folder, found.list, task)?;
            Ok(arrival(move |state| state.transients_found(&folder, &photos, list)))
        });
    state.masking.suggested.looking = Some(job);
    state.masking.suggested.dismissed.clear();
    state.panes.show(Pane::Photo);
}

/// Loads the suggestions of earlier runs, once.
pub fn want_suggestions(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    if std::mem::replace(&mut state.masking.suggested.read, true) {
        return;
    }
    let folder = session.folder.clone();
    work.jobs.start(&mut state.running, JobKind::Look, "Reading suggestions", move |task| {
        // There is no list, or it has an unknown format: a new search replaces it.
        let list = suggestions(&folder).and_then(|found| shown(&folder, found.list, task));
        Ok(arrival(move |state| {
            let same = state.session.as_ref().is_some_and(|session| session.folder == folder);
            if let (Ok(list), true) = (list, same && state.masking.suggested.looking.is_none()) {
                state.masking.suggested.put(list);
            }
        }))
    });
}

/// Masks suggestions by their numbers, as one step.
pub fn accept_suggestions(state: &mut State, work: &mut Work, numbers: &[u32]) {
    let list = state.masking.suggested.list.clone();
    let meant: Vec<&ShownSuggestion> =
        list.iter().filter(|shown| numbers.contains(&shown.it.number)).collect();
    let name = match meant[..] {
        [] => return,
        [one] => format!("mask of {} by suggestion {}", one.it.photo, one.it.number),
        _ => format!("mask by {} suggestions", meant.len()),
    };
    queue_mask(
        state,
        work,
        name,
        MaskWork::Edits(Arc::new(meant.into_iter().map(ShownSuggestion::edit).collect())),
    );
}

/// Formats the first names of many photos.
fn in_short(photos: &[&str]) -> String {
    match photos {
        [one] => format!("in {one}"),
        [one, other] => format!("in {one} and {other}"),
        [one, rest @ ..] => format!("in {one} and {} other photos", rest.len()),
        [] => String::new(),
    }
}

/// Reads the masks of suggestions.
fn shown(folder: &Path, list: Vec<MaskSuggestion>, task: &Task) -> Result<Vec<ShownSuggestion>> {
    let read = |it: MaskSuggestion| {
        task.check_cancelled()?;
        Ok(ShownSuggestion { masked: Arc::new(pixels(folder, &it)?), it })
    };
    list.into_iter().map(read).collect()
}
