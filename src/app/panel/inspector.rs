//! What is known of the selection.

use eframe::egui::{Grid, Key, RichText, ScrollArea, TextEdit, Ui};

use super::{grouped, percent};
use crate::app::command::{edit, layers, paint, view};
use crate::app::editor::{Ask, Editor};
use crate::app::selection::Selection;
use crate::app::session::Session;
use crate::document::stack::Reason;
use crate::recipe::decide::decided;
use crate::recipe::survey::{FaceInStack, face_in_stack};
use crate::scene::{FaceId, ObjectId};

/// Draws it.
pub fn inspector_ui(editor: &mut Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    ui.add_space(4.0);
    let Some(session) = &editor.session else { return };
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| match editor.selection {
        Selection::Nothing => nothing(session, ui),
        Selection::Photo(photo) => photo_ui(editor, session, photo, ui, asks),
        Selection::Object(object) => object_ui(editor, session, object, ui, asks),
        Selection::Face(face) => face_ui(editor, session, face, ui, asks),
        Selection::Layer { photo, layer } => layer_ui(editor, session, photo, layer, ui, asks),
    });
}

fn title(ui: &mut Ui, kind: &str, name: &str) {
    ui.weak(kind);
    ui.label(RichText::new(name).heading());
    ui.add_space(4.0);
}

fn rows(ui: &mut Ui, id: &str, rows: &[(&str, String)]) {
    Grid::new(id).num_columns(2).spacing([12.0, 4.0]).show(ui, |ui| {
        for (name, value) in rows {
            ui.weak(*name);
            ui.label(value);
            ui.end_row();
        }
    });
}

/// A button for a command; where it is not ready it says why.
pub fn button(
    editor: &Editor,
    ui: &mut Ui,
    command: &'static crate::app::command::Command,
    asks: &mut Vec<Ask>,
) {
    let ready = (command.ready)(editor);
    let on = command.on.is_some_and(|on| on(editor));
    let button = eframe::egui::Button::new(command.name).selected(on);
    let response = ui.add_enabled(ready.is_ok(), button);
    let response = response.on_hover_text(command.tooltip);
    if response.on_disabled_hover_text(ready.err().unwrap_or_default()).clicked() {
        asks.push(Ask::Run(command));
    }
}

fn nothing(session: &Session, ui: &mut Ui) {
    title(ui, "Project", &session.name());
    let model = session.model();
    let built = session.photos.iter().filter(|photo| photo.is_current()).count();
    let project = &session.opened.project;
    let facts = [
        ("Photos", format!("{} ({built} built)", session.photos.len())),
        ("Objects", grouped(model.objects.len() as u64)),
        ("Faces", grouped(model.faces.len() as u64)),
        ("Photos from", project.photos.clone()),
        ("Cameras from", project.cameras.clone()),
        ("Model from", project.model.clone()),
    ];
    rows(ui, "project", &facts);
    ui.add_space(8.0);
    ui.weak("Click a photo, an object or a layer to see what is known of it.");
}

fn photo_ui(editor: &Editor, session: &Session, place: usize, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let photo = &session.opened.site.photos[place];
    let status = &session.photos[place];
    title(ui, "Photo", &photo.name);
    let camera = &photo.camera;
    let field = 2.0 * (f64::from(camera.height) / 2.0 / camera.fy).atan().to_degrees();
    let mut facts = vec![
        ("Size", format!("{} × {} px", camera.width, camera.height)),
        ("Focal length", format!("{:.1} px", camera.fx)),
        ("Field of view", format!("{field:.1}° high")),
        ("State", status.word.to_owned()),
    ];
    if let Some(stack) = &status.stack {
        let own = u64::from(camera.width) * u64::from(camera.height);
        facts.push(("Visibility layers", stack.visibility_layers.len().to_string()));
        facts.push(("Image layers", stack.image_layers.len().to_string()));
        facts
            .push(("Texels", format!("{} ({:.2} × photo)", grouped(stack.texels), ratio(stack.texels, own))));
        facts.push(("Used", percent(stack.texels_used, stack.texels)));
        if let Some((hidden, filled)) = status.hidden() {
            facts.push(("Hidden", format!("{} ({})", grouped(hidden), percent(hidden, stack.texels_used))));
            facts.push(("Filled", percent(filled, hidden)));
        }
    }
    rows(ui, "photo", &facts);
    if let Some(problem) = &status.problem {
        ui.colored_label(ui.visuals().error_fg_color, problem);
    }
    ui.add_space(6.0);
    ui.horizontal_wrapped(|ui| {
        button(editor, ui, &view::SNAP, asks);
        if !status.is_current() {
            button(editor, ui, &layers::BUILD_PHOTO, asks);
        }
        if status.stack.is_some() {
            button(editor, ui, &paint::EDIT, asks);
        }
    });
    decisions(session, &photo.name, ui, asks);
}

fn ratio(part: u64, all: u64) -> f64 {
    part as f64 / all.max(1) as f64
}

fn object_ui(editor: &Editor, session: &Session, object: ObjectId, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let model = session.model();
    let it = model.object(object);
    title(ui, "Object", &it.name);
    let mut facts = vec![("Faces", it.faces.len().to_string())];
    if it.billboard {
        facts.push(("Billboard", "shown from both sides".into()));
    }
    rows(ui, "object", &facts);
    ui.add_space(6.0);
    surface_buttons(editor, ui, asks);
    ui.strong("Faces shown by photos");
    for face in &it.faces {
        let shown = photos_of(session, *face).filter(|(_, shown)| shown.is_ok()).count();
        let text = format!("{}: {shown} photos", model.face_name(*face));
        let text = if shown == 0 {
            RichText::new(text).color(ui.visuals().warn_fg_color)
        } else {
            RichText::new(text)
        };
        if ui.add(eframe::egui::Button::selectable(false, text)).clicked() {
            asks.push(Ask::Select(Selection::Face(*face)));
        }
    }
}

/// Each built photo, with how many layers of it show the face, or why none does.
fn photos_of(session: &Session, face: FaceId) -> impl Iterator<Item = (usize, Result<usize, String>)> + '_ {
    let model = session.model();
    let (object, index) = (&model.object(model.face(face).object).name, model.face(face).index);
    let built =
        session.photos.iter().enumerate().filter_map(|(place, photo)| Some((place, photo.stack.as_ref()?)));
    built.map(move |(place, stack)| {
        let shown = match face_in_stack(stack, object, index) {
            FaceInStack::Textured { image_layers, .. } => Ok(image_layers.len()),
            FaceInStack::Untextured(untextured) => Err(reason(untextured.reason, untextured.by.as_deref())),
            FaceInStack::Unknown => Err("the layers are of another model".into()),
        };
        (place, shown)
    })
}

fn reason(reason: Reason, by: Option<&str>) -> String {
    match (reason, by) {
        (Reason::Outside, _) => "outside the photo".into(),
        (Reason::Behind, _) => "behind the camera".into(),
        (Reason::TooSmall, _) => "too small or edge-on".into(),
        (Reason::Hidden, Some(by)) => format!("hidden by {by}"),
        (Reason::Hidden, None) => "hidden".into(),
        (Reason::Masked, _) => "masked".into(),
        (Reason::Excluded, _) => "excluded".into(),
        (Reason::Degenerate, _) => "has no area".into(),
    }
}

fn face_ui(editor: &Editor, session: &Session, face: FaceId, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let model = session.model();
    title(ui, "Face", &model.face_name(face));
    let it = model.face(face);
    let planar = if it.planar { "planar" } else { "not planar: treated by its triangles" };
    rows(ui, "face", &[("Corners", model.ring(face).len().to_string()), ("Shape", planar.into())]);
    ui.add_space(6.0);
    surface_buttons(editor, ui, asks);
    ui.strong("Photos");
    Grid::new("photos of face").num_columns(2).show(ui, |ui| {
        for (place, shown) in photos_of(session, face) {
            let name = &session.opened.site.photos[place].name;
            if ui.link(name).on_hover_text("Selects the photo.").clicked() {
                asks.push(Ask::Select(Selection::Photo(place)));
            }
            match shown {
                Ok(layers) => ui.label(format!("textured, {layers} layers")),
                Err(reason) => ui.weak(format!("no texture: {reason}")),
            };
            ui.end_row();
        }
    });
    if session.photos.iter().all(|photo| photo.stack.is_none()) {
        ui.weak("No photo has layers yet.");
    }
}

/// What may be decided about an object or a face and the photo that was selected last.
fn surface_buttons(editor: &Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    if let Some(photo) = editor.selected_photo_name() {
        ui.weak(format!("With {photo}:"));
    }
    ui.horizontal_wrapped(|ui| {
        for command in [&edit::PIN, &edit::EXCLUDE] {
            button(editor, ui, command, asks);
        }
    });
    ui.add_space(6.0);
}

/// A field for the layer's name; what is typed holds when the field is left.
fn rename(session: &Session, photo: usize, layer: usize, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let Some(it) = session.photos[photo].stack.as_ref().and_then(|stack| stack.image_layers.get(layer))
    else {
        return;
    };
    let id = ui.make_persistent_id(("name of layer", photo, &it.id));
    let mut typed = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| it.name.clone());
    ui.horizontal(|ui| {
        let label = ui.label("Name");
        let field = ui.add(TextEdit::singleline(&mut typed).desired_width(180.0)).labelled_by(label.id);
        if field.lost_focus() && typed != it.name && !ui.input(|input| input.key_pressed(Key::Escape)) {
            asks.push(Ask::Rename(photo, layer, typed.clone()));
        }
        if field.has_focus() {
            ui.data_mut(|data| data.insert_temp(id, typed));
        } else {
            ui.data_mut(|data| data.remove::<String>(id));
        }
    });
}

/// What was decided about a photo, each with a way to take it back.
fn decisions(session: &Session, name: &str, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let Some(decisions) = session.opened.project.decisions.photos.get(name) else { return };
    ui.add_space(8.0);
    ui.strong("Decided");
    for decision in decided(decisions) {
        ui.horizontal_wrapped(|ui| {
            if ui.small_button("Forget").on_hover_text("Takes this decision back.").clicked() {
                asks.push(Ask::ForgetDecision(name.to_owned(), decision.number));
            }
            ui.label(&decision.text);
        });
    }
}

fn layer_ui(
    editor: &Editor,
    session: &Session,
    photo: usize,
    layer: usize,
    ui: &mut Ui,
    asks: &mut Vec<Ask>,
) {
    let Some(stack) = &session.photos[photo].stack else { return };
    let Some(it) = stack.image_layers.get(layer) else { return };
    title(ui, "Image layer", &it.name);
    let hidden = it.texels_used - it.texels_visible;
    let rect = it.rect;
    let facts = [
        ("Photo", session.opened.site.photos[photo].name.clone()),
        ("Place", format!("{} from the front", it.order)),
        ("Rectangle", format!("{} × {} px at {}, {}", rect.w, rect.h, rect.x, rect.y)),
        ("Used", format!("{} texels ({})", grouped(it.texels_used), percent(it.texels_used, rect.area()))),
        ("Hidden", format!("{} ({})", grouped(hidden), percent(hidden, it.texels_used))),
        ("Filled", it.fill.as_ref().map_or("no".into(), |fill| percent(fill.texels_filled, hidden))),
        ("Token", it.id.clone()),
    ];
    rows(ui, "layer", &facts);
    ui.add_space(6.0);
    rename(session, photo, layer, ui, asks);
    ui.horizontal_wrapped(|ui| {
        for command in [&paint::EDIT, &edit::MERGE, &edit::SPLIT, &edit::PIN, &edit::EXCLUDE] {
            button(editor, ui, command, asks);
        }
    });
    ui.add_space(6.0);
    ui.strong("Elements");
    let elements: Vec<_> = stack.visibility_layers.iter().flatten().collect();
    for element in it.elements.iter().filter_map(|element| elements.get(*element as usize)) {
        let faces = element.faces.len() + element.pieces.len();
        let faces = if faces == 1 { "1 face".to_owned() } else { format!("{faces} faces") };
        let text = format!("{}: {faces}", element.object);
        if ui.add(eframe::egui::Button::selectable(false, text)).clicked() {
            let object = session.model().objects.iter().position(|object| object.name == element.object);
            asks.extend(object.map(|object| Ask::Select(Selection::Object(ObjectId(object as u32)))));
        }
    }
}
