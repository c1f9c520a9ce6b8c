//! The program: parse, run, exit code.

use std::process::ExitCode;

fn main() -> ExitCode {
    #[cfg(target_os = "linux")]
    choose_adapters_ourselves();
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    return_large_blocks();
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

/// The size from which blocks of memory are returned to the system as soon as they are free, in bytes.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const RETURNED_BYTES: i32 = 1 << 20;

/// Left to itself, glibc takes ever larger blocks from heaps, which layers of all sizes that come and go leave full of gaps: a program that
/// reads hundreds of layers would keep twice the memory that it uses.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn return_large_blocks() {
    // SAFETY: it sets a number of the allocator, and no other thread runs yet.
    unsafe { libc::mallopt(libc::M_MMAP_THRESHOLD, RETURNED_BYTES) };
}
