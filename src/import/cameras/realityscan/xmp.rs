//! A file `.xmp` beside each photo: `Rotation`, world to camera by rows, and `Position`, the camera in the world; each value is an
//! attribute or an element.

use std::path::{Path, PathBuf};

use glam::DVec3;
use roxmltree::{Document, Node};

use super::super::assembly::Assembly;
use super::super::foreign_text::{number, numbers, parse_xml, read_text};
use super::super::format::CameraFormat;
use super::super::photo_paths::{Without, photo_paths};
use super::super::pose::{of_rows, pose_at};
use super::super::recognise::{beginning, folder_of, holds, recognised};
use super::super::reconstruction::ReconstructionFiles;
use super::{Intrinsics, tangential_note};
use quadratura_base::error::Result;
use quadratura_base::geometry::Pose;
use quadratura_base::task::Task;
use quadratura_files::text::Objection;

/// The format.
pub(in super::super) struct RealityXmp;

const MARK: &str = "capturingreality.com/ns/xcr";
const REMEDY: &str = "export the metadata (XMP) of the photos again";

impl CameraFormat for RealityXmp {
    fn accepted(&self) -> &'static str {
        "RealityScan's .xmp files beside the photos"
    }

    fn program(&self) -> &'static str {
        "RealityScan"
    }

    fn kept_and_lost(&self) -> [&'static str; 2] {
        [
            "Brown's and division lenses; not tried with the program itself",
            "skew; points; photos in folders below",
        ]
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["xmp"]
    }

    fn of_file(&self, file: &Path) -> Option<Result<ReconstructionFiles>> {
        if !is_one(&beginning(file)) {
            return None;
        }
        let (folder, names) = folder_of(file);
        Some(Ok(all(folder, &names)))
    }

    fn in_folder(&self, folder: &Path, names: &[String]) -> Option<Result<ReconstructionFiles>> {
        let found = recognised(folder, names, ".xmp", &[], is_one);
        (!found.is_empty()).then(|| Ok(all(folder, names)))
    }

    fn read(&self, files: &ReconstructionFiles, assembly: &mut Assembly<'_>, task: &Task) -> Result<()> {
        let folder = files.images.parent().unwrap_or(Path::new("")).to_path_buf();
        let (mut photos, mut without, mut skewed, mut tangential) = (Vec::new(), 0, 0, 0);
        for (done, file) in files.others.iter().enumerate() {
            task.step("read poses", done as u64, files.others.len() as u64)?;
            // Other programs write files of this name, too.
            if !is_one(&beginning(file)) {
                continue;
            }
            match read_text(file, "expected XMP", REMEDY).and_then(|text| photo(file, &text)) {
                Ok(None) => without += 1,
                Ok(Some(photo)) => photos.push((file, photo)),
                Err(error) => assembly.refused_file(error),
            }
        }
        let stems: Vec<String> = photos.iter().map(|(file, _)| stem(file)).collect();
        let stems: Vec<&str> = stems.iter().map(String::as_str).collect();
        let named = photo_paths(&stems, &[folder], Without::Any);
        let sizes = assembly.sizes(&named, task)?;
        for (((file, photo), named), size) in photos.into_iter().zip(&named).zip(sizes) {
            if let Ok((intrinsics, has_skew)) = &photo.intrinsics {
                skewed += usize::from(*has_skew);
                tangential += usize::from(intrinsics.has_tangential());
            }
            let camera = photo.intrinsics.and_then(|(intrinsics, _)| intrinsics.camera(size?));
            let place = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
            assembly.photo(place, &named.name, camera, photo.pose);
        }
        let file = files.images.display();
        if without > 0 {
            assembly.note(format!(
                "{file}: {without} files beside it have no pose: these photos are not aligned"
            ));
        }
        if skewed > 0 {
            assembly.note(format!("{file}: {skewed} photos have a skew, which is not read"));
        }
        tangential_note(&files.images, tangential).into_iter().for_each(|note| assembly.note(note));
        Ok(())
    }
}

fn is_one(beginning: &[u8]) -> bool {
    holds(beginning, MARK)
}

/// Returns all files of the folder with this ending; those of other programs are sorted out when they are read.
fn all(folder: &Path, names: &[String]) -> ReconstructionFiles {
    let is_xmp = |name: &&String| name.to_lowercase().ends_with(".xmp");
    let others: Vec<PathBuf> = names.iter().filter(is_xmp).map(|name| folder.join(name)).collect();
    let first = others.iter().find(|file| is_one(&beginning(file))).or(others.first());
    let first = first.cloned().unwrap_or_else(|| folder.to_path_buf());
    ReconstructionFiles { others, ..ReconstructionFiles::one(&first) }
}

/// Returns the name of the photo beside a file, without its ending.
fn stem(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// What a file says of its photo; the flag is for a skew.
struct PhotoOfXmp {
    intrinsics: Result<(Intrinsics, bool), Objection>,
    pose: Result<Pose, Objection>,
}

fn photo(file: &Path, text: &str) -> Result<Option<PhotoOfXmp>> {
    let document = parse_xml(file, text, REMEDY)?;
    let (Some(rotation), Some(position)) = (value(&document, "Rotation"), value(&document, "Position"))
    else {
        return Ok(None);
    };
    let pose = numbers::<9>(rotation, "Rotation")
        .and_then(|rows| pose_at(of_rows(&rows), DVec3::from(numbers::<3>(position, "Position")?)));
    Ok(Some(PhotoOfXmp { intrinsics: intrinsics(&document), pose }))
}

fn intrinsics(document: &Document<'_>) -> Result<(Intrinsics, bool), Objection> {
    let or = |name: &str, usual: f64| value(document, name).map_or(Ok(usual), |text| number(text, name));
    let focal = value(document, "FocalLength35mm").ok_or_else(|| {
        ("it has no FocalLength35mm".to_owned(), "export the metadata with the calibration")
    })?;
    // The program's own spelling.
    let coefficients =
        value(document, "DistortionCoeficients").or_else(|| value(document, "DistortionCoefficients"));
    let intrinsics = Intrinsics {
        focal_mm: number(focal, "FocalLength35mm")?,
        aspect: or("AspectRatio", 1.0)?,
        principal: [or("PrincipalPointU", 0.0)?, or("PrincipalPointV", 0.0)?],
        model: value(document, "DistortionModel").unwrap_or_default().trim().to_owned(),
        coefficients: coefficients.map_or(Ok([0.0; 6]), |text| numbers(text, "DistortionCoeficients"))?,
    };
    Ok((intrinsics, or("Skew", 0.0)? != 0.0))
}

/// Returns a value of the program, an attribute or an element.
fn value<'a>(document: &'a Document<'_>, name: &str) -> Option<&'a str> {
    let is_own = |space: Option<&str>| space.is_some_and(|space| space.contains(MARK));
    let of_node = |node: Node<'a, '_>| -> Option<&'a str> {
        let tag = node.tag_name();
        if tag.name() == name && is_own(tag.namespace()) {
            return node.text();
        }
        let own = |it: &roxmltree::Attribute<'a, '_>| it.name() == name && is_own(it.namespace());
        node.attributes().find(own).map(|it| it.value())
    };
    document.descendants().filter(|node| node.is_element()).find_map(of_node)
}
