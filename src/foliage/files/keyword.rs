//! Reads plants of the keyword format (Max 1996): a file a sub-object, the first of them the whole plant.

use std::fs;
use std::path::{Path, PathBuf};

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::pictures::{Folder, PictureFault};
use super::remedies::{COARSER, FILE, Wrong};
use super::statements::Statements;
use super::tokens::{Tokens, quoted};
use crate::{Draft, MOST_CORNERS, MOST_USES, Plant, PlantFlaw, Primitive, assemble};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;

/// The largest file of a sub-object in bytes.
const LARGEST: u64 = 1 << 30;

/// The stage that is reported for reading files.
const STAGE: &str = "read plant";

/// Reads the plant of a file with all the files that it uses. Places where something was left out are noted, each kind
/// once, with their number.
///
/// # Errors
/// [`Error::Input`] with file and line, [`Error::Io`], [`Error::Cancelled`].
pub fn read_keyword(path: &Path, task: &Task) -> Result<Plant> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut reader = Reader {
        folder: Folder::of(path)?,
        files: vec![(name.clone(), path.to_path_buf())],
        known: FxHashMap::from_iter([(name, 0)]),
        corners: 0,
        uses: 0,
        notes: Vec::new(),
    };
    let (mut drafts, mut up, mut unit) = (Vec::new(), DVec3::Z, 1.0);
    while let Some((_, file)) = reader.files.get(drafts.len()).cloned() {
        task.step(STAGE, drafts.len() as u64, reader.files.len() as u64)?;
        let text = read_text(&file, &mut reader.folder)?;
        let read = Statements::new(Tokens::new(&file, &text), &mut reader).read(drafts.len())?;
        if drafts.is_empty() {
            up = read.up.unwrap_or(up);
            unit = read.unit.unwrap_or(unit);
        } else if read.up.is_some() || read.unit.is_some() {
            reader.note(FileNote::UnitOfPart, &file, 1);
        }
        drafts.push(read.draft);
    }
    reader.notes.iter().for_each(|noted| task.note(noted.text()));
    reader.folder.notes().iter().for_each(|note| task.note(note));
    assembled(path, drafts, up, unit)
}

fn read_text(file: &Path, folder: &mut Folder) -> Result<String> {
    let bytes = fs::metadata(file).map_err(Error::io(file, "read it"))?.len();
    if bytes > LARGEST {
        let found = format!("{bytes} bytes, but a sub-object has at most {LARGEST}");
        return Err(Error::input(file, "", found, "divide it into several files"));
    }
    let bytes = fs::read(file).map_err(Error::io(file, "read it"))?;
    folder.decoded(file, &bytes)
}

fn assembled(path: &Path, drafts: Vec<Draft>, up: DVec3, unit: f64) -> Result<Plant> {
    assemble(drafts, 0, up, unit).map_err(|flaw| {
        let file = match &flaw {
            PlantFlaw::Cycle(names) => path.with_file_name(&names[0]),
            PlantFlaw::Endless(name) => path.with_file_name(name),
            _ => path.to_path_buf(),
        };
        let Wrong { found, remedy } = Wrong::from(&flaw);
        Error::input(file, "", found, remedy)
    })
}

/// What is left out, or has no effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileNote {
    /// A use or limb whose transform is singular.
    Singular,
    /// A polygon without area.
    NoArea,
    /// A use of a bounding box.
    Box,
    /// A cut-out without a picture.
    NoPicture,
    /// What is up, or the unit, in a file that is not the whole plant.
    UnitOfPart,
}

/// A kind of note with the first place and the number of places.
struct Noted {
    note: FileNote,
    file: PathBuf,
    line: usize,
    count: usize,
}

impl Noted {
    fn text(&self) -> String {
        let what = match self.note {
            FileNote::Singular => "a use or limb is left out, because its transform is singular",
            FileNote::NoArea => "a polygon has no area, and nothing of it is seen",
            FileNote::Box => "a bounding box is passed over, because boxes are computed",
            FileNote::NoPicture => "`cutout` has no effect without `picture`",
            FileNote::UnitOfPart => "`unit` and `up` have an effect in the file of the whole plant alone",
        };
        let others = match self.count - 1 {
            0 => String::new(),
            others => format!(" (and {others} more)"),
        };
        format!("{}, line {}: {what}{others}", self.file.display(), self.line)
    }
}

/// The files of a plant so far.
pub struct Reader {
    folder: Folder,
    /// The names and paths of the sub-objects, in the order in which they are named.
    files: Vec<(String, PathBuf)>,
    /// The same by name.
    known: FxHashMap<String, usize>,
    corners: u64,
    uses: usize,
    notes: Vec<Noted>,
}

impl Reader {
    /// Returns the name of a sub-object.
    pub fn name(&self, index: usize) -> String {
        self.files[index].0.clone()
    }

    /// Notes what is left out in a line.
    pub fn note(&mut self, note: FileNote, file: &Path, line: usize) {
        match self.notes.iter_mut().find(|noted| noted.note == note) {
            Some(noted) => noted.count += 1,
            None => self.notes.push(Noted { note, file: file.to_path_buf(), line, count: 1 }),
        }
    }

    /// Returns the sub-object that `use NAME` names, which is read later.
    ///
    /// # Errors
    /// What was found, where the name is foreign or has no file, or there are too many.
    pub fn sub_object(&mut self, name: &str) -> std::result::Result<usize, Wrong> {
        self.uses += 1;
        if self.uses > MOST_USES {
            return Err((format!("more than {MOST_USES} uses"), COARSER).into());
        }
        // Names that are known need not be looked up on the disk again.
        let names = [name.to_owned(), format!("{name}.plant")];
        for name in &names {
            if let Some(&index) = self.known.get(name) {
                self.known.insert(names[0].clone(), index);
                return Ok(index);
            }
            let file = self.folder.file(name).filter(|_| !name.contains('/'));
            let foreign =
                || (format!("`use {}` names a file outside of the plant's folder", quoted(name)), FILE);
            let file = file.ok_or_else(foreign)?;
            if file.is_file() {
                self.known.insert(name.clone(), self.files.len());
                self.files.push((name.clone(), file));
                return Ok(self.files.len() - 1);
            }
        }
        let [name, ending] = names.map(|name| quoted(&name));
        let found = format!("`use` of {name}, but there is no file {name} or {ending} in the folder");
        Err((found, FILE).into())
    }

    /// Reads a picture.
    ///
    /// # Errors
    /// What was found, where the name is foreign; otherwise the errors about the picture.
    pub fn picture(&mut self, name: &str) -> Result<std::sync::Arc<crate::Pixels>, PictureFault> {
        self.folder.named_picture(name)
    }

    /// Counts a primitive.
    ///
    /// # Errors
    /// What was found, where there are too many corners.
    pub fn count(&mut self, primitive: &Primitive) -> std::result::Result<(), Wrong> {
        self.corners = self.corners.saturating_add(primitive.shape.corners());
        if self.corners > MOST_CORNERS {
            let found = format!("more than {MOST_CORNERS} corners of polygons, of the plant up to here");
            return Err((found, COARSER).into());
        }
        Ok(())
    }
}
