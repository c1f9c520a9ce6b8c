//! Depth images from elsewhere: a depth image is a layered depth image of one layer, and treated as one.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::depth_fit::{self, SparsePointDepth};
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Pinhole;
use quadratura_base::scene::PhotoPixels;
use quadratura_base::task::Task;
use quadratura_import::photo::read_photo;
use quadratura_io::colour::Conversion;
use quadratura_io::depth_image::{DepthEntry, DepthKind, DepthList, DepthMap, read_depth_map, read_list};
use quadratura_ldi::levels::pyramid;
use quadratura_ldi::spacing::{distance, entry_of, normal_of_plane, quartiles};
use quadratura_ldi::{DepthPixel, DepthPixelOrigin, Ldi, LdiKind, LdiReport, ResolutionLevel, Splat};

/// Neighbours whose inverse depths differ by a larger share are taken to show different surfaces, across which there is no
/// normal. A surface of that slope is seen at so small an angle that its pixels hardly tell its normal.
const LARGEST_STEP: f64 = 0.1;

/// The options of reading depth images.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DepthImageOptions {
    /// Whether depths are used whose scale contradicts the sparse points.
    pub force: bool,
}

/// Reads the depth images of a list (`docs/formats.md`): each becomes a layered depth image of one layer in the camera of its
/// picture, whose surfaces are unknown. An image that cannot be used does not stop the others; the second list has the
/// reasons.
///
/// # Errors
/// The errors of [`read_list`]; [`Error::Cancelled`].
pub fn depth_images(list: &Path, options: &DepthImageOptions, task: &Task) -> Result<(Vec<Ldi>, Vec<Error>)> {
    let mut list = read_list(list, task)?;
    let mut failed = std::mem::take(&mut list.problems);
    let mut images = Vec::new();
    let count = list.images.len() as u64;
    for (done, entry) in (0..).zip(&list.images) {
        task.step("depth images", done, count)?;
        match depth_image(&list, entry, options, &task.with_subject(&entry.name)) {
            Ok(image) => images.push(image),
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => failed.push(error),
        }
    }
    task.step("depth images", count, count)?;
    Ok((images, failed))
}

fn depth_image(
    list: &DepthList,
    entry: &DepthEntry,
    options: &DepthImageOptions,
    task: &Task,
) -> Result<Ldi> {
    let size = [entry.camera.width, entry.camera.height];
    let photo = read_photo(&entry.colour, size[0], size[1])?;
    let map = read_depth_map(&entry.depth, size)?;
    task.check_cancelled()?;
    let points = SparsePointDepth::all(list, entry, &map);
    let kind = entry.kind.ok_or_else(|| depth_fit::missing_kind(list, entry, &points))?;
    depth_fit::check_scale(list, entry, kind, &points, options.force, task)?;
    let depths = inverse_depths(entry, kind, &map);
    let held = depths.par_iter().filter(|depth| **depth > 0.0).count();
    if held == 0 {
        let found = format!(
            "no pixel has a depth: all numbers, as `{}`, are <= 0, not finite, or as far as `background`",
            kind.name()
        );
        let remedy = "check `kind`, `scale`, `offset` and `background` in the list";
        return Err(Error::input(&entry.depth, "", found, remedy));
    }
    task.check_cancelled()?;
    let colours = SrgbPixels::new(&photo, task);
    ldi_of(entry, kind, &depths, &colours, task)
}

/// Returns the inverse depth of each pixel, in 1/world unit; 0 where it has none.
fn inverse_depths(entry: &DepthEntry, kind: DepthKind, map: &DepthMap) -> Vec<f32> {
    let of_row = |y: u32| {
        (0..map.width).map(move |x| {
            let number = f64::from(map.at(x, y)) * entry.scale + entry.offset;
            let ray = entry.camera.ray_in_camera(centre(x, y)).length();
            let inverse_depth = kind.inverse_depth(number, ray, entry.background) as f32;
            // As in the file's checks; larger ones are nearer than any surface.
            if inverse_depth <= quadratura_ldi::layout::LARGEST_INVERSE_DEPTH { inverse_depth } else { 0.0 }
        })
    };
    (0..map.height).into_par_iter().flat_map_iter(of_row).collect()
}

/// Returns the image position of a pixel's centre.
fn centre(x: u32, y: u32) -> DVec2 {
    DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
}

/// The colours of a picture as sRGB with 8 bits.
struct SrgbPixels<'a> {
    photo: &'a PhotoPixels,
    conversion: Option<Conversion>,
}

impl<'a> SrgbPixels<'a> {
    fn new(photo: &'a PhotoPixels, task: &Task) -> Self {
        let conversion = Conversion::between(photo.icc.as_deref(), None).unwrap_or_else(|problem| {
            task.note(format!("{problem}; its colours are taken as sRGB"));
            None
        });
        Self { photo, conversion }
    }

    /// Returns the colours of a row; `None` where the picture is not valid.
    fn row(&self, y: u32) -> Vec<Option<[u8; 4]>> {
        let width = self.photo.width;
        let mut row: Vec<[u16; 4]> = (0..width).map(|x| self.photo.rgba16(x, y)).collect();
        if let Some(conversion) = &self.conversion {
            row = conversion.converted(&row);
        }
        // Of 16 bits to 8, rounded: 65535 is 257 times 255.
        let byte = |value: u16| ((u32::from(value) + 128) / 257) as u8;
        let colour = |(x, [r, g, b, _]): (u32, [u16; 4])| {
            self.photo.is_valid(x, y).then(|| [byte(r), byte(g), byte(b), u8::MAX])
        };
        (0..width).zip(row).map(colour).collect()
    }
}

/// Makes the layered depth image of one layer.
fn ldi_of(
    entry: &DepthEntry,
    kind: DepthKind,
    depths: &[f32],
    colours: &SrgbPixels,
    task: &Task,
) -> Result<Ldi> {
    let camera = entry.camera;
    let depth_at = |x: u32, y: u32| depths[y as usize * camera.width as usize + x as usize];
    let distances =
        |y: u32| (0..camera.width).map(move |x| distance(&camera, x as u16, y, depth_at(x, y)) as f32);
    let quartiles = quartiles((0..camera.height).into_par_iter().flat_map_iter(distances).collect());
    let row = |y: u32| {
        let pixel = |(x, colour): (u32, Option<[u8; 4]>)| {
            let inverse_depth = depth_at(x, y);
            let colour = colour.filter(|_| inverse_depth > 0.0)?;
            let normal = normal_at(&camera, depths, x, y);
            let entry = entry_of(normal, distance(&camera, x as u16, y, inverse_depth), &quartiles);
            let splat = Splat::new(entry, DepthPixelOrigin::Photo);
            Some((x as u16, DepthPixel { inverse_depth, colour, surface: 0, splat }))
        };
        (0..).zip(colours.row(y)).filter_map(pixel).collect::<Vec<_>>()
    };
    let rows: Vec<_> = (0..camera.height).into_par_iter().map(row).collect();
    let level = ResolutionLevel::of_rows(camera, rows);
    task.check_cancelled()?;
    Ok(of_level(entry, kind, level, quartiles))
}

/// Returns the layered depth image of a level of one layer.
fn of_level(entry: &DepthEntry, kind: DepthKind, level: ResolutionLevel, quartiles: [f64; 3]) -> Ldi {
    let report = LdiReport {
        depth_complexity: 1.0,
        layers: 1,
        samples: level.len() as u64,
        quartiles,
        options: described(entry, kind),
        ..LdiReport::default()
    };
    Ldi {
        kind: LdiKind::Depth,
        inputs: String::new(),
        camera: entry.camera,
        pose: entry.pose,
        photo_rect: Some(entry.camera.rect()),
        gain: [0.0; 3],
        surfaces: Vec::new(),
        sources: vec![entry.name.clone()],
        levels: pyramid(level, &[]),
        report,
    }
}

/// Returns what the list says of the depths.
fn described(entry: &DepthEntry, kind: DepthKind) -> BTreeMap<String, String> {
    let words = [
        ("from", LdiKind::Depth.name().to_owned()),
        ("kind", kind.name().to_owned()),
        ("scale", entry.scale.to_string()),
        ("offset", entry.offset.to_string()),
    ];
    let background = entry.background.is_finite().then(|| ("background", entry.background.to_string()));
    words.into_iter().chain(background).map(|(name, value)| (name.to_owned(), value)).collect()
}

/// Returns the unit normal of the surface at a pixel with a depth, in the camera's frame and towards the camera: by the plane
/// through it and its nearer neighbour in depth to either side, along the row and along the column. Where neighbours do not
/// tell it, it is the camera's axis.
fn normal_at(camera: &Pinhole, depths: &[f32], x: u32, y: u32) -> DVec3 {
    let (width, height) = (i64::from(camera.width), i64::from(camera.height));
    let at = |x: i64, y: i64| {
        let inside = (0..width).contains(&x) && (0..height).contains(&y);
        inside.then(|| f64::from(depths[(y * width + x) as usize])).filter(|depth| *depth > 0.0)
    };
    let (column, row) = (i64::from(x), i64::from(y));
    let own = f64::from(depths[(row * width + column) as usize]);
    let change = |(dx, dy): (i64, i64)| {
        let after = at(column + dx, row + dy).map(|depth| depth - own);
        let before = at(column - dx, row - dy).map(|depth| own - depth);
        let steps = [after, before].into_iter().flatten().filter(|step| step.abs() <= LARGEST_STEP * own);
        steps.min_by(|a, b| a.abs().total_cmp(&b.abs()))
    };
    let (Some(along_row), Some(along_column)) = (change((1, 0)), change((0, 1))) else { return -DVec3::Z };
    let DVec2 { x, y } = centre(x, y);
    normal_of_plane(DVec3::new(along_row, along_column, own - along_row * x - along_column * y), camera)
}
