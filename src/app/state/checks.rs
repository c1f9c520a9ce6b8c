//! The check of a project: its last report, the overlay that is shown, and the fix for likely errors.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use quadratura_base::geometry::Similarity;
use quadratura_base::scene::PhotoId;
use quadratura_sites::check::{CheckReport, Verdict};
use quadratura_view::Picture;

/// The results of checks, and the state of their window.
#[derive(Default)]
pub struct Checks {
    /// The last report of the open project.
    pub report: Option<Checked>,
    /// Whether the window is open.
    pub shown: bool,
    /// The photo whose overlay is shown, as an index in the report.
    pub photo: PhotoId,
    /// The overlay that was read last, and its file.
    pub overlay: Option<(PathBuf, Arc<Picture>)>,
    /// The overlay that is being read, or could not be read.
    pub asked: Option<PathBuf>,
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
    pub fn request_for(&mut self, path: &Path) -> bool {
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

/// Returns the verdict and its evidence.
pub fn verdict(report: &CheckReport) -> String {
    let verdict = match report.verdict {
        Verdict::Fits => "The model is aligned with the photos",
        Verdict::Poor => "The model is partly aligned with the photos",
        Verdict::Misses => "The model is not aligned with the photos",
    };
    let met = report.agreement.map_or(String::new(), |share| {
        format!(", and matches {} of the sparse-point observations", percent_of(share))
    });
    format!("{verdict}: it covers {} of a photo{met}.", percent_of(report.covered))
}

/// Formats a share in percent, without digits after the point.
pub fn percent_of(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}
