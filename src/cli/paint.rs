//! A little colour, where a terminal wants it.

use std::io::IsTerminal;

use clap::builder::styling::{AnsiColor, Style};

/// `error:`
pub const ERROR: Style = AnsiColor::Red.on_default().bold();
/// `note:`
pub const NOTE: Style = AnsiColor::Yellow.on_default().bold();

/// `text` in a style, if standard error is a terminal and `NO_COLOR` is not set (see no-color.org).
pub fn paint(style: Style, text: &str) -> String {
    let refused = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    if refused || !std::io::stderr().is_terminal() {
        return text.to_owned();
    }
    format!("{style}{text}{style:#}")
}
