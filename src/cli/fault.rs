//! What the user reads when the program itself is at fault.

use std::io::Write;
use std::panic::PanicHookInfo;

use crate::app::crash::is_of_display;

/// Replaces the message of a panic by one that tells the user what to do. With `RUST_BACKTRACE` set
/// the usual one follows.
pub fn install_message() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        // A terminal that went with the display must not turn a fault into an abort.
        let _ = writeln!(std::io::stderr(), "{}", message(panic));
        if std::env::var_os("RUST_BACKTRACE").is_some() {
            usual(panic);
        }
    }));
}

fn message(panic: &PanicHookInfo<'_>) -> String {
    let place = panic.location().map_or_else(|| "an unknown place".into(), ToString::to_string);
    if is_of_display(&place) {
        return format!("\nThe window's display is gone, or refused something ({place}).");
    }
    format!(
        "\nThis is a fault in quadratura, not in your files: {}\n\
         It happened at {place} (version {}, {}). Your project is whole: what was not finished was not saved.\n\
         Please report it with these lines; `RUST_BACKTRACE=1` before the command adds more.",
        panic.payload_as_str().unwrap_or("no message"),
        env!("CARGO_PKG_VERSION"),
        std::env::consts::OS,
    )
}
