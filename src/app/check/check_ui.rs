//! The window of the check: verdict, fix, a table of photos, an overlay, findings about faces.

use std::path::PathBuf;

use eframe::egui::{
    Button, Color32, Context, Grid, Image, RichText, ScrollArea, Ui, Window, load::SizedTexture, vec2,
};

use super::{Checked, Mend, percent, verdict};
use crate::app::check::ask_overlay;
use crate::app::command::layers;
use crate::app::editor::Editor;
use crate::app::panel::pictures::image;
use crate::app::state::State;
use crate::app::state::ask::{Ask, CheckAsk};
use crate::app::state::running::JobKind;
use crate::app::widget::dialog::escaped;
use crate::geometry::Similarity;
use crate::recipe::check::mistake::{advice_without_fix, likely_mistakes};
use crate::recipe::check::{AlignmentSuggestion, FaceReport, Names, PhotoReport, Verdict};

/// The greatest height of an overlay, in points: the findings about faces below it stay visible.
const HIGHEST: f32 = 330.0;

/// Draws the window when it is open.
pub fn check_ui(editor: &mut Editor, context: &Context, asks: &mut Vec<Ask>) {
    let Some(folder) = editor.state.session.as_ref().map(|session| session.folder.clone()) else { return };
    if !editor.state.checks.shown
        || !(editor.state.checks.has_report(&folder) || editor.state.running.runs(JobKind::Check))
    {
        return;
    }
    let (mut open, mut wanted) = (true, None);
    if let Some((path, picture)) = editor.state.checks.read.take() {
        let texture = context.load_texture("overlay", image(&picture), Default::default());
        editor.state.checks.picture = Some((path, texture));
    }
    let window = Window::new("Check")
        .open(&mut open)
        .default_pos([290.0, 60.0])
        .default_size([860.0, 560.0])
        .min_width(640.0);
    window.show(context, |ui| match editor.state.checks.report.take() {
        Some(checked) => {
            wanted = contents(editor, &checked, ui, asks);
            editor.state.checks.report = Some(checked);
        }
        None => {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label("Comparing cameras, photos and model…");
            });
        }
    });
    editor.state.checks.shown &= open && !escaped(context);
    if let Some(path) = wanted {
        ask_overlay(&mut editor.state, &mut editor.work, &path);
    }
}

/// Draws a report; returns the overlay that is needed and not loaded yet.
fn contents(editor: &mut Editor, checked: &Checked, ui: &mut Ui, asks: &mut Vec<Ask>) -> Option<PathBuf> {
    judgement(editor, checked, ui, asks);
    ui.separator();
    let mut wanted = None;
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.horizontal_top(|ui| {
            ui.vertical(|ui| {
                ui.set_width(380.0);
                photos(editor, &checked.report.photos, ui);
            });
            ui.vertical(|ui| wanted = overlay(editor, checked, ui));
        });
        ui.add_space(6.0);
        faces(&checked.report.faces, ui);
    });
    wanted
}

fn judgement(state: &State, checked: &Checked, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let color = match checked.report.verdict {
        Verdict::Fits => ui.visuals().strong_text_color(),
        Verdict::Poor => ui.visuals().warn_fg_color,
        Verdict::Misses => ui.visuals().error_fg_color,
    };
    let unmended = advice_without_fix(checked.report.verdict);
    match &checked.report.suggestion {
        // The advice comes first: figures of a model of another site mean little.
        None if checked.report.verdict == Verdict::Misses => {
            ui.label(RichText::new(unmended).size(16.0).color(color));
            ui.label(verdict(&checked.report));
        }
        suggestion => {
            ui.label(RichText::new(verdict(&checked.report)).size(16.0).color(color));
            match suggestion {
                Some(suggestion) => suggested(checked, suggestion, ui, asks),
                None if !unmended.is_empty() => drop(ui.label(unmended)),
                None => (),
            }
        }
    }
    ui.horizontal(|ui| {
        let again = ui.button("Check again").on_hover_text(layers::CHECK.tooltip);
        if again.clicked() {
            asks.push(layers::CHECK.asked(state));
        }
        let before = state.checks.before.as_ref().filter(|(project, _)| *project == checked.project);
        if let Some((_, before)) = before {
            let back = ui.button("Put the model back").on_hover_text(format!(
                "The model stands again where it stood before it was moved here: {before}"
            ));
            if back.clicked() {
                asks.push(Ask::Check(CheckAsk::Mend(Mend::Back)));
            }
        }
    });
}

fn suggested(checked: &Checked, suggestion: &AlignmentSuggestion, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let reach = match (suggestion.agreement, suggestion.covered) {
        (Some(share), _) => format!("It would meet {} of the sightings then.", percent(share)),
        (None, Some(share)) => format!("It would cover {} of a photo then.", percent(share)),
        (None, None) => String::new(),
    };
    let Ok(better) = Similarity::parse(&suggestion.transform) else { return };
    let mistakes = likely_mistakes(&checked.world_from_model, &better);
    ui.label(format!("{} {reach}", mistakes.join(" ")));
    ui.horizontal_wrapped(|ui| {
        let mend = Button::new(RichText::new("Mend it").strong()).min_size([110.0, 28.0].into());
        let tooltip = format!("Writes this transform of the model into the project: {better}");
        if ui.add(mend).on_hover_text(tooltip).clicked() {
            asks.push(Ask::Check(CheckAsk::Mend(Mend::Stand(better))));
        }
        if !suggestion.alternatives.is_empty() {
            ui.label("Nearly as well, so look at the edges afterwards:");
        }
        for other in &suggestion.alternatives {
            let Ok(there) = Similarity::parse(other) else { continue };
            if ui.button(other).on_hover_text("Moves the model so.").clicked() {
                asks.push(Ask::Check(CheckAsk::Mend(Mend::Stand(there))));
            }
        }
    });
}

fn photos(editor: &mut Editor, photos: &[PhotoReport], ui: &mut Ui) {
    Grid::new("checked photos").num_columns(5).striped(true).show(ui, |ui| {
        for (title, tooltip) in [
            ("Photo", "Click one to see the model's edges over it."),
            ("In front", "Share of the model's vertices in front of the camera."),
            ("Inside", "Share of the model's vertices within the photo."),
            ("Covered", "Share of the photo that the model covers."),
            ("Faces", "Faces that the photo sees."),
        ] {
            ui.strong(title).on_hover_text(tooltip);
        }
        ui.end_row();
        for (index, photo) in photos.iter().enumerate() {
            let name = ui.selectable_label(editor.state.checks.photo == index, &photo.name);
            if name.on_hover_text(photo.problem.as_deref().unwrap_or(&photo.name)).clicked() {
                editor.state.checks.photo = index;
            }
            for share in [photo.in_front, photo.inside, photo.covered] {
                let text = RichText::new(percent(share));
                ui.label(if share == 0.0 { text.color(ui.visuals().error_fg_color) } else { text });
            }
            ui.label(photo.faces.to_string());
            ui.end_row();
        }
    });
}

fn overlay(state: &State, checked: &Checked, ui: &mut Ui) -> Option<PathBuf> {
    let photo = checked.report.photos.get(state.checks.photo)?;
    let Some(path) = &photo.picture else {
        let why = photo.problem.as_deref().unwrap_or("There is no picture of it.");
        ui.colored_label(ui.visuals().warn_fg_color, why);
        return None;
    };
    match state.checks.picture.as_ref().filter(|(shown, _)| shown == path) {
        Some((_, texture)) => {
            let size = vec2(ui.available_width().max(200.0), HIGHEST);
            let picture = Image::new(SizedTexture::from_handle(texture)).max_size(size).tint(Color32::WHITE);
            ui.add(picture.alt_text(format!("{} with the model's edges", photo.name)));
            ui.weak("The model's edges over the photo, each object in a colour, what is hidden faint.");
            None
        }
        None => {
            ui.spinner();
            Some(path.clone())
        }
    }
}

fn faces(faces: &FaceReport, ui: &mut Ui) {
    ui.strong(format!("{} faces", faces.count));
    let lists = [
        ("without area, so without texture", &faces.degenerate),
        ("not planar, treated by their triangles", &faces.not_planar),
        ("the same as an earlier one", &faces.duplicate),
        ("seen from behind by most photos that see them", &faces.flipped),
        ("seen by no photo", &faces.unseen),
    ];
    let message = lists.iter().any(|(_, names)| names.count > 0) || faces.crossing_pairs > 0;
    lists.iter().filter(|(_, names)| names.count > 0).for_each(|(what, names)| list(ui, what, names));
    if faces.crossing_gave_up {
        ui.label("So many faces overlap that pairs that run through each other were not counted to the end.");
    }
    if faces.crossing_pairs > 0 {
        let pairs: Vec<String> = faces.crossing.iter().map(|pair| pair.faces.join(" and ")).collect();
        let names = Names { count: faces.crossing_pairs, names: pairs };
        list(ui, "pairs that run through each other", &names);
    }
    if !message {
        ui.weak("Nothing is wrong with them.");
    }
}

fn list(ui: &mut Ui, what: &str, names: &Names) {
    let title = format!("{} {what}", names.count);
    ui.collapsing(title, |ui| {
        let more = if names.count > names.names.len() { ", …" } else { "" };
        ui.label(format!("{}{more}", names.names.join(", ")));
    });
}
