//! Colours for messages on a terminal.

use std::io::IsTerminal;

use clap::builder::styling::{AnsiColor, Style};

/// The style of `error:`.
pub const ERROR: Style = AnsiColor::Red.on_default().bold();
/// The style of `note:`.
pub const NOTE: Style = AnsiColor::Yellow.on_default().bold();

/// Returns `text` in a style if standard error is a terminal and `NO_COLOR` is not set (see no-color.org).
pub fn paint(style: Style, text: &str) -> String {
    let refused = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    if refused || !std::io::stderr().is_terminal() {
        return text.to_owned();
    }
    format!("{style}{text}{style:#}")
}
