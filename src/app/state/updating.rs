//! Keeping everything up to date: when stacks and fillings are updated in the background, and what came of it.

use std::collections::BTreeMap;

use super::State;
use super::life::Phase;
use super::notes::{Note, Weight};
use super::numbers::counted;
use super::running::JobKind;
use quadratura_base::scene::PhotoId;

/// The time between two looks at what a running update has finished, in seconds: short compared with the time until all is
/// up to date, long compared with a look.
const LOOKS_EVERY_S: f64 = 3.0;
/// The time between two looks at what a running build has finished, in seconds. Only the list of photos shows that.
const LOOKS_AT_BUILD_EVERY_S: f64 = 0.5;

/// When results of a running job were last looked at.
#[derive(Debug, Default)]
struct Looks {
    /// The number of results then.
    results: usize,
    /// The time, in seconds.
    at_s: f64,
}

impl Looks {
    /// Returns whether the results are to be looked at, which is then remembered.
    fn are_due(&mut self, results: usize, now_s: f64, every_s: f64) -> bool {
        let due = results != self.results && now_s - self.at_s >= every_s;
        if due {
            (self.results, self.at_s) = (results, now_s);
        }
        due
    }
}

/// The state of the updates in the background.
#[derive(Debug, Default)]
pub struct Updating {
    /// Whether something has changed since the last update began.
    wanted: bool,
    /// Whether projects are updated that are not paused; none while no project is open.
    pub usual: Option<bool>,
    /// Whether the updates of the open project are paused, as it was last remembered.
    pub paused: Option<bool>,
    /// The share of the bar that updates have filled since everything was up to date.
    pub reached: f32,
    /// The looks at turns of updates.
    turns: Looks,
    /// The looks at photos that a build has finished.
    built: Looks,
    /// What was said of photos that cannot be updated; it is not repeated.
    failed: BTreeMap<String, String>,
}

impl Updating {
    /// Records that stacks or fillings may be out of date.
    pub fn want(&mut self) {
        self.wanted = true;
    }

    /// Returns whether stacks or fillings may be out of date.
    pub fn is_wanted(&self) -> bool {
        self.wanted
    }

    /// Records that an update begins.
    pub fn begin(&mut self) {
        self.wanted = false;
    }

    /// Returns whether finished photos of a running update are to be shown, which is then remembered.
    pub fn shows(&mut self, turns: usize, now_s: f64) -> bool {
        self.turns.are_due(turns, now_s, LOOKS_EVERY_S)
    }

    /// Returns whether photos that a running build has finished are to be listed as built, which is then remembered.
    pub fn lists(&mut self, built: u64, now_s: f64) -> bool {
        self.built.are_due(built as usize, now_s, LOOKS_AT_BUILD_EVERY_S)
    }

    /// Records how photos failed; returns notes about those that failed otherwise than before.
    pub fn failed(&mut self, failed: BTreeMap<String, String>) -> Vec<Note> {
        let news = failed.iter().filter(|(photo, why)| self.failed.get(*photo) != Some(*why));
        let notes = news.map(|(photo, why)| Note::about(Weight::Problem, photo, why.clone())).collect();
        self.failed = failed;
        notes
    }
}

/// The jobs beside which no stack is updated: they write or read the same files, or what they make depends on them.
const FIRST: [JobKind; 11] = [
    JobKind::Open,
    JobKind::Build,
    JobKind::Fill,
    JobKind::Export,
    JobKind::Import,
    JobKind::Projection,
    JobKind::Surroundings,
    JobKind::Mask,
    JobKind::Render,
    JobKind::Preview,
    JobKind::Update,
];

/// The jobs for which an update that runs is stopped; it goes on after them.
const STOPPING: [JobKind; 5] =
    [JobKind::Open, JobKind::Build, JobKind::Fill, JobKind::Export, JobKind::Render];

impl State {
    /// Returns whether an update begins now.
    pub fn updates_now(&self) -> bool {
        let Some(session) = &self.session else { return false };
        let pending = &session.pending;
        self.settings.keep_up_to_date
            && self.updating.wanted
            && session.photos.iter().any(|photo| photo.stack.is_some())
            && pending.invalidation.is_none()
            && !pending.looks
            && !pending.reload
            && self.masking.is_kept()
            && self.life.recovery.is_none()
            && self.life.phase == Phase::Staying
            && !self.running.runs_any(&FIRST)
    }

    /// Returns whether an update that runs stops: it is switched off, or the user has started something else.
    pub fn stops_updating(&self) -> bool {
        !self.settings.keep_up_to_date || self.running.runs_any(&STOPPING)
    }

    /// Returns whether imports and masks come before the next photo of an update.
    pub fn updates_wait(&self) -> bool {
        self.running.runs_any(&[JobKind::Import, JobKind::Projection, JobKind::Mask])
            || !self.masking.is_kept()
    }

    /// Returns whether photos that a running build has finished can be looked at now.
    pub fn can_list_built(&self) -> bool {
        self.running.runs(JobKind::Build) && !self.running.runs_any(&[JobKind::Survey, JobKind::Preview])
    }

    /// Returns whether the results of a running update can be shown: nothing else is about to show stacks.
    pub fn can_show_updates(&self) -> bool {
        self.running.runs(JobKind::Update) && !self.running.runs_any(&[JobKind::Survey, JobKind::Preview])
    }

    /// Moves the photo in view to the front.
    pub fn in_view_first(&self, mut photos: Vec<PhotoId>) -> Vec<PhotoId> {
        photos.sort_by_key(|photo| self.selected_photo() != Some(*photo));
        photos
    }

    /// Returns what waits because updates are switched off.
    pub fn paused_updates(&self) -> PausedUpdates {
        let Some(session) = self.session.as_ref().filter(|_| !self.settings.keep_up_to_date) else {
            return PausedUpdates::default();
        };
        let built = || session.photos.iter().filter(|photo| photo.stack.is_some());
        let stale = self.quality.fill.stale.found().map_or(0, Vec::len);
        let unfilled = built().filter(|photo| photo.is_current() && photo.lacks_filling()).count();
        PausedUpdates {
            outdated: built().filter(|photo| !photo.is_current()).count(),
            unfilled,
            stale: stale.saturating_sub(unfilled),
            lacks_paint: self.round_trip.is_behind,
        }
    }
}

/// What waits while updates are switched off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PausedUpdates {
    /// The number of photos whose layers are out of date.
    pub outdated: usize,
    /// The number of photos whose layers have occluded areas, and no filling.
    pub unfilled: usize,
    /// The number of photos whose fillings are known to be out of date.
    pub stale: usize,
    /// Whether photos lack paint of other photos in their files.
    pub lacks_paint: bool,
}

impl PausedUpdates {
    /// Describes what waits, as the end of a sentence; `None` where nothing does.
    pub fn in_words(&self) -> Option<String> {
        let photos = |count: usize| counted(count as u64, "photo");
        let part = |count: usize, text: String| (count > 0).then_some(text);
        let parts = [
            part(self.outdated, format!("layers of {} are out of date", photos(self.outdated))),
            part(self.unfilled, format!("occluded areas of {} are not filled", photos(self.unfilled))),
            part(self.stale, format!("fillings of {} are out of date", photos(self.stale))),
            self.lacks_paint.then(|| "paint is not yet in the files of other photos".to_owned()),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_waits_while_updates_are_paused_is_named() {
        assert_eq!(PausedUpdates::default().in_words(), None);
        let paused = PausedUpdates { outdated: 2, unfilled: 1, ..PausedUpdates::default() };
        assert_eq!(
            paused.in_words().unwrap(),
            "layers of 2 photos are out of date, occluded areas of 1 photo are not filled"
        );
        let paint = PausedUpdates { lacks_paint: true, ..PausedUpdates::default() };
        assert_eq!(paint.in_words().unwrap(), "paint is not yet in the files of other photos");
    }
}
