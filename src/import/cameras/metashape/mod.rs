//! Metashape: the XML of *Export Cameras*, and projects (`.psx` with its folder `.files`).
//!
//! A chunk holds sensors with their calibrations, and cameras with a transform from the camera to the chunk, in our axes. The
//! world is that of the chunk's transform (rotation, translation, scale), times that of the camera's component, if they have
//! one. A camera without a transform is not aligned. Tie points are in binary files and are not read; markers are points with
//! observations. Source: Agisoft, *Metashape user manual*, appendix on camera models; the conventions were compared with files that Metashape wrote.

use std::path::Path;

use roxmltree::{Document, Node};

use super::assembly::Assembly;
use super::foreign_text::{children, parse_xml};
use super::format::CameraFormat;
use super::photo_name::short;
use super::recognise::{beginning, holds, recognised};
use super::reconstruction::ReconstructionFiles;
use archive::{Source, sources};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;

mod archive;
mod cameras;
mod markers;
mod sensor;
mod shutter;

#[cfg(test)]
mod tests;

/// The format.
pub(super) struct Metashape;

const REMEDY: &str = "export the cameras again: File, Export, Export Cameras, Agisoft XML";

impl CameraFormat for Metashape {
    fn accepted(&self) -> &'static str {
        "Metashape's .xml of Export Cameras, or its project .psx"
    }

    fn program(&self) -> &'static str {
        "Metashape"
    }

    fn kept_and_lost(&self) -> [&'static str; 2] {
        [
            "frame and fisheye lenses with b1, b2 and k4; chunk, component and scale; markers as points; rolling shutter with --rolling-shutter; not tried with the program itself, but with files that it wrote",
            "tie points; p3 and p4; rigs; panoramas; disabled cameras",
        ]
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["xml", "psx"]
    }

    fn has_chunks(&self) -> bool {
        true
    }

    fn of_file(&self, file: &Path) -> Option<Result<ReconstructionFiles>> {
        let beginning = beginning(file);
        if archive::is_project(&beginning) {
            return Some(archive::of_project(file));
        }
        is_export(&beginning).then(|| Ok(ReconstructionFiles::one(file)))
    }

    fn in_folder(&self, folder: &Path, names: &[String]) -> Option<Result<ReconstructionFiles>> {
        let exports = recognised(folder, names, ".xml", &["cameras.xml"], is_export);
        let projects = recognised(folder, names, ".psx", &[], archive::is_project);
        let mut files = match (exports.first(), projects.first()) {
            (Some(export), _) => Ok(ReconstructionFiles::one(export)),
            (None, Some(project)) => archive::of_project(project),
            (None, None) => return archive::of_folder(folder, names),
        };
        if let Ok(files) = &mut files {
            files.note_instead_of(&[exports, projects].concat()[1..]);
        }
        Some(files)
    }

    fn read(&self, files: &ReconstructionFiles, assembly: &mut Assembly<'_>, task: &Task) -> Result<()> {
        let sources = sources(files)?;
        let mut documents = Vec::with_capacity(sources.len());
        for (done, source) in sources.iter().enumerate() {
            task.step("read cameras", done as u64, sources.len() as u64)?;
            documents.push(parse_xml(&source.file, &source.text, REMEDY)?);
        }
        let mut chunks = Vec::new();
        for (source, document) in sources.iter().zip(&documents) {
            chunks.extend(chunks_in(document).map(|node| Chunk::new(source, node)));
        }
        let chunk = chosen(&files.images, &chunks, assembly)?;
        cameras::read(&files.images, chunk, assembly, task)
    }
}

/// Returns true for a document with a chunk.
fn is_export(beginning: &[u8]) -> bool {
    beginning.trim_ascii_start().first() == Some(&b'<')
        && holds(beginning, "<document")
        && (holds(beginning, "<chunk ") || holds(beginning, "<chunk>"))
}

/// Returns the chunks of a document, which may be one itself.
fn chunks_in<'a, 'i>(document: &'a Document<'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    let root = document.root_element();
    let below =
        children(root, "chunk").chain(children(root, "chunks").flat_map(|all| children(all, "chunk")));
    root.has_tag_name("chunk").then_some(root).into_iter().chain(below)
}

/// A chunk of a project.
struct Chunk<'a, 'i> {
    source: &'a Source,
    node: Node<'a, 'i>,
    label: &'a str,
    /// The numbers of all cameras, and of those that are aligned.
    cameras: [usize; 2],
}

impl<'a, 'i> Chunk<'a, 'i> {
    fn new(source: &'a Source, node: Node<'a, 'i>) -> Self {
        let label = node.attribute("label").unwrap_or("without a name");
        let cameras = cameras::cameras_in(node);
        let counts = cameras.fold([0; 2], |[all, aligned], camera| {
            [all + 1, aligned + usize::from(cameras::is_aligned(camera))]
        });
        Self { source, node, label, cameras: counts }
    }

    fn described(&self) -> String {
        let [all, aligned] = self.cameras;
        format!("{} ({aligned} of {all} cameras are aligned)", short(self.label))
    }
}

/// Chooses the chunk that the user named, or else the first of those with most aligned cameras, and tells of the others.
///
/// # Errors
/// [`Error::Input`] where there is no such chunk, or no camera in it is aligned.
fn chosen<'c, 'a, 'i>(
    file: &Path,
    chunks: &'c [Chunk<'a, 'i>],
    assembly: &mut Assembly<'_>,
) -> Result<&'c Chunk<'a, 'i>> {
    let listed = |chunks: &[Chunk<'_, '_>]| {
        let all: Vec<String> = chunks.iter().take(20).map(Chunk::described).collect();
        all.join(", ")
    };
    let chunk = match &assembly.options().chunk {
        Some(name) => {
            let mut named = chunks.iter().filter(|chunk| chunk.label == name);
            let chunk = named.next().ok_or_else(|| {
                let found = format!("there is no chunk {}; there are {}", short(name), listed(chunks));
                Error::input(file, "", found, "name one of them, with its upper and lower case")
            })?;
            if named.next().is_some() {
                let (file, name) = (file.display(), short(name));
                assembly.note(format!("{file}: several chunks are called {name}; the first is read"));
            }
            chunk
        }
        None => {
            let most = chunks.iter().map(|chunk| chunk.cameras[1]).max().unwrap_or(0);
            let chunk = chunks.iter().find(|chunk| chunk.cameras[1] == most);
            chunk.ok_or_else(|| Error::input(file, "", "it has no chunk with cameras", REMEDY))?
        }
    };
    let [all, aligned] = chunk.cameras;
    if aligned == 0 {
        let found = match all {
            0 => format!("the chunk {} is empty", short(chunk.label)),
            _ => format!("none of the {all} cameras of the chunk {} is aligned", short(chunk.label)),
        };
        return Err(Error::input(
            file,
            "",
            found,
            "align the photos in Metashape, and export the cameras again",
        ));
    }
    if chunks.len() > 1 {
        let (file, used, all) = (file.display(), short(chunk.label), listed(chunks));
        assembly.note(format!(
            "{file}: the chunk {used} is read, of {all}; --chunk NAME of `new`, or \"chunk\" in project.json, chooses another"
        ));
    }
    Ok(chunk)
}
