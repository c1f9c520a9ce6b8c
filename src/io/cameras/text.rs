//! Reads COLMAP's text files: one record per line, photos in two lines, comments begin with `#`.

use std::borrow::Cow;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::str::FromStr;

use super::assembly::Assembly;
use super::colmap_model::{ColmapModel, MODELS};
use super::photo_name::short;
use super::{Files, RawCamera, RawImage};
use crate::error::{Error, Result};
use crate::task::Task;

/// The longest line in bytes: a photo with over a million keypoints. The limit keeps a file without line ends
/// from filling the memory.
const LONGEST_LINE: usize = 64 << 20;

/// The byte order mark that some editors put before the first line.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// A finding that refuses a record, and what to do about it.
type Objection = (String, &'static str);

/// Reads all files into `assembly`.
pub(super) fn read(files: &Files, assembly: &mut Assembly, task: &Task) -> Result<()> {
    let mut cameras = Lines::open(&files.cameras)?;
    while cameras.next_record("read cameras", task)? {
        take_camera(&cameras.text(), cameras.place(), assembly);
    }
    let mut images = Lines::open(&files.images)?;
    read_images(&mut images, assembly, task)?;
    if let Some(points) = &files.points {
        let mut lines = Lines::open(points)?;
        while lines.next_record("read points", task)? {
            match parse_point(&lines.text()) {
                Ok((id, position)) => assembly.point(lines.place(), id, position),
                Err(objection) => assembly.problem(points, lines.place(), objection),
            }
        }
    }
    Ok(())
}

fn take_camera(line: &str, place: String, assembly: &mut Assembly) {
    let mut fields = line.split_ascii_whitespace();
    let id = parse(fields.next(), "CAMERA_ID");
    let parsed = parse_camera_fields(fields);
    match (id, parsed) {
        (Ok(id), Ok((model, width, height, parameters))) => {
            assembly.camera(place, &RawCamera { id, model, width, height, parameters: &parameters });
        }
        (Ok(id), Err(objection)) => assembly.refused_camera(id, place, objection),
        // No photo can refer to a camera without a number.
        (Err(objection), _) => assembly.refused_camera(u32::MAX, place, objection),
    }
}

/// Parses `MODEL WIDTH HEIGHT PARAMS...`.
fn parse_camera_fields<'a>(
    mut fields: impl Iterator<Item = &'a str>,
) -> Result<(&'static ColmapModel, u64, u64, Vec<f64>), Objection> {
    let name = fields.next().unwrap_or_default();
    let model = ColmapModel::by_name(name).ok_or_else(|| unknown_model(name))?;
    let width = parse(fields.next(), "WIDTH")?;
    let height = parse(fields.next(), "HEIGHT")?;
    let parameters = fields.map(|field| parse(Some(field), "PARAMS")).collect::<Result<_, _>>()?;
    Ok((model, width, height, parameters))
}

fn unknown_model(name: &str) -> Objection {
    let known: Vec<_> = MODELS.iter().map(|model| model.name).collect();
    let found = format!("the camera model {}; known models are {}", short(name), known.join(", "));
    (found, "use one of COLMAP's models")
}

/// Reads photos of two lines each, the second with the keypoints and often empty. Some programs omit the
/// second line; then the next photo's first line follows directly, and is recognised as one.
fn read_images(lines: &mut Lines<'_>, assembly: &mut Assembly, task: &Task) -> Result<()> {
    let mut missing = 0;
    let mut at_header = lines.next_record("read poses", task)?;
    while at_header {
        let header = lines.text().into_owned();
        let place = lines.place();
        lines.advance()?;
        let second = lines.text();
        let (observations, keypoints_left_out) = match parse_keypoints(&second) {
            Ok(observations) => (observations, false),
            Err(_) if parse_header(&second).is_ok() => (Vec::new(), true),
            Err((found, remedy)) => {
                let found = format!("{found}: the keypoints of this photo are not used");
                assembly.problem(lines.path, lines.place(), (found, remedy));
                (Vec::new(), false)
            }
        };
        match parse_header(&header) {
            Ok(image) => assembly.image(place, RawImage { observations, ..image }),
            Err(objection) => assembly.problem(lines.path, place, objection),
        }
        missing += u64::from(keypoints_left_out);
        at_header = keypoints_left_out || lines.next_record("read poses", task)?;
    }
    if missing > 0 {
        let file = lines.path.display();
        assembly.note(format!(
            "{file}: {missing} photos lack their second line; they are read without keypoints"
        ));
    }
    Ok(())
}

/// Parses `IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME`; the name is the rest of the line.
fn parse_header(line: &str) -> Result<RawImage<'_>, Objection> {
    let mut rest = line;
    let id = parse(field(&mut rest), "IMAGE_ID")?;
    let mut quaternion = [0.0; 4];
    for (value, name) in quaternion.iter_mut().zip(["QW", "QX", "QY", "QZ"]) {
        *value = parse(field(&mut rest), name)?;
    }
    let mut translation = [0.0; 3];
    for (value, name) in translation.iter_mut().zip(["TX", "TY", "TZ"]) {
        *value = parse(field(&mut rest), name)?;
    }
    let camera = parse(field(&mut rest), "CAMERA_ID")?;
    Ok(RawImage { id, quaternion, translation, camera, name: rest.trim(), observations: Vec::new() })
}

/// Parses a sequence of `X Y POINT3D_ID`; keypoints without a point (-1) are left out.
fn parse_keypoints(line: &str) -> Result<Vec<([f64; 2], u64)>, Objection> {
    let mut fields = line.split_ascii_whitespace();
    let mut observations = Vec::new();
    while let Some(x) = fields.next() {
        let at: [f64; 2] = [parse(Some(x), "X")?, parse(fields.next(), "Y")?];
        let point: i64 = parse(fields.next(), "POINT3D_ID")?;
        if point >= 0 && at.iter().all(|v| v.is_finite()) {
            observations.push((at, point as u64));
        }
    }
    Ok(observations)
}

/// Parses `POINT3D_ID X Y Z ..`; colour, error and track are not needed.
fn parse_point(line: &str) -> Result<(u64, [f64; 3]), Objection> {
    let mut fields = line.split_ascii_whitespace();
    let id = parse(fields.next(), "POINT3D_ID")?;
    Ok((id, [parse(fields.next(), "X")?, parse(fields.next(), "Y")?, parse(fields.next(), "Z")?]))
}

/// Splits the next field off the front of `rest`.
fn field<'a>(rest: &mut &'a str) -> Option<&'a str> {
    let from = rest.trim_ascii_start();
    let end = from.find(|c: char| c.is_ascii_whitespace()).unwrap_or(from.len());
    let (field, behind) = from.split_at(end);
    *rest = behind;
    (!field.is_empty()).then_some(field)
}

fn parse<T: FromStr>(field: Option<&str>, name: &str) -> Result<T, Objection> {
    let field = field.ok_or_else(|| (format!("the line ends before {name}"), "write all fields"))?;
    field.parse().map_err(|_| (format!("{} where {name} should be", short(field)), "write a number there"))
}

/// A reader of lines, which are counted from 1, with one line at a time in memory.
struct Lines<'a> {
    path: &'a Path,
    reader: BufReader<File>,
    line: Vec<u8>,
    number: u64,
    at: u64,
    size: u64,
}

impl<'a> Lines<'a> {
    fn open(path: &'a Path) -> Result<Self> {
        let file = File::open(path).map_err(Error::io(path, "read it"))?;
        let size = file.metadata().map_err(Error::io(path, "read it"))?.len();
        let reader = BufReader::with_capacity(1 << 16, file);
        Ok(Self { path, reader, line: Vec::new(), number: 0, at: 0, size })
    }

    fn place(&self) -> String {
        format!("line {}", self.number)
    }

    /// Advances to the next line that is neither empty nor a comment; false at the end of the file.
    fn next_record(&mut self, stage: &'static str, task: &Task) -> Result<bool> {
        loop {
            if self.number.is_multiple_of(1024) {
                task.step(stage, self.at, self.size)?;
            }
            if !self.advance()? {
                return Ok(false);
            }
            if !matches!(self.text().as_bytes().first(), None | Some(b'#')) {
                return Ok(true);
            }
        }
    }

    /// Advances to the next line, whatever it contains; false, and an empty line, at the end of the file.
    fn advance(&mut self) -> Result<bool> {
        self.line.clear();
        let most = LONGEST_LINE as u64 + 1;
        let read = self.reader.by_ref().take(most).read_until(b'\n', &mut self.line);
        let bytes = read.map_err(Error::io(self.path, "read it"))?;
        self.number += 1;
        self.at += bytes as u64;
        if self.line.len() > LONGEST_LINE {
            let found = format!("a line of more than {} megabytes", LONGEST_LINE >> 20);
            return Err(Error::input(self.path, self.place(), found, "check that it is a COLMAP text file"));
        }
        Ok(bytes > 0)
    }

    /// Returns the line without surrounding spaces; bytes that are not UTF-8 become U+FFFD, which no name may
    /// contain.
    fn text(&self) -> Cow<'_, str> {
        let line = self.line.trim_ascii();
        String::from_utf8_lossy(line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(line))
    }
}
