//! What lies over the 3D view to be clicked: what is shown, the photo one looks through, hints.

use eframe::egui::{Align2, Area, ComboBox, Frame, Id, Rect, RichText, Slider, Spinner, Ui, vec2};

use super::{exploded, legend};
use crate::app::command;
use crate::app::editor::{Ask, Editor};
use crate::app::jobs::Kind;
use crate::app::panel::{named, toggle_ui};
use crate::projection::{Blend, Mode};

/// Height of the bar of the photo one looks through, with its distance from what is above it, in points.
const PHOTO_BAR: f32 = 48.0;

/// Draws it.
pub fn tools_ui(editor: &mut Editor, ui: &mut Ui, rect: Rect, asks: &mut Vec<Ask>) {
    let id = ui.scope_id().with("tools");
    if editor.space.exploded.is_on() {
        over(ui, id.with("exploded"), rect, Align2::CENTER_BOTTOM, |ui| {
            ui.horizontal(|ui| pulled_apart(editor, ui, asks));
        });
        return;
    }
    over(ui, id.with("top"), rect, Align2::LEFT_TOP, |ui| {
        ui.set_max_width(rect.width() - 40.0);
        ui.horizontal_wrapped(|ui| top(editor, ui, asks));
    });
    if legend::is_shown(editor) {
        // One of another size is another one: it is placed by its size.
        // Above the photo's bar, which lies below in the middle.
        let lower = if editor.space.through().is_some() { PHOTO_BAR } else { 0.0 };
        let rect = rect.with_max_y(rect.bottom() - lower);
        over(ui, id.with(("legend", editor.space.look.shown)), rect, Align2::LEFT_BOTTOM, |ui| {
            legend::legend_ui(editor, ui, asks)
        });
    }
    if editor.space.through().is_some() {
        over(ui, id.with("photo"), rect, Align2::CENTER_BOTTOM, |ui| {
            ui.horizontal(|ui| through(editor, ui));
        });
    }
    if let Some(hint) = hint(editor) {
        over(ui, id.with("hint"), rect, Align2::CENTER_CENTER, |ui| empty(editor, ui, hint, asks));
    }
}

fn over(ui: &Ui, id: Id, rect: Rect, align: Align2, contents: impl FnOnce(&mut Ui)) {
    let margin = 10.0;
    let at = align.pos_in_rect(&rect.shrink(margin));
    Area::new(id).pivot(align).fixed_pos(at).constrain_to(rect).show(ui.ctx(), |ui| {
        let fill = ui.visuals().window_fill.gamma_multiply(0.92);
        Frame::popup(ui.style()).fill(fill).shadow(Default::default()).show(ui, contents);
    });
}

fn top(editor: &mut Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    shown(editor, ui, asks);
    let mode = &mut editor.space.look.blend;
    let combo = ComboBox::from_id_salt("blending").selected_text(mode_name(mode.mode));
    let combo = combo.show_ui(ui, |ui| {
        for other in Mode::ALL {
            ui.selectable_value(&mut mode.mode, other, mode_name(other)).on_hover_text(mode_tooltip(other));
        }
    });
    named(&combo.response, "How photos are mixed");
    ui.add(Slider::new(&mut mode.photos, 1..=Blend::MOST).text("photos"))
        .on_hover_text("At most so many photos share a place.");
    let mut relief = !editor.space.look.flat;
    ui.checkbox(&mut relief, "Relief").on_hover_text("Surfaces have the relief that the photos tell.");
    editor.space.look.flat = !relief;
    for command in [&command::view::WIREFRAME, &command::view::CAMERAS, &command::view::BACKS] {
        toggle_ui(editor, ui, command, asks);
    }
}

/// Which of the understanding views is shown.
fn shown(editor: &Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let views = command::view::SHOWN;
    let now = views.iter().find(|command| command.on.is_some_and(|on| on(editor)));
    let text = now.map_or("", |command| command.name);
    let combo = ComboBox::from_id_salt("shown").selected_text(text).width(110.0);
    let combo = combo.show_ui(ui, |ui| {
        for &command in views {
            let on = command.on.is_some_and(|on| on(editor));
            if ui.selectable_label(on, command.name).on_hover_text(command.tooltip).clicked() {
                asks.push(Ask::Run(command));
            }
        }
    });
    named(&combo.response, "What is shown");
}

/// How far a photo's layers are pulled apart.
fn pulled_apart(editor: &mut Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let name = editor.selected_photo_name().unwrap_or_default();
    ui.label(RichText::new(name).strong());
    let slider = Slider::new(&mut editor.space.exploded.apart, 0.0..=exploded::MOST_APART);
    ui.add(slider.show_value(false).text("distance of layers")).on_hover_text(
        "Pulls the image layers apart. Stripes: needed by a surface, and hidden by what is in front.",
    );
    if !editor.sheets_are_complete() {
        ui.spinner();
    }
    let back = ui.button("Put together").on_hover_text("Goes back to the 3D view.");
    if back.clicked() {
        asks.push(Ask::Run(&command::view::EXPLODED));
    }
}

fn through(editor: &mut Editor, ui: &mut Ui) {
    let name = editor.selected_photo_name().unwrap_or_default();
    ui.label(RichText::new(name).strong());
    ui.checkbox(&mut editor.space.photo_over, "Photo")
        .on_hover_text("Lays the photo over the view; hold X to flip.");
    ui.add_enabled_ui(editor.space.photo_over, |ui| {
        ui.add(Slider::new(&mut editor.space.photo_opacity, 0.0..=1.0).show_value(false).text("opacity"));
        ui.add(Slider::new(&mut editor.space.wipe, 0.0..=1.0).show_value(false).text("wipe"));
    });
}

/// What to do where there is nothing to see yet.
fn hint(editor: &Editor) -> Option<&'static str> {
    let session = editor.session.as_ref()?;
    if editor.space.shown.is_some() {
        return None;
    }
    Some(if session.painter.is_some() || editor.jobs.runs(Kind::Preview) {
        "Preparing the view…"
    } else if editor.jobs.runs(Kind::Build) {
        "Building layers…"
    } else if session.photos.iter().all(|photo| photo.stack.is_none()) {
        "No photo has layers yet."
    } else if editor.space.trouble.is_some() {
        "The 3D view cannot be drawn."
    } else {
        "The 3D view is not running."
    })
}

fn empty(editor: &Editor, ui: &mut Ui, hint: &str, asks: &mut Vec<Ask>) {
    ui.set_min_width(220.0);
    ui.vertical_centered(|ui| {
        ui.label(RichText::new(hint).heading());
        let waits = [Kind::Preview, Kind::Build].into_iter().any(|kind| editor.jobs.runs(kind));
        if waits {
            ui.add(Spinner::new().size(24.0));
            return;
        }
        if let Some(trouble) = &editor.space.trouble {
            ui.set_max_width(520.0);
            ui.label(trouble);
            ui.add_space(4.0);
            ui.label("Until then there is no 3D view, there are no pictures and films of it, and no layers are built.");
            ui.label(
                "Your work is safe, and all else goes on: the views of photos and layers, layers pulled apart, \
                 decisions, masks, filling, exports and imports, saving.",
            );
            ui.add_space(6.0);
        }
        let session = editor.session.as_ref();
        let none_built =
            session.is_some_and(|session| session.photos.iter().all(|photo| photo.stack.is_none()));
        let command = if none_built { &command::layers::BUILD } else { &command::view::RESTART };
        ui.label(command.tooltip);
        ui.add_space(6.0);
        if ui.add(eframe::egui::Button::new(command.name).min_size(vec2(160.0, 30.0))).clicked() {
            asks.push(Ask::Run(command));
        }
    });
}

fn mode_name(mode: Mode) -> &'static str {
    match mode {
        Mode::Best => "Best photo alone",
        Mode::Debevec => "Nearest angles",
        Mode::Lumigraph => "Lumigraph",
        Mode::Smooth => "Smooth",
    }
}

fn mode_tooltip(mode: Mode) -> &'static str {
    match mode {
        Mode::Best => "Each place shows one photo: the one that fits it best.",
        Mode::Debevec => "Photos weigh by angle alone (Debevec, Yu & Borshukov 1998).",
        Mode::Lumigraph => "Angle, resolution and borders count (Buehler et al. 2001).",
        Mode::Smooth => "As lumigraph, with weights that change without a kink.",
    }
}
