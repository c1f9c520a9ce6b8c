//! Draws the assistant for new projects.

use eframe::egui::{Button, Context, ProgressBar, RichText, Ui};

use super::place::{is_entered, line, part_found, part_line, typed_ui, wrong, wrongs};
use super::view::OpeningView;
use crate::state::opening::assistant::Assistant;
use crate::state::opening::{DialogRequest, Purpose};
use crate::state::request::{JobRequest, Request};
use crate::state::running::JobKind;
use crate::widget::dialog::{Dialog, Keys, scrolled};
use crate::widget::spinner::Spinner;
use quadratura_sites::discover::{DiscoveryReport, SitePart};

/// The width of the dialog, in points.
const WIDTH: f32 = 680.0;
/// The jobs during which nothing is changed: creating the project, suggesting its model.
const MAKES: [JobKind; 2] = [JobKind::Open, JobKind::Model];

/// Draws the assistant when it is open.
pub fn assistant_ui(
    view: &OpeningView<'_>,
    assistant: &mut Assistant,
    context: &Context,
    requests: &mut Vec<DialogRequest>,
    app: &mut Vec<Request>,
) {
    let makes = view.running.runs_any(&MAKES);
    // Escape first leaves the text field.
    let types = context.text_edit_focused();
    let answer = Dialog::new("new project", WIDTH).show(context, |ui, keys| {
        ui.heading("New project");
        ui.add_enabled_ui(!makes, |ui| {
            if scrolled(ui, |ui| contents(view, assistant, ui, keys, requests)) {
                keys.take_enter();
            }
        });
        ui.add_space(8.0);
        if makes {
            progress(view, ui, app);
        } else {
            buttons(view, assistant, ui, keys, requests);
        }
    });
    if answer.escaped && !types && !makes {
        requests.push(DialogRequest::Cancel);
    }
}

/// Draws the contents; returns whether Enter belonged to one of the text fields.
fn contents(
    view: &OpeningView<'_>,
    assistant: &mut Assistant,
    ui: &mut Ui,
    keys: &Keys,
    requests: &mut Vec<DialogRequest>,
) -> bool {
    ui.label(
        "A project consists of photos, their calibrated cameras and a coarse model. Drop a folder on the window, or \
         choose one. Contents are detected automatically; your files are not modified.",
    );
    ui.add_space(6.0);
    let searches = root(view, assistant, ui, keys, requests);
    let look = view.opening.looking.look.as_ref();
    for part in SitePart::ALL {
        ui.add_space(6.0);
        let place = &mut assistant.places[part as usize];
        part_line(ui, part, place, requests);
        part_found(ui, part, place, look);
    }
    suggest(assistant, ui, requests);
    ui.add_space(6.0);
    folder(assistant, ui, requests);
    assistant.judge_folder();
    searches
}

/// Draws the site folder; returns whether Enter was pressed in it, which searches and does not create the project.
fn root(
    view: &OpeningView<'_>,
    assistant: &mut Assistant,
    ui: &mut Ui,
    keys: &Keys,
    requests: &mut Vec<DialogRequest>,
) -> bool {
    let mut entered = false;
    ui.strong("Site folder");
    ui.horizontal(|ui| {
        let field = line(ui, &mut assistant.root, "Folder of the site", 470.0);
        keys.begin_at(&field);
        if field.changed() {
            assistant.forget_found();
        }
        entered = is_entered(&field);
        if entered {
            requests.push(DialogRequest::Search);
        }
        let typed = !assistant.root.trim().is_empty();
        let search = ui.add_enabled(typed, Button::new("Search"));
        if search.on_hover_text("Searches this folder for photos, cameras and a model.").clicked() {
            requests.push(DialogRequest::Search);
        }
        if ui.button("Folder…").on_hover_text("Chooses the folder of the site.").clicked() {
            requests.push(DialogRequest::Choose(Purpose::Site));
        }
        if view.running.runs(JobKind::Search) {
            ui.add(Spinner::new().size(16.0));
        }
    });
    if let Some(error) = &assistant.root_error {
        wrong(ui, error);
    }
    if assistant.cut_short {
        let text =
            "This folder is very large, and only a part of it was searched. Choose a folder further down.";
        ui.colored_label(ui.visuals().warn_fg_color, text);
    }
    entered
}

/// Offers to suggest a model where there are photos and cameras, and no model.
fn suggest(assistant: &Assistant, ui: &mut Ui, requests: &mut Vec<DialogRequest>) {
    let is_typed = |part: SitePart| !assistant.places[part as usize].typed.trim().is_empty();
    if is_typed(SitePart::Model) || !is_typed(SitePart::Photos) || !is_typed(SitePart::Cameras) {
        return;
    }
    ui.indent("suggest", |ui| {
        ui.horizontal(|ui| {
            let help = "Makes a first model of ground, walls and roofs from photos and sparse points. It is written to suggested.obj \
                        in the site folder.";
            if ui.button("Suggest a model").on_hover_text(help).clicked() {
                requests.push(DialogRequest::SuggestModel);
            }
            ui.weak("It takes a minute or a few.");
        });
    });
}

fn folder(assistant: &mut Assistant, ui: &mut Ui, requests: &mut Vec<DialogRequest>) {
    ui.strong("Project folder");
    ui.horizontal(|ui| {
        let before = assistant.folder.typed.clone();
        typed_ui(ui, &mut assistant.folder.typed, "Folder of the project", 470.0);
        if assistant.folder.typed != before {
            assistant.folder_typed();
        }
        let browse = ui.button("Browse…").on_hover_text("Chooses an empty folder for the project.");
        if browse.clicked() {
            requests.push(DialogRequest::Choose(Purpose::Folder));
        }
    });
    ui.indent("folder", |ui| match (&assistant.folder.errors, assistant.objection()) {
        (errors, _) if !errors.is_empty() => wrongs(ui, errors),
        (_, Some(text)) if assistant.folder.typed.is_empty() => drop(ui.weak(text)),
        (_, Some(text)) => wrong(ui, text),
        _ => drop(ui.weak("A new folder, which will contain layers, paint and decisions.")),
    });
}

fn progress(view: &OpeningView<'_>, ui: &mut Ui, requests: &mut Vec<Request>) {
    let Some((id, job)) = view.running.all().find(|(_, job)| MAKES.contains(&job.kind)) else {
        return;
    };
    ui.horizontal(|ui| {
        ui.add(ProgressBar::new(job.progress.share().unwrap_or_default()).desired_width(240.0));
        ui.label(job.in_words());
        if ui.button("Stop").clicked() {
            requests.push(JobRequest::Stop(id).into());
        }
    });
}

fn buttons(
    view: &OpeningView<'_>,
    assistant: &Assistant,
    ui: &mut Ui,
    keys: &mut Keys,
    requests: &mut Vec<DialogRequest>,
) {
    ui.horizontal(|ui| {
        let why_not = why_not(view.opening.looking.now(), assistant);
        let create = Button::new(RichText::new("Create project").strong()).min_size([150.0, 30.0].into());
        let response = ui.add_enabled(why_not.is_none(), create);
        let response = response.on_hover_text("Reads all files once, creates the project and checks it.");
        if keys.press(&response.on_disabled_hover_text(why_not.unwrap_or_default())) {
            requests.push(DialogRequest::Create);
        }
        if ui.add(Button::new("Cancel").min_size([80.0, 30.0].into())).clicked() {
            requests.push(DialogRequest::Cancel);
        }
        if let Some(why_not) = why_not {
            ui.weak(why_not);
        }
    });
}

fn why_not(look: Option<&DiscoveryReport>, assistant: &Assistant) -> Option<&'static str> {
    let missing =
        SitePart::ALL.into_iter().find(|part| assistant.places[*part as usize].typed.trim().is_empty());
    match missing {
        Some(SitePart::Photos) => return Some("The photos are missing."),
        Some(SitePart::Cameras) => return Some("The cameras are missing."),
        Some(SitePart::Model) => return Some("The model is missing."),
        None => (),
    }
    let Some(look) = look else { return Some("The files are still being checked.") };
    if !look.is_whole() {
        return Some("The parts marked above cannot be used.");
    }
    assistant.objection().map(|_| "Choose another folder for the project.")
}
