//! Blender's own file, which only Blender writes: its program runs the script of an export, or Python does with the module `bpy`.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::SCRIPT_FILE;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_io::programs::{blender, python_with_blender};

/// The name of the file.
const BLEND: &str = "site.blend";
/// How many lines of what Blender says are shown when it fails.
const LINES: usize = 6;

/// Makes `site.blend` in the folder `out` of an export, and returns its path.
///
/// # Errors
/// Returns [`Error::Request`] when neither Blender nor `bpy` is found, when the file exists, and when the script fails, with what
/// Blender says; [`Error::Io`] when the program cannot be started.
pub fn make_blend(out: &Path, task: &Task) -> Result<PathBuf> {
    let file = out.join(BLEND);
    if file.exists() {
        return Err(Error::Request(format!(
            "{}: this file exists, and it may have changes of yours; rename it, or run {SCRIPT_FILE} in it by Blender's text editor",
            file.display()
        )));
    }
    let (program, arguments): (PathBuf, &[&str]) = if let Some(blender) = blender() {
        (blender, &["-b", "--python-exit-code", "1", "-P"])
    } else if let Some(python) = python_with_blender() {
        (python, &[])
    } else {
        return Err(Error::Request(format!(
            "Blender was not found on the search path, and no Python with the module bpy; install one of them, or open {} with \
             blender -P",
            out.join(SCRIPT_FILE).display()
        )));
    };
    let mut command = Command::new(&program);
    command.args(arguments).arg(out.join(SCRIPT_FILE)).args(["--", "--save"]).arg(&file).stdin(Stdio::null());
    let ran = task.timed("Blender", || command.output()).map_err(Error::io(&program, "start the program"))?;
    // Blender may end badly after it has saved.
    if file.exists() {
        return Ok(file);
    }
    let said = String::from_utf8_lossy(&[ran.stdout, ran.stderr].concat()).into_owned();
    let lines: Vec<&str> = said.lines().filter(|line| !line.trim().is_empty()).collect();
    let last = lines[lines.len().saturating_sub(LINES)..].join("\n");
    Err(Error::Request(format!("{}: it made no {BLEND}; it says:\n{last}", program.display())))
}
