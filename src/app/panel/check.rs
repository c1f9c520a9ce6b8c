//! The window of the check: verdict, fix, a table of photos, an overlay, findings about faces.

use std::sync::Arc;

use eframe::egui::{
    Button, Color32, Context, Grid, Image, RichText, ScrollArea, TextureHandle, Ui, Window,
    load::SizedTexture, vec2,
};

use crate::command::{Commands, layers};
use crate::panel::button;
use crate::panel::pictures::image;
use crate::state::State;
use crate::state::checks::{Checked, Checks, Mend, percent_of, verdict};
use crate::state::request::{CheckRequest, Flag, Request, WindowRequest};
use crate::state::running::{JobKind, Running};
use crate::state::session::Session;
use crate::widget::dialog::escaped;
use crate::widget::spinner::Spinner;
use quadratura_base::scene::PhotoId;
use quadratura_sites::check::mistake::{advice_without_fix, likely_mistakes};
use quadratura_sites::check::{AlignmentSuggestion, FaceReport, Names, PhotoReport, Verdict};
use quadratura_view::Picture;

/// The greatest height of an overlay, in points: the findings about faces below it stay visible.
const HIGHEST: f32 = 330.0;

/// The texture of the overlay that is shown, and the picture that it was made of.
#[derive(Default)]
pub struct CheckTextures {
    overlay: Option<(Arc<Picture>, TextureHandle)>,
}

impl CheckTextures {
    /// Returns the texture of a picture; made anew where the picture is another one than before.
    fn of(&mut self, context: &Context, picture: &Arc<Picture>) -> &TextureHandle {
        let known = self.overlay.take().filter(|(known, _)| Arc::ptr_eq(known, picture));
        let made = || (picture.clone(), context.load_texture("overlay", image(picture), Default::default()));
        &self.overlay.insert(known.unwrap_or_else(made)).1
    }
}

/// What the window of the check shows.
pub struct CheckView<'a> {
    /// The commands that the panel offers.
    commands: Commands<'a>,
    /// The results of checks.
    checks: &'a Checks,
    /// The running jobs.
    running: &'a Running,
    /// The open project.
    session: Option<&'a Session>,
}

impl<'a> CheckView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self {
            commands: Commands::of(state),
            checks: &state.checks,
            running: &state.running,
            session: state.session.as_ref(),
        }
    }
}

/// Draws the window when it is open.
pub fn check_ui(
    view: &CheckView<'_>,
    textures: &mut CheckTextures,
    context: &Context,
    requests: &mut Vec<Request>,
) {
    let checks = view.checks;
    if checks.overlay.is_none() {
        *textures = CheckTextures::default();
    }
    let Some(session) = view.session else { return };
    if !checks.shown || !(checks.has_report(&session.folder) || view.running.runs(JobKind::Check)) {
        return;
    }
    let mut open = true;
    let window = Window::new("Check")
        .open(&mut open)
        .default_pos([290.0, 60.0])
        .default_size([860.0, 560.0])
        .min_width(640.0);
    window.show(context, |ui| match &checks.report {
        Some(checked) => contents(view, checked, textures, ui, requests),
        None => {
            ui.horizontal(|ui| {
                ui.add(Spinner::new());
                ui.label("Comparing cameras, photos and model…");
            });
        }
    });
    if !open || escaped(context) {
        requests.push(WindowRequest::Hide(Flag::Check).into());
    }
}

/// Draws a report; asks for the overlay that is needed and not loaded yet.
fn contents(
    view: &CheckView<'_>,
    checked: &Checked,
    textures: &mut CheckTextures,
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    judgement(view, checked, ui, requests);
    ui.separator();
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.horizontal_top(|ui| {
            ui.vertical(|ui| {
                ui.set_width(380.0);
                photos(view.checks.photo, &checked.report.photos, ui, requests);
            });
            ui.vertical(|ui| overlay(view, checked, textures, ui, requests));
        });
        ui.add_space(6.0);
        faces(&checked.report.faces, ui);
        if let Some(sentence) = checked.report.unexplained.as_ref().and_then(|found| found.sentence(3)) {
            ui.label(sentence).on_hover_text(
                "Views show what is not modelled infinitely far away, or flat on what is behind it. The dots in the \
                 overlays show these points.",
            );
            button(view.commands, ui, &layers::COMPLETE, requests);
        }
    });
}

fn judgement(view: &CheckView<'_>, checked: &Checked, ui: &mut Ui, requests: &mut Vec<Request>) {
    let color = match checked.report.verdict {
        Verdict::Fits => ui.visuals().strong_text_color(),
        Verdict::Poor => ui.visuals().warn_fg_color,
        Verdict::Misses => ui.visuals().error_fg_color,
    };
    let unmended = advice_without_fix(checked.report.verdict, checked.report.search);
    match &checked.report.suggestion {
        // The advice comes first: figures of a model of another site mean little.
        None if checked.report.verdict == Verdict::Misses => {
            ui.label(RichText::new(unmended).size(16.0).color(color));
            ui.label(verdict(&checked.report));
        }
        suggestion => {
            ui.label(RichText::new(verdict(&checked.report)).size(16.0).color(color));
            match suggestion {
                Some(suggestion) => suggested(checked, suggestion, ui, requests),
                None if !unmended.is_empty() => drop(ui.label(unmended)),
                None => (),
            }
        }
    }
    ui.horizontal(|ui| {
        let again = ui.button("Check again").on_hover_text(layers::CHECK.tooltip);
        if again.clicked() {
            requests.push(view.commands.requested(&layers::CHECK));
        }
        let before = view.checks.before.as_ref().filter(|(project, _)| *project == checked.project);
        if let Some((_, before)) = before {
            let back = ui.button("Undo alignment").on_hover_text(format!(
                "Restores the transform that the model had before it was aligned: {before}"
            ));
            if back.clicked() {
                requests.push(Request::Check(CheckRequest::Mend(Mend::Back)));
            }
        }
    });
}

fn suggested(checked: &Checked, suggestion: &AlignmentSuggestion, ui: &mut Ui, requests: &mut Vec<Request>) {
    let reach = match (suggestion.agreement, suggestion.covered) {
        (Some(share), _) => format!("The fixed model matches {} of the observations.", percent_of(share)),
        (None, Some(share)) => format!("The fixed model covers {} of a photo.", percent_of(share)),
        (None, None) => String::new(),
    };
    let better = suggestion.similarity();
    let mistakes = likely_mistakes(&checked.world_from_model, &better);
    ui.label(format!("{} {reach}", mistakes.join(" ")));
    ui.horizontal_wrapped(|ui| {
        let mend = Button::new(RichText::new("Fix alignment").strong()).min_size([110.0, 28.0].into());
        let tooltip = format!("Writes this transform of the model into the project: {better}");
        if ui.add(mend).on_hover_text(tooltip).clicked() {
            requests.push(Request::Check(CheckRequest::Mend(Mend::Stand(better))));
        }
        if !suggestion.alternatives.is_empty() {
            ui.label("These transforms fit nearly as well. Check the edges afterwards:");
        }
        for other in &suggestion.alternatives {
            let there = other.similarity();
            let share = other.agreement.or(other.covered).map_or_else(String::new, percent_of);
            let tooltip = format!("Writes this transform of the model into the project: {there}");
            if ui.button(format!("Alternative: {share}")).on_hover_text(tooltip).clicked() {
                requests.push(Request::Check(CheckRequest::Mend(Mend::Stand(there))));
            }
        }
    });
}

fn photos(shown: PhotoId, photos: &[PhotoReport], ui: &mut Ui, requests: &mut Vec<Request>) {
    Grid::new("checked photos").num_columns(5).striped(true).show(ui, |ui| {
        for (title, tooltip) in [
            ("Photo", "Click a photo to see the model's edges over it."),
            ("In front", "Share of the model's vertices in front of the camera."),
            ("Inside", "Share of the model's vertices within the photo."),
            ("Covered", "Share of the photo that the model covers."),
            ("Faces", "Number of faces that are visible in the photo."),
        ] {
            ui.strong(title).on_hover_text(tooltip);
        }
        ui.end_row();
        for (id, photo) in PhotoId::all(photos.len()).zip(photos) {
            let name = ui.selectable_label(shown == id, &photo.name);
            if name.on_hover_text(photo.problem.as_deref().unwrap_or(&photo.name)).clicked() {
                requests.push(CheckRequest::ShowPhoto(id).into());
            }
            for share in [photo.in_front, photo.inside, photo.covered] {
                let text = RichText::new(percent_of(share));
                ui.label(if share == 0.0 { text.color(ui.visuals().error_fg_color) } else { text });
            }
            ui.label(photo.faces.to_string());
            ui.end_row();
        }
    });
}

fn overlay(
    view: &CheckView<'_>,
    checked: &Checked,
    textures: &mut CheckTextures,
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    let Some(photo) = checked.report.photos.get(view.checks.photo.index()) else { return };
    let Some(path) = &photo.picture else {
        let why = photo.problem.as_deref().unwrap_or("There is no overlay picture of this photo.");
        ui.colored_label(ui.visuals().warn_fg_color, why);
        return;
    };
    match view.checks.overlay.as_ref().filter(|(shown, _)| shown == path) {
        Some((_, picture)) => {
            let texture = textures.of(ui.ctx(), picture);
            let size = vec2(ui.available_width().max(200.0), HIGHEST);
            let image = Image::new(SizedTexture::from_handle(texture)).max_size(size).tint(Color32::WHITE);
            ui.add(image.alt_text(format!("{} with the model's edges", photo.name)));
            ui.weak("The model's edges over the photo: one colour per object, hidden edges faint.");
        }
        None => {
            ui.add(Spinner::new());
            requests.push(CheckRequest::Overlay(path.clone()).into());
        }
    }
}

fn faces(faces: &FaceReport, ui: &mut Ui) {
    ui.strong(format!("{} faces", faces.count));
    let lists = [
        ("without area, so without texture", &faces.degenerate),
        ("not planar, treated as triangles", &faces.not_planar),
        ("duplicates of earlier faces", &faces.duplicate),
        ("shown mostly from the back (in pixels)", &faces.flipped),
        ("not covered by any photo", &faces.unseen),
        ("crossed by billboards that turn", &faces.turning),
    ];
    let message = lists.iter().any(|(_, names)| names.count > 0) || faces.crossing_pairs > 0;
    lists.iter().filter(|(_, names)| names.count > 0).for_each(|(what, names)| list(ui, what, names));
    if faces.crossing_gave_up {
        ui.label("Too many faces overlap to count all pairs of intersecting faces.");
    }
    if faces.crossing_pairs > 0 {
        let pairs: Vec<String> = faces.crossing.iter().map(|pair| pair.faces.join(" and ")).collect();
        let names = Names { count: faces.crossing_pairs, names: pairs };
        list(ui, "pairs of intersecting faces", &names);
    }
    if !message {
        ui.weak("The faces have no problems.");
    }
}

fn list(ui: &mut Ui, what: &str, names: &Names) {
    let title = format!("{} {what}", names.count);
    ui.collapsing(title, |ui| {
        let more = if names.count > names.names.len() { ", …" } else { "" };
        ui.label(format!("{}{more}", names.names.join(", ")));
    });
}
