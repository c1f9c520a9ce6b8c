//! Commands on stacks and layers.

use eframe::egui::Key;

use super::{Command, Menu, PLAIN, WhyNot, ctrl, shift, with_project};
use crate::state::State;
use crate::state::request::{CheckRequest, Flag, JobRequest, ModelRequest, QualityRequest, WindowRequest};
use crate::state::running::JobKind;
use crate::state::session::Session;

/// The commands in the order of their menus.
pub const COMMANDS: &[&Command] = &[
    &BUILD,
    &BUILD_PHOTO,
    &FILL,
    &KEEP_UP,
    &PROPAGATE,
    &TAKE_OFF,
    &OPTIONS,
    &AS_TABLE,
    &CHECK,
    &CHECKED,
    &COMPLETE,
    &STOP,
];

/// Builds all stacks that are out of date.
pub const BUILD: Command = Command {
    name: "Build layers",
    tooltip: "Sorts surfaces by visibility and writes the image layers of all photos that are not up to date.",
    keys: &[ctrl(Key::B)],
    menu: Menu::Layers,
    ready: can_write,
    request: |_| JobRequest::Build(Vec::new()).into(),
    ..PLAIN
};

/// Builds the stack of one photo.
pub const BUILD_PHOTO: Command = Command {
    name: "Build layers of this photo",
    tooltip: "Builds the image layers of the selected photo only.",
    menu: Menu::Layers,
    ready: |state| can_write(state).and(with_photo(state)),
    request: |state| JobRequest::Build(state.selected_photo_name().into_iter().collect()).into(),
    ..PLAIN
};

/// Fills occluded areas.
pub const FILL: Command = Command {
    name: "Fill occluded areas",
    tooltip: "Fills occluded areas: from other photos, else by inpainting (patch-based or smooth).",
    menu: Menu::Layers,
    ready: |state| can_write(state).and(with_stacks(state)),
    request: |_| JobRequest::Fill.into(),
    ..PLAIN
};

/// Switches updates in the background on or off.
pub const KEEP_UP: Command = Command {
    name: "Keep everything up to date",
    tooltip: "Builds and fills layers that are out of date in the background. Photos without layers are left to Build \
              layers. Off: layers are updated only when you choose Build layers or Fill occluded areas.",
    menu: Menu::Layers,
    on: Some(|state| state.settings.keep_up_to_date),
    request: |_| WindowRequest::Flip(Flag::KeepUpToDate).into(),
    ..PLAIN
};

/// Projects the paint of photos to the other photos.
pub const PROPAGATE: Command = Command {
    name: "Project paint to other photos",
    tooltip: "Fills occluded areas, and projects paint of one photo to the others that show the same surfaces.",
    menu: Menu::Layers,
    ready: |state| can_write(state).and(with_stacks(state)),
    request: |_| QualityRequest::Propagate.into(),
    ..PLAIN
};

/// Removes projected paint: each photo has its own paint only.
pub const TAKE_OFF: Command = Command {
    name: "Remove paint from other photos",
    tooltip: "Fills occluded areas again without paint projected from other photos; paint stays in the photo where \
              it was painted.",
    menu: Menu::Layers,
    ready: |state| {
        can_write(state).and(with_stacks(state))?;
        if state.session.as_ref().is_some_and(Session::has_propagated) {
            Ok(())
        } else {
            Err("no paint is projected to another photo")
        }
    },
    request: |_| QualityRequest::TakePropagatedOff.into(),
    ..PLAIN
};

/// Shows the list of layers as a table.
pub const AS_TABLE: Command = Command {
    name: "Layers as table",
    tooltip: "Lists the photo's layers in a table that can be sorted by any column.",
    menu: Menu::Layers,
    starts_group: true,
    on: Some(|state| state.settings.layer_list.as_table),
    request: |_| WindowRequest::Flip(Flag::LayerTable).into(),
    ..PLAIN
};

/// Shows the project's layer options.
pub const OPTIONS: Command = Command {
    name: "Layer options…",
    tooltip: "Sets how layers are built: when a surface counts as hidden, and how large image layers are.",
    menu: Menu::Layers,
    ready: with_project,
    on: Some(|state| state.dialogs.layer_options),
    request: |_| WindowRequest::Flip(Flag::LayerOptions).into(),
    ..PLAIN
};

/// Compares cameras, photos and model.
pub const CHECK: Command = Command {
    name: "Check project",
    tooltip: "Compares cameras, photos and model, and reports likely mistakes.",
    menu: Menu::Layers,
    starts_group: true,
    ready: with_project,
    request: |_| CheckRequest::Check.into(),
    ..PLAIN
};

/// Shows the result of the last check.
pub const CHECKED: Command = Command {
    name: "Check results",
    tooltip: "Shows the results of the last check, with the model's edges over the photos.",
    menu: Menu::Layers,
    ready: with_check,
    on: Some(|state| state.checks.shown),
    request: |_| WindowRequest::Flip(Flag::Check).into(),
    ..PLAIN
};

/// Suggests what the model lacks.
pub const COMPLETE: Command = Command {
    name: "Suggest what is missing",
    tooltip: "Finds walls, roofs and ground that the photos show and the model lacks, and shows them as glass; those that you accept \
              are added to the model.",
    menu: Menu::Layers,
    ready: |state| {
        with_project(state)?;
        if state.running.runs(JobKind::Model) { Err("it is running") } else { Ok(()) }
    },
    request: |_| ModelRequest::Suggest.into(),
    ..PLAIN
};

/// Stops running jobs.
pub const STOP: Command = Command {
    name: "Stop all jobs",
    tooltip: "Stops all running jobs; finished results are kept.",
    keys: &[shift(Key::Escape)],
    menu: Menu::Layers,
    ready: |state| if state.running.is_idle() { Err("no job is running") } else { Ok(()) },
    request: |_| JobRequest::StopAll.into(),
    ..PLAIN
};

/// Succeeds when a project is open and no other job writes to its stacks.
fn can_write(state: &State) -> Result<(), WhyNot> {
    with_project(state)?;
    // A film is drawn by the renderer of the 3D view, which new layers replace.
    let writes =
        [JobKind::Build, JobKind::Fill, JobKind::Import, JobKind::Export, JobKind::Open, JobKind::Render];
    match writes.into_iter().any(|kind| state.running.runs(kind)) {
        true => Err("wait until the running job has ended, or stop it"),
        false => Ok(()),
    }
}

fn with_check(state: &State) -> Result<(), WhyNot> {
    let session = state.session.as_ref().ok_or("open a project first")?;
    if state.checks.has_report(&session.folder) { Ok(()) } else { Err("check the project first") }
}

fn with_photo(state: &State) -> Result<(), WhyNot> {
    state.selected_photo().map(|_| ()).ok_or("select a photo first")
}

fn with_stacks(state: &State) -> Result<(), WhyNot> {
    let session = state.session.as_ref().ok_or("open a project first")?;
    let built = session.photos.iter().any(|photo| photo.stack.is_some());
    if built { Ok(()) } else { Err("build the layers first") }
}
