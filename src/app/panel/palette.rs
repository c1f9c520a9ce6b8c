//! The command palette, which finds any command by a few letters of its name.

use eframe::egui::{Align2, Context, Id, Key, RichText, ScrollArea, TextEdit, Ui};

use crate::command::{self, Command, Commands, first_keys};
use crate::state::palette::Palette;
use crate::widget::dialog::Dialog;

/// Draws the palette when it is open; returns the command that was chosen.
pub fn palette_ui(
    commands: Commands<'_>,
    palette: &mut Palette,
    context: &Context,
) -> Option<&'static Command> {
    if !palette.is_open() {
        return None;
    }
    let dialog = Dialog::new("palette", 460.0).at(Align2::CENTER_TOP, [0.0, 80.0]);
    let answer = dialog.show(context, |ui, _| contents(commands, palette, ui));
    if answer.is_left() || answer.inner.is_some() {
        *palette = Palette::default();
    }
    answer.inner
}

fn contents(commands: Commands<'_>, palette: &mut Palette, ui: &mut Ui) -> Option<&'static Command> {
    let steps = |ui: &Ui, key| ui.input_mut(|input| input.count_and_consume_key(Default::default(), key));
    let (down, up) = (steps(ui, Key::ArrowDown), steps(ui, Key::ArrowUp));
    let enter = ui.input_mut(|input| input.consume_key(Default::default(), Key::Enter));
    // The focus is set before drawing, so that letters of the same frame are received.
    let id = Id::unique("letters of a command");
    ui.memory_mut(|memory| memory.request_focus(id));
    let field = TextEdit::singleline(&mut palette.typed)
        .id(id)
        .hint_text("Type a few letters of a command")
        .desired_width(f32::INFINITY);
    let typed = ui.add(field);
    if typed.changed() {
        palette.chosen = 0;
    }
    let found = found(&palette.typed);
    let last = found.len().saturating_sub(1);
    palette.chosen = (palette.chosen + down).saturating_sub(up).min(last);
    let moved = down + up > 0;
    let mut clicked = None;
    ScrollArea::vertical().max_height(360.0).auto_shrink([false, true]).show(ui, |ui| {
        for (index, command) in found.iter().enumerate() {
            if row(commands, ui, command, index == palette.chosen, moved) {
                clicked = Some(*command);
            }
        }
        if found.is_empty() {
            ui.label("No command's name contains these letters.");
        }
    });
    let entered = enter.then(|| found.get(palette.chosen).copied()).flatten();
    clicked.or(entered).filter(|command| commands.ready(command).is_ok())
}

fn row(commands: Commands<'_>, ui: &mut Ui, command: &Command, chosen: bool, moved: bool) -> bool {
    let why_not = commands.ready(command).err();
    let keys = first_keys(ui.ctx(), command);
    let text = RichText::new(format!("{} › {}", command.menu.name(), command.name));
    let response = ui
        .horizontal(|ui| {
            let button = ui.add_enabled(why_not.is_none(), eframe::egui::Button::selectable(chosen, text));
            ui.weak(keys);
            button
        })
        .inner;
    if chosen && moved {
        response.scroll_to_me(None);
    }
    let response = response.on_hover_text(command.tooltip);
    response.on_disabled_hover_text(why_not.unwrap_or_default()).clicked()
}

/// Returns the commands that match all typed words, best matches first, otherwise in the order of menus.
fn found(typed: &str) -> Vec<&'static Command> {
    let typed = typed.to_lowercase();
    let words: Vec<&str> = typed.split_whitespace().collect();
    let mut found: Vec<_> =
        command::all().filter_map(|command| Some((rank(command, &words)?, command))).collect();
    found.sort_by_key(|(rank, _)| *rank);
    found.into_iter().map(|(_, command)| command).collect()
}

/// The number of letters from which a word is searched for in tooltips; shorter ones are in every sentence.
const TELLING: usize = 4;

/// Ranks a match, smaller is better; none where a word is missing. Letters of a word may be scattered, as in `bl` for
/// *Build layers*; words missing in the name may be in the tooltip.
fn rank(command: &Command, words: &[&str]) -> Option<u32> {
    let name = command.name.to_lowercase();
    words.iter().try_fold(0, |sum, word| {
        let rank = if name.starts_with(word) {
            0
        } else if name.split_whitespace().any(|part| part.starts_with(word)) {
            1
        } else if name.contains(word) {
            2
        } else {
            let tooltip = || command.tooltip.to_lowercase();
            let in_tooltip = || word.len() >= TELLING && tooltip().contains(word);
            scattered(&name, word).then_some(3).or_else(|| in_tooltip().then_some(4))?
        };
        Some(sum + rank)
    })
}

fn scattered(name: &str, word: &str) -> bool {
    let mut letters = name.chars();
    word.chars().all(|letter| letters.any(|other| other == letter))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_of_the_tooltip_finds_a_command_too() {
        assert_eq!(found("sheets").first().map(|command| command.name), Some("Exploded view"));
    }

    #[test]
    fn every_command_is_found_by_its_name_and_by_its_first_letters() {
        for command in command::all() {
            assert_eq!(found(command.name).first().map(|c| c.name), Some(command.name));
        }
        assert_eq!(found("bu la").first().map(|command| command.name), Some("Build layers"));
        assert!(found("bl").iter().any(|command| command.name == "Build layers"));
        assert!(found("xyzzy").is_empty());
    }
}
