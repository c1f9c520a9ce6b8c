//! The folder of an export to another program: files with fixed names, so that links between them survive, of which none is
//! overwritten that was changed since.
//!
//! `handover.json` in it lists the files with the hashes of their content. The project keeps the hashes of all files that it ever
//! wrote in `exports/handover/written.json`: a file whose hash is there is an unchanged one of ours and may be replaced. A folder
//! whose `handover.json` the project did not write holds an export of another project, and is refused.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::baked::report::BakedReport;
use super::format::HandoverFormat;
use super::origin::Placement;
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_editing::export::check_place;
use quadratura_files::atomic::{AtomicFile, remove_dead_leftovers, write_atomically};
use quadratura_files::hash::{hash_bytes, hash_file};
use quadratura_files::json::{read_json, to_json};

/// The file that lists what is in the folder.
pub const CONTENTS_FILE: &str = "handover.json";
const VERSION: u32 = 1;
/// Limit on the size of either record in bytes.
const LARGEST: u64 = 1 << 26;
/// Files that are complete under a temporary name wait in this number, so that the project's record is written once for all of
/// them and few files are open.
const MOST_PENDING: usize = 64;

/// What a folder holds; the content of [`CONTENTS_FILE`].
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
struct Contents {
    version: u32,
    /// The formats that were written to it.
    formats: BTreeSet<String>,
    /// The point of the world, or of the frame, that is zero in every file.
    origin: [f64; 3],
    /// The rows of the matrix from the cameras' world to the site's frame, in which coordinates are; `None` for the world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    frame_from_world: Option<[[f64; 4]; 4]>,
    /// The hashes of the files' content when they were written, by their paths in the folder.
    files: BTreeMap<String, String>,
}

/// The hashes of the content of all files that exports of this project wrote.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Written {
    version: u32,
    hashes: BTreeSet<String>,
}

/// A folder that an export is being written to.
#[derive(Debug)]
pub struct HandoverFolder<'a> {
    out: &'a Path,
    record: PathBuf,
    written: Written,
    contents: Contents,
    pending: Vec<AtomicFile>,
    report: HandedOver,
}

/// What an export wrote.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct HandedOver {
    /// The files and folders of image layers, with their sizes in bytes, in the order in which they were written.
    pub files: Vec<HandedFile>,
    /// Files that were not overwritten, because they were changed since their export.
    pub spared: Vec<PathBuf>,
    /// What is not in the export, and why: one sentence each.
    pub left_out: Vec<String>,
    /// What could not be read or written, and is not in the export for that reason: one sentence each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub failed: Vec<String>,
    /// The point of the world, or of the frame, that is zero in the files.
    pub origin: [f64; 3],
    /// The rows of the matrix from the cameras' world to the site's frame, in which coordinates are; `None` for the world.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame_from_world: Option<[[f64; 4]; 4]>,
    /// Numbers about a baked model; `None` in other formats.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baked: Option<BakedReport>,
}

/// A file, or a folder of image layers, that was written.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HandedFile {
    /// The path in the folder, with `/`.
    pub name: String,
    /// The size in bytes.
    pub bytes: u64,
}

impl<'a> HandoverFolder<'a> {
    /// Opens the folder `out`, which is created if necessary, for an export of the project in the folder `project`.
    ///
    /// # Errors
    /// Returns [`Error::Request`] for a folder of the project's own and for one with an export of another project, [`Error::Input`]
    /// when the project's record is damaged, or [`Error::Io`].
    pub fn open(
        project: &Path,
        out: &'a Path,
        format: HandoverFormat,
        placement: &Placement,
    ) -> Result<Self> {
        check_place(project, out)?;
        fs::create_dir_all(out).map_err(Error::io(out, "create the folder"))?;
        let records = project.join("exports/handover");
        fs::create_dir_all(&records).map_err(Error::io(&records, "create the folder"))?;
        [out, &records].into_iter().for_each(remove_dead_leftovers);
        let record = records.join("written.json");
        let written = match record.exists() {
            true => {
                read_json(&record, LARGEST, "remove it; files of earlier exports then count as changed ones")?
            }
            false => Written { version: VERSION, ..Written::default() },
        };
        let mut contents = contents_of(out, &written)?;
        contents.formats.insert(format.name().to_owned());
        contents.origin = placement.origin.to_array();
        contents.frame_from_world = placement.frame_from_world.map(Into::into);
        let report = HandedOver {
            origin: contents.origin,
            frame_from_world: contents.frame_from_world,
            ..HandedOver::default()
        };
        Ok(Self { out, record, written, contents, pending: Vec::new(), report })
    }

    /// Returns the path of the folder.
    pub fn path(&self) -> &Path {
        self.out
    }

    /// Writes a file, whose path in the folder is `name`, with `/`. Where a file of this name was changed since its export, it is
    /// kept, and the new one is `NAME-2` beside it. A file that has this content already is not touched.
    ///
    /// # Errors
    /// Returns [`Error::Io`].
    pub fn write(&mut self, name: &str, content: &[u8]) -> Result<()> {
        let hash = hash_bytes(content);
        let (name, is_there) = self.free_name(name, &hash)?;
        if !is_there {
            let target = self.out.join(&name);
            let folder = target.parent().unwrap_or(self.out);
            fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
            let mut file = AtomicFile::create(&target)?;
            file.file().write_all(content).map_err(Error::io(&target, "write it"))?;
            self.pending.push(file);
        }
        self.written.hashes.insert(hash.clone());
        self.contents.files.insert(name.clone(), hash);
        self.report.files.push(HandedFile { name, bytes: content.len() as u64 });
        if self.pending.len() >= MOST_PENDING { self.commit() } else { Ok(()) }
    }

    /// Counts a folder that another writer filled, by its path in this one.
    pub fn count(&mut self, name: String, bytes: u64) {
        self.report.files.push(HandedFile { name, bytes });
    }

    /// Notes something that the export does not contain, with the reason, in a sentence.
    pub fn leave_out(&mut self, what: impl Into<String>) {
        self.report.left_out.push(what.into());
    }

    /// Notes a fault of one photo, without which the others are exported.
    pub fn fail(&mut self, what: impl Into<String>) {
        self.report.failed.push(what.into());
    }

    /// Completes the export: all files have their names, and `handover.json` lists them. Files that were kept are noted.
    ///
    /// # Errors
    /// Returns [`Error::Io`].
    pub fn finish(mut self, task: &Task) -> Result<HandedOver> {
        let contents = to_json(&self.contents);
        self.written.hashes.insert(hash_bytes(&contents));
        self.commit()?;
        write_atomically(self.out.join(CONTENTS_FILE), &contents)?;
        for file in &self.report.spared {
            task.note(format!("{} was changed since it was exported and is kept", file.display()));
        }
        Ok(self.report)
    }

    /// Gives the pending files their names, after their hashes are on record: a file without a record would count as changed for ever.
    fn commit(&mut self) -> Result<()> {
        write_atomically(&self.record, &to_json(&self.written))?;
        self.pending.drain(..).try_for_each(AtomicFile::commit)
    }

    /// Finds the name for a file that is to have the content of `hash`: its own, or that with a number where the user changed the file;
    /// and whether the content is there already.
    fn free_name(&mut self, name: &str, hash: &str) -> Result<(String, bool)> {
        for number in 1u32.. {
            let name = if number == 1 { name.to_owned() } else { numbered(name, number) };
            let target = self.out.join(&name);
            if !target.try_exists().map_err(Error::io(&target, "look at it"))? {
                return Ok((name, false));
            }
            if target.is_file() {
                let found = hash_file(&target)?;
                if found == hash || self.written.hashes.contains(&found) {
                    return Ok((name, found == hash));
                }
            }
            self.report.spared.push(target);
        }
        Err(Error::Request(format!("{}: no free name for {name}", self.out.display())))
    }
}

/// Returns `scene-2.py` for `scene.py` and 2.
fn numbered(name: &str, number: u32) -> String {
    let start = name.rfind('/').map_or(0, |slash| slash + 1);
    match name[start..].rfind('.') {
        Some(dot) if dot > 0 => format!("{}-{number}{}", &name[..start + dot], &name[start + dot..]),
        _ => format!("{name}-{number}"),
    }
}

/// Reads what an earlier export wrote to `out`; nothing where there was none.
fn contents_of(out: &Path, written: &Written) -> Result<Contents> {
    let file = out.join(CONTENTS_FILE);
    if !file.exists() {
        return Ok(Contents { version: VERSION, ..Contents::default() });
    }
    if !written.hashes.contains(&hash_file(&file)?) {
        return Err(Error::Request(format!(
            "{}: this folder holds an export of another project, or its {CONTENTS_FILE} was changed; export to another folder, or \
             move this one away",
            out.display()
        )));
    }
    read_json(&file, LARGEST, "remove it, and export again")
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    const AS_IT_IS: Placement = Placement { frame_from_world: None, origin: DVec3::ZERO };

    struct Place {
        _folder: tempfile::TempDir,
        project: PathBuf,
        out: PathBuf,
    }

    fn place() -> Place {
        let folder = tempfile::tempdir().unwrap();
        let [project, out] = ["project", "out"].map(|name| folder.path().join(name));
        fs::create_dir(&project).unwrap();
        Place { _folder: folder, project, out }
    }

    impl Place {
        fn export(&self, files: &[(&str, &str)]) -> Result<HandedOver> {
            let mut folder =
                HandoverFolder::open(&self.project, &self.out, HandoverFormat::Cameras, &AS_IT_IS)?;
            for (name, content) in files {
                folder.write(name, content.as_bytes())?;
            }
            folder.finish(&Task::silent())
        }

        fn text(&self, name: &str) -> String {
            fs::read_to_string(self.out.join(name)).unwrap()
        }
    }

    #[test]
    fn a_file_that_nobody_changed_is_replaced() {
        let place = place();
        place.export(&[("a/scene.py", "one")]).unwrap();
        let again = place.export(&[("a/scene.py", "two")]).unwrap();
        assert_eq!((place.text("a/scene.py").as_str(), again.spared.len()), ("two", 0));
    }

    #[test]
    fn a_changed_file_is_kept_and_the_new_one_is_beside_it() {
        let place = place();
        place.export(&[("scene.py", "one")]).unwrap();
        fs::write(place.out.join("scene.py"), "mine").unwrap();
        for content in ["two", "three"] {
            let done = place.export(&[("scene.py", content)]).unwrap();
            assert_eq!(done.spared, [place.out.join("scene.py")]);
            assert_eq!(
                (place.text("scene.py").as_str(), place.text("scene-2.py").as_str()),
                ("mine", content)
            );
        }
    }

    #[test]
    fn a_folder_of_another_project_is_refused() {
        let (place, other) = (place(), place());
        place.export(&[("scene.py", "one")]).unwrap();
        let mut folder = other;
        folder.out = place.out.clone();
        let refused = folder.export(&[("scene.py", "two")]).unwrap_err();
        assert!(refused.to_string().contains("another project"), "{refused}");
        assert_eq!(place.text("scene.py"), "one");
    }

    #[test]
    fn the_same_export_gives_the_same_bytes_and_touches_nothing() {
        let place = place();
        place.export(&[("a", "one"), ("b", "two")]).unwrap();
        let times = || ["a", "b"].map(|name| place.out.join(name).metadata().unwrap().modified().unwrap());
        let (contents, before) = (place.text(CONTENTS_FILE), times());
        place.export(&[("a", "one"), ("b", "two")]).unwrap();
        assert_eq!((place.text(CONTENTS_FILE), times()), (contents, before));
    }

    #[test]
    fn numbers_come_before_the_ending() {
        let numbered = ["a.b/scene.py", "a.b/scene", ".hidden"].map(|name| numbered(name, 2));
        assert_eq!(numbered, ["a.b/scene-2.py", "a.b/scene-2", ".hidden-2"]);
    }
}
