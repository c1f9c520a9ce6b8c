//! The message that users read when the program itself has a fault.

use std::io::Write;
use std::panic::PanicHookInfo;

#[cfg(feature = "gui")]
use quadratura_app::crash::is_of_display;
use quadratura_files::guarded::is_decoding;

/// Replaces the message of a panic by one that says what to do. With `RUST_BACKTRACE` set the standard
/// message follows.
pub fn install_message() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let wants_details = std::env::var_os("RUST_BACKTRACE").is_some();
        // A decoder's panic becomes an error about its file.
        if is_decoding() && !wants_details {
            return;
        }
        // A closed terminal must not turn a panic into an abort.
        let _ = writeln!(std::io::stderr(), "{}", message(panic));
        if wants_details {
            usual(panic);
        }
    }));
}

/// Without a window there is no display connection.
#[cfg(not(feature = "gui"))]
fn is_of_display(_: &str) -> bool {
    false
}

fn message(panic: &PanicHookInfo<'_>) -> String {
    let place = panic.location().map_or_else(|| "an unknown place".into(), ToString::to_string);
    if is_of_display(&place) {
        return format!(
            "\nThe connection to the display was lost, or the display refused a request ({place})."
        );
    }
    format!(
        "\nThis is a fault in quadratura, not in your files: {}\n\
         It happened at {place} (version {}, {}). Your project is intact; work that had not finished was not saved.\n\
         Please report it with these lines; setting `RUST_BACKTRACE=1` before the command adds details.",
        panic.payload_as_str().unwrap_or("no message"),
        env!("CARGO_PKG_VERSION"),
        std::env::consts::OS,
    )
}
