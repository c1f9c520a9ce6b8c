//! Translates advice of the command line into that of the window: errors from below the window name commands as they
//! are typed.

use eframe::egui::ModifierNames;

use super::{Command, edit, file, layers, mask};

/// The typed commands and their counterparts in the window, longer ones first.
const SAME: &[(&str, Here)] = &[
    ("build", Here::Command(&layers::BUILD)),
    ("fill", Here::Command(&layers::FILL)),
    ("check", Here::Command(&layers::CHECK)),
    ("new", Here::Command(&file::NEW)),
    ("mask --suggest", Here::Command(&mask::LOOK_EVERYWHERE)),
    ("mask --clear", Here::Command(&mask::CLEAR)),
    ("object --on", Here::Words("its eye in the list of objects")),
    ("object", Here::Words("the list of objects")),
    ("decide --photo", Here::Command(&edit::RESET)),
    ("decide", Here::Words("the photo's page")),
    ("colour", Here::Words("the panel “Colour”")),
    ("info", Here::Words("the list on the left")),
];

enum Here {
    Command(&'static Command),
    Words(&'static str),
}

impl Here {
    /// Formats the counterpart: `“Build layers” (Ctrl+B)`.
    fn words(&self) -> String {
        match self {
            Self::Words(words) => (*words).to_owned(),
            Self::Command(command) => {
                let keys = command.keys.first();
                let is_mac = cfg!(target_os = "macos");
                let names = if is_mac { ModifierNames::SYMBOLS } else { ModifierNames::NAMES };
                let keys = keys.map(|keys| format!(" ({})", keys.format(&names, is_mac)));
                format!("“{}”{}", command.name, keys.unwrap_or_default())
            }
        }
    }
}

/// Replaces typed commands in a text by the commands of the window.
pub fn in_window(text: &str) -> String {
    const BEGINS: &str = "`quadratura ";
    let mut message = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, typed)) = rest.split_once(BEGINS) {
        let Some((typed, after)) = typed.split_once('`') else { break };
        message.push_str(before);
        let same = SAME.iter().find(|(known, _)| {
            typed.strip_prefix(known).is_some_and(|more| more.is_empty() || more.starts_with(' '))
        });
        match same {
            Some((_, here)) => message.push_str(&here.words()),
            None => message.push_str(&format!("{BEGINS}{typed}`")),
        }
        rest = after;
    }
    message + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The modules below do not know the window, and any of their messages may be shown in it.
    #[test]
    fn whatever_the_program_advises_to_type_is_known_here() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        let (mut folders, mut found) = (vec![root.clone()], 0);
        while let Some(folder) = folders.pop() {
            for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
                if path.is_dir() {
                    folders.extend((path != root.join("cli") && path != root.join("app")).then_some(path));
                    continue;
                }
                let text = std::fs::read_to_string(&path).unwrap();
                for line in text.lines().filter(|line| !line.trim_start().starts_with("//")) {
                    let message = in_window(line);
                    found += usize::from(message != line);
                    assert!(!message.contains("`quadratura ") || line.contains("assert"), "{path:?}: {line}");
                }
            }
        }
        assert!(found > 10, "{found}");
    }

    #[test]
    fn what_is_typed_becomes_what_is_clicked() {
        let message = in_window(
            "the stacks of a, b; `quadratura build` renews them, `quadratura decide --photo a --reset` no",
        );
        let reset = "“Forget decisions about this photo” no";
        assert_eq!(
            message,
            format!("the stacks of a, b; {} renews them, {reset}", Here::Command(&layers::BUILD).words())
        );
        assert!(message.contains("“Build layers” ("), "{message}");
        assert_eq!(in_window("a `quadratura` and `quadratura open"), "a `quadratura` and `quadratura open");
    }
}
