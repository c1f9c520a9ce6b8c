//! Dialogs of the round trip: files to import, export options, the image editor.

use eframe::egui::{Button, Context, Grid, RichText, ScrollArea, TextEdit, Ui};

use crate::command::{Command, Commands, flight, images};
use crate::state::State;
use crate::state::request::{Request, RoundTripRequest};
use crate::state::round_trip::dialogs::{DialogPurpose, ExportDialog, RoundTripDialogs};
use crate::state::round_trip::image_editor::EditorChoice;
use crate::state::running::{JobKind, Running};
use crate::state::session::Session;
use crate::widget::dialog::{Dialog, at_the_right};
use crate::widget::spinner::Spinner;
use quadratura_base::scene::PhotoId;
use quadratura_document::export_record::ExportFormat;
use quadratura_exports::handover::HandoverFormat;
use quadratura_io::programs::{ImageEditor, check_program};
use quadratura_layered_files::FORMATS;
use quadratura_layered_files::format::file_names;
use std::path::PathBuf;

/// What the dialogs of the round trip depend on.
pub struct DialogsView<'a> {
    /// The commands that the panel offers.
    commands: Commands<'a>,
    /// The open project.
    session: Option<&'a Session>,
    /// The photo that commands on a photo apply to.
    photo: Option<PhotoId>,
    /// The running jobs.
    running: &'a Running,
    /// The image editors that are installed, as far as they were looked for.
    found: &'a [(ImageEditor, PathBuf)],
    /// The image editor that is used.
    image_editor: &'a EditorChoice,
}

impl<'a> DialogsView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self {
            commands: Commands::of(state),
            session: state.session.as_ref(),
            photo: state.selected_photo(),
            running: &state.running,
            found: state.round_trip.found.as_deref().unwrap_or_default(),
            image_editor: &state.settings.image_editor,
        }
    }
}

/// Draws the open dialogs, which change as they are edited.
pub fn dialogs_ui(
    context: &Context,
    view: &DialogsView<'_>,
    dialogs: &mut RoundTripDialogs,
    requests: &mut Vec<Request>,
) {
    import_ui(context, dialogs, requests);
    export_ui(context, view, dialogs, requests);
    editor_ui(context, view, &mut dialogs.choosing_editor, requests);
}

/// The width of the dialogs, in points.
const WIDTH: f32 = 470.0;
/// The width of a field with a label before it and a button behind it, in points.
const FIELD: f32 = 280.0;

fn import_ui(context: &Context, dialogs: &mut RoundTripDialogs, requests: &mut Vec<Request>) {
    let Some(dialog) = &mut dialogs.import else { return };
    let (mut open, mut choose, mut done) = (true, false, false);
    let answer = Dialog::new("import", WIDTH).show(context, |ui, keys| {
        ui.heading("Import edited files");
        let files = file_names();
        ui.label(format!("{files} files that were exported from this project, or exported folders."));
        ui.weak("You can also drop them on the window.");
        Grid::new("files").num_columns(2).show(ui, |ui| {
            for (index, path) in dialog.paths.iter_mut().enumerate() {
                let label = ui.label(if index == 0 { "File or folder" } else { "And" });
                ui.horizontal(|ui| {
                    let line = ui.add(TextEdit::singleline(path).desired_width(FIELD));
                    if index == 0 {
                        keys.begin_at(&line);
                        choose = ui.button("Browse…").on_hover_text("Adds files to the list.").clicked();
                    }
                    line.labelled_by(label.id);
                });
                ui.end_row();
            }
        });
        let scaled = "The images are scaled back to the photo's size; faint paint is lost.";
        ui.checkbox(&mut dialog.scaled, "Allow scaled images").on_hover_text(scaled);
        let unseen = "Paint is left out where this photo or another one shows the surface: it only fills what no photo \
                      shows.";
        ui.checkbox(&mut dialog.only_unseen, "Only where no photo shows the surface").on_hover_text(unseen);
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            let any = dialog.paths.iter().any(|path| !path.trim().is_empty());
            done = keys.press(&ui.add_enabled(any, usual("Import")));
            open = !ui.add(button("Cancel")).clicked();
        });
    });
    if !open || answer.escaped {
        dialogs.import = None;
    }
    if choose {
        requests.push(RoundTripRequest::ChoosePath(DialogPurpose::Layered).into());
    }
    if done {
        requests.push(Request::RoundTrip(RoundTripRequest::Import));
    }
}

/// The formats that have dialogs of their own, because they are of one photo or of a view.
const OTHERS: &[(&Command, &str)] = &[
    (&images::SAVE, "Layered depth image…"),
    (&images::PAGE, "Page of one photo…"),
    (&images::PUBLISH, "The site as a web page…"),
    (&images::ORTHOPHOTO, "Orthophoto…"),
    (&flight::STILL, "Picture of the view…"),
];

/// Draws buttons for formats with dialogs of their own; returns the one that is clicked.
fn others(ui: &mut Ui, view: &DialogsView<'_>, row: &'static [(&Command, &str)]) -> Option<&'static Command> {
    let mut clicked = None;
    for (command, text) in row {
        let ready = view.commands.ready(command);
        let button = ui.add_enabled(ready.is_ok(), Button::new(*text).small());
        let button = button.on_hover_text(command.tooltip);
        if button.on_disabled_hover_text(ready.err().unwrap_or_default()).clicked() {
            clicked = Some(*command);
        }
    }
    clicked
}

fn export_ui(
    context: &Context,
    view: &DialogsView<'_>,
    dialogs: &mut RoundTripDialogs,
    requests: &mut Vec<Request>,
) {
    let Some(dialog) = &mut dialogs.export else { return };
    let (mut open, mut choose, mut go, mut show, mut other) = (true, false, false, None, None);
    let answer = Dialog::new("export", WIDTH).show(context, |ui, keys| {
        ui.heading("Export files");
        Grid::new("export").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
            ui.label("Layered files");
            ui.horizontal(|ui| layered(ui, dialog));
            ui.end_row();
            ui.label("Other programs");
            ui.horizontal(|ui| programs(ui, dialog));
            ui.end_row();
            ui.label("Photo, view, face");
            ui.vertical(|ui| {
                // A row of a grid does not grow with what wraps in it.
                for row in OTHERS.chunks(3) {
                    ui.horizontal(|ui| other = others(ui, view, row).or(other));
                }
            });
            ui.end_row();
            let label = ui.label("Folder");
            ui.horizontal(|ui| {
                let folder = ui.add(TextEdit::singleline(&mut dialog.folder).desired_width(FIELD));
                keys.begin_at(&folder.labelled_by(label.id));
                choose = ui.button("Browse…").clicked();
            });
            ui.end_row();
        });
        ui.weak(
            "Relative to the project folder, unless it begins with /. Changed files are never overwritten.",
        );
        photos(view, &mut dialog.photos, dialog.program.is_some(), ui);
        match dialog.program {
            None => options_of_layered(ui, dialog),
            Some(format) if format.has_tiles() => options_of_tiles(ui, dialog),
            Some(_) => (),
        }
        let problem = dialog.problem();
        if let Some(problem) = problem {
            ui.colored_label(ui.visuals().warn_fg_color, problem);
        }
        for line in &dialog.report {
            ui.label(line);
        }
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            let runs = view.running.runs(JobKind::Export);
            go = keys.press(&ui.add_enabled(problem.is_none() && !runs, usual("Export")));
            let leave = if runs || dialog.done.is_some() { "Close" } else { "Cancel" };
            open = !ui.add(button(leave)).clicked();
            if runs {
                ui.add(Spinner::new());
            }
            if let Some(done) = &dialog.done {
                ui.label("Done.");
                if ui.button("Open folder").on_hover_text(done.display().to_string()).clicked() {
                    show = Some(done.clone());
                }
            }
        });
    });
    if !open || answer.escaped || other.is_some() {
        dialogs.export = None;
    }
    requests.extend(other.map(|command: &Command| view.commands.requested(command)));
    if choose {
        requests.push(RoundTripRequest::ChoosePath(DialogPurpose::ExportFolder).into());
    }
    if go {
        requests.push(Request::RoundTrip(RoundTripRequest::Export));
    }
    if let Some(folder) = show {
        requests.push(RoundTripRequest::ShowFolder(folder).into());
    }
}

fn button(text: &str) -> Button<'_> {
    Button::new(text).min_size([96.0, 28.0].into())
}

/// Draws the main button.
fn usual(text: &str) -> Button<'_> {
    Button::new(RichText::new(text).strong()).min_size([96.0, 28.0].into())
}

fn formats(ui: &mut Ui, format: &mut ExportFormat) {
    for entry in FORMATS {
        ui.radio_value(format, entry.format, entry.title);
    }
}

/// Draws the choice of a layered format, which is none while another program is chosen.
fn layered(ui: &mut Ui, dialog: &mut ExportDialog) {
    for entry in FORMATS {
        let is_chosen = dialog.program.is_none() && dialog.format == entry.format;
        if ui.radio(is_chosen, entry.title).on_hover_text(entry.about).clicked() {
            dialog.choose(None);
            dialog.format = entry.format;
        }
    }
}

/// Draws the choice of another program's format.
fn programs(ui: &mut Ui, dialog: &mut ExportDialog) {
    for (_, format, about) in HandoverFormat::TABLE {
        if ui.radio(dialog.program == Some(*format), format.title()).on_hover_text(*about).clicked() {
            dialog.choose(Some(*format));
        }
    }
}

fn options_of_layered(ui: &mut Ui, dialog: &mut ExportDialog) {
    let guides = "Adds hidden layers with hatching where the photo does not show the surfaces.";
    ui.checkbox(&mut dialog.guides, "Guides").on_hover_text(guides);
    let provenance = "Writes pictures beside the files, which show where each filled texel comes from.";
    ui.checkbox(&mut dialog.provenance, "Provenance").on_hover_text(provenance);
    let even = "Exports all photos with matched exposures, for viewing only: such files cannot be imported.";
    ui.checkbox(&mut dialog.even, "Matched exposure").on_hover_text(even);
}

fn options_of_tiles(ui: &mut Ui, dialog: &mut ExportDialog) {
    let tiles =
        "Makes the textures tiles of one picture, for programs of film: site_texture.1001.jpg and so on.";
    ui.checkbox(&mut dialog.tiles, "Tiles (UDIM)").on_hover_text(tiles);
}

/// Draws the choice of photos: all, of layered files all that have layers, or some.
fn photos(
    view: &DialogsView<'_>,
    chosen: &mut std::collections::BTreeSet<PhotoId>,
    needs_no_layers: bool,
    ui: &mut Ui,
) {
    let Some(session) = view.session else { return };
    ui.horizontal(|ui| {
        let all = if needs_no_layers { "All photos" } else { "All photos that have layers" };
        if ui.radio(chosen.is_empty(), all).clicked() {
            chosen.clear();
        }
        if ui.radio(!chosen.is_empty(), "Choose photos").clicked() && chosen.is_empty() {
            chosen.extend(view.photo.or(session.opened.site.photo_ids().next()));
        }
    });
    if chosen.is_empty() {
        return;
    }
    ScrollArea::vertical().max_height(160.0).show(ui, |ui| {
        for (id, photo) in session.opened.site.numbered_photos() {
            let mut on = chosen.contains(&id);
            let is_offered = needs_no_layers || session.stack_of(id).is_some();
            ui.add_enabled_ui(is_offered, |ui| {
                if ui.checkbox(&mut on, &photo.name).changed() {
                    if on {
                        chosen.insert(id)
                    } else {
                        chosen.remove(&id)
                    };
                }
            });
        }
    });
}

fn editor_ui(context: &Context, view: &DialogsView<'_>, shown: &mut bool, requests: &mut Vec<Request>) {
    if !*shown {
        return;
    }
    let found = view.found;
    let mut choice = view.image_editor.clone();
    let (mut open, mut choose, mut again) = (true, false, false);
    let answer = Dialog::new("image editor", WIDTH).show(context, |ui, keys| {
        ui.heading("Image editor");
        ui.label("“Edit in image editor” opens photos in:");
        for known in ImageEditor::ALL {
            let program = found.iter().find(|(editor, _)| *editor == known).map(|(_, program)| program);
            ui.horizontal(|ui| {
                ui.add_enabled_ui(program.is_some(), |ui| {
                    ui.radio_value(&mut choice.editor, Some(known), known.name());
                });
                ui.weak(program.map_or("not found".into(), |program| program.display().to_string()));
            });
        }
        ui.radio_value(&mut choice.editor, None, "Another program");
        ui.add_enabled_ui(choice.editor.is_none(), |ui| {
            ui.horizontal(|ui| {
                let label = ui.label("Program");
                let path = TextEdit::singleline(&mut choice.program).desired_width(290.0);
                ui.add(path).labelled_by(label.id);
                choose = ui.button("Browse…").clicked();
            });
            if choice.editor.is_none()
                && !choice.program.is_empty()
                && check_program(choice.program.as_ref()).is_err()
            {
                ui.colored_label(ui.visuals().warn_fg_color, "There is no such program.");
            }
            ui.horizontal(|ui| {
                ui.label("File format");
                formats(ui, &mut choice.format);
            });
        });
        ui.add_space(8.0);
        again = ui.button("Search again").on_hover_text("Searches for image editors again.").clicked();
        open = !keys.press(&at_the_right(ui, |ui| ui.add(usual("Close"))));
    });
    *shown = open && !answer.is_left();
    if choice != *view.image_editor {
        requests.push(RoundTripRequest::UseEditor(choice).into());
    }
    if choose {
        requests.push(RoundTripRequest::ChoosePath(DialogPurpose::Program).into());
    }
    if again {
        requests.push(RoundTripRequest::LookForEditors.into());
    }
}
