//! The program: parse, run, exit code.

use std::process::ExitCode;

fn main() -> ExitCode {
    #[cfg(target_os = "linux")]
    choose_adapters_ourselves();
    quadratura::run(std::env::args_os())
}

/// Mesa comes with a Vulkan layer that asks the desktop which GPU to prefer. Where no user is logged
/// in, libwayland prints `error: XDG_RUNTIME_DIR is invalid` for that, which is no error of ours.
/// The layer is not needed: `gpu` chooses among all adapters.
#[cfg(target_os = "linux")]
fn choose_adapters_ourselves() {
    let no_desktop = std::env::var_os("XDG_RUNTIME_DIR").is_none();
    if no_desktop && std::env::var_os("NODEVICE_SELECT").is_none() {
        // SAFETY: this is the first thing the program does; no other thread reads the environment.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}
