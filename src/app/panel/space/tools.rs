//! The toolbars over the 3D view: display mode, the photo that the view looks through, the hint.

use eframe::egui::{Align2, Area, Button, ComboBox, Frame, Id, Label, Rect, RichText, Slider, Ui, vec2};

use super::view::SpacePaneView;
use super::{brush, hint, images, legend, measure, trees};
use crate::command;
use crate::panel::bar::{Bar, BarPart, BarPosition};
use crate::panel::named;
use crate::state::request::Request;
use crate::state::running::JobKind;
use crate::state::space::exploded::MOST_APART;
use crate::state::space::memory::SpaceMemory;
use crate::widget::spinner::Spinner;
use quadratura_base::scene::PhotoId;
use quadratura_view::{Blend, Mode};

/// The height of the photo's bar with its distance from the parts above, in points.
const PHOTO_BAR: f32 = 48.0;
/// The height of the bar at the top with its distance from the bar below, in points.
const TOP_BAR: f32 = 44.0;
/// The margin between a bar and the edge of the view, in points.
const MARGIN: f32 = 10.0;
/// The width of the frame around a bar, in points.
const FRAME: f32 = 16.0;
/// The longest line of text, in points.
const WORDS: f32 = 520.0;

/// The width of the list of display modes, in points: the longest name fits.
const DISPLAY_COMMANDS: f32 = 100.0;

/// The parts of the bar at the top of the view.
fn top<'a>() -> [BarPart<SpacePaneView<'a>, SpaceMemory>; 11] {
    [
        BarPart::Tool(shown),
        BarPart::Switch(&command::view::BRUSH),
        BarPart::Switch(&command::view::MEASURE),
        BarPart::Tool(mixing),
        BarPart::Tool(photos),
        BarPart::Tool(relief),
        BarPart::Switch(&command::view::WIREFRAME),
        BarPart::Switch(&command::view::CAMERAS),
        BarPart::Switch(&command::view::BACKS),
        BarPart::Switch(&command::view::GLASS),
        BarPart::Switch(&command::view::NO_UNCOVERED),
    ]
}
/// The parts of the bar while the view looks through a photo.
fn through_photo<'a>() -> [BarPart<SpacePaneView<'a>, SpaceMemory>; 3] {
    [BarPart::Tool(photo_over), BarPart::Tool(opacity), BarPart::Tool(wipe)]
}
/// The parts of the bar of the exploded view.
fn exploded_parts<'a>() -> [BarPart<SpacePaneView<'a>, SpaceMemory>; 2] {
    [BarPart::Tool(distance), BarPart::Tool(together)]
}

/// Draws the toolbars.
pub fn tools_ui(
    ui: &mut Ui,
    view: &SpacePaneView<'_>,
    it: &mut SpaceMemory,
    rect: Rect,
    requests: &mut Vec<Request>,
) {
    let id = ui.scope_id().with("tools");
    let named = |photo: Option<PhotoId>| {
        Some(view.scene.session.opened.site.photos.get(photo?.index())?.name.clone())
    };
    let (apart, through) = (named(view.scene.space.exploded.photo), named(it.through));
    let room = rect.width() - 2.0 * MARGIN - FRAME;
    let bar = |ui: &mut Ui,
               it: &mut SpaceMemory,
               of: &str,
               name: Option<&str>,
               parts: &[BarPart<_, SpaceMemory>],
               requests: &mut Vec<Request>| {
        ui.set_max_width(room);
        let commands = view.commands;
        Bar { of, name, parts, commands, view }.show(ui, it, requests);
    };
    if view.scene.space.exploded.is_on() {
        over(ui, id.with("exploded"), rect, Align2::CENTER_BOTTOM, |ui| {
            bar(ui, it, "exploded view", apart.as_deref(), &exploded_parts(), requests);
        });
        return;
    }
    over(ui, id.with("top"), rect, Align2::LEFT_TOP, |ui| bar(ui, it, "3D view", None, &top(), requests));
    let looks_through = it.through.is_some();
    // The legend is above the photo's bar, which is centred at the bottom.
    let lower = if looks_through { PHOTO_BAR } else { 0.0 };
    let above = rect.with_max_y(rect.bottom() - lower);
    if legend::is_shown(view) {
        // The id depends on the display mode, because the position depends on the size.
        over(ui, id.with(("legend", view.scene.space.shown_display())), above, Align2::LEFT_BOTTOM, |ui| {
            ui.set_max_width(room);
            legend::legend_ui(view, ui, requests);
        });
    } else if hint::is_wanted(view) {
        over(ui, id.with("first steps"), above, Align2::LEFT_BOTTOM, |ui| {
            ui.set_max_width(room);
            hint::hint_ui(ui, view, &mut it.hints, requests);
        });
    }
    if looks_through {
        over(ui, id.with("photo"), rect, Align2::CENTER_BOTTOM, |ui| {
            bar(ui, it, "photo overlay", through.as_deref(), &through_photo(), requests);
        });
    }
    // Below the bar at the top, where it does not move when panels open or the view leaves a photo.
    let below = rect.with_min_y((rect.top() + TOP_BAR).min(rect.bottom()));
    if view.scene.space.images.on && view.scene.space.why_no_images().is_none() {
        over(ui, id.with("images"), below, Align2::LEFT_TOP, |ui| {
            bar(ui, it, "layered depth image", None, &images::tools(), requests);
        });
    }
    if it.brush.on {
        over(ui, id.with("brush"), below, Align2::LEFT_TOP, |ui| {
            bar(ui, it, "brush", None, &brush::tools(), requests);
            if let Some(remark) = &it.brush.remark {
                ui.set_max_width(room.min(WORDS));
                ui.colored_label(ui.visuals().warn_fg_color, remark);
            }
        });
    }
    if it.measure.on {
        over(ui, id.with("measure"), below, Align2::LEFT_TOP, |ui| {
            bar(ui, it, "measure", None, &measure::tools(), requests);
        });
    }
    if view.scene.trees.hand.on {
        over(ui, id.with("place tree"), below, Align2::LEFT_TOP, |ui| {
            bar(ui, it, "place tree", None, &trees::tools(), requests);
        });
    }
    if let Some(why) = without_picture(view) {
        over(ui, id.with("empty"), rect, Align2::CENTER_CENTER, |ui| {
            ui.set_max_width(room.min(WORDS));
            empty(view, ui, why, requests);
        });
    }
}

fn over(ui: &Ui, id: Id, rect: Rect, align: Align2, contents: impl FnOnce(&mut Ui)) {
    let at = align.pos_in_rect(&rect.shrink(MARGIN));
    Area::new(id).pivot(align).fixed_pos(at).constrain_to(rect).show(ui.ctx(), |ui| {
        let fill = ui.visuals().window_fill.gamma_multiply(0.92);
        Frame::popup(ui.style()).fill(fill).shadow(Default::default()).show(ui, contents);
    });
}

/// Draws the choice of blending: a list in the bar, the options themselves in the menu.
fn mixing(
    ui: &mut Ui,
    _: &SpacePaneView<'_>,
    it: &mut SpaceMemory,
    place: BarPosition,
    _: &mut Vec<Request>,
) {
    let mode = &mut it.look.blend.mode;
    let title = "Blending mode";
    let choices = |ui: &mut Ui, mode: &mut Mode| {
        for other in Mode::ALL {
            let choice = ui.add(Button::selectable(*mode == other, mode_name(other)));
            if choice.on_hover_text(mode_tooltip(other)).clicked() {
                *mode = other;
            }
        }
    };
    if place == BarPosition::Menu {
        ui.weak(title);
        choices(ui, mode);
        ui.separator();
        return;
    }
    let combo = ComboBox::from_id_salt("blending").selected_text(mode_name(*mode));
    named(&combo.show_ui(ui, |ui| choices(ui, mode)).response, title);
}

fn photos(ui: &mut Ui, _: &SpacePaneView<'_>, it: &mut SpaceMemory, _: BarPosition, _: &mut Vec<Request>) {
    ui.horizontal(|ui| {
        ui.add(Slider::new(&mut it.look.blend.photos, 1..=Blend::MOST).text("photos"))
            .on_hover_text("Maximum photos blended per point.");
    });
}

fn relief(ui: &mut Ui, _: &SpacePaneView<'_>, it: &mut SpaceMemory, _: BarPosition, _: &mut Vec<Request>) {
    let mut relief = !it.look.flat;
    ui.checkbox(&mut relief, "Detail").on_hover_text("Shows depth detail that is estimated from photos.");
    it.look.flat = !relief;
}

/// Draws the choice of the display mode.
fn shown(
    ui: &mut Ui,
    view: &SpacePaneView<'_>,
    _: &mut SpaceMemory,
    _: BarPosition,
    requests: &mut Vec<Request>,
) {
    let views = command::view::DISPLAY_COMMANDS;
    // The label changes with the picture, as the legend does.
    let text = command::view::command_of(view.scene.space.shown_display()).name;
    let combo = ComboBox::from_id_salt("shown").selected_text(text).width(DISPLAY_COMMANDS);
    let combo = combo.show_ui(ui, |ui| {
        for &command in views {
            let on = view.commands.is_on(command);
            if ui.selectable_label(on, command.name).on_hover_text(command.tooltip).clicked() {
                requests.push(view.commands.requested(command));
            }
        }
    });
    named(&combo.response, "Display mode");
}

/// Draws the spacing of the exploded view.
fn distance(ui: &mut Ui, _: &SpacePaneView<'_>, it: &mut SpaceMemory, _: BarPosition, _: &mut Vec<Request>) {
    ui.horizontal(|ui| {
        let slider = Slider::new(&mut it.apart, 0.0..=MOST_APART);
        ui.add(slider.show_value(false).text("spacing")).on_hover_text(
            "Sets the spacing of the image layers. Hatching marks areas that a surface needs and other layers hide.",
        );
        if it.is_loading {
            ui.add(Spinner::new());
        }
    });
}

fn together(
    ui: &mut Ui,
    view: &SpacePaneView<'_>,
    _: &mut SpaceMemory,
    _: BarPosition,
    requests: &mut Vec<Request>,
) {
    if ui.button("Collapse").on_hover_text("Returns to the 3D view.").clicked() {
        requests.push(view.commands.requested(&command::view::EXPLODED));
    }
}

fn photo_over(
    ui: &mut Ui,
    _: &SpacePaneView<'_>,
    it: &mut SpaceMemory,
    _: BarPosition,
    _: &mut Vec<Request>,
) {
    ui.checkbox(&mut it.photo_over, "Photo").on_hover_text("Overlays the photo; hold X to flip.");
}

fn opacity(ui: &mut Ui, _: &SpacePaneView<'_>, it: &mut SpaceMemory, _: BarPosition, _: &mut Vec<Request>) {
    let shown = it.photo_over;
    ui.add_enabled_ui(shown, |ui| {
        let slider = Slider::new(&mut it.photo_opacity, 0.0..=1.0);
        ui.horizontal(|ui| ui.add(slider.show_value(false).text("opacity")));
    });
}

fn wipe(ui: &mut Ui, _: &SpacePaneView<'_>, it: &mut SpaceMemory, _: BarPosition, _: &mut Vec<Request>) {
    let shown = it.photo_over;
    ui.add_enabled_ui(shown, |ui| {
        let slider = Slider::new(&mut it.wipe, 0.0..=1.0);
        ui.horizontal(|ui| ui.add(slider.show_value(false).text("wipe")));
    });
}

/// Describes the next step where there is no picture yet.
fn without_picture(view: &SpacePaneView<'_>) -> Option<&'static str> {
    let session = view.scene.session;
    if view.scene.space.has_picture() {
        return None;
    }
    Some(if view.scene.space.device.is_some() || view.running.runs(JobKind::Preview) {
        "Preparing the view…"
    } else if view.running.runs(JobKind::Build) {
        "Building layers…"
    } else if session.photos.iter().all(|photo| photo.stack.is_none()) {
        "No photo has layers yet."
    } else if view.scene.space.trouble.is_some() {
        "The 3D view cannot be drawn."
    } else {
        "The 3D view is not running."
    })
}

fn empty(view: &SpacePaneView<'_>, ui: &mut Ui, why: &str, requests: &mut Vec<Request>) {
    ui.vertical_centered(|ui| {
        ui.add(Label::new(RichText::new(why).heading()).selectable(false));
        let runs = [JobKind::Preview, JobKind::Build].into_iter().any(|kind| view.running.runs(kind));
        // The device is there: the first picture is being drawn.
        if runs || view.scene.space.device.is_some() {
            ui.add(Spinner::new().size(24.0));
            return;
        }
        if let Some(trouble) = &view.scene.space.trouble {
            ui.label(trouble);
            ui.add_space(4.0);
            ui.label("Until then the 3D view, rendering of pictures and videos, and building of layers do not work.");
            ui.label(
                "Your work is safe, and everything else works: the views of photos and layers, the exploded view, \
                 decisions, masks, filling, exports and imports, saving.",
            );
            ui.add_space(6.0);
        }
        let session = Some(view.scene.session);
        let none_built =
            session.is_some_and(|session| session.photos.iter().all(|photo| photo.stack.is_none()));
        let command = if none_built { &command::layers::BUILD } else { &command::view::RESTART };
        ui.label(command.tooltip);
        ui.add_space(6.0);
        if ui.add(eframe::egui::Button::new(command.name).min_size(vec2(160.0, 30.0))).clicked() {
            requests.push(view.commands.requested(command));
        }
    });
}

fn mode_name(mode: Mode) -> &'static str {
    match mode {
        Mode::Best => "Best photo only",
        Mode::Debevec => "Nearest angles",
        Mode::Lumigraph => "Lumigraph",
        Mode::Smooth => "Smooth",
    }
}

fn mode_tooltip(mode: Mode) -> &'static str {
    match mode {
        Mode::Best => "Each point shows one photo: the one that fits it best.",
        Mode::Debevec => "Photos are weighted by angle only (Debevec, Yu & Borshukov 1998).",
        Mode::Lumigraph => "Photos are weighted by angle, resolution and borders (Buehler et al. 2001).",
        Mode::Smooth => "Like Lumigraph, with weights that change smoothly.",
    }
}
