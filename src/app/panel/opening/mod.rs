//! Draws the dialogs for opening, creating and relinking projects.

mod assistant;
mod copy;
mod held;
pub mod place;
mod relinking;
mod sample;
mod typing;

use eframe::egui::Context;

use self::assistant::assistant_ui;
use self::copy::copy_ui;
use self::held::held_ui;
use self::relinking::relinking_ui;
use self::sample::sample_ui;
use self::typing::typing_ui;
use crate::command::Commands;
use crate::state::State;
use crate::state::opening::{Opening, OpeningDialogs};
use crate::state::request::{ProjectRequest, Request};
use crate::state::running::Running;

/// What the dialogs for opening and creating projects depend on.
pub struct OpeningView<'a> {
    /// The commands that the panel offers.
    commands: Commands<'a>,
    /// The dialogs for opening projects.
    opening: &'a Opening,
    /// The running jobs.
    running: &'a Running,
}

impl<'a> OpeningView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self { commands: Commands::of(state), opening: &state.opening, running: &state.running }
    }
}

/// Draws the open dialogs; `dialogs` is what is typed in them.
pub fn opening_ui(
    view: &OpeningView<'_>,
    dialogs: &mut OpeningDialogs,
    context: &Context,
    requests: &mut Vec<Request>,
) {
    let mut dialog_requests = Vec::new();
    if let Some(assistant) = &mut dialogs.assistant {
        assistant_ui(view, assistant, context, &mut dialog_requests, requests);
    }
    if let Some(relinking) = &mut dialogs.relinking {
        relinking_ui(view, relinking, context, &mut dialog_requests);
    }
    if let Some(sample) = &mut dialogs.sample {
        sample_ui(view, sample, context, &mut dialog_requests);
    }
    if let Some(copy) = &mut dialogs.copy {
        copy_ui(view, copy, context, &mut dialog_requests);
    }
    held_ui(view, context, &mut dialog_requests);
    if view.opening.typing {
        typing_ui(&mut dialogs.typed, context, &mut dialog_requests);
    }
    requests
        .extend(dialog_requests.into_iter().map(|request| Request::Project(ProjectRequest::Dialog(request))));
}
