//! Actions of the check: compares cameras, photos and model in a job, and reads overlays.

use std::path::Path;
use std::sync::Arc;

use crate::app::state::State;
use crate::app::state::ask::CheckAsk;
use crate::app::state::checks::{Checked, Mend, verdict};
use crate::app::state::notes::{Note, Weight};
use crate::app::state::running::JobKind;
use crate::app::work::Work;
use crate::app::work::jobs::arrival;
use crate::document::Project;
use crate::gpu::{Gpu, GpuRasteriser};
use crate::recipe::check::{CheckOptions, CheckReport, Verdict, check_site};
use crate::recipe::thumbnail::picture_of_file;

/// The longer side of an overlay in the window, in pixels.
const SHOWN_PX: u32 = 1600;

/// Applies an ask about the check.
pub fn apply(state: &mut State, work: &mut Work, ask: CheckAsk) {
    match ask {
        CheckAsk::Check => check_project(state, work),
        CheckAsk::Mend(mend) => state.mend(mend),
        CheckAsk::ShowPhoto(photo) => state.checks.photo = photo,
        CheckAsk::Overlay(path) => ask_overlay(state, work, &path),
    }
}

impl State {
    /// Shows a report, unless its project was left.
    fn checked(&mut self, checked: Checked) {
        if self.session.as_ref().is_none_or(|session| session.folder != checked.project) {
            return;
        }
        self.notes.add(judged(&checked.report));
        // The photo that sees most faces shows best whether edges match.
        let faces = checked.report.photos.iter().map(|photo| photo.faces).enumerate();
        let best = faces.max_by_key(|(index, faces)| (*faces, std::cmp::Reverse(*index)));
        self.checks.photo = best.map_or(0, |(photo, _)| photo);
        (self.checks.overlay, self.checks.asked) = (None, None);
        self.checks.report = Some(checked);
        self.checks.shown = true;
    }

    /// Moves the model, as a step that can be undone, and checks the project again.
    fn mend(&mut self, mend: Mend) {
        let Some(session) = &self.session else { return };
        let mut project = Project::clone(session.history.present());
        let (now, folder) = (project.world_from_model, session.folder.clone());
        let there = match (&mend, &self.checks.before) {
            (Mend::Stand(there), _) => *there,
            (Mend::Back, Some((project, before))) if *project == folder => *before,
            (Mend::Back, _) => return,
        };
        self.checks.before = (mend != Mend::Back).then_some((folder, now));
        project.world_from_model = there;
        self.edit("move of the model", project, None);
        self.checks.again = true;
    }
}

/// Starts the job that compares cameras, photos and model.
pub fn check_project(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let (folder, opened) = (session.folder.clone(), session.opened.clone());
    work.jobs.start(&mut state.running, JobKind::Check, "Checking cameras, photos and model", move |task| {
        let project = &opened.project;
        let (world_from_model, tolerance) = (project.world_from_model, project.options.tolerance);
        let pictures = Some(folder.join("cache/check"));
        let options = CheckOptions { world_from_model, tolerance, pictures };
        let rasteriser = GpuRasteriser::new(&Gpu::headless()?)?;
        let report = check_site(&opened.site, &opened.points, &options, &rasteriser, task)?;
        let checked = Checked { project: folder, world_from_model, report };
        Ok(arrival(move |state| state.checked(checked)))
    });
}

/// Starts the check again once the model has been moved.
pub fn check_again(state: &mut State, work: &mut Work) {
    let Some(session) = state.session.as_ref().filter(|_| state.checks.again) else { return };
    let wanted = session.history.present().world_from_model;
    if session.opened.project.world_from_model == wanted && !state.running.runs(JobKind::Check) {
        state.checks.again = false;
        check_project(state, work);
    }
}

/// Starts the job that reads an overlay.
fn ask_overlay(state: &mut State, work: &mut Work, path: &Path) {
    if !state.checks.ask_for(path) {
        return;
    }
    let path = path.to_path_buf();
    work.jobs.start(&mut state.running, JobKind::PhotoView, "Reading an overlay", move |_| {
        let picture = picture_of_file(&path, SHOWN_PX)?;
        Ok(arrival(move |state| {
            state.checks.overlay = Some((path, Arc::new(picture)));
        }))
    });
}

/// Summarises a check in a sentence or two.
fn judged(report: &CheckReport) -> Note {
    let weight = match report.verdict {
        Verdict::Fits => Weight::Info,
        Verdict::Poor => Weight::Warning,
        Verdict::Misses => Weight::Problem,
    };
    Note::new(weight, verdict(report))
}
