//! Finds and starts other programs of the system: installed image editors and the file manager.

use std::env;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use quadratura_base::error::{Error, Result};
use quadratura_document::export_record::ExportFormat;

/// An image editor whose installation is found automatically.
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
    /// All supported image editors.
    pub const ALL: [Self; 3] = [Self::Gimp, Self::Krita, Self::Photoshop];

    /// Returns the editor's usual name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gimp => "GIMP",
            Self::Krita => "Krita",
            Self::Photoshop => "Photoshop",
        }
    }

    /// Returns the export format that the editor saves without loss: its own, or the one that it reads best
    /// where this program does not write its own.
    pub fn format(self) -> ExportFormat {
        match self {
            Self::Gimp => ExportFormat::Xcf,
            Self::Krita => ExportFormat::Ora,
            Self::Photoshop => ExportFormat::Psd,
        }
    }

    /// Returns the editor's commands on the search path, including those of Flatpak's and Snap's wrappers.
    fn commands(self) -> &'static [&'static str] {
        match self {
            Self::Gimp => &["gimp", "gimp-3.0", "gimp-3", "gimp-2.10", "org.gimp.GIMP"],
            Self::Krita => &["krita", "org.kde.krita"],
            Self::Photoshop => &["photoshop", "Photoshop"],
        }
    }

    /// Returns where installers put the editor outside the search path.
    fn installed(self, system: OperatingSystem) -> &'static [Installed] {
        match (system, self) {
            (OperatingSystem::Linux, _) => &[],
            (OperatingSystem::Mac, Self::Gimp) => {
                const { &[Installed::new("/Applications", "GIMP", "Contents/MacOS/gimp")] }
            }
            (OperatingSystem::Mac, Self::Krita) => {
                const { &[Installed::new("/Applications", "krita", "Contents/MacOS/krita")] }
            }
            (OperatingSystem::Mac, Self::Photoshop) => {
                const { &[Installed::new("/Applications", "Adobe Photoshop", "")] }
            }
            (OperatingSystem::Windows, Self::Gimp) => {
                const {
                    &[
                        Installed::new("C:/Program Files", "GIMP", "bin/gimp-3.0.exe"),
                        Installed::new("C:/Program Files", "GIMP", "bin/gimp-3.exe"),
                        Installed::new("C:/Program Files", "GIMP", "bin/gimp-2.10.exe"),
                    ]
                }
            }
            (OperatingSystem::Windows, Self::Krita) => {
                const { &[Installed::new("C:/Program Files", "Krita", "bin/krita.exe")] }
            }
            (OperatingSystem::Windows, Self::Photoshop) => {
                const { &[Installed::new("C:/Program Files/Adobe", "Adobe Photoshop", "Photoshop.exe")] }
            }
        }
    }
}

/// A program in one of several folders that differ by version number.
#[derive(Debug, Clone, Copy)]
struct Installed {
    root: &'static str,
    /// The beginning of the folder's name.
    folder: &'static str,
    /// The path of the program below the folder; empty for a bundle that the system opens itself.
    program: &'static str,
}

impl Installed {
    const fn new(root: &'static str, folder: &'static str, program: &'static str) -> Self {
        Self { root, folder, program }
    }

    /// Returns the newest installed version.
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

/// The kinds of systems, which differ in where programs are installed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum OperatingSystem {
    Linux,
    Mac,
    Windows,
}

const HERE: OperatingSystem = if cfg!(target_os = "macos") {
    OperatingSystem::Mac
} else if cfg!(windows) {
    OperatingSystem::Windows
} else {
    OperatingSystem::Linux
};

/// Returns the installed editors with the paths of their programs, in the order of [`ImageEditor::ALL`].
pub fn image_editors() -> Vec<(ImageEditor, PathBuf)> {
    let folders = search_path();
    let find = |editor: ImageEditor| {
        let installed = || editor.installed(HERE).iter().find_map(Installed::find);
        Some((editor, on_path(editor.commands(), &folders).or_else(installed)?))
    };
    ImageEditor::ALL.into_iter().filter_map(find).collect()
}

/// Returns the folders of `PATH`, followed by those of Flatpak's and Snap's wrappers.
fn search_path() -> Vec<PathBuf> {
    let path = env::var_os("PATH").unwrap_or_default();
    let mut folders: Vec<PathBuf> = env::split_paths(&path).collect();
    if HERE == OperatingSystem::Linux {
        folders.extend(["/snap/bin", "/var/lib/flatpak/exports/bin"].map(PathBuf::from));
        folders.extend(env::home_dir().map(|home| home.join(".local/share/flatpak/exports/bin")));
    }
    folders
}

/// Returns the first of `commands` that exists in one of `folders`; the order of the commands takes
/// precedence over the order of the folders.
fn on_path(commands: &[&str], folders: &[PathBuf]) -> Option<PathBuf> {
    let names = commands.iter().map(|command| format!("{command}{}", env::consts::EXE_SUFFIX));
    let mut files = names.flat_map(|name| folders.iter().map(move |folder| folder.join(&name)));
    files.find(|file| file.is_file())
}

/// Returns Blender's program, from the search path or where installers put it; `None` where it is not found.
pub fn blender() -> Option<PathBuf> {
    let installed: &[Installed] = match HERE {
        OperatingSystem::Linux => &[],
        OperatingSystem::Mac => {
            const { &[Installed::new("/Applications", "Blender", "Contents/MacOS/Blender")] }
        }
        OperatingSystem::Windows => {
            const { &[Installed::new("C:/Program Files/Blender Foundation", "Blender", "blender.exe")] }
        }
    };
    let commands = ["blender", "org.blender.Blender"];
    on_path(&commands, &search_path()).or_else(|| installed.iter().find_map(Installed::find))
}

/// Returns a Python on the search path whose module `bpy` is Blender; `None` where there is none.
pub fn python_with_blender() -> Option<PathBuf> {
    let python = on_path(&["python3", "python"], &search_path())?;
    let code = "import importlib.util as u, sys; sys.exit(0 if u.find_spec('bpy') else 1)";
    let tried = Command::new(&python).args(["-c", code]).stdin(Stdio::null()).output();
    tried.is_ok_and(|tried| tried.status.success()).then_some(python)
}

/// Checks that `program`, a path or a name on the search path, can be started.
///
/// # Errors
/// [`Error::Input`] that says what was found instead.
pub fn check_program(program: &Path) -> Result<()> {
    let remedy = "choose another one with `Choose image editor…`";
    let is_name = program.components().count() == 1;
    if is_name && on_path(&[&program.to_string_lossy()], &search_path()).is_some() {
        return Ok(());
    }
    let is_bundle = HERE == OperatingSystem::Mac && program.extension() == Some(OsStr::new("app"));
    match fs::metadata(program) {
        Err(_) => Err(Error::input(program, "", "this program does not exist", remedy)),
        Ok(found) if found.is_dir() && !is_bundle => {
            Err(Error::input(program, "", "this is a folder, not a program", remedy))
        }
        Ok(found) if !may_run(&found) => {
            Err(Error::input(program, "", "this file is not an executable program", remedy))
        }
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

/// Starts a program with a file and does not wait for it: it keeps running when this program ends. `failed`
/// receives the exit status if the program fails within the first seconds, for example because it has no
/// display.
///
/// # Errors
/// [`Error::Io`] when it cannot be started.
pub fn start_with(program: &Path, file: &Path, failed: impl FnOnce(String) + Send + 'static) -> Result<()> {
    let is_bundle = HERE == OperatingSystem::Mac && program.extension() == Some(OsStr::new("app"));
    let mut command = if is_bundle { Command::new("open") } else { Command::new(program) };
    if is_bundle {
        command.arg("-a").arg(program);
    }
    spawn(command.arg(file), program, failed)
}

/// Opens a file or a folder with the program that the system has for it: a page in the browser, a folder in the file manager.
///
/// # Errors
/// [`Error::Io`] when the system's program for that cannot be started.
pub fn open_with_system(path: &Path) -> Result<()> {
    let program = match HERE {
        OperatingSystem::Linux => "xdg-open",
        OperatingSystem::Mac => "open",
        OperatingSystem::Windows => "explorer",
    };
    spawn(Command::new(program).arg(path), Path::new(program), |_| ())
}

/// A program that fails within this time failed to start; later failures are not reported.
const START_UP: Duration = Duration::from_secs(10);

fn spawn(command: &mut Command, program: &Path, failed: impl FnOnce(String) + Send + 'static) -> Result<()> {
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    // Ctrl-C in the terminal that started this program should not reach the other one.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    let mut child = command.spawn().map_err(Error::io(program, "start the program"))?;
    // An ended process stays in the process table until its status is read.
    let since = Instant::now();
    let reap = move || match child.wait() {
        Ok(status) if !status.success() && since.elapsed() < START_UP => failed(status.to_string()),
        _ => (),
    };
    // Without the thread the process stays in the process table, which is harmless.
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
        let message = start_with(Path::new("/no/such/editor"), &file, |_| ()).unwrap_err().to_string();
        assert!(message.contains("/no/such/editor"), "{message}");
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
    fn files_that_are_no_programs_are_refused_with_what_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("wall.psd");
        fs::write(&file, "x").unwrap();
        let message = |program: &Path| check_program(program).unwrap_err().to_string();
        assert!(message(&folder.path().join("gimp")).contains("this program does not exist"));
        assert!(message(folder.path()).contains("a folder"));
        assert!(
            message(&file).contains("not an executable program")
                && message(&file).contains("Choose image editor")
        );
        assert!(check_program(Path::new("sh")).is_ok() && check_program(Path::new("/bin/sh")).is_ok());
    }
}
