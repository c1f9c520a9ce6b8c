//! The commands of the window: name, tooltip, keys, menu, condition and request. Menus, palette, keyboard and tests know
//! commands from these tables alone.

pub mod edit;
pub mod file;
pub mod flat;
pub mod flight;
pub mod images;
pub mod layers;
pub mod mask;
mod offered;
pub mod paint;
pub mod trees;
pub mod view;
pub mod words;

pub use self::offered::Commands;
use eframe::egui::{Context, Event, Key, KeyboardShortcut, Modifiers};

use crate::state::State;
use crate::state::notes::{Note, Weight};
use crate::state::panes::{KeyOwner, Pane};
use crate::state::request::{Flag, Request, WindowRequest};

/// A menu of the menu bar, in order from left to right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Menu {
    /// Projects.
    File,
    /// Decisions, undo and redo.
    Edit,
    /// Stacks and layers.
    Layers,
    /// The round trip to the image editor: export and import.
    Paint,
    /// The 3D view: its viewpoint and display.
    View,
    /// The flat views: the photo, and its layers.
    Photo,
    /// Masks of photos.
    Mask,
    /// Trees of the project.
    Trees,
    /// The window and its panels.
    Window,
    /// Keys, documents, and facts about the program.
    Help,
}

impl Menu {
    /// All menus, in order from left to right.
    pub const ALL: [Self; 10] = [
        Self::File,
        Self::Edit,
        Self::Layers,
        Self::Paint,
        Self::View,
        Self::Photo,
        Self::Mask,
        Self::Trees,
        Self::Window,
        Self::Help,
    ];

    /// Returns the menu's name in the menu bar.
    pub fn name(self) -> &'static str {
        match self {
            Self::File => "File",
            Self::Edit => "Edit",
            Self::Layers => "Layers",
            Self::Paint => "Paint",
            Self::View => "View",
            Self::Photo => "Photo",
            Self::Mask => "Mask",
            Self::Trees => "Trees",
            Self::Window => "Window",
            Self::Help => "Help",
        }
    }
}

/// The parts of the window in which keys without Ctrl apply to a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KeysIn {
    /// All parts: the command changes nothing in the project, or asks first.
    All,
    /// All parts but the flat views, in which the key has another function.
    AllButFlat,
    /// The 3D view.
    Space,
}

impl KeysIn {
    /// Returns whether keys apply while they belong to `owner`.
    pub fn includes(self, owner: KeyOwner) -> bool {
        match self {
            Self::All => true,
            Self::AllButFlat => matches!(owner, KeyOwner::View(Pane::Space) | KeyOwner::Beside),
            Self::Space => owner == KeyOwner::View(Pane::Space),
        }
    }
}

/// The reason why a command cannot be run now.
pub type WhyNot = &'static str;

/// A command.
pub struct Command {
    /// The unique name that the user reads.
    pub name: &'static str,
    /// A sentence about what the command does.
    pub tooltip: &'static str,
    /// The keys; the menu shows the first.
    pub keys: &'static [KeyboardShortcut],
    /// The parts of the window in which keys without Ctrl apply.
    pub keys_in: KeysIn,
    /// The menu that contains the command.
    pub menu: Menu,
    /// Whether the menu has a line above the command.
    pub starts_group: bool,
    /// Returns whether the command can be run, or the reason why not.
    pub ready: fn(&State) -> Result<(), WhyNot>,
    /// Returns whether the switch is on, for a command that switches something.
    pub on: Option<fn(&State) -> bool>,
    /// Returns whether the keys also work while a dialog is open, because the command does no harm there.
    pub in_dialog: fn(&State) -> bool,
    /// Returns what the command would apply to, for the menu: `merge of 3 layers`.
    pub detail: Option<fn(&State) -> Option<String>>,
    /// Returns the request of the command.
    pub request: fn(&State) -> Request,
}

impl Command {
    /// Returns the command's request if it is ready; otherwise a note with the reason.
    pub fn requested(&self, state: &State) -> Request {
        match (self.ready)(state) {
            Ok(()) => (self.request)(state),
            Err(why_not) => {
                WindowRequest::Say(Note::new(Weight::Info, format!("{}: {why_not}", self.name))).into()
            }
        }
    }
}

impl PartialEq for Command {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl std::fmt::Debug for Command {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(self.name)
    }
}

/// The defaults of a command: it has no keys, switches nothing and can be run whenever no dialog is open.
pub const PLAIN: Command = Command {
    name: "",
    tooltip: "",
    keys: &[],
    keys_in: KeysIn::All,
    menu: Menu::File,
    starts_group: false,
    ready: always,
    on: None,
    in_dialog: |_| false,
    detail: None,
    request: |_| WindowRequest::Flip(Flag::Help).into(),
};

/// Returns all commands in the order of their menus.
pub fn all() -> impl Iterator<Item = &'static Command> {
    const TABLES: [&[&Command]; 9] = [
        file::COMMANDS,
        edit::COMMANDS,
        layers::COMMANDS,
        paint::COMMANDS,
        view::COMMANDS,
        flight::COMMANDS,
        flat::COMMANDS,
        mask::COMMANDS,
        trees::COMMANDS,
    ];
    TABLES.into_iter().flatten().copied()
}

/// Succeeds in any state.
pub fn always(_: &State) -> Result<(), WhyNot> {
    Ok(())
}

/// Succeeds when a project is open.
pub fn with_project(state: &State) -> Result<(), WhyNot> {
    state.session.as_ref().map(|_| ()).ok_or("open a project first")
}

/// Returns a shortcut with Ctrl (Command on a Mac).
pub const fn ctrl(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::COMMAND, key)
}

/// Returns a shortcut without modifiers.
pub const fn plain(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::NONE, key)
}

/// Returns a shortcut with Shift.
pub const fn shift(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::SHIFT, key)
}

/// Formats a shortcut for display: `Ctrl+P`, `]`.
pub fn keys_text(context: &Context, keys: &KeyboardShortcut) -> String {
    let (name, symbol) = (keys.logical_key.name(), keys.logical_key.symbol_or_name());
    // The typographic minus sign is on no keyboard.
    let symbol = if keys.logical_key == Key::Minus { "-" } else { symbol };
    let text = context.format_shortcut(keys);
    if symbol.is_ascii() { text.replace(name, symbol) } else { text }
}

/// Formats the first shortcut of a command; empty where it has none.
pub fn first_keys(context: &Context, command: &Command) -> String {
    command.keys.first().map(|keys| keys_text(context, keys)).unwrap_or_default()
}

/// Returns the command whose keys were pressed first among the events of this frame, and consumes the press; a slow
/// frame has several. Keys without Ctrl are text while a text field has the focus; `taken` are the keys that belong to
/// the focused widget. Commands that are not `heard` are skipped.
pub fn next_pressed(
    context: &Context,
    taken: &[Key],
    heard: impl Fn(&Command, &KeyboardShortcut) -> bool,
) -> Option<&'static Command> {
    let typing = context.text_edit_focused();
    let usable = |keys: &KeyboardShortcut| {
        let theirs = typing || taken.contains(&keys.logical_key);
        let of_window = keys.modifiers.command && !(typing && edits_text(keys.logical_key));
        !theirs || of_window || is_function_key(keys.logical_key)
    };
    // Shortcuts with more modifiers are tested first: otherwise Ctrl+Shift+S would match Ctrl+S.
    let mut found: Vec<(&'static Command, &'static KeyboardShortcut)> =
        all().flat_map(with_keys).filter(|(command, keys)| heard(command, keys)).collect();
    found.sort_by_key(|(_, keys)| std::cmp::Reverse(count(keys.modifiers)));
    let of_press = |event: &Event| {
        let Event::Key { key, pressed: true, modifiers, .. } = event else { return None };
        let matches = |keys: &KeyboardShortcut| {
            keys.logical_key == *key && modifiers.matches_logically(keys.modifiers) && usable(keys)
        };
        found.iter().find(|(_, keys)| matches(keys)).map(|(command, _)| *command)
    };
    context.input_mut(|input| {
        let (index, command) =
            input.events.iter().enumerate().find_map(|(index, event)| Some((index, of_press(event)?)))?;
        input.events.remove(index);
        Some(command)
    })
}

fn with_keys(
    command: &'static Command,
) -> impl Iterator<Item = (&'static Command, &'static KeyboardShortcut)> {
    command.keys.iter().map(move |keys| (command, keys))
}

fn count(modifiers: Modifiers) -> usize {
    let Modifiers { alt, ctrl, shift, mac_cmd, command } = modifiers;
    [alt, ctrl, shift, mac_cmd, command].into_iter().filter(|held| *held).count()
}

/// Returns whether a key with Ctrl belongs to the text field that is being edited.
fn edits_text(key: Key) -> bool {
    matches!(key, Key::A | Key::C | Key::V | Key::X | Key::Y | Key::Z)
}

fn is_function_key(key: Key) -> bool {
    use Key::{F1, F2, F3, F4, F5, F6, F7, F11};
    matches!(key, F1 | F2 | F3 | F4 | F5 | F6 | F7 | F11)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    fn press(key: Key, modifiers: Modifiers) -> Event {
        Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers }
    }

    #[test]
    fn keys_pressed_within_one_frame_are_all_told_in_their_order() {
        let context = Context::default();
        let ctrl_shift = Modifiers { shift: true, ..Modifiers::COMMAND };
        let events = vec![
            press(Key::CloseBracket, Modifiers::NONE),
            press(Key::OpenBracket, Modifiers::NONE),
            press(Key::CloseBracket, Modifiers::NONE),
            press(Key::Z, ctrl_shift),
            press(Key::Z, Modifiers::COMMAND),
        ];
        context.begin_pass(eframe::egui::RawInput { events, ..Default::default() });
        let message: Vec<_> =
            std::iter::from_fn(|| next_pressed(&context, &[], |_, _| true)).map(|c| c.name).collect();
        assert_eq!(message, ["Next photo", "Previous photo", "Next photo", "Redo", "Undo"]);
        let _ = context.end_pass();
    }

    #[test]
    fn names_and_keys_are_given_once_and_every_command_says_what_it_does() {
        let (mut names, mut keys) = (BTreeMap::new(), BTreeMap::new());
        for command in all() {
            assert!(command.tooltip.ends_with('.'), "{}: {}", command.name, command.tooltip);
            assert!(names.insert(command.name, ()).is_none(), "{} twice", command.name);
            for shortcut in command.keys {
                let other = keys.insert(format!("{shortcut:?}"), command.name);
                assert_eq!(other, None, "{} has the keys of another", command.name);
            }
        }
        assert!(names.len() > 20);
    }
}
