//! Actions that draw orthophotos, with the functions of the command line.

use std::path::PathBuf;

use crate::state::State;
use crate::state::orthophoto::OrthophotoDialog;
use crate::state::request::OrthoRequest;
use crate::state::running::JobKind;
use crate::work::Work;
use crate::work::jobs::{Arrival, arrival};
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_gpu::start_device;
use quadratura_recipe::budget::default_memory;
use quadratura_recipe::open::Opened;
use quadratura_recipe::ortho::{OrthoOptions, make, planned, preview_picture};
use quadratura_recipe::preview::{self, Preview, PreviewOptions};
use quadratura_recipe::trees::PlantParts;

/// Applies a request about orthophotos.
pub fn apply(state: &mut State, work: &mut Work, request: OrthoRequest) {
    match request {
        OrthoRequest::Choose => state.choose_orthophoto(),
        OrthoRequest::Preview(dialog) => start(state, work, &dialog, "Drawing a preview", draw_preview),
        OrthoRequest::Draw(dialog) => start(state, work, &dialog, "Drawing an orthophoto", draw),
    }
}

/// What a job draws.
type Draw = fn(&Opened, &OrthoOptions, &PathBuf, &Task) -> Result<Arrival>;

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
fn renderer(opened: &Opened, folder: &PathBuf, task: &Task) -> Result<Preview> {
    let device = start_device()?;
    // The window says which photos have no stack.
    let look = PreviewOptions {
        without_stack_notes: true,
        tree_parts: PlantParts::Nothing,
        ..PreviewOptions::default()
    };
    preview::open(folder, &opened.project, &opened.site, &*device, &look, task)
}

fn draw_preview(opened: &Opened, options: &OrthoOptions, folder: &PathBuf, task: &Task) -> Result<Arrival> {
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

fn draw(opened: &Opened, options: &OrthoOptions, folder: &PathBuf, task: &Task) -> Result<Arrival> {
    let plan = planned(opened, options)?;
    let report = make(opened, &plan, options, &mut renderer(opened, folder, task)?, task)?;
    Ok(arrival(move |state| state.orthophoto_made(&report)))
}
