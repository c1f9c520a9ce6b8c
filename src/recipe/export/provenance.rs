//! Pictures of the provenance of filled texels, with a colour for each source photo and for each kind of
//! inpainting, and a legend.

use std::path::Path;

use serde::Serialize;

use super::names::layer_name;
use crate::document::Decisions;
use crate::document::names::file_name_of_photo;
use crate::document::stack::{ImageLayer, LayerFill, StackFill, origins};
use crate::error::{Remedy, Result};
use crate::geometry::PixelRect;
use crate::io::atomic::write_atomically;
use crate::io::json::to_json;
use crate::io::layer_reader::{read_grey, read_layer};
use crate::io::picture_png::{make_folder, write_picture};
use crate::io::stack_store::StackStore;
use crate::recipe::layer_names::rename;
use crate::scene::Photo;
use crate::task::Task;

/// The colour of texels that the photo itself shows.
const VISIBLE: [u8; 3] = [96, 96, 96];

/// The contents of `legend.json`.
#[derive(Debug, Serialize)]
struct LegendFile<'a> {
    photo: &'a str,
    /// Colours as #rrggbb, with their meanings.
    colours: Vec<LegendEntry<'a>>,
    layers: Vec<LegendPicture>,
}

/// A colour of the legend.
#[derive(Debug, Serialize)]
struct LegendEntry<'a> {
    colour: String,
    origin: &'a str,
}

/// A picture of one layer.
#[derive(Debug, Serialize)]
struct LegendPicture {
    layer: String,
    file: String,
    rect: PixelRect,
}

/// Writes `OUT/<photo>.provenance/`: a PNG for the needed part of each filled image layer, and `legend.json`. A
/// picture that was changed by hand is kept, and the new one gets a number. Photos without a filling are noted.
/// `decisions` contain the layers' names.
///
/// # Errors
/// Returns [`crate::Error::Io`], [`crate::Error::Input`] for a stack's files, or [`crate::Error::Cancelled`].
pub fn write_provenance(
    project: &Path,
    photos: &[&Photo],
    decisions: &Decisions,
    out: &Path,
    task: &Task,
) -> Result<()> {
    let store = StackStore::new(project);
    for (done, photo) in (0..).zip(photos) {
        task.step("provenance", done, photos.len() as u64)?;
        let Some(mut stack) = store.current(&photo.name)? else { continue };
        rename(&mut stack, &decisions.of(&photo.name).names);
        let Some(fill) = &stack.fill else {
            task.with_subject(&photo.name).note((
                "this photo is not filled, so there is no provenance; ",
                Remedy::Fill,
                " fills it",
            ));
            continue;
        };
        let folder = out.join(format!("{}.provenance", file_name_of_photo(&photo.name)));
        make_folder(&folder)?;
        let mut layers = Vec::new();
        for layer in &stack.image_layers {
            let Some(of_layer) = &layer.fill else { continue };
            layers.push(write_one(&store.folder(&photo.name), &folder, layer, of_layer, fill)?);
        }
        let legend = LegendFile { photo: &photo.name, colours: entries(&photo.name, fill), layers };
        write_atomically(folder.join("legend.json"), &to_json(&legend))?;
    }
    Ok(())
}

/// Writes the picture of one layer.
fn write_one(
    stacks: &Path,
    folder: &Path,
    layer: &ImageLayer,
    of_layer: &LayerFill,
    fill: &StackFill,
) -> Result<LegendPicture> {
    let rect = layer.needed_rect.intersection(&layer.rect);
    let sources = read_grey(&stacks.join(&of_layer.provenance_file), layer.rect, rect)?;
    let photo = read_layer(&stacks.join(&layer.file), layer.rect, rect)?;
    let mut pixels = Vec::with_capacity(4 * sources.len());
    for (source, photo) in sources.iter().zip(photo.as_chunks::<4>().0) {
        // A visible texel under another photo's paint has the source of that paint.
        let is_photo = photo[3] != 0 && *source == 0;
        let [r, g, b] = if is_photo { VISIBLE } else { colour(usize::from(*source), fill) };
        let holds = photo[3] != 0 || *source != 0;
        pixels.extend([r, g, b, if holds { u8::MAX } else { 0 }]);
    }
    let placed = write_picture(folder, &layer.id, [rect.w, rect.h], &pixels)?;
    let file = placed.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(LegendPicture { layer: layer_name(&layer.name, &layer.id), file, rect })
}

/// Lists the colours with their meanings.
fn entries<'a>(photo: &'a str, fill: &'a StackFill) -> Vec<LegendEntry<'a>> {
    let named = |[r, g, b]: [u8; 3], origin: &'a str| LegendEntry {
        colour: format!("#{r:02x}{g:02x}{b:02x}"),
        origin,
    };
    let filled = fill.origins.iter().enumerate().skip(1).map(|(i, origin)| named(colour(i, fill), origin));
    std::iter::once(named(VISIBLE, photo)).chain(filled).collect()
}

/// Returns the colour of an index in the list of sources: warm for inpainting, cool and distinct for photos.
fn colour(index: usize, fill: &StackFill) -> [u8; 3] {
    match fill.origins.get(index).map(String::as_str) {
        None | Some(origins::NONE) => [0; 3],
        Some(origins::PAINTED) => [255; 3],
        Some(origins::EXEMPLAR) => [255, 150, 0],
        Some(origins::DIFFUSED) => [225, 30, 30],
        // Paint in other photos: light colours with distinct hues.
        Some(origin) if origins::painter(origin).is_some() => {
            rgb_of((index as f64 * 137.508) % 360.0, 0.25, 1.0)
        }
        // Photos: hues at steps of the golden angle from green to violet, in two shades.
        Some(_) => {
            let hue = 90.0 + (index as f64 * 137.508) % 210.0;
            let value = if index.is_multiple_of(2) { 0.95 } else { 0.65 };
            rgb_of(hue, 0.8, value)
        }
    }
}

/// Converts hue in degrees, saturation and value to RGB.
fn rgb_of(hue: f64, saturation: f64, value: f64) -> [u8; 3] {
    [5.0, 3.0, 1.0].map(|n: f64| {
        let k = (n + hue / 60.0) % 6.0;
        let part = k.min(4.0 - k).clamp(0.0, 1.0);
        (255.0 * value * (1.0 - saturation * part)).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_go_round_as_they_should_and_those_of_a_legend_differ() {
        assert_eq!([rgb_of(0.0, 1.0, 1.0), rgb_of(120.0, 1.0, 1.0)], [[255, 0, 0], [0, 255, 0]]);
        let fixed = [origins::NONE, origins::PAINTED, origins::EXEMPLAR, origins::DIFFUSED].map(String::from);
        let photos = (0..24).map(|i| format!("{i}.jpg"));
        let painted = (0..5).map(|i| origins::painted_in(&format!("{i}.jpg")));
        let fill = StackFill {
            inputs: String::new(),
            origins: fixed.into_iter().chain(photos).chain(painted).collect(),
            texels_hidden: 0,
            texels_from_photos: 0,
            texels_from_paint: 0,
            propagated: Vec::new(),
            texels_by_example: 0,
            texels_diffused: 0,
            bytes: 0,
            basis: None,
        };
        let entries = entries("own.jpg", &fill);
        let mut colours: Vec<&str> = entries.iter().map(|entry| entry.colour.as_str()).collect();
        colours.sort_unstable();
        colours.dedup();
        assert_eq!(colours.len(), entries.len());
    }
}
