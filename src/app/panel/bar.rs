//! Toolbars over and beside views: parts that do not fit are in a menu, under the same names.

use eframe::egui::{Button, Id, Label, Popup, PopupCloseBehavior, RichText, Role, TextStyle, Ui, WidgetInfo};

use super::{named, text_width, toggle_ui};
use crate::command::{Command, Commands};
use crate::state::request::Request;
use crate::widget::elide::elided;

/// The position in which a part of a bar is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BarPosition {
    /// In the bar.
    Bar,
    /// In the menu, one part to a line.
    Menu,
}

/// A function that draws a part of what the panel shows; it may change the bar's memory.
pub type DrawPart<V, M> = fn(&mut Ui, &V, &mut M, BarPosition, &mut Vec<Request>);

/// A part of a bar.
pub enum BarPart<V, M> {
    /// A command that switches something.
    Switch(&'static Command),
    /// A custom widget.
    Tool(DrawPart<V, M>),
    /// A separator between groups.
    Gap,
}

/// The width of the menu button with its margin, in points.
const MORE: f32 = 28.0;
/// The width of the menu button without its margin, in points.
const MORE_BUTTON: f32 = MORE - 4.0;
/// The smallest width of the name, in points; a shorter one is left out.
const LEAST_NAME: f32 = 60.0;
/// The bar width below which sliders are short, in points.
const NARROW: f32 = 480.0;
/// The length of short sliders, in points.
const SHORT_RAIL: f32 = 56.0;

/// A toolbar: the name of its subject as far as it fits, and its parts. Parts are in the order of their importance: the last
/// ones move to the menu first.
pub struct Bar<'a, V, M> {
    /// The kind of the subject, for screen readers.
    pub of: &'a str,
    /// The name of the subject.
    pub name: Option<&'a str>,
    /// The parts.
    pub parts: &'a [BarPart<V, M>],
    /// The commands that the parts may switch.
    pub commands: Commands<'a>,
    /// What the parts show.
    pub view: &'a V,
}

impl<V, M> Bar<'_, V, M> {
    /// Draws the toolbar.
    pub fn show(&self, ui: &mut Ui, memory: &mut M, requests: &mut Vec<Request>) {
        let parts = self.parts;
        let id = ui.scope_id().with(self.of);
        ui.horizontal(|ui| {
            if ui.available_width() < NARROW {
                ui.spacing_mut().slider_width = SHORT_RAIL;
            }
            let room = ui.available_width();
            let gap = ui.spacing().item_spacing.x;
            let widths =
                ui.data(|data| data.get_temp::<Vec<f32>>(id)).filter(|known| known.len() == parts.len());
            let (shown, rest) = match &widths {
                Some(widths) => share(widths, gap, room, self.name.map(|name| text_width(ui, name) + 1.0)),
                // The widths are unknown: the bar is drawn once to measure them, and then again.
                None => (parts.len(), None),
            };
            if let (Some(name), Some(width)) = (self.name, rest) {
                ui.scope(|ui| {
                    let shown = elided(ui, name, &[], width, &TextStyle::Body);
                    named(&ui.add(Label::new(RichText::new(shown).strong())).on_hover_text(name), name);
                });
            }
            let mut measured = widths.clone().unwrap_or_else(|| vec![0.0; parts.len()]);
            let is_tool = |part: &BarPart<V, M>| !matches!(part, BarPart::Gap);
            let last = parts[..shown].iter().rposition(is_tool).map_or(0, |last| last + 1);
            for (part, width) in parts[..last].iter().zip(&mut measured) {
                let drawn = ui.scope(|ui| self.part(ui, memory, part, BarPosition::Bar, requests));
                *width = drawn.response.rect.width();
            }
            if shown < parts.len() {
                self.more(ui, memory, id, &parts[shown..], requests);
            }
            if widths.is_none() {
                ui.ctx().request_discard("a bar is measured");
            }
            ui.data_mut(|data| data.insert_temp(id, measured));
        });
    }

    fn part(
        &self,
        ui: &mut Ui,
        memory: &mut M,
        part: &BarPart<V, M>,
        position: BarPosition,
        requests: &mut Vec<Request>,
    ) {
        match part {
            BarPart::Switch(command) => toggle_ui(self.commands, ui, command, requests),
            BarPart::Tool(draw) => draw(ui, self.view, memory, position, requests),
            BarPart::Gap => drop(ui.separator()),
        }
    }

    /// Draws the menu button.
    fn more(
        &self,
        ui: &mut Ui,
        memory: &mut M,
        id: Id,
        parts: &[BarPart<V, M>],
        requests: &mut Vec<Request>,
    ) {
        let button = ui.add(Button::new("…").min_size([MORE_BUTTON, 0.0].into()));
        let name = format!("More tools: {}", self.of);
        button.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
        let menu = Popup::menu(&button).id(id.with("more"));
        // The menu stays open while several switches and sliders are changed.
        menu.close_behavior(PopupCloseBehavior::CloseOnClickOutside).show(|ui| {
            for part in parts.iter().skip_while(|part| matches!(part, BarPart::Gap)) {
                self.part(ui, memory, part, BarPosition::Menu, requests);
            }
        });
        button.on_hover_text("Tools that do not fit into the bar.");
    }
}

/// Returns how many parts fit, and the width that is left for the name; none where that is too small.
fn share(widths: &[f32], gap: f32, room: f32, name: Option<f32>) -> (usize, Option<f32>) {
    let upto = |count: usize| widths[..count].iter().map(|width| width + gap).sum::<f32>();
    // The name is left out before a tool is.
    let shown = match upto(widths.len()) <= room + gap {
        true => widths.len(),
        false => (0..widths.len()).rev().find(|count| upto(*count) + MORE <= room).unwrap_or(0),
    };
    let taken = upto(shown) + if shown < widths.len() { MORE } else { -gap };
    let left = room - taken - gap;
    (shown, name.filter(|wanted| left >= wanted.min(LEAST_NAME)).map(|wanted| wanted.min(left)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_room_is_left_out_from_the_end_and_the_name_before_all() {
        let widths = [100.0, 50.0, 50.0];
        assert_eq!(share(&widths, 8.0, 400.0, Some(90.0)), (3, Some(90.0)));
        assert_eq!(share(&widths, 8.0, 300.0, Some(90.0)), (3, Some(76.0)), "it is shortened");
        assert_eq!(share(&widths, 8.0, 240.0, Some(90.0)), (3, None));
        assert_eq!(share(&widths, 8.0, 216.0, None), (3, None), "just so");
        assert_eq!(share(&widths, 8.0, 215.0, None), (2, None));
        assert_eq!(share(&widths, 8.0, 190.0, None), (1, None));
        assert_eq!(share(&widths, 8.0, 90.0, None), (0, None));
    }
}
