//! The files of a Metashape project: `site.psx` names `site.files/project.zip`, that the archives of the chunks, and each of
//! them those of its frames, the first of which holds the paths of the photos and the places of the markers.

use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use zip::ZipArchive;

use super::super::foreign_text::{checked_text, child, children, parse_xml, read_text};
use super::super::recognise::{beginning, holds};
use super::super::reconstruction::ReconstructionFiles;
use super::REMEDY;
use quadratura_base::error::{Error, Result};

/// The largest document in an archive, in bytes.
const LARGEST: u64 = 256 << 20;
/// The most chunks of a project.
const MOST_CHUNKS: usize = 1000;
const EXPECTED: &str = "expected XML of Metashape";

/// The text of a chunk, or of a document with chunks.
pub(super) struct Source {
    /// The file that it is in.
    pub file: PathBuf,
    /// The XML.
    pub text: String,
    /// The archive of the chunk's first frame.
    pub frame: Option<PathBuf>,
}

/// Returns true for the beginning of a `.psx`.
pub(super) fn is_project(beginning: &[u8]) -> bool {
    beginning.trim_ascii_start().first() == Some(&b'<')
        && holds(beginning, "<document")
        && holds(beginning, "project.zip")
}

/// Finds the files of the project that a `.psx` names.
///
/// # Errors
/// [`Error::Input`] where the folder of its files is not beside it.
pub(super) fn of_project(file: &Path) -> Result<ReconstructionFiles> {
    let text = String::from_utf8_lossy(&beginning(file)).into_owned();
    let document = parse_xml(file, &text, REMEDY)?;
    let named = document.root_element().attribute("path").unwrap_or_default();
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let named = named.replace("{projectname}", &stem).replace('\\', "/");
    let project = below(file.parent().unwrap_or(Path::new("")), &named);
    let project = project.filter(|project| project.is_file()).ok_or_else(|| {
        let found = format!("{named} is not beside it, which holds the contents of the project");
        Error::input(
            file,
            "",
            found,
            "copy the folder .files together with the .psx, or export the cameras as XML",
        )
    })?;
    Ok(ReconstructionFiles { others: archives(&project), ..ReconstructionFiles::one(file) })
}

/// Finds the files of a project in its folder `.files`.
pub(super) fn of_folder(folder: &Path, names: &[String]) -> Option<Result<ReconstructionFiles>> {
    let is_one = folder.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("files"));
    if !is_one || !names.iter().any(|name| name == "project.zip") {
        return None;
    }
    let project = folder.join("project.zip");
    Some(Ok(ReconstructionFiles { others: archives(&project), ..ReconstructionFiles::one(&project) }))
}

/// Lists the archive of a project, those of its chunks, and those of their frames where they usually are: the documents of chunks are too
/// large to be read for a list. What cannot be read is told by [`sources`].
fn archives(project: &Path) -> Vec<PathBuf> {
    let mut all = vec![project.to_path_buf()];
    for chunk in chunks_of(project).unwrap_or_default() {
        let frame = chunk.with_file_name("0").join("frame.zip");
        all.push(chunk);
        all.extend(frame.is_file().then_some(frame));
    }
    all
}

/// Reads the documents with chunks: the file itself, or those in the archives of a project.
///
/// # Errors
/// [`Error::Input`] and [`Error::Io`] for what cannot be read.
pub(super) fn sources(files: &ReconstructionFiles) -> Result<Vec<Source>> {
    let Some(project) = files.others.first() else {
        let text = read_text(&files.images, EXPECTED, REMEDY)?;
        return Ok(vec![Source { file: files.images.clone(), text, frame: None }]);
    };
    let mut sources = Vec::new();
    for file in chunks_of(project)? {
        let text = document_of(&file)?;
        let frame = frame_of(&file, &text)?.filter(|frame| frame.is_file());
        sources.push(Source { file, text, frame });
    }
    Ok(sources)
}

/// Lists the archives of a project's chunks.
fn chunks_of(project: &Path) -> Result<Vec<PathBuf>> {
    let text = document_of(project)?;
    let document = parse_xml(project, &text, REMEDY)?;
    let chunks = children(document.root_element(), "chunks").flat_map(|all| children(all, "chunk"));
    let named = chunks.filter_map(|chunk| below(project.parent()?, chunk.attribute("path")?));
    Ok(named.take(MOST_CHUNKS).collect())
}

/// Returns the archive of a chunk's first frame.
fn frame_of(chunk: &Path, text: &str) -> Result<Option<PathBuf>> {
    let document = parse_xml(chunk, text, REMEDY)?;
    let frame = child(document.root_element(), "frames").and_then(|frames| child(frames, "frame"));
    Ok(frame.and_then(|frame| below(chunk.parent()?, frame.attribute("path")?)))
}

/// Joins a path that an archive names; `None` for one that leads out of the folder.
fn below(folder: &Path, path: &str) -> Option<PathBuf> {
    let path = Path::new(path);
    let is_below = path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    (is_below && !path.as_os_str().is_empty()).then(|| folder.join(path))
}

/// Reads `doc.xml` of an archive.
///
/// # Errors
/// [`Error::Io`] when the archive cannot be opened; [`Error::Input`] when it is damaged, or its document is too large.
pub(super) fn document_of(archive: &Path) -> Result<String> {
    let file = File::open(archive).map_err(Error::io(archive, "read it"))?;
    let damaged = |found: String| {
        Error::input(archive, "doc.xml", found, "save the project again, or export the cameras as XML")
    };
    let mut zip = ZipArchive::new(file).map_err(|error| damaged(error.to_string()))?;
    let entry = zip.by_name("doc.xml").map_err(|error| damaged(error.to_string()))?;
    let mut bytes = Vec::new();
    // The size that the archive states may be wrong.
    entry.take(LARGEST + 1).read_to_end(&mut bytes).map_err(|error| damaged(error.to_string()))?;
    if bytes.len() as u64 > LARGEST {
        return Err(damaged(format!("more than the {LARGEST} bytes that such a document may have")));
    }
    checked_text(archive, bytes, EXPECTED, REMEDY)
}
