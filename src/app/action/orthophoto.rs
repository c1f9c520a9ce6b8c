//! Actions that draw orthophotos, with the functions of the command line.

use std::path::Path;
use std::sync::Arc;

use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::orthophoto::OrthophotoDialog;
use crate::state::request::OrthoRequest;
use crate::state::running::JobKind;
use crate::state::selection::Selection;
use crate::work::Work;
use crate::work::jobs::{Arrival, arrival};
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_gpu::start_device;
use quadratura_sites::budget::default_memory;
use quadratura_sites::open::Opened;
use quadratura_trees::PlantParts;
use quadratura_view::Picture;
use quadratura_views::ortho::{OrthoFormat, OrthoOptions, OrthoReport, make, planned, preview_picture};
use quadratura_views::preview::{self, Preview, PreviewOptions};

/// Applies a request about orthophotos.
pub fn apply(state: &mut State, work: &mut Work, request: OrthoRequest) {
    match request {
        OrthoRequest::Choose => state.choose_orthophoto(),
        OrthoRequest::Preview(dialog) => start(state, work, &dialog, "Drawing a preview", draw_preview),
        OrthoRequest::Draw(dialog) => start(state, work, &dialog, "Drawing an orthophoto", draw),
        OrthoRequest::ChooseFrame => state.choose_site_frame(),
        OrthoRequest::SetFrame(dialog) => state.set_site_frame(&dialog),
        OrthoRequest::ForgetFrame(part) => state.forget_site_frame(part),
    }
}

/// What a job draws.
type Draw = fn(&Opened, &OrthoOptions, &Path, &Task) -> Result<Arrival>;

/// Starts a job with the options of the dialog.
fn start(state: &mut State, work: &mut Work, dialog: &OrthophotoDialog, name: &str, draw: Draw) {
    let Some(session) = state.session.as_ref().filter(|session| session.folder == dialog.project) else {
        return;
    };
    let Ok(options) = dialog.options(default_memory()) else { return };
    let (folder, lock) = (session.folder.clone(), session.lock.clone());
    let opened = session.opened.with_project(&folder, Project::clone(session.history.present()));
    let stacks = work.live.stacks.clone();
    work.jobs.start(&mut state.running, JobKind::Export, name, move |task| {
        // Files of layers that are being updated are read when they are complete.
        let _locks = (lock, stacks.take());
        draw(&opened, &options, &folder, task)
    });
}

/// Makes a renderer for one picture.
fn renderer(opened: &Opened, folder: &Path, task: &Task) -> Result<Preview> {
    let device = start_device()?;
    // The window says which photos have no stack.
    let look = PreviewOptions {
        without_stack_notes: true,
        tree_parts: PlantParts::Nothing,
        ..PreviewOptions::default()
    };
    preview::open(folder, &opened.project, &opened.site, &*device, &look, task)
}

fn draw_preview(opened: &Opened, options: &OrthoOptions, folder: &Path, task: &Task) -> Result<Arrival> {
    let plan = planned(opened, options)?;
    let picture = preview_picture(opened, options, &mut renderer(opened, folder, task)?, task)?;
    let [width, height] = plan.size_px();
    let metres = [width, height].map(|side| f64::from(side) * options.resolution.pixel_m);
    let lines = vec![format!(
        "{width} x {height} pixels of {:.2} mm: {:.2} x {:.2} m",
        1000.0 * options.resolution.pixel_m,
        metres[0],
        metres[1]
    )];
    Ok(arrival(move |state| state.orthophoto_previewed(picture, lines)))
}

fn draw(opened: &Opened, options: &OrthoOptions, folder: &Path, task: &Task) -> Result<Arrival> {
    let plan = planned(opened, options)?;
    let report = make(opened, &plan, options, &mut renderer(opened, folder, task)?, task)?;
    Ok(arrival(move |state| state.orthophoto_made(&report)))
}

impl State {
    /// Opens the dialog for what is selected.
    pub fn choose_orthophoto(&mut self) {
        let Some(session) = &self.session else { return };
        let model = session.model();
        let selected = match self.selection.main {
            Selection::Object(object) => Some(model.object(object).name.clone()),
            Selection::Face(face) => Some(model.face_name(face)),
            _ => None,
        };
        self.dialogs.orthophoto = Some(OrthophotoDialog {
            project: session.folder.clone(),
            is_plan: selected.is_none(),
            selected,
            scale: "50".into(),
            dpi: "300".into(),
            depth: String::new(),
            folder: "orthophotos".into(),
            formats: vec![OrthoFormat::Tiff, OrthoFormat::Pdf],
            holes: false,
            has_scale: session.history.present().frame.scale.is_some(),
            preview: None,
            report: Vec::new(),
            done: None,
        });
    }

    /// Takes in a preview.
    pub fn orthophoto_previewed(&mut self, picture: Picture, lines: Vec<String>) {
        if let Some(dialog) = &mut self.dialogs.orthophoto {
            (dialog.preview, dialog.report, dialog.done) = (Some(Arc::new(picture)), lines, None);
        }
    }

    /// Takes in an orthophoto that was made.
    pub fn orthophoto_made(&mut self, report: &OrthoReport) {
        let [width, height] = report.size_px;
        let text = format!(
            "Orthophoto of {}: {width} x {height} pixels in {}",
            report.subject,
            report.folder.display()
        );
        self.notify(Note::new(Weight::Info, text.clone()));
        if let Some(dialog) = &mut self.dialogs.orthophoto {
            let percent = |share: f64| format!("{:.1} %", 100.0 * share);
            let shares = &report.shares;
            let sources = format!(
                "Record {}, reconstruction {}, shown by no photo {}",
                percent(shares.record()),
                percent(shares.reconstruction()),
                percent(shares.nothing)
            );
            let fineness = report.photo_pixel_m.map(|pixel| {
                format!(
                    "The best photo has pixels of {:.1} mm on the surface: points are known to about so much",
                    1000.0 * pixel
                )
            });
            let left_out = report.left_out.iter().map(|what| format!("Not shown: {what}"));
            dialog.report = [text, sources].into_iter().chain(fineness).chain(left_out).collect();
            dialog.done = Some(report.folder.clone());
        }
    }
}
