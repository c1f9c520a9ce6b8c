//! The words of the command line for remedies.

use crate::error::{Error, Message, Remedy};

/// Words a remedy as the command to type.
pub fn typed(remedy: &Remedy) -> String {
    let command = match remedy {
        Remedy::CreateProject => "new",
        Remedy::Build => "update",
        Remedy::Fill => "update",
        Remedy::List => "info",
        Remedy::ClearMasks => "mask --clear",
        Remedy::SuggestMasks => "mask --suggest",
        Remedy::ListObjects => "object",
        Remedy::RestoreObject => "object --on NAME",
        Remedy::ListDecisions => "decide",
        Remedy::ResetDecisions(photo) => &format!("decide --photo {photo} --reset"),
        Remedy::FreeColour(photo) => &format!("colour --free {photo}"),
    };
    format!("`quadratura {command}`")
}

/// Words a message for the command line.
pub fn worded(message: &Message) -> String {
    message.worded(&typed)
}

/// Words an error for the command line.
pub fn error_text(error: &Error) -> String {
    worded(&error.message())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A remedy that cannot be typed would send users to a command that does not exist.
    #[test]
    fn every_remedy_is_a_command_that_parses() {
        use clap::Parser as _;

        let photo = || "a.jpg".to_owned();
        let remedies = [
            Remedy::Build,
            Remedy::Fill,
            Remedy::List,
            Remedy::ClearMasks,
            Remedy::SuggestMasks,
            Remedy::ListObjects,
            Remedy::RestoreObject,
            Remedy::ListDecisions,
            Remedy::ResetDecisions(photo()),
            Remedy::FreeColour(photo()),
        ];
        for remedy in remedies {
            let typed = typed(&remedy);
            let words = typed.trim_matches('`').split(' ').map(|word| word.replace("NAME", "tower"));
            let mut words: Vec<String> = words.collect();
            words.insert(2, "project".into());
            if matches!(remedy, Remedy::ClearMasks) {
                words.extend(["--photo".into(), "a.jpg".into()]);
            }
            let parsed = crate::cli::args::Cli::try_parse_from(&words);
            assert!(
                parsed.is_ok(),
                "{words:?}: {}",
                parsed.err().map(|error| error.to_string()).unwrap_or_default()
            );
        }
    }
}
