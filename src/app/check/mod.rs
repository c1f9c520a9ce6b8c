//! The check of a project: runs as a job, is shown in a window, and offers a fix for likely errors.

pub mod check_ui;

use std::path::{Path, PathBuf};

use eframe::egui::TextureHandle;

pub use check_ui::check_ui;

use crate::app::state::State;
use crate::app::state::notes::{Note, Weight};
use crate::app::state::running::JobKind;
use crate::app::work::Work;
use crate::app::work::jobs::arrival;
use crate::document::Project;
use crate::geometry::Similarity;
use crate::gpu::{Gpu, GpuRasteriser};
use crate::projection::Picture;
use crate::recipe::check::{CheckOptions, CheckReport, Verdict, check_site};
use crate::recipe::thumbnail::picture_of_file;

/// The longer side of an overlay in the window, in pixels.
const SHOWN_PX: u32 = 1600;

/// The results of checks, and the state of their window.
#[derive(Default)]
pub struct Checks {
    /// The last report of the open project.
    report: Option<Checked>,
    /// Whether the window is open.
    pub shown: bool,
    /// The photo whose overlay is shown, as an index in the report.
    photo: usize,
    picture: Option<(PathBuf, TextureHandle)>,
    /// An overlay that was read and is not on the device yet.
    read: Option<(PathBuf, Picture)>,
    /// The overlay that is being read, or could not be read.
    asked: Option<PathBuf>,
    /// The placement of the model before the fix was applied, by project.
    before: Option<(PathBuf, Similarity)>,
    /// Whether the model was moved and the site is being read again.
    again: bool,
}

/// A report, and the placement of the model that it is about.
struct Checked {
    project: PathBuf,
    /// The placement of the model.
    world_from_model: Similarity,
    report: CheckReport,
}

/// A change of the model's placement that the window offers.
#[derive(Debug, Clone, PartialEq)]
pub enum Mend {
    /// Moves the model to this placement.
    Stand(Similarity),
    /// Restores the placement before the fix.
    Back,
}

impl Checks {
    /// Returns whether there is a report of this project.
    pub fn has_report(&self, project: &Path) -> bool {
        self.report.as_ref().is_some_and(|checked| checked.project == project)
    }
}

impl State {
    fn checked(&mut self, checked: Checked) {
        if self.session.as_ref().is_none_or(|session| session.folder != checked.project) {
            return;
        }
        self.notes.add(judged(&checked.report));
        // The photo that sees most faces shows best whether edges match.
        let faces = checked.report.photos.iter().map(|photo| photo.faces).enumerate();
        let best = faces.max_by_key(|(index, faces)| (*faces, std::cmp::Reverse(*index)));
        self.checks.photo = best.map_or(0, |(photo, _)| photo);
        (self.checks.picture, self.checks.asked) = (None, None);
        self.checks.report = Some(checked);
        self.checks.shown = true;
    }

    /// Moves the model, as a step that can be undone, and checks the project again.
    pub fn mend(&mut self, mend: Mend) {
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
pub fn ask_overlay(state: &mut State, work: &mut Work, path: &Path) {
    if state.checks.asked.as_deref() == Some(path) {
        return;
    }
    state.checks.asked = Some(path.to_path_buf());
    let path = path.to_path_buf();
    work.jobs.start(&mut state.running, JobKind::PhotoView, "Reading an overlay", move |_| {
        let picture = picture_of_file(&path, SHOWN_PX)?;
        Ok(arrival(move |state| {
            state.checks.read = Some((path, picture));
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

/// Returns the verdict and its evidence.
fn verdict(report: &CheckReport) -> String {
    let verdict = match report.verdict {
        Verdict::Fits => "The model fits the photos",
        Verdict::Poor => "The model fits the photos in part",
        Verdict::Misses => "The model does not stand where the photos are",
    };
    let met = report.agreement.map_or(String::new(), |share| {
        format!(", and meets {} of the sparse points' sightings", percent(share))
    });
    format!("{verdict}: it covers {} of a photo{met}.", percent(report.covered))
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}
