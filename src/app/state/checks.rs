//! The check of a project: its last report, the overlay that is shown, and the fix for likely errors.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::State;
use super::notes::{Note, Weight};
use crate::document::Project;
use crate::geometry::Similarity;
use crate::projection::Picture;
use crate::recipe::check::{CheckReport, Verdict};

/// The results of checks, and the state of their window.
#[derive(Default)]
pub struct Checks {
    /// The last report of the open project.
    pub report: Option<Checked>,
    /// Whether the window is open.
    pub shown: bool,
    /// The photo whose overlay is shown, as an index in the report.
    pub photo: usize,
    /// The overlay that was read last, and its file.
    pub overlay: Option<(PathBuf, Arc<Picture>)>,
    /// The overlay that is being read, or could not be read.
    asked: Option<PathBuf>,
    /// The placement of the model before the fix was applied, by project.
    pub before: Option<(PathBuf, Similarity)>,
    /// Whether the model was moved and the site is being read again.
    pub again: bool,
}

/// A report, and the placement of the model that it is about.
pub struct Checked {
    /// The folder of the project.
    pub project: PathBuf,
    /// The placement of the model.
    pub world_from_model: Similarity,
    /// The report.
    pub report: CheckReport,
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
    /// Returns whether an overlay has to be read, and remembers that it is being read.
    pub fn ask_for(&mut self, path: &Path) -> bool {
        let is_new = self.asked.as_deref() != Some(path);
        if is_new {
            self.asked = Some(path.to_path_buf());
        }
        is_new
    }

    /// Returns whether there is a report of this project.
    pub fn has_report(&self, project: &Path) -> bool {
        self.report.as_ref().is_some_and(|checked| checked.project == project)
    }
}

impl State {
    /// Shows a report, unless its project was left.
    pub fn checked(&mut self, checked: Checked) {
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
pub fn verdict(report: &CheckReport) -> String {
    let verdict = match report.verdict {
        Verdict::Fits => "The model fits the photos",
        Verdict::Poor => "The model fits the photos in part",
        Verdict::Misses => "The model does not stand where the photos are",
    };
    let met = report.agreement.map_or(String::new(), |share| {
        format!(", and meets {} of the sparse points' sightings", percent_of(share))
    });
    format!("{verdict}: it covers {} of a photo{met}.", percent_of(report.covered))
}

/// Formats a share in percent, without digits after the point.
pub fn percent_of(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}
