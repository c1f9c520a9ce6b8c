//! Other programs of the system: which image editors are installed, and how they and the file manager are started
//! beside this one.

use std::env;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::document::export_record::ExportFormat;
use crate::error::{Error, Result};

/// An image editor that is looked for by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum ImageEditor {
    /// GIMP.
    Gimp,
    /// Krita.
    Krita,
    /// Adobe Photoshop.
    Photoshop,
}

impl ImageEditor {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Gimp, Self::Krita, Self::Photoshop];

    /// As people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gimp => "GIMP",
            Self::Krita => "Krita",
            Self::Photoshop => "Photoshop",
        }
    }

    /// The format that it gives back as it was: its own, or where we do not write that, the one it reads best.
    pub fn format(self) -> ExportFormat {
        match self {
            Self::Gimp => ExportFormat::Xcf,
            Self::Krita => ExportFormat::Ora,
            Self::Photoshop => ExportFormat::Psd,
        }
    }

    /// Names on the search path, those of wrappers that Flatpak and Snap put there too.
    fn commands(self) -> &'static [&'static str] {
        match self {
            Self::Gimp => &["gimp", "gimp-3.0", "gimp-3", "gimp-2.10", "org.gimp.GIMP"],
            Self::Krita => &["krita", "org.kde.krita"],
            Self::Photoshop => &["photoshop", "Photoshop"],
        }
    }

    /// Where installers put it outside the search path.
    fn installed(self, system: System) -> &'static [Installed] {
        match (system, self) {
            (System::Linux, _) => &[],
            (System::Mac, Self::Gimp) => {
                const { &[Installed::new("/Applications", "GIMP", "Contents/MacOS/gimp")] }
            }
            (System::Mac, Self::Krita) => {
                const { &[Installed::new("/Applications", "krita", "Contents/MacOS/krita")] }
            }
            (System::Mac, Self::Photoshop) => {
                const { &[Installed::new("/Applications", "Adobe Photoshop", "")] }
            }
            (System::Windows, Self::Gimp) => {
                const {
                    &[
                        Installed::new("C:/Program Files", "GIMP", "bin/gimp-3.0.exe"),
                        Installed::new("C:/Program Files", "GIMP", "bin/gimp-3.exe"),
                        Installed::new("C:/Program Files", "GIMP", "bin/gimp-2.10.exe"),
                    ]
                }
            }
            (System::Windows, Self::Krita) => {
                const { &[Installed::new("C:/Program Files", "Krita", "bin/krita.exe")] }
            }
            (System::Windows, Self::Photoshop) => {
                const { &[Installed::new("C:/Program Files/Adobe", "Adobe Photoshop", "Photoshop.exe")] }
            }
        }
    }
}

/// A program in one of several folders that differ by their versions.
#[derive(Debug, Clone, Copy)]
struct Installed {
    root: &'static str,
    /// How the folder's name begins.
    folder: &'static str,
    /// Below it; empty for a bundle that the system opens itself.
    program: &'static str,
}

impl Installed {
    const fn new(root: &'static str, folder: &'static str, program: &'static str) -> Self {
        Self { root, folder, program }
    }

    /// The newest one.
    fn find(&self) -> Option<PathBuf> {
        let mut found: Vec<PathBuf> = fs::read_dir(self.root).ok()?.flatten().map(|e| e.path()).collect();
        found.retain(|path| {
            path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(self.folder))
        });
        found.sort();
        let program = |path: PathBuf| if self.program.is_empty() { path } else { path.join(self.program) };
        found.into_iter().rev().map(program).find(|path| path.exists())
    }
}

/// What is usual where programs are installed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum System {
    Linux,
    Mac,
    Windows,
}

const HERE: System = if cfg!(target_os = "macos") {
    System::Mac
} else if cfg!(windows) {
    System::Windows
} else {
    System::Linux
};

/// The editors that are installed, with their programs, in the order of [`ImageEditor::ALL`].
pub fn image_editors() -> Vec<(ImageEditor, PathBuf)> {
    let folders = search_path();
    let find = |editor: ImageEditor| {
        let installed = || editor.installed(HERE).iter().find_map(Installed::find);
        Some((editor, on_path(editor.commands(), &folders).or_else(installed)?))
    };
    ImageEditor::ALL.into_iter().filter_map(find).collect()
}

/// The folders of `PATH`, then those where Flatpak and Snap put their wrappers.
fn search_path() -> Vec<PathBuf> {
    let path = env::var_os("PATH").unwrap_or_default();
    let mut folders: Vec<PathBuf> = env::split_paths(&path).collect();
    if HERE == System::Linux {
        folders.extend(["/snap/bin", "/var/lib/flatpak/exports/bin"].map(PathBuf::from));
        folders.extend(env::home_dir().map(|home| home.join(".local/share/flatpak/exports/bin")));
    }
    folders
}

/// The first of these commands that is in one of the folders; a command earlier in the list counts more than a folder.
fn on_path(commands: &[&str], folders: &[PathBuf]) -> Option<PathBuf> {
    let names = commands.iter().map(|command| format!("{command}{}", env::consts::EXE_SUFFIX));
    let mut files = names.flat_map(|name| folders.iter().map(move |folder| folder.join(&name)));
    files.find(|file| file.is_file())
}

/// Whether something that can be started is where a user says that an image editor is: a path, or a name on the search
/// path.
///
/// # Errors
/// [`Error::Input`] that says what is there instead.
pub fn check_program(program: &Path) -> Result<()> {
    let remedy = "choose another one with `Choose image editor…`";
    let is_name = program.components().count() == 1;
    if is_name && on_path(&[&program.to_string_lossy()], &search_path()).is_some() {
        return Ok(());
    }
    let is_bundle = HERE == System::Mac && program.extension() == Some(OsStr::new("app"));
    match fs::metadata(program) {
        Err(_) => Err(Error::input(program, "", "there is no such program", remedy)),
        Ok(found) if found.is_dir() && !is_bundle => {
            Err(Error::input(program, "", "a folder, not a program", remedy))
        }
        Ok(found) if !may_run(&found) => Err(Error::input(program, "", "a file that is no program", remedy)),
        Ok(_) => Ok(()),
    }
}

#[cfg(unix)]
fn may_run(file: &fs::Metadata) -> bool {
    std::os::unix::fs::PermissionsExt::mode(&file.permissions()) & 0o111 != 0
}

#[cfg(not(unix))]
fn may_run(_: &fs::Metadata) -> bool {
    true
}

/// Starts a program with a file, and does not wait for it: it goes on when this program ends. `failed` hears how it
/// ended when it did so at once and not well, as one that lacks a display.
///
/// # Errors
/// [`Error::Io`] when it cannot be started.
pub fn start_with(program: &Path, file: &Path, failed: impl FnOnce(String) + Send + 'static) -> Result<()> {
    let is_bundle = HERE == System::Mac && program.extension() == Some(OsStr::new("app"));
    let mut command = if is_bundle { Command::new("open") } else { Command::new(program) };
    if is_bundle {
        command.arg("-a").arg(program);
    }
    spawn(command.arg(file), program, failed)
}

/// Shows a folder in the system's file manager.
///
/// # Errors
/// [`Error::Io`] when there is none.
pub fn show_folder(folder: &Path) -> Result<()> {
    let program = match HERE {
        System::Linux => "xdg-open",
        System::Mac => "open",
        System::Windows => "explorer",
    };
    spawn(Command::new(program).arg(folder), Path::new(program), |_| ())
}

/// Who has ended within so long was not used.
const AT_ONCE: Duration = Duration::from_secs(10);

fn spawn(command: &mut Command, program: &Path, failed: impl FnOnce(String) + Send + 'static) -> Result<()> {
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    // Ctrl-C in the terminal that this program was started from is not meant for it.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    let mut child = command.spawn().map_err(Error::io(program, "start the program"))?;
    // Whoever has ended is listed until somebody has asked how.
    let since = Instant::now();
    let reap = move || match child.wait() {
        Ok(status) if !status.success() && since.elapsed() < AT_ONCE => failed(status.to_string()),
        _ => (),
    };
    // Without a thread for it that is a line in a list, no more.
    drop(std::thread::Builder::new().name("started program".into()).spawn(reap));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_better_name_counts_more_than_an_earlier_folder() {
        let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
        let paths: Vec<PathBuf> = folders.iter().map(|folder| folder.path().to_owned()).collect();
        let file =
            |folder: usize, name: &str| paths[folder].join(format!("{name}{}", env::consts::EXE_SUFFIX));
        assert_eq!(on_path(&["gimp", "gimp-2.10"], &paths), None);
        fs::write(file(0, "gimp-2.10"), "").unwrap();
        assert_eq!(on_path(&["gimp", "gimp-2.10"], &paths), Some(file(0, "gimp-2.10")));
        fs::write(file(1, "gimp"), "").unwrap();
        assert_eq!(on_path(&["gimp", "gimp-2.10"], &paths), Some(file(1, "gimp")));
    }

    #[test]
    fn of_several_versions_the_newest_that_holds_the_program_is_taken() {
        let root = tempfile::tempdir().unwrap();
        let program = |version: &str| root.path().join(format!("GIMP {version}/bin/gimp"));
        for version in ["2", "3", "4"] {
            fs::create_dir_all(program(version).parent().unwrap()).unwrap();
        }
        ["2", "3"].iter().for_each(|version| fs::write(program(version), "").unwrap());
        let name: &'static str = root.path().to_str().unwrap().to_owned().leak();
        assert_eq!(Installed::new(name, "GIMP", "bin/gimp").find(), Some(program("3")));
        assert_eq!(Installed::new(name, "Krita", "bin/krita").find(), None);
    }

    #[cfg(unix)]
    #[test]
    fn a_program_is_started_with_the_file_and_one_that_is_not_there_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("touched");
        start_with(Path::new("touch"), &file, |_| ()).unwrap();
        while !file.exists() {
            std::thread::yield_now();
        }
        let told = start_with(Path::new("/no/such/editor"), &file, |_| ()).unwrap_err().to_string();
        assert!(told.contains("/no/such/editor"), "{told}");
    }

    #[cfg(unix)]
    #[test]
    fn one_that_ends_at_once_and_not_well_is_told() {
        let (send, receive) = std::sync::mpsc::channel();
        start_with(Path::new("false"), Path::new("a.psd"), move |how| drop(send.send(how))).unwrap();
        assert!(receive.recv().unwrap().contains('1'));
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_program_is_told_as_what_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("wall.psd");
        fs::write(&file, "x").unwrap();
        let told = |program: &Path| check_program(program).unwrap_err().to_string();
        assert!(told(&folder.path().join("gimp")).contains("no such program"));
        assert!(told(folder.path()).contains("a folder"));
        assert!(told(&file).contains("no program") && told(&file).contains("Choose image editor"));
        assert!(check_program(Path::new("sh")).is_ok() && check_program(Path::new("/bin/sh")).is_ok());
    }
}
