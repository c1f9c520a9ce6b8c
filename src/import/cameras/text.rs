//! COLMAP's text files: one record a line, photos in two lines. A line that begins with `#` is a comment; the name of a photo is the
//! rest of its line, whatever that holds.

use std::str::FromStr;

use super::assembly::Assembly;
use super::colmap_model::{ColmapModel, MODELS};
use super::lines::LineReader;
use super::photo_name::short;
use super::pose::pose_of_quaternion;
use super::raw::RawImage;
use super::reconstruction::ReconstructionFiles;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_files::text::Objection;

/// Reads all files into `assembly`.
pub(super) fn read(files: &ReconstructionFiles, assembly: &mut Assembly, task: &Task) -> Result<()> {
    let mut cameras = LineReader::open(&files.cameras)?;
    while cameras.next_record("read cameras", task)? {
        take_camera(&cameras.text(), cameras.place(), assembly);
    }
    assembly.some_cameras()?;
    let mut images = LineReader::open(&files.images)?;
    read_images(&mut images, assembly, task)?;
    if let Some(points) = &files.points {
        let mut lines = LineReader::open(points)?;
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
    let parsed = (|| {
        let name = fields.next().unwrap_or_default();
        let model = ColmapModel::by_name(name).ok_or_else(|| unknown_model(name))?;
        let (width, height) = (parse(fields.next(), "WIDTH")?, parse(fields.next(), "HEIGHT")?);
        let parameters = fields.take_while(|field| !field.starts_with('#'));
        let parameters =
            parameters.map(|field| parse(Some(field), "PARAMS")).collect::<Result<Vec<f64>, _>>()?;
        Ok((model, width, height, parameters))
    })();
    match (id, parsed) {
        (Ok(id), Ok((model, width, height, parameters))) => {
            assembly.camera(place, id, model.camera(width, height, &parameters));
        }
        (Ok(id), Err(objection)) => assembly.refused_camera(id, place, objection),
        // Without its number no photo can refer to it.
        (Err(objection), _) => assembly.refused_camera(u32::MAX, place, objection),
    }
}

fn unknown_model(name: &str) -> Objection {
    let known: Vec<_> = MODELS.iter().map(|model| model.name).collect();
    let found = format!("the camera model {}; known models are {}", short(name), known.join(", "));
    (found, "use one of COLMAP's models")
}

/// Photos come in two lines, the second with the keypoints and often empty. Some programs leave it
/// out; then the next photo's first line stands in its place, and is taken for what it is.
fn read_images(lines: &mut LineReader<'_>, assembly: &mut Assembly, task: &Task) -> Result<()> {
    let mut missing = 0;
    let mut at_header = lines.next_record("read poses", task)?;
    while at_header {
        let (header, place) = (lines.text().into_owned(), lines.place());
        lines.advance()?;
        let second = lines.text();
        let (observations, problem, keypoints_left_out) = match parse_keypoints(&second) {
            Ok(observations) => (observations, None, false),
            Err(_) if parse_header(&second).is_ok() => (Vec::new(), None, true),
            Err(objection) => (Vec::new(), Some(objection), false),
        };
        match parse_header(&header) {
            Ok(image) => assembly.image(place, RawImage { observations, ..image }),
            Err(objection) => assembly.refused_photo(place, objection),
        }
        // Behind the problem of the photo itself: where no photo can be used, the first problem is reported.
        if let Some((found, remedy)) = problem {
            let found = format!("{found}: the keypoints of this photo are not used");
            assembly.problem(lines.path, lines.place(), (found, remedy));
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

/// `IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME`; the name is the rest of the line.
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
    let pose = pose_of_quaternion(quaternion, translation);
    Ok(RawImage { id, pose, camera, name: rest.trim_ascii(), observations: Vec::new() })
}

/// `X Y POINT3D_ID` again and again; those without a point (-1) are left out.
fn parse_keypoints(line: &str) -> Result<Vec<([f64; 2], u64)>, Objection> {
    let mut fields = line.split_ascii_whitespace();
    let mut observations = Vec::new();
    while let Some(x) = fields.next() {
        let at: [f64; 2] = [parse(Some(x), "X")?, parse(fields.next(), "Y")?];
        let point: i64 = parse(fields.next(), "POINT3D_ID")?;
        if point >= 0 {
            observations.push((at, point as u64));
        }
    }
    Ok(observations)
}

/// `POINT3D_ID X Y Z ..`; colour, error and track are not needed.
fn parse_point(line: &str) -> Result<(u64, [f64; 3]), Objection> {
    let mut fields = line.split_ascii_whitespace();
    let id = parse(fields.next(), "POINT3D_ID")?;
    Ok((id, [parse(fields.next(), "X")?, parse(fields.next(), "Y")?, parse(fields.next(), "Z")?]))
}

/// Takes the next field off the front of `rest`.
fn field<'a>(rest: &mut &'a str) -> Option<&'a str> {
    let from = rest.trim_ascii_start();
    let end = from.find(|c: char| c.is_ascii_whitespace()).unwrap_or(from.len());
    let (field, behind) = from.split_at(end);
    *rest = behind;
    (!field.is_empty()).then_some(field)
}

/// Returns the number of a field, which errors call `name`.
pub(super) fn parse<T: FromStr>(field: Option<&str>, name: &str) -> Result<T, Objection> {
    let field = field.ok_or_else(|| (format!("the line ends before {name}"), "write all fields"))?;
    field.parse().map_err(|_| (format!("{} where {name} should be", short(field)), "write a number there"))
}
