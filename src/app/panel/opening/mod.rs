//! Draws the dialogs for opening, creating and relinking projects.

mod assistant;
mod copy;
mod held;
pub mod place;
mod relinking;
mod sample;
mod typing;
pub mod view;

use eframe::egui::Context;

use self::assistant::assistant_ui;
use self::copy::copy_ui;
use self::held::held_ui;
use self::relinking::relinking_ui;
use self::sample::sample_ui;
use self::typing::typing_ui;
use self::view::OpeningView;
use crate::state::opening::OpeningDialogs;
use crate::state::request::{ProjectRequest, Request};

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
