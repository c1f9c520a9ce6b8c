//! The command `ldi info`.

use std::path::Path;

use serde_json::{Value, json};

use crate::Outcome;
use crate::args::LdiInfoArgs;
use crate::bytes::readable_bytes;
use crate::table::{Table, counted};
use crate::words::{about_project, command_for_project, error_text};
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::PhotoId;
use quadratura_base::task::Task;
use quadratura_images::view::name_of;
use quadratura_images::{LdiSite, LdiState, StackLdiOptions, ldi_state};
use quadratura_ldi::file::{LdiCamera, LdiFile, LdiHeader, Packing, WholeRows};
use quadratura_ldi::{Arrangement, DepthPixelOrigin, Ldi};
use quadratura_sites::open::open;

/// The names of the origins of colours.
const ORIGINS: [(DepthPixelOrigin, &str, &str); 4] = [
    (DepthPixelOrigin::Photo, "photo", "the photo"),
    (DepthPixelOrigin::Paint, "paint", "paint"),
    (DepthPixelOrigin::OtherPhotos, "other_photos", "other photos"),
    (DepthPixelOrigin::Invented, "inpainted", "inpainted"),
];

/// Runs `ldi info`.
pub fn run(args: &LdiInfoArgs, task: &Task) -> Result<Outcome> {
    match &args.path {
        path if !path.is_dir() => of_file(path, task),
        folder => of_project(folder, task),
    }
}

/// Describes a file. One that is cut short is described as far as it goes, and is a problem.
fn of_file(path: &Path, task: &Task) -> Result<Outcome> {
    let file = LdiFile::open(path)?;
    let bytes = std::fs::metadata(path).map_err(Error::io(path, "read its size"))?.len();
    if file.arrangement != Arrangement::Single {
        return of_several(&file, bytes, task);
    }
    let OfImage { header, ldi, rows, fault } = OfImage::read(&file, 0, task)?;
    let problems: Vec<String> = fault.iter().map(error_text).collect();
    let packing = packing_name(header.packing);
    let json = described(header.camera, packing, &ldi, rows, bytes, &problems);
    Ok(Outcome { text: text(packing, &ldi, rows, bytes), json, problems })
}

/// Returns the name of how a file is packed.
fn packing_name(packing: Packing) -> &'static str {
    match packing {
        Packing::None => "none",
        Packing::Deflate => "deflate",
    }
}

/// An image of a file, as far as it goes.
struct OfImage {
    header: LdiHeader,
    ldi: Ldi,
    rows: WholeRows,
    /// Why not all of it could be read.
    fault: Option<Error>,
}

impl OfImage {
    fn read(file: &LdiFile, image: usize, task: &Task) -> Result<Self> {
        let header = file.header(image)?;
        let (ldi, rows, fault) = match file.read(image, task) {
            Ok(ldi) => {
                let height = ldi.camera.height;
                (ldi, WholeRows { whole: height, height }, None)
            }
            Err(fault @ Error::Input { .. }) => {
                let (ldi, rows) = file.read_whole_rows(image, task)?;
                (ldi, rows, Some(fault))
            }
            Err(error) => return Err(error),
        };
        Ok(Self { header, ldi, rows, fault })
    }
}

/// Describes a cube or a set, image by image.
fn of_several(file: &LdiFile, bytes: u64, task: &Task) -> Result<Outcome> {
    let mut table =
        Table::new(&["image", "made from", "frame", "depth pixels", "complexity", "layers", "size"]);
    let (mut images, mut errors) = (Vec::new(), Vec::new());
    errors.extend(file.check().err());
    for index in 0..file.count() {
        let OfImage { header, ldi, rows, fault } = match OfImage::read(file, index, task) {
            Ok(image) => image,
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => {
                errors.push(error);
                continue;
            }
        };
        errors.extend(fault);
        let level = &ldi.levels[0];
        table.row([
            name_of(file.arrangement, &ldi, index),
            made_from(&ldi),
            format!("{} x {}", ldi.camera.width, ldi.camera.height),
            level.len().to_string(),
            format!("{:.3}", level.len() as f64 / level.layered().max(1) as f64),
            ldi.report.layers.to_string(),
            readable_bytes(header.report.bytes),
        ]);
        let packing = packing_name(header.packing);
        images.push(described(header.camera, packing, &ldi, rows, header.report.bytes, &[]));
    }
    let mut problems: Vec<String> = errors.iter().map(error_text).collect();
    problems.dedup();
    let name = file.arrangement.name();
    let text = format!("{}\n{name} of {}, {}\n", table.render(), file.count(), readable_bytes(bytes));
    let json = json!({ "arrangement": name, "bytes": bytes, "images": images, "problems": problems });
    Ok(Outcome { text, json, problems })
}

/// The largest number of sources that are named in a table.
const NAMED: usize = 3;

/// Returns in words what an image was made from.
fn made_from(ldi: &Ldi) -> String {
    let named =
        ldi.sources.iter().take(NAMED).map(|name| name.escape_debug().to_string()).collect::<Vec<_>>();
    let others = match ldi.sources.len().saturating_sub(NAMED) {
        0 => String::new(),
        others => format!(" and {}", counted(others, "other")),
    };
    format!("{} of {}{others}", ldi.kind.name(), named.join(", "))
}

/// Returns the number of depth pixels of full resolution with each origin.
fn by_origin(ldi: &Ldi) -> [u64; 4] {
    let mut counts = [0; 4];
    ldi.levels[0].splats.iter().for_each(|splat| counts[splat.origin() as usize] += 1);
    counts
}

fn text(packing: &str, ldi: &Ldi, rows: WholeRows, bytes: u64) -> String {
    let (level, report, camera) = (&ldi.levels[0], &ldi.report, &ldi.camera);
    let mut table = Table::new(&["", ""]);
    let mut row = |name: &str, value: String| table.row([name.to_owned(), value]);
    row("made from", made_from(ldi));
    row("frame", format!("{} x {}, focal length {:.1} px", camera.width, camera.height, camera.fx));
    if !rows.are_all() {
        row("whole rows", format!("{} of {}", rows.whole, rows.height));
    }
    row("depth pixels", level.len().to_string());
    row("depth complexity", format!("{:.3}", level.len() as f64 / level.layered().max(1) as f64));
    row("surfaces", ldi.surfaces.len().to_string());
    let stored = if packing == packing_name(Packing::None) { "" } else { ", of which the first is stored" };
    row("levels", format!("{}{stored}", ldi.levels.len()));
    // Of a file that is cut short, the bytes are also those of depth pixels that cannot be read.
    let size = match level.len() {
        count if count > 0 && rows.are_all() => {
            format!(
                "{}, {:.1} bytes a depth pixel ({packing})",
                readable_bytes(bytes),
                bytes as f64 / count as f64
            )
        }
        _ => format!("{} ({packing})", readable_bytes(bytes)),
    };
    row("size", size);
    row("empty", format!("{} texels that need paint", report.empty_needed));
    row("left out", format!("{} beyond the largest number of layers", report.dropped));
    let mut layers = Table::new(&["layers", "positions", "share"]);
    let positions: u64 = level.histogram().iter().sum();
    for (count, pixels) in level.histogram().iter().enumerate() {
        let share = 100.0 * *pixels as f64 / positions.max(1) as f64;
        layers.row([count.to_string(), pixels.to_string(), format!("{share:.1} %")]);
    }
    let mut origins = Table::new(&["colours from", "depth pixels", "share"]);
    for ((_, _, name), count) in ORIGINS.iter().zip(by_origin(ldi)) {
        let share = 100.0 * count as f64 / level.len().max(1) as f64;
        origins.row([(*name).to_owned(), count.to_string(), format!("{share:.1} %")]);
    }
    format!("{}\n{}\n{}", table.render().trim_start(), layers.render(), origins.render())
}

fn described(
    camera: LdiCamera,
    packing: &str,
    ldi: &Ldi,
    rows: WholeRows,
    bytes: u64,
    problems: &[String],
) -> Value {
    let level = &ldi.levels[0];
    let origins: serde_json::Map<String, Value> = ORIGINS
        .iter()
        .zip(by_origin(ldi))
        .map(|((_, name, _), count)| ((*name).to_owned(), count.into()))
        .collect();
    json!({
        "kind": ldi.kind.name(),
        "inputs": ldi.inputs,
        "sources": ldi.sources,
        "camera": camera,
        "gain": ldi.gain,
        "depth_pixels": level.len(),
        "depth_complexity": level.len() as f64 / level.layered().max(1) as f64,
        "histogram": level.histogram(),
        "origins": origins,
        "surfaces": ldi.surfaces.len(),
        "levels": ldi.levels.len(),
        "packing": packing,
        "bytes": bytes,
        "whole_rows": rows.whole,
        "report": ldi.report,
        "problems": problems,
    })
}

/// Lists which photos of a project have a layered depth image that is up to date.
fn of_project(folder: &Path, task: &Task) -> Result<Outcome> {
    about_project(folder);
    let opened = open(folder, task)?;
    let site = LdiSite::open(folder, &opened.project, &opened.site)?;
    let mut table = Table::new(&["photo", "state", "depth pixels", "complexity", "layers", "empty", "size"]);
    let (mut list, mut waiting) = (Vec::new(), 0);
    for (id, photo) in PhotoId::all(opened.site.photos.len()).zip(&opened.site.photos) {
        let state = ldi_state(folder, &site, id, &photo.name, &StackLdiOptions::default());
        let (word, header) = match &state {
            LdiState::Current(header) => ("up to date", Some(header)),
            LdiState::Stale(header) => ("out of date", Some(header)),
            LdiState::Missing => ("not built", None),
        };
        waiting += usize::from(!matches!(state, LdiState::Current(_)));
        let cells = header.map_or([const { String::new() }; 5], cells);
        table.row([photo.name.clone(), word.to_owned()].into_iter().chain(cells));
        list.push(json!({
            "photo": photo.name,
            "state": word,
            "report": header.map(|header| &header.report),
        }));
    }
    let problems: Vec<String> = opened.problems.errors.iter().map(error_text).collect();
    let rest = match waiting {
        0 => "all are up to date\n".to_owned(),
        _ => format!("{} builds those that are not up to date\n", command_for_project("ldi build")),
    };
    let text = format!("{}\n{rest}", table.render());
    Ok(Outcome { text, json: json!({ "images": list, "problems": problems }), problems })
}

/// Returns the figures of a file in the table of a project.
fn cells(header: &LdiHeader) -> [String; 5] {
    let report = &header.report.report;
    let depth_pixels = header.levels.first().map_or(0, |level| level.depth_pixels);
    [
        depth_pixels.to_string(),
        format!("{:.2}", report.depth_complexity),
        report.layers.to_string(),
        report.empty_needed.to_string(),
        readable_bytes(header.report.bytes),
    ]
}
