//! Reads the folder.

use std::path::Path;

use super::json::{FORMAT, JSON, LayersFile, MOST_LAYERS, NEAREST, VERSION};
use super::picture_kind::{HELD, PictureKind, REMEDY};
use crate::file::{SurfaceEntry, wrong_content, wrong_photo_rect};
use crate::layout::LARGEST_INVERSE_DEPTH;
use crate::levels::pyramid;
use crate::{DepthPixel, Ldi, LdiKind, ResolutionLevel, Splat};
use quadratura_base::error::{Error, Result};
use quadratura_base::task::Task;
use quadratura_files::json::read_json;

/// The largest `ldi.json` in bytes: 65535 surfaces with long names.
const LARGEST_JSON: u64 = 64 << 20;

/// The remedy for a description that cannot be used.
const AGAIN: &str = "export the layers anew with `quadratura ldi export`";

/// The depth pixels of a layer with their positions in reading order.
type LayerPixels = Vec<(u32, DepthPixel)>;

/// Reads a folder that [`super::write_ldi_layers`] wrote, whose pictures may have been changed since: the layered depth image
/// that it was made of, with depths of 16 bits, and the levels made anew. Which positions have a depth pixel is in the
/// surfaces' pictures alone.
///
/// # Errors
/// [`Error::Io`]; [`Error::Cancelled`]; [`Error::Input`] with file, place, finding and remedy.
pub fn read_ldi_layers(folder: &Path, task: &Task) -> Result<Ldi> {
    let file = folder.join(JSON);
    let json: LayersFile = read_json(&file, LARGEST_JSON, AGAIN)?;
    check(&json).map_err(|found| Error::input(&file, "", found, AGAIN))?;
    let count = json.layers.len() as u64;
    let mut layers = Vec::new();
    for (done, layer) in (0..count).zip(0..) {
        task.step("read layers", done, count)?;
        layers.push(read_layer(folder, layer, &json)?);
    }
    let level = level_of(folder, &json, &layers)?;
    let surfaces: Vec<_> = json.surfaces.iter().map(SurfaceEntry::surface).collect();
    let kind = LdiKind::ALL.into_iter().find(|kind| kind.name() == json.kind);
    Ok(Ldi {
        kind: kind.expect("the description was checked"),
        camera: json.camera.pinhole(),
        pose: json.camera.pose(),
        inputs: json.inputs,
        photo_rect: json.photo_rect,
        gain: json.gain,
        sources: json.sources,
        levels: pyramid(level, &surfaces),
        surfaces,
        report: json.report,
    })
}

/// Checks what `ldi.json` says.
fn check(json: &LayersFile) -> Result<(), String> {
    if json.format != FORMAT {
        return Err(format!("`format` is {:?}; expected {FORMAT:?}", json.format));
    }
    if json.version != VERSION {
        let version = json.version;
        return Err(format!(
            "`version` is {version}; expected {VERSION}: a newer version of quadratura may read it"
        ));
    }
    if let Some(found) = wrong_content(&json.kind, json.gain, &json.camera, &json.surfaces) {
        return Err(found);
    }
    if let Some(found) = wrong_photo_rect(json.photo_rect.as_ref(), &json.camera) {
        return Err(found);
    }
    let range = 0.0..=LARGEST_INVERSE_DEPTH;
    let (near, far) = (json.near, json.far);
    if !(range.contains(&near) && range.contains(&far) && near >= far) {
        return Err(format!("inverse depths from {far} to {near}; expected 0 to {LARGEST_INVERSE_DEPTH:e}"));
    }
    if json.layers.len() > MOST_LAYERS {
        return Err(format!("{} layers; expected {MOST_LAYERS} at most", json.layers.len()));
    }
    Ok(())
}

fn read_layer(folder: &Path, layer: usize, json: &LayersFile) -> Result<LayerPixels> {
    let decoded = |picture: PictureKind| picture.decoded(&folder.join(picture.file_name(layer)), json);
    let infos = decoded(PictureKind::Surfaces)?;
    let (colours, depths) = (decoded(PictureKind::Colours)?, decoded(PictureKind::Depths)?);
    let (infos, colours, depths) =
        (infos.as_chunks::<6>().0, colours.as_chunks::<4>().0, depths.as_chunks::<2>().0);
    let mut pixels = LayerPixels::new();
    for (at, ((info, colour), depth)) in (0u32..).zip(infos.iter().zip(colours).zip(depths)) {
        let [surface, splat, held] = [0, 2, 4].map(|i| u16::from_be_bytes([info[i], info[i + 1]]));
        if held == 0 {
            continue;
        }
        let wrong = |found: String| {
            let (file, place) = (folder.join(PictureKind::Surfaces.file_name(layer)), place(at, json));
            Error::input(file, place, found, REMEDY)
        };
        if held != HELD || splat > u16::from(u8::MAX) {
            return Err(wrong(format!("green {splat} and blue {held}; expected 0 to 255, and 0 or {HELD}")));
        }
        if usize::from(surface) > json.surfaces.len() {
            return Err(wrong(format!("surface {surface}; expected 0 to {}", json.surfaces.len())));
        }
        let inverse_depth = inverse_depth(u16::from_be_bytes(*depth), json);
        pixels.push((at, DepthPixel { inverse_depth, colour: *colour, surface, splat: Splat(splat as u8) }));
    }
    Ok(pixels)
}

/// Returns the inverse depth that a value stands for.
fn inverse_depth(value: u16, json: &LayersFile) -> f32 {
    let [near, far] = [json.near, json.far].map(f64::from);
    (far + (near - far) * f64::from(value) / NEAREST) as f32
}

/// Returns the words for a position in reading order.
fn place(at: u32, json: &LayersFile) -> String {
    format!("column {}, row {}", at % json.camera.width, at / json.camera.width)
}

/// Puts the layers together, row by row.
fn level_of(folder: &Path, json: &LayersFile, layers: &[LayerPixels]) -> Result<ResolutionLevel> {
    let camera = json.camera.pinhole();
    let total: u64 = layers.iter().map(|layer| layer.len() as u64).sum();
    if total > u64::from(u32::MAX) {
        let found = format!("{total} depth pixels; expected less than 2^32");
        return Err(Error::input(folder.join(JSON), "", found, "export a smaller image"));
    }
    let mut level = ResolutionLevel::without_rows(camera);
    let mut rest: Vec<&[(u32, DepthPixel)]> = layers.iter().map(Vec::as_slice).collect();
    for y in 0..camera.height {
        // A frame has less than 2^28 positions.
        let end = (y + 1) * camera.width;
        let mut row: Vec<(u32, usize, DepthPixel)> = Vec::new();
        for (layer, pixels) in rest.iter_mut().enumerate() {
            let (of_row, after) = pixels.split_at(pixels.partition_point(|(at, _)| *at < end));
            row.extend(of_row.iter().map(|(at, pixel)| (*at, layer, *pixel)));
            *pixels = after;
        }
        row.sort_unstable_by_key(|(at, layer, _)| (*at, *layer));
        for pixels in row.chunk_by(|a, b| a.0 == b.0) {
            check_order(pixels).map_err(|(layer, picture, found)| {
                Error::input(folder.join(picture.file_name(layer)), place(pixels[0].0, json), found, REMEDY)
            })?;
        }
        let row: Vec<_> = row.into_iter().map(|(at, _, pixel)| ((at % camera.width) as u16, pixel)).collect();
        level.push_row(&row);
    }
    Ok(level.finished())
}

/// Checks the depth pixels of one position; an error says in which picture of which layer something is wrong, and what.
fn check_order(pixels: &[(u32, usize, DepthPixel)]) -> Result<(), (usize, PictureKind, String)> {
    for (expected, (_, layer, _)) in pixels.iter().enumerate() {
        if *layer != expected {
            let found = format!("a depth pixel, but none in layer {expected}; expected layers without gaps");
            return Err((*layer, PictureKind::Surfaces, found));
        }
    }
    match pixels.windows(2).find(|pair| pair[1].2.inverse_depth > pair[0].2.inverse_depth) {
        Some(pair) => Err((
            pair[1].1,
            PictureKind::Depths,
            "it is nearer than the layer before; expected the nearest first".to_owned(),
        )),
        None => Ok(()),
    }
}
