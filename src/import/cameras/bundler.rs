//! Bundler's `.out` file, version 0.3, with the photos' names in a list beside it (`bundler_list`).
//!
//! Each photo has `f k1 k2`, a rotation and a translation, world to camera, in OpenGL's axes: y up, looking along -z.
//! A point P in the camera's frame is imaged at `p = -P / P.z`, in pixels `f (1 + k1 |p|^2 + k2 |p|^4) p` from the
//! photo's middle, y up. With y down, `p` is our (X/Z, Y/Z), and the factor, which depends on |p| alone, is the radial
//! one of [`Lens::Brown`] with the same signs. A focal length of 0 is a photo that was not registered. Sizes are the
//! photos' own. Source: Bundler, *User's Manual*, section VI.

use std::path::{Path, PathBuf};

use glam::{DMat3, DVec2, DVec3};

use super::assembly::Assembly;
use super::bundler_list::{read_list, with_list};
use super::format::CameraFormat;
use super::lines::LineReader;
use super::photo_name::short;
use super::photo_paths::{PhotoPath, Without, photo_paths};
use super::pose::{CV_FROM_GL, is_on_a_map, rotation_and_scale};
use super::raw::RawCamera;
use super::recognise::{beginning, has_name, recognised};
use super::reconstruction::ReconstructionFiles;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::{Lens, Pose};
use quadratura_base::task::Task;
use quadratura_files::text::Objection;

/// The format.
pub(super) struct Bundler;

/// The names that Bundler and the programs that correct its lenses use.
const USUAL_NAMES: [&str; 2] = ["bundle.out", "bundle.rd.out"];
const MARK: &str = "# Bundle file v";
const CUT: &str = "copy the file again; it is cut short or damaged";

impl CameraFormat for Bundler {
    fn accepted(&self) -> &'static str {
        "Bundler's .out file with its list of photos beside it, such as list.txt"
    }

    fn program(&self) -> &'static str {
        "Bundler"
    }

    fn folders(&self) -> &'static [&'static str] {
        &["", "bundle"]
    }

    fn kept_and_lost(&self) -> [&'static str; 2] {
        [
            "focal length, k1, k2; points with observations; not tried with the program itself",
            "a principal point, which it cannot say",
        ]
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["out"]
    }

    fn of_file(&self, file: &Path) -> Option<Result<ReconstructionFiles>> {
        let is_one = has_name(file, &USUAL_NAMES) || is_bundle(&beginning(file));
        is_one.then(|| with_list(file))
    }

    fn in_folder(&self, folder: &Path, names: &[String]) -> Option<Result<ReconstructionFiles>> {
        let found = recognised(folder, names, ".out", &USUAL_NAMES, is_bundle);
        Some(with_list(found.first()?))
    }

    fn read(&self, files: &ReconstructionFiles, assembly: &mut Assembly<'_>, task: &Task) -> Result<()> {
        let list = &files.others[0];
        let mut reader = NumberReader::open(&files.images)?;
        let [cameras, points] = reader.head(task)?;
        let names = read_list(list, usize::try_from(cameras).ok(), task)?;
        if cameras != names.len() as u64 {
            let found =
                format!("{} photos where {} has {cameras} cameras", names.len(), files.images.display());
            return Err(Error::input(
                list,
                "",
                found,
                "use both files of the same run, as Bundler wrote them",
            ));
        }
        let paths: Vec<&str> = names.iter().map(String::as_str).collect();
        let photos = photo_paths(&paths, &folders_of(list), Without::Png);
        let placed = read_cameras(&mut reader, &photos, assembly, task)?;
        read_points(&mut reader, points, &placed, assembly, task)
    }
}

fn is_bundle(beginning: &[u8]) -> bool {
    beginning.trim_ascii_start().starts_with(MARK.as_bytes())
}

/// Returns the folders to which the list's paths may be relative: its own, or the one above where Bundler ran.
fn folders_of(list: &Path) -> [PathBuf; 2] {
    let folder = list.parent().unwrap_or(Path::new("")).to_path_buf();
    [folder.clone(), folder.join("..")]
}

/// A camera that is used.
struct UsedCamera {
    /// The photo's index in the assembly.
    photo: u32,
    pose: Pose,
    /// The middle of the photo, in pixels.
    middle: DVec2,
}

fn read_cameras(
    reader: &mut NumberReader<'_>,
    photos: &[PhotoPath],
    assembly: &mut Assembly<'_>,
    task: &Task,
) -> Result<Vec<Option<UsedCamera>>> {
    let (mut placed, mut unregistered) = (Vec::with_capacity(photos.len()), 0);
    let sizes = assembly.sizes(photos, task)?;
    for (index, (photo, size)) in photos.iter().zip(sizes).enumerate() {
        let what = format!("camera {index} of {}", photos.len());
        let place = reader.place_of_next(&what, task)?;
        let numbers = reader.numbers::<15>(&what, task)?;
        if matches!(numbers, Ok([0.0, ..])) {
            unregistered += 1;
            placed.push(None);
            continue;
        }
        let camera = numbers.clone().and_then(|numbers| camera(&numbers, size?));
        let middle = camera.as_ref().map(|camera| DVec2::from(camera.centre)).unwrap_or_default();
        let pose = numbers.and_then(|numbers| pose(&numbers));
        let kept = assembly.photo(place, &photo.name, camera, pose.clone());
        placed.push(kept.zip(pose.ok()).map(|(photo, pose)| UsedCamera { photo, pose, middle }));
    }
    if unregistered > 0 {
        let (file, all) = (reader.lines.path.display(), photos.len());
        assembly.note(format!("{file}: {unregistered} of {all} photos are not registered (focal length 0)"));
    }
    Ok(placed)
}

fn camera(&[f, k1, k2, ..]: &[f64; 15], size: [u64; 2]) -> Result<RawCamera, Objection> {
    let lens = Lens::Brown { k: [k1, k2, 0.0, 0.0, 0.0, 0.0], p: [0.0; 2] };
    Ok(RawCamera { size, focal: [f; 2], centre: size.map(|side| 0.5 * side as f64), lens })
}

fn pose(numbers: &[f64; 15]) -> Result<Pose, Objection> {
    let rows: &[f64; 9] = numbers[3..12].try_into().expect("nine of them");
    let (rotation, _) = rotation_and_scale(DMat3::from_cols_array(rows).transpose(), "the rotation")?;
    let translation = DVec3::new(numbers[12], numbers[13], numbers[14]);
    if !is_on_a_map(translation.into()) {
        let found = format!("the translation {:?} is not within 1e15 of the origin", translation.to_array());
        return Err((found, "write it in the model's unit"));
    }
    Ok(Pose { rotation: CV_FROM_GL * rotation, translation: CV_FROM_GL * translation })
}

fn read_points(
    reader: &mut NumberReader<'_>,
    count: u64,
    placed: &[Option<UsedCamera>],
    assembly: &mut Assembly<'_>,
    task: &Task,
) -> Result<()> {
    let (mut seen, mut behind) = (0u64, 0u64);
    for index in 0..count {
        let what = format!("point {index} of {count}");
        let place = reader.place_of_next(&what, task)?;
        let position = reader.numbers::<3>(&what, task)?;
        for _colour in 0..3 {
            reader.next(&what, task)?;
        }
        let views = reader.count("the number of photos that show a point", &what, task)?;
        let mut observations = Vec::new();
        for _ in 0..views {
            let view = reader.view(&what, placed, task)?;
            match view {
                Ok(Some((photo, at))) => {
                    if let Ok(position) = position {
                        seen += 1;
                        behind += u64::from(photo.pose.camera_from_world(position.into()).z <= 0.0);
                    }
                    observations.push((photo.photo, at));
                }
                Ok(None) => (),
                Err(objection) => assembly.problem(reader.lines.path, reader.lines.place(), objection),
            }
        }
        match position {
            Ok(position) => assembly.seen_point(place, index, position, observations),
            Err(objection) => assembly.problem(reader.lines.path, place, objection),
        }
    }
    if 2 * behind > seen {
        let found = format!("{behind} of {seen} observed points lie behind the photo that shows them");
        let remedy = "export Bundler's format with cameras that look along -z (\"negative Z\")";
        return Err(Error::input(reader.lines.path, "", found, remedy));
    }
    Ok(())
}

/// The file as a sequence of numbers separated by white space.
struct NumberReader<'a> {
    lines: LineReader<'a>,
    line: String,
    at: usize,
}

impl<'a> NumberReader<'a> {
    fn open(path: &'a Path) -> Result<Self> {
        Ok(Self { lines: LineReader::open(path)?, line: String::new(), at: 0 })
    }

    /// Reads the first line, and the numbers of cameras and points.
    fn head(&mut self, task: &Task) -> Result<[u64; 2]> {
        if !self.lines.advance()? {
            let found = format!("it is empty, expected \"{MARK}0.3\" in the first line");
            return Err(Error::input(self.lines.path, "", found, CUT));
        }
        let line = self.lines.text().into_owned();
        if line.strip_prefix(MARK).map(str::trim) != Some("0.3") {
            let found = format!("{}, expected \"{MARK}0.3\"", short(&line));
            return Err(Error::input(self.lines.path, "line 1", found, "export version 0.3 of the format"));
        }
        let what = "the numbers of cameras and points";
        Ok([
            self.count("the number of cameras", what, task)?,
            self.count("the number of points", what, task)?,
        ])
    }

    /// Advances to the line of the next number.
    fn fill(&mut self, what: &str, task: &Task) -> Result<()> {
        while self.line[self.at..].trim_ascii_start().is_empty() {
            if !self.lines.next_record("read cameras", task)? {
                let found = format!("the file ends within {what}");
                return Err(Error::input(self.lines.path, self.lines.place(), found, CUT));
            }
            self.line.clear();
            self.line.push_str(&self.lines.text());
            self.at = 0;
        }
        Ok(())
    }

    fn place_of_next(&mut self, what: &str, task: &Task) -> Result<String> {
        self.fill(what, task)?;
        Ok(self.lines.place())
    }

    /// Reads the next number as text; an end of the file here is an error that mentions `what`.
    fn next(&mut self, what: &str, task: &Task) -> Result<&str> {
        self.fill(what, task)?;
        let rest = &self.line[self.at..];
        let from = self.at + rest.len() - rest.trim_ascii_start().len();
        let length = self.line[from..].find(|c: char| c.is_ascii_whitespace());
        self.at = length.map_or(self.line.len(), |length| from + length);
        Ok(&self.line[from..self.at])
    }

    /// Reads the next N numbers. The inner error is a malformed number, after which reading can go on.
    fn numbers<const N: usize>(&mut self, what: &str, task: &Task) -> Result<Result<[f64; N], Objection>> {
        let mut numbers = Ok([0.0; N]);
        for index in 0..N {
            let text = self.next(what, task)?;
            match (&mut numbers, text.parse::<f64>().ok().filter(|number| number.is_finite())) {
                (Ok(numbers), Some(number)) => numbers[index] = number,
                (Ok(_), None) => {
                    numbers = Err((format!("{what}: {} where a number should be", short(text)), CUT))
                }
                (Err(_), _) => (),
            }
        }
        Ok(numbers)
    }

    /// Reads a count, without which the rest of the file cannot be read.
    fn count(&mut self, name: &str, what: &str, task: &Task) -> Result<u64> {
        let text = self.next(what, task)?;
        let (count, text) = (text.parse(), short(text));
        count.map_err(|_| {
            let found = format!("{text} where {name} should be");
            Error::input(self.lines.path, self.lines.place(), found, CUT)
        })
    }

    /// Reads an observation: camera, keypoint, x, y. Returns `None` for a photo that is not used.
    fn view<'p>(
        &mut self,
        what: &str,
        placed: &'p [Option<UsedCamera>],
        task: &Task,
    ) -> Result<Result<Option<(&'p UsedCamera, DVec2)>, Objection>> {
        let text = self.next(what, task)?;
        let (camera, text) = (text.parse::<usize>().ok().and_then(|camera| placed.get(camera)), short(text));
        self.next(what, task)?;
        let at = self.numbers::<2>(what, task)?;
        let Some(camera) = camera else {
            let found = format!("{what}: {text} where one of {} cameras should be", placed.len());
            return Ok(Err((found, CUT)));
        };
        let pixel = |camera: &'p UsedCamera, [x, y]: [f64; 2]| (camera, camera.middle + DVec2::new(x, -y));
        Ok(at.map(|at| camera.as_ref().map(|camera| pixel(camera, at))))
    }
}
