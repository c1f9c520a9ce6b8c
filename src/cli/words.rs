//! The words of the command line for remedies.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use quadratura_base::error::{Error, Message, Remedy};

/// The project that the running command is about, as it was typed; commands to type name it.
static PROJECT: OnceLock<PathBuf> = OnceLock::new();

/// Says which project the running command is about.
pub fn about_project(folder: &Path) {
    // The first one counts: a process runs one command.
    let _ = PROJECT.set(folder.to_path_buf());
}

/// Words a remedy as the command to type.
pub fn typed(remedy: &Remedy) -> String {
    let command = match remedy {
        Remedy::CreateProject => "new",
        Remedy::Build => "update",
        Remedy::Fill => "update",
        Remedy::List => "info",
        Remedy::ClearMasks => "mask --clear",
        Remedy::FindMasks => "mask --find",
        Remedy::SuggestMasks => "mask --suggest",
        Remedy::ListObjects => "object",
        Remedy::RestoreObject => "object --on NAME",
        Remedy::ListDecisions => "decide",
        Remedy::ResetDecisions(photo) => &format!("decide --photo {photo} --reset"),
        Remedy::FreeColour(photo) => &format!("colour --free {photo}"),
    };
    match remedy {
        Remedy::CreateProject => typed_with(command, None),
        _ => command_for_project(command),
    }
}

/// Words a command with its options as it is to be typed for the project of the running command.
pub fn command_for_project(command: &str) -> String {
    typed_with(command, PROJECT.get().map(PathBuf::as_path))
}

/// Returns a path as it is typed in a command.
pub fn as_typed(path: &Path) -> String {
    let path = path.display().to_string();
    if path.contains(' ') { format!("'{path}'") } else { path }
}

/// Returns a command with its project behind its name.
fn typed_with(command: &str, project: Option<&Path>) -> String {
    let Some(project) = project else { return format!("`quadratura {command}`") };
    let project = as_typed(project);
    // A command may have two words; options begin with a dash.
    let (name, options) = command.split_at(command.find(" -").unwrap_or(command.len()));
    format!("`quadratura {name} {project}{options}`")
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

    #[test]
    fn commands_to_type_name_the_project() {
        assert_eq!(typed_with("update", None), "`quadratura update`");
        assert_eq!(typed_with("update", Some(Path::new("site"))), "`quadratura update site`");
        assert_eq!(typed_with("ldi build", Some(Path::new("site"))), "`quadratura ldi build site`");
        let spaced = typed_with("object --on NAME", Some(Path::new("old church")));
        assert_eq!(spaced, "`quadratura object 'old church' --on NAME`");
    }

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
            Remedy::FindMasks,
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
            let parsed = crate::args::Cli::try_parse_from(&words);
            assert!(
                parsed.is_ok(),
                "{words:?}: {}",
                parsed.err().map(|error| error.to_string()).unwrap_or_default()
            );
        }
    }
}
