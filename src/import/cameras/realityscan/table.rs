//! The table of *Internal/External camera parameters*: a line a photo, with the camera in the world (x, y, alt), its heading, pitch and
//! roll in degrees, and its intrinsics. Camera to world, in OpenGL's axes, is Rz(-heading) Rx(pitch) Ry(roll).

use std::path::Path;

use glam::{DMat3, DVec3};

use super::super::assembly::Assembly;
use super::super::foreign_text::number;
use super::super::format::CameraFormat;
use super::super::lines::LineReader;
use super::super::photo_name::short;
use super::super::photo_paths::{Without, photo_paths};
use super::super::pose::{CV_FROM_GL, pose_at};
use super::super::recognise::{beginning, recognised};
use super::super::reconstruction::ReconstructionFiles;
use super::{Intrinsics, tangential_note};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Pose;
use quadratura_base::task::Task;
use quadratura_files::text::Objection;

/// The format.
pub(in super::super) struct RealityTable;

/// The columns without which there are no cameras.
const NEEDED: [&str; 7] = ["x", "y", "alt", "heading", "pitch", "roll", "f"];
const REMEDY: &str = "export Internal/External camera parameters, with all columns";

impl CameraFormat for RealityTable {
    fn accepted(&self) -> &'static str {
        "RealityScan's .csv of Internal/External camera parameters"
    }

    fn program(&self) -> &'static str {
        "RealityScan"
    }

    fn kept_and_lost(&self) -> [&'static str; 2] {
        ["Brown's lens with k1 to k4, t1, t2; not tried with the program itself", "points"]
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["csv"]
    }

    fn of_file(&self, file: &Path) -> Option<Result<ReconstructionFiles>> {
        is_one(&beginning(file)).then(|| Ok(ReconstructionFiles::one(file)))
    }

    fn in_folder(&self, folder: &Path, names: &[String]) -> Option<Result<ReconstructionFiles>> {
        let found = recognised(folder, names, ".csv", &[], is_one);
        ReconstructionFiles::first_of(&found).map(Ok)
    }

    fn read(&self, files: &ReconstructionFiles, assembly: &mut Assembly<'_>, task: &Task) -> Result<()> {
        let file = &files.images;
        let mut lines = LineReader::open(file)?;
        let mut columns: Option<Vec<String>> = None;
        let mut rows = Vec::new();
        while lines.next_line("read poses", task)? {
            let line = lines.text();
            match &columns {
                None => columns = columns_of(&line),
                Some(_) if line.starts_with('#') => (),
                Some(columns) => {
                    let fields = split(&line);
                    match fields.first().filter(|_| fields.len() == columns.len()) {
                        Some(name) => rows.push((lines.place(), (*name).to_owned(), row(columns, &fields))),
                        None => {
                            let found = format!("{} fields, expected {}", fields.len(), columns.len());
                            assembly.refused_photo(lines.place(), (found, REMEDY));
                        }
                    }
                }
            }
        }
        let columns = columns.ok_or_else(|| {
            Error::input(file, "", "no line names the columns, expected #name,x,y,alt,...", REMEDY)
        })?;
        if let Some(missing) = NEEDED.iter().find(|needed| !columns.iter().any(|column| column == *needed)) {
            return Err(Error::input(file, "", format!("it has no column {missing}"), REMEDY));
        }
        let names: Vec<&str> = rows.iter().map(|(_, name, _)| name.as_str()).collect();
        let folder = file.parent().unwrap_or(Path::new("")).to_path_buf();
        let photos = photo_paths(&names, &[folder], Without::Any);
        let sizes = assembly.sizes(&photos, task)?;
        let mut tangential = 0;
        for (((place, _, row), photo), size) in rows.into_iter().zip(&photos).zip(sizes) {
            let (camera, pose) = match row {
                Ok((intrinsics, pose)) => {
                    tangential += usize::from(intrinsics.has_tangential());
                    (size.and_then(|size| intrinsics.camera(size)), pose)
                }
                Err(objection) => (Err(objection.clone()), Err(objection)),
            };
            assembly.photo(place, &photo.name, camera, pose);
        }
        tangential_note(file, tangential).into_iter().for_each(|note| assembly.note(note));
        Ok(())
    }
}

/// Returns true for a text with a line that names the columns.
fn is_one(beginning: &[u8]) -> bool {
    let text = String::from_utf8_lossy(beginning);
    text.lines().take(4).find_map(columns_of).is_some_and(|columns| {
        ["heading", "pitch", "roll"].iter().all(|needed| columns.iter().any(|column| column == needed))
    })
}

/// Returns the names of columns, if a line has them.
fn columns_of(line: &str) -> Option<Vec<String>> {
    let line = line.trim().trim_start_matches('#');
    let columns: Vec<String> = split(line).iter().map(|name| name.to_lowercase()).collect();
    (columns.len() > 6 && columns[0] == "name").then_some(columns)
}

fn split(line: &str) -> Vec<&str> {
    let separator = if line.contains(';') && !line.contains(',') { ';' } else { ',' };
    line.split(separator).map(|field| field.trim().trim_matches('"')).collect()
}

type Row = (Intrinsics, Result<Pose, Objection>);

fn row(columns: &[String], fields: &[&str]) -> Result<Row, Objection> {
    let value = |name: &str| {
        let column = columns.iter().position(|column| column == name);
        column.map_or(Ok(0.0), |column| number(fields[column], name))
    };
    let mut coefficients = [0.0; 6];
    for (to, name) in coefficients.iter_mut().zip(["k1", "k2", "k3", "k4", "t1", "t2"]) {
        *to = value(name)?;
    }
    let principal = [value("px")?, value("py")?];
    if principal.iter().any(|part| part.abs() > 10.0) {
        let found =
            format!("a principal point {} longer sides off the middle", short(&format!("{principal:?}")));
        return Err((found, "px and py are parts of the longer side; export the table again"));
    }
    let (model, focal_mm) = (String::new(), value("f")?);
    let intrinsics = Intrinsics { focal_mm, aspect: 1.0, principal, model, coefficients };
    let [heading, pitch, roll] = [value("heading")?, value("pitch")?, value("roll")?].map(f64::to_radians);
    let world_from_gl =
        DMat3::from_rotation_z(-heading) * DMat3::from_rotation_x(pitch) * DMat3::from_rotation_y(roll);
    let centre = DVec3::new(value("x")?, value("y")?, value("alt")?);
    Ok((intrinsics, pose_at(CV_FROM_GL * world_from_gl.transpose(), centre)))
}
