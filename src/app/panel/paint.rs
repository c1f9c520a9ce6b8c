//! The panel of imported paint: the last import with pictures before and after, and the imports that can be undone.

use std::sync::{Arc, Weak};

use eframe::egui::{
    Color32, Context, Image, Rect, RichText, ScrollArea, Sense, TextureHandle, TextureOptions, Ui, Vec2,
    pos2, vec2,
};

use super::fill::question::{QuestionTextures, question_ui};
use super::import_question::{ImportQuestionTextures, import_question_ui};
use super::{button, counted, grouped, link_ui};
use crate::command::{Commands, paint};
use crate::panel::pictures::image;
use crate::state::State;
use crate::state::quality::filling::FillSession;
use crate::state::request::{QualityRequest, Request, SelectRequest};
use crate::state::round_trip::report::Report;
use crate::state::round_trip::{RoundTrip, shown_path};
use crate::state::running::Running;
use crate::state::selection::Selection;
use crate::state::session::Session;
use quadratura_document::paint::PaintImport;
use quadratura_editing::import::elsewhere::PaintElsewhere;
use quadratura_editing::import::pictures::ChangedLayer;
use quadratura_editing::import::report::{FileReport, LayerImportReport, LayerState};
use quadratura_stacks::fill::seen::{EditedPaint, Seen, SeenEdit};
use quadratura_view::Picture;

/// The pictures of the last import's changes on the device.
#[derive(Default)]
pub struct PaintTextures {
    /// The changes that the textures show; they are uploaded again when the report has others.
    of: Weak<Vec<ChangedLayer>>,
    /// Before and after, by index of the change.
    textures: Vec<[TextureHandle; 2]>,
    /// The question where paint is seen.
    question: QuestionTextures,
    /// The question about a file.
    import_question: ImportQuestionTextures,
}

impl PaintTextures {
    /// Uploads the pictures of a report where it has new ones, and drops those of the one before.
    fn follow(&mut self, report: Option<&Report>, context: &Context) {
        let Some(report) = report else {
            (self.of, self.textures) = Default::default();
            return;
        };
        if std::ptr::eq(self.of.as_ptr(), Arc::as_ptr(&report.looks)) {
            return;
        }
        let number = report.imported.number.unwrap_or_default();
        let load = |layer: &ChangedLayer| {
            let texture = |when: &str, picture: &Picture| {
                let name = format!("{} {when} import {number}", layer.token);
                context.load_texture(name, image(picture), TextureOptions::LINEAR)
            };
            [texture("before", &layer.before), texture("after", &layer.after)]
        };
        self.textures = report.looks.iter().map(load).collect();
        self.of = Arc::downgrade(&report.looks);
    }
}

/// What the panel of imported paint shows.
pub struct PaintView<'a> {
    /// The commands that the panel offers.
    commands: Commands<'a>,
    /// The open project.
    pub session: Option<&'a Session>,
    /// The round trip to image editors.
    pub round_trip: &'a RoundTrip,
    /// The facts about fillings.
    pub fill: &'a FillSession,
    /// The running jobs.
    pub running: &'a Running,
    /// Whether it is asked where paint is seen.
    pub asks_where_seen: bool,
}

impl<'a> PaintView<'a> {
    /// Borrows what the panel shows.
    pub fn new(state: &'a State) -> Self {
        Self {
            commands: Commands::of(state),
            session: state.session.as_ref(),
            round_trip: &state.round_trip,
            fill: &state.quality.fill,
            running: &state.running,
            asks_where_seen: state.asks_where_paint_is_seen(),
        }
    }
}

/// Draws the panel.
pub fn paint_ui(
    ui: &mut Ui,
    view: &PaintView<'_>,
    textures: &mut PaintTextures,
    requests: &mut Vec<Request>,
) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            for command in [&paint::EDIT, &paint::IMPORT, &paint::TAKE_BACK] {
                button(view.commands, ui, command, requests);
            }
        });
        ui.separator();
        import_question_ui(ui, view, &mut textures.import_question, requests);
        question_ui(ui, view, &mut textures.question, requests);
        textures.follow(view.round_trip.report.as_ref(), ui.ctx());
        match &view.round_trip.report {
            Some(report) => {
                let shown = ShownReport { report, textures: &textures.textures };
                report_ui(ui, view, shown, requests);
            }
            None => {
                // The report of an import is that of this session; the imports before are listed below.
                ui.weak(
                    "“Edit in image editor” opens the selected photo's layers; paint on a layer and \
                     save, and the paint appears here and in the 3D view.",
                );
            }
        }
        ui.separator();
        history(view, ui);
    });
}

/// A report with the textures of its changes.
#[derive(Clone, Copy)]
struct ShownReport<'a> {
    report: &'a Report,
    /// The pictures of each change, before and after.
    textures: &'a [[TextureHandle; 2]],
}

fn report_ui(ui: &mut Ui, view: &PaintView<'_>, shown: ShownReport<'_>, requests: &mut Vec<Request>) {
    let report = shown.report;
    let imported = &report.imported;
    ui.horizontal_wrapped(|ui| {
        match imported.number {
            Some(number) => ui.heading(format!("Import {number}")),
            None => ui.heading("Nothing changed"),
        };
        ui.weak(format!("{:.2} s", report.spent.as_secs_f64()))
            .on_hover_text("Time for reading and comparing.");
        if report.taken_back {
            ui.colored_label(ui.visuals().warn_fg_color, "undone");
        }
    });
    let painted = imported.changed - imported.masked;
    if painted > 0 {
        ui.label(format!("{} of new paint.", counted(painted, "pixel")));
    }
    if let Some(number) = imported.number.filter(|_| painted > 0 && !report.taken_back) {
        only_here(ui, view, number, requests);
    }
    for paint in &imported.elsewhere {
        let PaintElsewhere { photo, face, pixels, .. } = paint;
        let pixels = counted(*pixels, "pixel");
        let text =
            format!("Conflict: {photo} has other paint on {face} at {pixels} of this paint, and keeps it.");
        ui.colored_label(ui.visuals().warn_fg_color, text);
    }
    let folder = view.session.map(|session| session.folder.clone()).unwrap_or_default();
    for file in &imported.files {
        ui.add_space(6.0);
        ui.strong(shown_path(&folder, &file.file));
        file_ui(ui, view, file, shown, requests);
    }
    for (path, problem) in &imported.failed {
        ui.add_space(6.0);
        ui.strong(shown_path(&folder, path));
        ui.colored_label(ui.visuals().error_fg_color, problem.to_string());
    }
}

/// Draws the switch of an import's paint.
fn only_here(ui: &mut Ui, view: &PaintView<'_>, number: u32, requests: &mut Vec<Request>) {
    let Some(session) = view.session else { return };
    let mut stays = session.opened.project.fill.only_here.imports.contains(&number);
    let tooltip = "The paint of this import is not projected to other photos.";
    if ui.checkbox(&mut stays, "Only in this photo").on_hover_text(tooltip).changed() {
        let seen = if stays { Seen::OnlyHere } else { Seen::Everywhere };
        requests.push(QualityRequest::See(SeenEdit { paint: EditedPaint::OfImport(number), seen }).into());
    }
}

fn file_ui(
    ui: &mut Ui,
    view: &PaintView<'_>,
    file: &FileReport,
    shown: ShownReport<'_>,
    requests: &mut Vec<Request>,
) {
    let looks = || shown.report.looks.iter().zip(shown.textures);
    file.notes.iter().for_each(|note| {
        ui.weak(note);
    });
    let plain = |layer: &&LayerImportReport| {
        layer.state == LayerState::Unchanged && layer.changed == 0 && layer.moved.is_none() && !layer.renamed
    };
    for layer in file.layers.iter().filter(|layer| !plain(layer)) {
        layer_ui(view, file, layer, ui, requests);
        let is_it =
            |look: &ChangedLayer| look.photo == file.photo && Some(&look.token) == layer.token.as_ref();
        if let Some((look, pictures)) = looks().find(|(look, _)| is_it(look)) {
            before_and_after(look, pictures, ui);
        }
    }
    // Paint appears on every layer that contains its surface, whichever layer it was painted in.
    let in_file =
        |look: &ChangedLayer| file.layers.iter().any(|layer| layer.token.as_ref() == Some(&look.token));
    for (look, pictures) in looks().filter(|(look, _)| look.photo == file.photo && !in_file(look)) {
        ui.label(format!("Also on another layer: {}", look.token));
        before_and_after(look, pictures, ui);
    }
    let unchanged = file.layers.iter().filter(plain).count() as u64;
    if unchanged > 0 {
        ui.weak(format!("{} unchanged", counted(unchanged, "layer")));
    }
}

fn layer_ui(
    view: &PaintView<'_>,
    file: &FileReport,
    layer: &LayerImportReport,
    ui: &mut Ui,
    requests: &mut Vec<Request>,
) {
    ui.horizontal_wrapped(|ui| {
        let warns =
            !matches!(layer.state, LayerState::Unchanged | LayerState::Painted | LayerState::Restored);
        let color = if warns { ui.visuals().warn_fg_color } else { ui.visuals().hyperlink_color };
        ui.label(RichText::new(layer.state.word()).color(color).strong());
        match index_of(view, file, layer) {
            Some(index) => {
                if link_ui(ui, &layer.name).on_hover_text("Selects the layer.").clicked() {
                    requests.push(Request::Select(SelectRequest::Only(index)));
                }
            }
            None => {
                ui.label(&layer.name);
            }
        }
    });
    let facts = facts(layer);
    if !facts.is_empty() {
        ui.weak(facts);
    }
    for conflict in &layer.conflicts {
        let text = format!(
            "{} of import {} on {} had other paint; this import is on top",
            counted(conflict.pixels, "pixel"),
            conflict.import,
            conflict.face
        );
        ui.colored_label(ui.visuals().warn_fg_color, text);
    }
    layer.notes.iter().for_each(|note| {
        ui.weak(note);
    });
}

/// Describes an imported layer in a line.
fn facts(layer: &LayerImportReport) -> String {
    let count = |number: u64, word: &str| (number > 0).then(|| format!("{} px {word}", grouped(number)));
    let parts = [
        count(layer.painted, "painted"),
        count(layer.erased, "of them erased"),
        count(
            layer.changed,
            if layer.state == LayerState::Restored { "of earlier paint removed" } else { "new" },
        ),
        count(layer.over_photos.unwrap_or(0), "over what other photos show"),
        layer.turned.map(|turned| format!("{turned}, imported to where it belongs")),
        layer.moved.map(|[x, y]| format!("moved by {x}, {y}, imported to where it belongs")),
        layer.resized.then(|| "resized".to_owned()),
        layer.renamed.then(|| "renamed".to_owned()),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// Returns the current layer that matches a layer of a file.
fn index_of(view: &PaintView<'_>, file: &FileReport, layer: &LayerImportReport) -> Option<Selection> {
    let session = view.session?;
    let photo = session.opened.site.photo_named(&file.photo)?;
    let layer = session.stack_of(photo)?.layer_with_token(layer.token.as_ref()?)?;
    Some(Selection::Layer { photo, layer })
}

/// Draws both pictures, side by side where they fit, otherwise one above the other.
fn before_and_after(look: &ChangedLayer, [before, after]: &[TextureHandle; 2], ui: &mut Ui) {
    let room = ui.available_width();
    let gap = ui.spacing().item_spacing.x;
    let width = ((room - gap) / 2.0).max(80.0).min(room);
    ui.horizontal_wrapped(|ui| {
        for (texture, name) in [(before, "Before"), (after, "After")] {
            let size = texture.size_vec2();
            // Small painted areas are enlarged, but never beyond the width of the panel.
            let shown = size * (width / size.x).min(width / size.y).min(8.0);
            ui.vertical(|ui| {
                ui.set_width(width);
                let (rect, response) = ui.allocate_exact_size(shown, Sense::hover());
                checkerboard(ui, rect);
                Image::new((texture.id(), size)).fit_to_exact_size(shown).paint_at(ui, rect);
                let r = look.rect;
                response.widget_info(|| {
                    let label = format!("{name}: {}", look.token);
                    eframe::egui::WidgetInfo::labeled(eframe::egui::Role::Image, true, label)
                });
                response.on_hover_text(format!("{} × {} px at {}, {} of the photo", r.w, r.h, r.x, r.y));
                ui.weak(name);
            });
        }
    });
}

/// Draws the checkerboard behind transparent areas.
fn checkerboard(ui: &Ui, rect: Rect) {
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0.0, Color32::from_gray(110));
    let side = 8.0;
    let (columns, rows) = ((rect.width() / side).ceil() as i32, (rect.height() / side).ceil() as i32);
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        if (row + column) % 2 == 0 {
            let at = rect.min + vec2(column as f32, row as f32) * side;
            painter.rect_filled(
                Rect::from_min_size(pos2(at.x, at.y), Vec2::splat(side)),
                0.0,
                Color32::from_gray(140),
            );
        }
    }
}

/// Draws the imports that can be undone, the last one first.
fn history(view: &PaintView<'_>, ui: &mut Ui) {
    ui.strong("Imports and brush strokes");
    if view.round_trip.history.is_empty() {
        ui.weak("There are none that can be undone.");
    }
    for import in view.round_trip.history.iter().rev() {
        let line = ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new(format!("{}", import.number)).strong());
            ui.label(in_words(import));
        });
        if !import.files.is_empty() {
            line.response.on_hover_text(import.files.join("\n"));
        }
    }
}

fn in_words(import: &PaintImport) -> String {
    let stroke = import.brush.map_or(String::new(), |brush| format!("Brush stroke ({}): ", brush.word()));
    format!("{stroke}{} of {}", counted(import.pixels, "pixel"), import.photos.join(", "))
}
