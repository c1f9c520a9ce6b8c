//! Actions of the check: compares cameras, photos and model in a job, and reads overlays.

use std::path::Path;
use std::sync::Arc;

use crate::state::State;
use crate::state::checks::{Checked, Mend, verdict};
use crate::state::notes::{Note, Weight};
use crate::state::request::CheckRequest;
use crate::state::running::JobKind;
use crate::work::Work;
use crate::work::jobs::arrival;
use quadratura_base::scene::PhotoId;
use quadratura_gpu::{Gpu, GpuRasteriser};
use quadratura_sites::check::fix::realigned;
use quadratura_sites::check::{CheckOptions, CheckReport, Verdict, check_site};
use quadratura_sites::thumbnail::picture_of_file;

/// The longer side of an overlay in the window, in pixels.
const SHOWN_PX: u32 = 1600;

/// Applies a request about the check.
pub fn apply(state: &mut State, work: &mut Work, request: CheckRequest) {
    match request {
        CheckRequest::Check => check_project(state, work),
        CheckRequest::Mend(mend) => state.mend(mend),
        CheckRequest::ShowPhoto(photo) => state.checks.photo = photo,
        CheckRequest::Overlay(path) => request_overlay(state, work, &path),
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
        let photos = &checked.report.photos;
        let faces = PhotoId::all(photos.len()).zip(photos.iter().map(|photo| photo.faces));
        let best = faces.max_by_key(|(photo, faces)| (*faces, std::cmp::Reverse(*photo)));
        self.checks.photo = best.map(|(photo, _)| photo).unwrap_or_default();
        (self.checks.overlay, self.checks.asked) = (None, None);
        self.checks.report = Some(checked);
        self.checks.shown = true;
    }

    /// Moves the model, as a step that can be undone, and checks the project again.
    fn mend(&mut self, mend: Mend) {
        let Some(session) = &self.session else { return };
        let project = session.history.present();
        let (now, folder) = (project.world_from_model, session.folder.clone());
        let there = match (&mend, &self.checks.before) {
            (Mend::Stand(there), _) => *there,
            (Mend::Back, Some((project, before))) if *project == folder => *before,
            (Mend::Back, _) => return,
        };
        let project = realigned(project, there);
        self.checks.before = (mend != Mend::Back).then_some((folder, now));
        self.edit("alignment of the model", project, None);
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
fn request_overlay(state: &mut State, work: &mut Work, path: &Path) {
    if !state.checks.request_for(path) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::action::tests::bench::TestBench;
    use crate::state::checks::Mend;
    use crate::state::request::DecideRequest;
    use quadratura_base::geometry::Similarity;
    use quadratura_sites::check::{FaceReport, Names, PhotoReport};

    fn photo(name: &str, faces: usize) -> PhotoReport {
        let (picture, problem) = (None, None);
        PhotoReport { name: name.into(), in_front: 1.0, inside: 0.5, covered: 0.25, faces, picture, problem }
    }

    fn report(verdict: Verdict) -> CheckReport {
        let none = Names::default;
        let faces = FaceReport {
            count: 4,
            degenerate: none(),
            not_planar: none(),
            duplicate: none(),
            flipped: none(),
            unseen: none(),
            turning: Default::default(),
            crossing_pairs: 0,
            sunk_pairs: 0,
            crossing_gave_up: false,
            crossing: Vec::new(),
        };
        let photos = vec![photo("a.jpg", 1), photo("b.jpg", 3), photo("c.jpg", 3)];
        CheckReport {
            verdict,
            agreement: Some(0.5),
            covered: 0.25,
            suggestion: None,
            search: None,
            photos,
            faces,
            distances: Vec::new(),
            unexplained: None,
        }
    }

    fn checked(bench: &mut TestBench, verdict: Verdict) {
        let project = bench.folder().to_path_buf();
        let checked = Checked { project, world_from_model: Similarity::IDENTITY, report: report(verdict) };
        bench.state.checked(checked);
    }

    fn twice_as_large() -> Similarity {
        Similarity { scale: 2.0, ..Similarity::IDENTITY }
    }

    #[test]
    fn a_report_is_shown_with_the_photo_that_sees_most_faces_and_told() {
        let mut bench = TestBench::new();
        checked(&mut bench, Verdict::Poor);
        assert!(bench.state.checks.shown && bench.state.checks.has_report(bench.folder()));
        assert_eq!(bench.state.checks.photo, PhotoId(1), "the first of those that see equally many");
        let note = bench.state.notes.list().last().unwrap();
        assert_eq!(note.weight, Weight::Warning);
        assert!(
            bench
                .said()
                .last()
                .unwrap()
                .ends_with("covers 25 % of a photo, and matches 50 % of the sparse-point observations.")
        );
        bench.request(CheckRequest::ShowPhoto(PhotoId(2)));
        assert_eq!(bench.state.checks.photo, PhotoId(2));
    }

    #[test]
    fn a_report_of_a_project_that_was_left_is_dropped() {
        let mut bench = TestBench::new();
        let other = Checked {
            project: bench.folder().join("other"),
            world_from_model: Similarity::IDENTITY,
            report: report(Verdict::Fits),
        };
        let before = bench.said().len();
        bench.state.checked(other);
        assert!(bench.state.checks.report.is_none() && !bench.state.checks.shown);
        assert_eq!(bench.said().len(), before);
    }

    #[test]
    fn a_report_replaces_the_overlay_of_the_one_before() {
        let mut bench = TestBench::new();
        checked(&mut bench, Verdict::Fits);
        assert!(bench.state.checks.request_for(Path::new("a.jpg")));
        assert!(!bench.state.checks.request_for(Path::new("a.jpg")), "it is being read");
        checked(&mut bench, Verdict::Fits);
        assert!(bench.state.checks.overlay.is_none() && bench.state.checks.request_for(Path::new("a.jpg")));
    }

    #[test]
    fn the_model_is_moved_as_a_step_and_put_back() {
        let mut bench = TestBench::new();
        bench.request(CheckRequest::Mend(Mend::Back));
        assert_eq!(bench.undoes(), None, "it was not moved");
        bench.request(CheckRequest::Mend(Mend::Stand(twice_as_large())));
        assert_eq!(bench.project().world_from_model, twice_as_large());
        assert_eq!(bench.undoes(), Some("alignment of the model"));
        assert!(bench.state.checks.again && bench.state.checks.before.is_some());
        bench.request(CheckRequest::Mend(Mend::Back));
        assert_eq!(bench.project().world_from_model, Similarity::IDENTITY);
        assert!(bench.state.checks.before.is_none());
        bench.request(DecideRequest::Undo);
        assert_eq!(bench.project().world_from_model, twice_as_large());
    }

    #[test]
    fn a_check_after_a_move_waits_until_the_site_was_read() {
        let mut bench = TestBench::new();
        bench.request(CheckRequest::Mend(Mend::Stand(twice_as_large())));
        check_again(&mut bench.state, &mut bench.work);
        assert!(bench.state.checks.again && !bench.state.running.runs(JobKind::Check));
    }

    #[test]
    fn an_overlay_is_read_once_and_one_that_cannot_be_read_is_told() {
        let mut bench = TestBench::new();
        let path = bench.folder().join("none.jpg");
        bench.request(CheckRequest::Overlay(path.clone()));
        assert!(bench.state.running.runs(JobKind::PhotoView));
        bench.settle();
        let messages = bench.said().len();
        assert!(
            bench.said().iter().any(|text| text.starts_with("Reading an overlay: ")),
            "{:?}",
            bench.said()
        );
        bench.request(CheckRequest::Overlay(path));
        bench.settle();
        assert!(bench.state.checks.overlay.is_none());
        assert_eq!(bench.said().len(), messages);
    }
}
