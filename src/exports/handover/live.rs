//! Folders that follow the project: exports whose files are written again in place when layers, paint or cameras have changed.
//!
//! `exports/handover/folders.json` of the project lists them with what they were made with, and the hash of the state that they show. Models with
//! textures and cameras are not among them: they are exported when somebody wants them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::folder::{CONTENTS_FILE, HandedOver};
use super::{HandoverFormat, HandoverOptions, hand_over};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::Photo;
use quadratura_base::task::Task;
use quadratura_files::atomic::write_atomically;
use quadratura_files::hash::hash_bytes;
use quadratura_files::json::{read_json, to_json};
use quadratura_io::project::relative_to;
use quadratura_io::stack_store::StackStore;
use quadratura_sites::open::Opened;

const VERSION: u32 = 1;
/// Limit on the size of the list in bytes.
const LARGEST: u64 = 1 << 24;

/// The list; folders by their paths relative to the project.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Folders {
    version: u32,
    folders: BTreeMap<String, LiveFolder>,
}

/// What a folder was made with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct LiveFolder {
    format: String,
    /// The photos; `None` for all of the site.
    photos: Option<Vec<String>>,
    photos_per_face: usize,
    world: bool,
    /// The hash of the project's state that it shows.
    state: String,
}

/// A folder that was written again.
#[derive(Debug)]
pub struct Refreshed {
    /// The folder.
    pub folder: PathBuf,
    /// What is in it; or why it could not be written.
    pub done: Result<HandedOver>,
}

/// Remembers a folder that was just written from the state with the hash `state`.
///
/// # Errors
/// Returns the errors of reading and writing the list.
pub(super) fn remember(
    project: &Path,
    opened: &Opened,
    photos: &[&Photo],
    out: &Path,
    options: &HandoverOptions,
    state: String,
) -> Result<()> {
    let mut list = read(project)?;
    let all = photos.len() == opened.site.photos.len();
    let photos = (!all).then(|| photos.iter().map(|photo| photo.name.clone()).collect());
    let format = options.format.name().to_owned();
    let folder =
        LiveFolder { format, photos, photos_per_face: options.photos_per_face, world: options.world, state };
    list.folders.insert(relative_to(project, out)?, folder);
    write(project, &list)
}

/// Writes the folders again whose project has changed since, but for those in which one of the files `except` is, because somebody has just saved it
/// there. Folders that are gone are forgotten, with a note.
///
/// # Errors
/// Returns the errors of reading and writing the list, or [`Error::Cancelled`].
pub fn refresh(
    project: &Path,
    opened: &Opened,
    except: &[PathBuf],
    memory: u64,
    task: &Task,
) -> Result<Vec<Refreshed>> {
    let mut list = read(project)?;
    let mut refreshed = Vec::new();
    let known = list.folders.clone();
    for (path, folder) in known {
        let out = project.join(&path);
        if !out.join(CONTENTS_FILE).is_file() {
            task.note(format!("{} is gone, and is no longer brought up to date", out.display()));
            list.folders.remove(&path);
            write(project, &list)?;
            continue;
        }
        let is_in_it = |file: &PathBuf| {
            let whole = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
            whole(file).starts_with(whole(&out))
        };
        let photos = photos_of(&folder, opened);
        if except.iter().any(is_in_it) || state(project, &photos)? == folder.state {
            continue;
        }
        let Some(format) = HandoverFormat::named(&folder.format) else { continue };
        let options = HandoverOptions {
            format,
            photos_per_face: folder.photos_per_face,
            world: folder.world,
            memory,
            ..HandoverOptions::default()
        };
        let no_device = || Err(Error::Request("this format needs no device".into()));
        match hand_over(project, opened, &photos, &out, &options, &no_device, task) {
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            done => {
                let folder = out.canonicalize().unwrap_or(out);
                refreshed.push(Refreshed { folder, done });
            }
        }
    }
    Ok(refreshed)
}

/// Returns the photos of a folder that the site still has.
fn photos_of<'a>(folder: &LiveFolder, opened: &'a Opened) -> Vec<&'a Photo> {
    let is_of = |photo: &&Photo| folder.photos.as_ref().is_none_or(|names| names.contains(&photo.name));
    opened.site.photos.iter().filter(is_of).collect()
}

/// Returns the hash of what an export of these photos shows: the project, its paint, and the stacks.
///
/// # Errors
/// Returns [`Error::Io`].
pub(super) fn state(project: &Path, photos: &[&Photo]) -> Result<String> {
    let store = StackStore::new(project);
    let mut files = vec![project.join("project.json"), project.join("paint/paint.json")];
    files.extend(photos.iter().map(|photo| store.stack_file(&photo.name)));
    let mut hashes = String::new();
    for file in files {
        // What is not there is a state, too.
        let bytes = match file.is_file() {
            true => std::fs::read(&file).map_err(Error::io(&file, "read it"))?,
            false => Vec::new(),
        };
        hashes.push_str(&hash_bytes(&bytes));
    }
    Ok(hash_bytes(hashes.as_bytes()))
}

fn list_file(project: &Path) -> PathBuf {
    project.join("exports/handover/folders.json")
}

fn read(project: &Path) -> Result<Folders> {
    let file = list_file(project);
    match file.is_file() {
        true => {
            read_json(&file, LARGEST, "remove it; exported folders are then no longer brought up to date")
        }
        false => Ok(Folders { version: VERSION, ..Folders::default() }),
    }
}

fn write(project: &Path, list: &Folders) -> Result<()> {
    write_atomically(list_file(project), &to_json(list))
}
