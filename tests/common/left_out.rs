//! Tests that cannot run on a machine are left out, and say so.
//!
//! Rust's test harness knows tests that pass and tests that fail; a test that returns early because it lacks
//! something reads as passed. So such a test says on standard error that it is left out, past the harness, which
//! hides what passing tests print, and adds a line to the file that the environment variable `LEFT_OUT_LOG`
//! names. `tests/run.sh` counts these lines and prints them last. Unit tests below `src/` share this file.

use std::fmt::Display;
use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Whether this is the run for every change, where nothing may be left out that the set-up can provide.
fn in_ci() -> bool {
    std::env::var("CI").is_ok_and(|ci| ci == "true")
}

/// Says that the running test is left out, and why.
fn leave_out(reason: &str) {
    let program = std::env::current_exe().unwrap_or_default();
    // Cargo adds a hash to the name: `projection-0123456789abcdef`.
    let stem = program.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let binary = stem.rsplit_once('-').map_or(stem.as_str(), |(name, _)| name);
    // The harness names each test's thread after the test.
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    // Not eprintln!, which the harness captures.
    let _ = writeln!(std::io::stderr(), "left out: {binary}: {test}: {reason}");
    let Some(path) = std::env::var_os("LEFT_OUT_LOG") else { return };
    let log = OpenOptions::new().create(true).append(true).open(&path);
    // In one piece: other tests write to the same file at the same time.
    let line = format!("{reason}\t{binary}: {test}\n");
    log.and_then(|mut log| log.write_all(line.as_bytes()))
        .expect("LEFT_OUT_LOG is a file that can be written");
}

/// What was made on this machine's adapter. Without one the test is left out; where `CI=true` it fails, because the
/// set-up there installs a software adapter.
#[allow(dead_code)]
pub fn on_adapter<T, E: Display>(made: Result<T, E>) -> Option<T> {
    match made {
        Ok(made) => Some(made),
        Err(error) => {
            assert!(!in_ci(), "{error}");
            leave_out(&format!("there is no graphics adapter ({error})"));
            None
        }
    }
}

/// The folder of the castle, a real site of 19 photos that lies beside the project and not in it. Where it is missing
/// the test is left out; in CI it fails where the folder that it belongs in exists.
#[allow(dead_code)]
pub fn castle() -> Option<PathBuf> {
    // The packages in src/ have this file, too.
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let project = package.ancestors().find(|folder| folder.join("Cargo.lock").is_file()).unwrap_or(package);
    let folder = project.join("../shared/data/castle");
    if folder.exists() {
        return Some(folder);
    }
    let shared = folder.ancestors().nth(2).expect("it lies in shared/data");
    assert!(!in_ci() || !shared.exists(), "{} is missing", folder.display());
    leave_out("the castle, a site with 19 photos, is not beside this project in ../shared/data/castle");
    None
}

/// Chromium, by which pages are drawn. Where it is missing the test is left out.
#[allow(dead_code)]
pub fn chromium() -> Option<PathBuf> {
    const NAMES: &[&str] = &["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    installed(NAMES, "there is no Chromium, which `sh tests/editors.sh` installs")
}

/// Python, which drives browsers. Where it is missing the test is left out.
#[allow(dead_code)]
pub fn python() -> Option<PathBuf> {
    installed(&["python3"], "there is no Python 3, which drives the browser")
}

/// Returns the first program that is there, by any of its names; without one, the test is left out.
#[allow(dead_code)]
fn installed(names: &[&str], why_left_out: &str) -> Option<PathBuf> {
    let paths: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()).collect();
    let mut files = paths.iter().flat_map(|path| names.iter().map(|name| path.join(name)));
    let found = files.find(|file| file.is_file());
    if found.is_none() {
        leave_out(why_left_out);
    }
    found
}
