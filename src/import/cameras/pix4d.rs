//! Pix4D's `*_calibrated_camera_parameters.txt`: eight lines of explanation, then ten lines per photo.
//!
//! ```text
//! NAME WIDTH HEIGHT
//! K                     three rows
//! R1 R2 R3              radial coefficients
//! T1 T2                 tangential ones, in OpenCV's order
//! t                     the camera in the world
//! R                     three rows, world to camera: x right, y down, z forward
//! ```
//!
//! Positions are less the offset in `*_offset.xyz` beside it, as they are in the meshes that the program writes. Source: Pix4D, *How are the
//! internal and external camera parameters defined?*, and the header of the file. Not tried with the program itself.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::assembly::Assembly;
use super::foreign_text::{number, numbers, read_text};
use super::format::CameraFormat;
use super::lines::LineReader;
use super::photo_name::short;
use super::photo_paths::{Without, photo_paths};
use super::pose::{of_rows, pose_at};
use super::raw::RawCamera;
use super::recognise::{beginning, holds, recognised};
use super::reconstruction::ReconstructionFiles;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Lens, Pose};
use quadratura_base::task::Task;
use quadratura_files::text::Objection;

/// The format.
pub(super) struct Pix4d;

/// The last line of the explanation.
const MODEL: &str = "camera model m = K [R|-Rt] X";
const FIRST: &str = "fileName imageWidth imageHeight";
const ENDING: &str = "_calibrated_camera_parameters.txt";
const OFFSET: &str = "_offset.xyz";
const REMEDY: &str =
    "copy the file from 1_initial/params of the project again; it may be cut short or damaged";

impl CameraFormat for Pix4d {
    fn accepted(&self) -> &'static str {
        "Pix4D's ..._calibrated_camera_parameters.txt"
    }

    fn program(&self) -> &'static str {
        "Pix4D"
    }

    fn folders(&self) -> &'static [&'static str] {
        &["", "1_initial/params", "params"]
    }

    fn kept_and_lost(&self) -> [&'static str; 2] {
        [
            "perspective lenses; not tried with the program itself",
            "points; the offset, which is told; fisheye lenses, rigs",
        ]
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["txt"]
    }

    fn of_file(&self, file: &Path) -> Option<Result<ReconstructionFiles>> {
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        (name.ends_with(ENDING) || is_one(&beginning(file))).then(|| Ok(with_offset(file)))
    }

    fn in_folder(&self, folder: &Path, names: &[String]) -> Option<Result<ReconstructionFiles>> {
        let found = recognised(folder, names, ".txt", &[], is_one);
        let mut files = with_offset(found.first()?);
        files.note_instead_of(&found[1..]);
        Some(Ok(files))
    }

    fn read(&self, files: &ReconstructionFiles, assembly: &mut Assembly<'_>, task: &Task) -> Result<()> {
        let file = &files.images;
        let entries = entries(file, task)?;
        let names: Vec<&str> = entries.iter().map(|entry| entry.name.as_str()).collect();
        let folder = file.parent().unwrap_or(Path::new("")).to_path_buf();
        for (entry, named) in entries.iter().zip(photo_paths(&names, &[folder], Without::Any)) {
            assembly.photo(entry.place.clone(), &named.name, entry.camera.clone(), entry.pose.clone());
        }
        for offset in &files.others {
            note_offset(offset, assembly);
        }
        Ok(())
    }
}

fn is_one(beginning: &[u8]) -> bool {
    holds(beginning, FIRST) || holds(beginning, MODEL)
}

/// Returns the file with the offset beside it, where there is one.
fn with_offset(file: &Path) -> ReconstructionFiles {
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let offset = name.strip_suffix(ENDING).map(|project| file.with_file_name(format!("{project}{OFFSET}")));
    let others: Vec<PathBuf> = offset.into_iter().filter(|offset| offset.is_file()).collect();
    ReconstructionFiles { others, ..ReconstructionFiles::one(file) }
}

fn note_offset(file: &Path, assembly: &mut Assembly<'_>) {
    let read = read_text(file, "expected three numbers", REMEDY);
    match read.map(|text| numbers::<3>(&text, "the offset")) {
        Ok(Ok([x, y, z])) => assembly.note(format!(
            "{}: positions are those of the project less {x}, {y}, {z}, as in the meshes that Pix4D writes; `quadratura frame --crs \
             EPSG:N --offset {x} {y} {z}` keeps it for maps",
            file.display()
        )),
        Ok(Err(objection)) => assembly.problem(file, String::new(), objection),
        Err(error) => assembly.note(format!("{error}")),
    }
}

/// What the lines of a photo say.
struct Entry {
    place: String,
    name: String,
    camera: Result<RawCamera, Objection>,
    pose: Result<Pose, Objection>,
}

fn entries(file: &Path, task: &Task) -> Result<Vec<Entry>> {
    let mut lines = LineReader::open(file)?;
    let mut entries = Vec::new();
    let mut explained = false;
    while lines.next_line("read cameras", task)? {
        let head = lines.text().into_owned();
        // The explanation ends with the camera model; a file without it begins with a photo.
        explained |= head.trim() == MODEL;
        if head.trim() == MODEL || (!explained && size_of(&head).is_none()) {
            continue;
        }
        let place = lines.place();
        let Some((name, size)) = size_of(&head) else {
            let found = format!("{}, expected a photo: name, width, height", short(&head));
            return Err(Error::input(file, place, found, REMEDY));
        };
        let mut rows = Vec::with_capacity(9);
        for row in 0..9 {
            if !lines.next_line("read cameras", task)? {
                let found = format!("the file ends after {row} of the 9 lines of {}", short(&name));
                return Err(Error::input(file, lines.place(), found, REMEDY));
            }
            rows.push(lines.text().into_owned());
        }
        let (camera, pose) = (camera(size, &rows), pose(&rows));
        entries.push(Entry { place, name, camera, pose });
    }
    if entries.is_empty() {
        return Err(Error::input(file, "", "it has no photo", REMEDY));
    }
    Ok(entries)
}

/// Returns name and size of a photo's first line; names may hold spaces.
fn size_of(line: &str) -> Option<(String, [u64; 2])> {
    let (rest, height) = line.trim().rsplit_once(char::is_whitespace)?;
    let (name, width) = rest.trim_end().rsplit_once(char::is_whitespace)?;
    let name = name.trim();
    (!name.is_empty()).then_some((name.to_owned(), [width.parse().ok()?, height.parse().ok()?]))
}

fn camera(size: [u64; 2], rows: &[String]) -> Result<RawCamera, Objection> {
    let [fx, skew, cx] = numbers(&rows[0], "the first row of K")?;
    let [zero, fy, cy] = numbers(&rows[1], "the second row of K")?;
    if numbers::<3>(&rows[2], "the third row of K")? != [0.0, 0.0, 1.0] || zero != 0.0 {
        return Err(("K is no matrix of intrinsics".into(), "only perspective lenses are read"));
    }
    if skew != 0.0 {
        return Err((format!("K has a skew of {skew}"), "calibrate without"));
    }
    let [k1, k2, k3] = numbers(&rows[3], "the radial distortion")?;
    let mut tangential = rows[4].split_whitespace();
    let mut next = |what: &str| tangential.next().map_or(Ok(0.0), |text| number(text, what));
    let p = [next("T1")?, next("T2")?];
    Ok(RawCamera {
        size,
        focal: [fx, fy],
        centre: [cx, cy],
        lens: Lens::Brown { k: [k1, k2, k3, 0.0, 0.0, 0.0], p },
    })
}

fn pose(rows: &[String]) -> Result<Pose, Objection> {
    let centre: [f64; 3] = numbers(&rows[5], "the position")?;
    let rotation: [f64; 9] = numbers(&rows[6..9].join(" "), "the rotation")?;
    pose_at(of_rows(&rotation), DVec3::from(centre))
}
