//! The list of depth images: a JSON file that names pictures with their depths, their cameras, and what the numbers mean.
//!
//! `docs/formats.md` describes it. What is wrong with one image leaves that one out.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use quadratura_base::error::{Error, Message, Result};
use quadratura_base::geometry::{Pinhole, Pose};
use quadratura_base::scene::SparsePoint;
use quadratura_base::scene::alike;
use quadratura_base::task::Task;
use quadratura_files::foreign_json::{no_number, read_foreign_json};
use quadratura_files::json::in_words;
use quadratura_files::named_file::NamedFiles;
use quadratura_import::cameras::{Cameras, read_cameras};
use quadratura_import::photo::picture_size;
use quadratura_ldi::file::{LdiCamera, wrong_camera};
use quadratura_ldi::layout::LONGEST_SIDE;

/// The only version of the list.
const VERSION: u32 = 1;

/// The largest list in bytes.
const LARGEST: u64 = 64 << 20;

/// The remedy for a list that cannot be understood.
const DESCRIBED: &str = "correct the list; docs/formats.md describes it";

/// The remedy for an image without a usable camera.
const CAMERA: &str =
    "give `camera` as {K, R, t}, or as the name of a photo in the files that `cameras` names";

/// What the numbers of a depth image are, after scale and offset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DepthKind {
    /// The depth along the camera's axis, in world units.
    Axis,
    /// The distance from the camera's centre, in world units.
    Ray,
    /// The inverse of the depth along the axis, in 1/world unit.
    Inverse,
}

impl DepthKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Axis, Self::Ray, Self::Inverse];

    /// Returns the kind's name in the list.
    pub fn name(self) -> &'static str {
        match self {
            Self::Axis => "axis",
            Self::Ray => "ray",
            Self::Inverse => "inverse",
        }
    }

    /// Returns the inverse depth along the axis, in 1/world unit, that a number says at a pixel whose ray, scaled to z = 1, has
    /// this length. 0 where the number says none: it is <= 0, not finite, or as far as `background`.
    pub fn inverse_depth(self, number: f64, ray_length: f64, background: f64) -> f64 {
        if !(number > 0.0 && number.is_finite()) {
            return 0.0;
        }
        match self {
            Self::Axis | Self::Ray if number >= background => 0.0,
            Self::Inverse if number * background <= 1.0 => 0.0,
            Self::Axis => 1.0 / number,
            Self::Ray => ray_length / number,
            Self::Inverse => number,
        }
    }
}

/// A list that was read.
#[derive(Debug)]
pub struct DepthList {
    /// The file.
    pub file: PathBuf,
    /// The images, in the list's order, without those that cannot be used.
    pub images: Vec<DepthEntry>,
    /// The sparse points of the cameras' files; `observations` count through the photos there ([`DepthEntry::photo`]).
    pub points: Vec<SparsePoint>,
    /// The images that were left out, one error each.
    pub problems: Vec<Error>,
}

/// An image of the list.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthEntry {
    /// Its place in the list, for messages.
    pub place: String,
    /// The picture as the list names it.
    pub name: String,
    /// The file of the picture.
    pub colour: PathBuf,
    /// The file of the depths.
    pub depth: PathBuf,
    /// The camera, without distortion; its size is the picture's.
    pub camera: Pinhole,
    /// The camera's pose, world to camera.
    pub pose: Pose,
    /// The number of the photo in the cameras' files, where the camera is from there.
    pub photo: Option<u32>,
    /// What the numbers are; `None` where the list does not say it.
    pub kind: Option<DepthKind>,
    /// What the numbers are multiplied with.
    pub scale: f64,
    /// What is added after that.
    pub offset: f64,
    /// The depth or distance, in world units, from which on there is none; infinite where the list has none.
    pub background: f64,
}

/// The list as its file has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ListFile {
    version: u32,
    #[serde(default)]
    cameras: Option<PathBuf>,
    images: Vec<Value>,
}

/// An image as the file has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EntryFile {
    colour: PathBuf,
    depth: PathBuf,
    #[serde(default)]
    camera: Option<Value>,
    #[serde(default)]
    kind: Option<DepthKind>,
    #[serde(default = "one")]
    scale: f64,
    #[serde(default)]
    offset: f64,
    #[serde(default)]
    background: Option<f64>,
}

fn one() -> f64 {
    1.0
}

/// A camera as in `stack.json`, perhaps with the size of its picture.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(non_snake_case)]
struct CameraFile {
    K: [[f64; 3]; 3],
    R: [[f64; 3]; 3],
    t: [f64; 3],
    #[serde(default)]
    width: Option<u32>,
    #[serde(default)]
    height: Option<u32>,
}

/// A camera with its pose and its photo's number in the cameras' files.
type Camera = (Pinhole, Pose, Option<u32>);

/// Reads a list and the cameras that it names. Paths in it are relative to its folder.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] where the list itself or the cameras' files cannot be used; [`Error::Cancelled`]. What
/// concerns one image is in [`DepthList::problems`].
pub fn read_list(file: &Path, task: &Task) -> Result<DepthList> {
    let list: ListFile = read_foreign_json(file, LARGEST, DESCRIBED)?;
    if list.version != VERSION {
        let found = format!("`version` is {}; expected {VERSION}", list.version);
        return Err(Error::input(file, "", found, "use a newer version of quadratura, or correct the list"));
    }
    let folder = file.parent().unwrap_or(Path::new(""));
    let cameras =
        list.cameras.map(|path| read_cameras(&folder.join(path), task)).transpose()?.unwrap_or_default();
    let problems = cameras.problems.iter().map(Error::message);
    cameras
        .notes
        .iter()
        .map(|note| Message::from(note.clone()))
        .chain(problems)
        .for_each(|note| task.note(note));
    let reading = DepthListReader { file, folder, cameras: &cameras };
    let (mut images, mut problems) = (Vec::new(), Vec::new());
    for (number, value) in (1..).zip(list.images) {
        task.check_cancelled()?;
        match reading.entry(number, value) {
            Ok(entry) => images.push(entry),
            Err(error) => problems.push(error),
        }
    }
    Ok(DepthList { file: file.to_path_buf(), images, points: cameras.points, problems })
}

/// A list while its images are read.
struct DepthListReader<'a> {
    file: &'a Path,
    folder: &'a Path,
    cameras: &'a Cameras,
}

impl DepthListReader<'_> {
    fn entry(&self, number: usize, mut value: Value) -> Result<DepthEntry> {
        let named = value.get("colour").and_then(Value::as_str).unwrap_or_default().to_owned();
        let place =
            if named.is_empty() { format!("image {number}") } else { format!("image {number} ({named})") };
        let wrong = |found: String, remedy: &str| Error::input(self.file, place.clone(), found, remedy);
        // Some programs write that there is no background as one that is infinitely far.
        if let Some(background) = value.get_mut("background")
            && no_number(background).is_some_and(|word| word.to_lowercase().starts_with("inf"))
        {
            *background = Value::Null;
        }
        let entry: EntryFile =
            serde_json::from_value(value).map_err(|error| wrong(in_words(&error.to_string()), DESCRIBED))?;
        let EntryFile { scale, offset, .. } = entry;
        let background = entry.background.unwrap_or(f64::INFINITY);
        if !(scale.is_finite() && scale != 0.0 && offset.is_finite() && background > 0.0) {
            let found = format!("`scale` {scale}, `offset` {offset}, `background` {background}");
            return Err(wrong(found, "give a scale other than 0 and a background above 0"));
        }
        let file = |path: &Path| NamedFiles::default().path_below(self.folder, path);
        let colour = file(&entry.colour);
        let camera = entry.camera.ok_or_else(|| wrong("`camera` is missing".to_owned(), CAMERA))?;
        let (camera, pose, photo) = match camera {
            Value::String(name) => self.camera_named(&name).map_err(|found| wrong(found, CAMERA))?,
            other => self.own_camera(other, picture_size(&colour)?).map_err(|found| wrong(found, CAMERA))?,
        };
        if let Some(found) = wrong_camera(&LdiCamera::of(&camera, &pose)) {
            return Err(wrong(found, CAMERA));
        }
        Ok(DepthEntry {
            name: entry.colour.to_string_lossy().replace('\\', "/"),
            depth: file(&entry.depth),
            kind: entry.kind,
            place,
            colour,
            camera,
            pose,
            photo,
            scale,
            offset,
            background,
        })
    }

    /// Returns the camera of a photo of the cameras' files.
    fn camera_named(&self, name: &str) -> Result<Camera, String> {
        let photos = &self.cameras.photos;
        let number = alike::find(name, photos.iter().map(|photo| &photo.name)).one().ok_or_else(|| {
            match photos.len() {
                0 => format!("the camera {name:?}, but the list names no `cameras`"),
                count => format!(
                    "the camera {name:?}, which is none of the {count} in {}",
                    self.cameras.file.display()
                ),
            }
        })?;
        let photo = &photos[number];
        if !photo.lens.is_none() {
            return Err(format!(
                "the camera {name:?} has a lens with distortion; expected pictures and depths without one, as COLMAP's \
                 `image_undistorter` makes them"
            ));
        }
        Ok((photo.camera, photo.pose, Some(number as u32)))
    }

    /// Returns the camera that the list has itself, of a picture of this size.
    fn own_camera(&self, value: Value, [width, height]: [u32; 2]) -> Result<Camera, String> {
        let camera: CameraFile = serde_json::from_value(value)
            .map_err(|error| format!("`camera`: {}", in_words(&error.to_string())))?;
        let sides = 1..=LONGEST_SIDE;
        if !(sides.contains(&width) && sides.contains(&height)) {
            return Err(format!(
                "a picture of {width} x {height} pixels; expected sides of 1 to {LONGEST_SIDE}"
            ));
        }
        let stated = (camera.width.unwrap_or(width), camera.height.unwrap_or(height));
        if stated != (width, height) {
            return Err(format!(
                "a camera of {} x {} pixels; the picture has {width} x {height}",
                stated.0, stated.1
            ));
        }
        let camera = LdiCamera { K: camera.K, R: camera.R, t: camera.t, width, height };
        // K with skew or another last row would be lost in a pinhole camera, so it is checked as it is.
        wrong_camera(&camera).map_or_else(|| Ok((camera.pinhole(), camera.pose(), None)), Err)
    }
}
