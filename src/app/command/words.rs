//! The words of the window for remedies: the command to click, with its keys.

use eframe::egui::ModifierNames;

use super::{Command, edit, file, layers, mask};
use quadratura_base::error::{Message, Remedy};

/// Words a remedy as the command or the part of the window that has its effect.
fn clicked(remedy: &Remedy) -> String {
    match remedy {
        Remedy::CreateProject => of_command(&file::NEW),
        Remedy::Build => of_command(&layers::BUILD),
        Remedy::Fill => of_command(&layers::FILL),
        Remedy::List => "the list on the left".into(),
        Remedy::ClearMasks => of_command(&mask::CLEAR),
        Remedy::FindMasks => "“Choose a file…” in the messages".into(),
        Remedy::SuggestMasks => of_command(&mask::LOOK_EVERYWHERE),
        Remedy::ListObjects => "the list of objects".into(),
        Remedy::RestoreObject => "“Restore” in the list of objects".into(),
        Remedy::ListDecisions => "the photo's page".into(),
        Remedy::ResetDecisions(_) => of_command(&edit::RESET),
        Remedy::FreeColour(_) => "the panel “Colour”".into(),
    }
}

/// Words a command by its name and keys: `“Build layers” (Ctrl+B)`.
fn of_command(command: &Command) -> String {
    let is_mac = cfg!(target_os = "macos");
    let names = if is_mac { ModifierNames::SYMBOLS } else { ModifierNames::NAMES };
    let keys = command.keys.first().map(|keys| format!(" ({})", keys.format(&names, is_mac)));
    format!("“{}”{}", command.name, keys.unwrap_or_default())
}

/// Words a message for the window.
pub fn worded(message: &Message) -> String {
    message.worded(&clicked)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_remedy_is_worded_as_the_command_to_click() {
        let stale = Message::from(("the stacks of a, b are stale; ", Remedy::Build, " renews them; "));
        let message = stale.and(Remedy::ResetDecisions("a".into())).and(" no");
        let text = worded(&message);
        assert!(text.starts_with("the stacks of a, b are stale; “Build layers” ("), "{text}");
        assert!(text.ends_with(&format!(" renews them; “{}” no", edit::RESET.name)), "{text}");
        assert!(!text.contains("quadratura "), "{text}");
    }
}
