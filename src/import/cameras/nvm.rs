//! VisualSFM's `.nvm`, which COLMAP writes, too.
//!
//! A photo has its name, a focal length, a quaternion w x y z, world to camera, the camera's centre, and a coefficient r: the undistorted
//! place is the measured one times 1 + r d^2, with the distance d from the middle in focal lengths. Measurements are from the middle.
//! COLMAP writes r = -k of its own model, which acts the other way round, and measurements from the corner. Which of these a file has is
//! decided by its observations, and told. Source: VisualSFM, *Documentation*; the convention was compared with a file that COLMAP wrote.

use std::path::Path;

use glam::{DVec2, DVec3};

use super::assembly::Assembly;
use super::foreign_text::{number, numbers};
use super::format::CameraFormat;
use super::kept::CameraPhoto;
use super::lines::LineReader;
use super::photo_name::short;
use super::photo_paths::{Without, photo_paths};
use super::pose::{pose_at, pose_of_quaternion};
use super::raw::RawCamera;
use super::recognise::{beginning, recognised};
use super::reconstruction::ReconstructionFiles;
use super::reprojection::Reprojection;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Lens, Pinhole, Pose};
use quadratura_base::scene::SparsePoint;
use quadratura_base::task::Task;
use quadratura_files::text::Objection;

/// The format.
pub(super) struct Nvm;

const MARK: &[u8] = b"NVM_V3";
const CUT: &str = "save the file again; it is cut short or damaged";
/// The most photos and points that a file may announce before they are there.
const MOST: u64 = 100_000_000;

impl CameraFormat for Nvm {
    fn accepted(&self) -> &'static str {
        "VisualSFM's .nvm"
    }

    fn program(&self) -> &'static str {
        "VisualSFM"
    }

    fn kept_and_lost(&self) -> [&'static str; 2] {
        [
            "focal length and r; points with observations; not tried with the program itself, but with a file of COLMAP",
            "all models but the first",
        ]
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["nvm"]
    }

    fn of_file(&self, file: &Path) -> Option<Result<ReconstructionFiles>> {
        is_one(&beginning(file)).then(|| Ok(ReconstructionFiles::one(file)))
    }

    fn in_folder(&self, folder: &Path, names: &[String]) -> Option<Result<ReconstructionFiles>> {
        let found = recognised(folder, names, ".nvm", &[], is_one);
        ReconstructionFiles::first_of(&found).map(Ok)
    }

    fn read(&self, files: &ReconstructionFiles, assembly: &mut Assembly<'_>, task: &Task) -> Result<()> {
        let file = &files.images;
        let mut lines = LineReader::open(file)?;
        // The first line may fix the intrinsics, which every photo has as well, but for the principal point.
        lines.next_line("read cameras", task)?;
        let fixed = fixed_centre(&lines.text());
        let mut photos = Vec::new();
        for index in 0..count(&mut lines, "photos", task)? {
            if !lines.next_line("read cameras", task)? {
                return Err(ends(&lines, &format!("photo {index}")));
            }
            photos.push((lines.place(), photo(&lines.text())));
        }
        let mut points = Vec::new();
        for index in 0..count(&mut lines, "points", task)? {
            if !lines.next_line("read points", task)? {
                return Err(ends(&lines, &format!("point {index}")));
            }
            points.push((lines.place(), point(&lines.text(), photos.len())));
        }
        if lines.next_line("read points", task)? && lines.text().parse::<u64>().is_ok_and(|more| more > 0) {
            assembly.note(format!("{}: the first of several models in it is read", file.display()));
        }
        take(file, photos, points, fixed, assembly, task)
    }
}

fn is_one(beginning: &[u8]) -> bool {
    beginning.trim_ascii_start().starts_with(MARK)
}

/// Returns the principal point of a first line `NVM_V3 FixedK fx cx fy cy`, from the middle or the corner.
fn fixed_centre(line: &str) -> Option<[f64; 2]> {
    let fields: Vec<&str> = line.split_ascii_whitespace().collect();
    let at = fields.iter().position(|field| *field == "FixedK")?;
    Some([fields.get(at + 2)?.parse().ok()?, fields.get(at + 4)?.parse().ok()?])
}

fn ends(lines: &LineReader<'_>, what: &str) -> Error {
    Error::input(lines.path, lines.place(), format!("the file ends before {what}"), CUT)
}

fn count(lines: &mut LineReader<'_>, what: &str, task: &Task) -> Result<u64> {
    if !lines.next_line("read cameras", task)? {
        return Err(ends(lines, &format!("the number of {what}")));
    }
    let text = lines.text();
    text.parse().ok().filter(|count| *count <= MOST).ok_or_else(|| {
        let found = format!("{} where the number of {what} should be", short(&text));
        Error::input(lines.path, lines.place(), found, CUT)
    })
}

/// A photo as its line has it.
struct NvmPhoto {
    name: String,
    focal: f64,
    r: f64,
    pose: Result<Pose, Objection>,
}

/// Reads `name f w x y z cx cy cz r 0`; the name may hold spaces where a tab ends it, and has `"` in their place elsewhere.
fn photo(line: &str) -> Result<NvmPhoto, Objection> {
    let (name, rest) = line
        .split_once('\t')
        .or_else(|| line.split_once(' '))
        .ok_or_else(|| (format!("{}, expected a photo", short(line)), CUT))?;
    let values: Vec<&str> = rest.split_ascii_whitespace().take(9).collect();
    let [focal, w, x, y, z, a, b, c, r] = numbers(&values.join(" "), "the line")?;
    let turn = pose_of_quaternion([w, x, y, z], [0.0; 3]);
    let pose = turn.and_then(|turn| pose_at(turn.rotation, DVec3::new(a, b, c)));
    Ok(NvmPhoto { name: name.replace('"', " "), focal, r, pose })
}

/// A point as its line has it, with places in photos by their index.
struct NvmPoint {
    position: DVec3,
    seen: Vec<(usize, DVec2)>,
}

/// Reads `x y z r g b n`, then n times `photo feature x y`.
fn point(line: &str, photos: usize) -> Result<NvmPoint, Objection> {
    let fields: Vec<&str> = line.split_ascii_whitespace().collect();
    if fields.len() < 7 {
        return Err((format!("{} fields, expected a point", fields.len()), CUT));
    }
    let position = DVec3::from(numbers::<3>(&fields[..3].join(" "), "the position")?);
    let mut seen = Vec::new();
    for places in fields[7..].chunks_exact(4) {
        let photo = places[0].parse::<usize>().ok().filter(|photo| *photo < photos);
        let photo = photo
            .ok_or_else(|| (format!("{} where one of {photos} photos should be", short(places[0])), CUT))?;
        seen.push((photo, DVec2::new(number(places[2], "x")?, number(places[3], "y")?)));
    }
    Ok(NvmPoint { position, seen })
}

/// The two ways in which programs write the file: the lens of a coefficient, and where measurements are counted from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct LensReading {
    forward: bool,
    from_corner: bool,
}

impl LensReading {
    /// As VisualSFM writes it, which is what holds where nothing is observed.
    const OF_VISUALSFM: Self = Self { forward: false, from_corner: false };
    const ALL: [Self; 4] = [
        Self::OF_VISUALSFM,
        Self { forward: true, from_corner: true },
        Self { forward: true, from_corner: false },
        Self { forward: false, from_corner: true },
    ];

    fn lens(self, r: f64) -> Lens {
        match self.forward {
            _ if r == 0.0 => Lens::None,
            true => Lens::Brown { k: [-r, 0.0, 0.0, 0.0, 0.0, 0.0], p: [0.0; 2] },
            false => Lens::Reverse { k: r },
        }
    }

    fn camera(self, photo: &NvmPhoto, size: [u64; 2], fixed: Option<[f64; 2]>) -> RawCamera {
        let middle = size.map(|side| 0.5 * side as f64);
        let centre = match fixed {
            // From the corner it is near the middle, from the middle near 0.
            Some(centre) if centre[0] > 0.5 * middle[0] => centre,
            Some(centre) => [middle[0] + centre[0], middle[1] + centre[1]],
            None => middle,
        };
        RawCamera { size, focal: [photo.focal; 2], centre, lens: self.lens(photo.r) }
    }

    fn place(self, at: DVec2, size: [u64; 2]) -> DVec2 {
        let middle = 0.5 * DVec2::new(size[0] as f64, size[1] as f64);
        if self.from_corner { at } else { at + middle }
    }
}

type CameraLine<T> = (String, Result<T, Objection>);

fn take(
    file: &Path,
    photos: Vec<CameraLine<NvmPhoto>>,
    points: Vec<CameraLine<NvmPoint>>,
    fixed: Option<[f64; 2]>,
    assembly: &mut Assembly<'_>,
    task: &Task,
) -> Result<()> {
    let names: Vec<&str> =
        photos.iter().map(|(_, photo)| photo.as_ref().map_or("", |photo| photo.name.as_str())).collect();
    let named = photo_paths(&names, &[file.parent().unwrap_or(Path::new("")).to_path_buf()], Without::Any);
    let sizes = assembly.sizes(&named, task)?;
    let readings =
        LensReading::ALL.map(|reading| (reading, median(reading, &photos, &points, &sizes, fixed)));
    let least = readings.iter().map(|(_, median)| *median).fold(f64::INFINITY, f64::min);
    let reading =
        readings.iter().find(|(_, median)| *median <= least).map_or(LensReading::OF_VISUALSFM, |(it, _)| *it);
    if reading != LensReading::OF_VISUALSFM && assembly.knows_sizes() {
        let origin = if reading.from_corner { "the corner" } else { "the middle" };
        let lens = if reading.forward { "acts as -k of COLMAP" } else { "acts on the measurement" };
        assembly.note(format!(
            "{}: by its observations ({least:.2} px), measurements are from {origin} and the distortion {lens}, other than VisualSFM writes it",
            file.display()
        ));
    }
    let mut kept = Vec::with_capacity(photos.len());
    for (((place, photo), named), size) in photos.into_iter().zip(&named).zip(&sizes) {
        kept.push(match photo {
            Ok(photo) => {
                let camera = size.clone().map(|size| reading.camera(&photo, size, fixed));
                assembly.photo(place, &named.name, camera, photo.pose)
            }
            Err(objection) => {
                assembly.refused_photo(place, objection);
                None
            }
        });
    }
    for (id, (place, point)) in points.into_iter().enumerate() {
        match point {
            Ok(NvmPoint { position, seen }) => {
                let seen = seen.into_iter().filter_map(|(photo, at)| {
                    Some((kept[photo]?, reading.place(at, *sizes[photo].as_ref().ok()?)))
                });
                assembly.seen_point(place, id as u64, position.into(), seen.collect());
            }
            Err(objection) => assembly.point_problem(place, objection),
        }
    }
    Ok(())
}

/// Returns the median error of reprojection in pixels, if the file is read in this way; infinite where too little is observed.
fn median(
    reading: LensReading,
    photos: &[CameraLine<NvmPhoto>],
    points: &[CameraLine<NvmPoint>],
    sizes: &[Result<[u64; 2], Objection>],
    fixed: Option<[f64; 2]>,
) -> f64 {
    let mut index = vec![None; photos.len()];
    let mut cameras = Vec::new();
    for (photo, ((_, read), size)) in photos.iter().zip(sizes).enumerate() {
        if let (Ok(read), Ok(size)) = (read, size)
            && let Ok(pose) = read.pose
        {
            let RawCamera { focal: [fx, fy], centre: [cx, cy], lens, .. } =
                reading.camera(read, *size, fixed);
            let [width, height] = size.map(|side| u32::try_from(side).unwrap_or(u32::MAX));
            let camera = Pinhole { width, height, fx, fy, cx, cy };
            index[photo] = Some(cameras.len() as u32);
            let (name, place) = (String::new(), String::new());
            cameras.push(CameraPhoto { name, camera, lens, pose, shutter: None, place });
        }
    }
    let of_point = |point: &NvmPoint| {
        let seen = point.seen.iter().filter_map(|&(photo, at)| {
            Some((index[photo]?, reading.place(at, *sizes[photo].as_ref().ok()?)))
        });
        SparsePoint { position: point.position, observations: seen.collect() }
    };
    let points: Vec<SparsePoint> =
        points.iter().filter_map(|(_, point)| Some(of_point(point.as_ref().ok()?))).collect();
    Reprojection::new(&cameras, &points, false).map_or(f64::INFINITY, |reprojection| reprojection.median_px)
}
