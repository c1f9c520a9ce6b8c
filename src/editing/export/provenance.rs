//! Pictures of the provenance of filled texels, with a colour for each source photo and for each kind of
//! inpainting, and a legend.

use std::path::Path;

use serde::Serialize;

use super::folder::layer_stem;
use super::names::layer_name;
use quadratura_base::error::{Remedy, Result};
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::Photo;
use quadratura_base::task::Task;
use quadratura_document::Decisions;
use quadratura_document::names::file_name_of_photo;
use quadratura_document::stack::{ImageLayer, LayerFill, StackFill, origins};
use quadratura_files::atomic::write_atomically;
use quadratura_files::json::to_json;
use quadratura_io::layer_reader::{read_grey, read_layer};
use quadratura_io::picture_png::{make_folder, write_picture};
use quadratura_io::stack_store::StackStore;
use quadratura_stacks::layer_names::rename;
use quadratura_view::legend::Origin;

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
    /// The meaning in words.
    text: String,
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
/// Returns [`quadratura_base::Error::Io`], [`quadratura_base::Error::Input`] for a stack's files, or [`quadratura_base::Error::Cancelled`].
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
        let [r, g, b] = if is_photo { Origin::Photo.colour() } else { colour(usize::from(*source), fill) };
        let holds = photo[3] != 0 || *source != 0;
        pixels.extend([r, g, b, if holds { u8::MAX } else { 0 }]);
    }
    let placed = write_picture(folder, &layer_stem(layer), [rect.w, rect.h], &pixels)?;
    let file = placed.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(LegendPicture { layer: layer_name(&layer.name, &layer.id), file, rect })
}

/// Lists the colours with their meanings.
fn entries<'a>(photo: &'a str, fill: &'a StackFill) -> Vec<LegendEntry<'a>> {
    let named = |[r, g, b]: [u8; 3], origin: &'a str, text: String| LegendEntry {
        colour: format!("#{r:02x}{g:02x}{b:02x}"),
        origin,
        text,
    };
    let filled = fill.origins.iter().enumerate().skip(1);
    let filled = filled.map(|(i, origin)| named(colour(i, fill), origin, in_words(origin)));
    std::iter::once(named(Origin::Photo.colour(), photo, Origin::Photo.name().into())).chain(filled).collect()
}

/// Returns the meaning of a source.
fn in_words(origin: &str) -> String {
    match kind(origin) {
        Some(fixed @ (Origin::Propagated | Origin::OtherPhoto)) => {
            format!("{}: {}", fixed.name(), origins::painter(origin).unwrap_or(origin))
        }
        Some(fixed) => fixed.name().to_owned(),
        None => String::new(),
    }
}

/// Returns the kind of a source, of which views show the same colours; `None` where nothing was filled.
fn kind(origin: &str) -> Option<Origin> {
    Some(match origin {
        origins::NONE => return None,
        origins::PAINTED => Origin::Paint,
        origins::EXEMPLAR => Origin::Example,
        origins::DIFFUSED => Origin::Diffused,
        origin if origins::painter(origin).is_some() => Origin::Propagated,
        _ => Origin::OtherPhoto,
    })
}

/// Returns the colour of an index in the list of sources: that of views (`view/legend.rs`), but each photo has a
/// shade of its own.
fn colour(index: usize, fill: &StackFill) -> [u8; 3] {
    let kind = fill.origins.get(index).and_then(|origin| kind(origin));
    // Steps of the golden angle keep the shades of any number of photos apart.
    let step = (index as f64 * 0.618_034).fract();
    let value = if index.is_multiple_of(2) { 0.95 } else { 0.7 };
    match kind {
        None => [0; 3],
        // Oranges, for paint in other photos.
        Some(Origin::Propagated) => rgb_of(8.0 + 22.0 * step, 0.95, value),
        // Greens, from olive to turquoise.
        Some(Origin::OtherPhoto) => rgb_of(70.0 + 110.0 * step, 0.8, value),
        Some(fixed) => fixed.colour(),
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
            matte_pixels: 0,
            matte_unknown: 0,
            bytes: 0,
            basis: None,
        };
        let entries = entries("own.jpg", &fill);
        let mut colours: Vec<&str> = entries.iter().map(|entry| entry.colour.as_str()).collect();
        colours.sort_unstable();
        colours.dedup();
        assert_eq!(colours.len(), entries.len());
        let of = |origin: &str| entries.iter().find(|entry| entry.origin == origin).unwrap();
        let hexadecimal = |[r, g, b]: [u8; 3]| format!("#{r:02x}{g:02x}{b:02x}");
        assert_eq!(of(origins::EXEMPLAR).colour, hexadecimal(Origin::Example.colour()), "as in views");
        assert_eq!(of("[painted in 3.jpg]").text, "paint of another photo: 3.jpg");
        assert_eq!(of("3.jpg").text, "filled from other photos: 3.jpg");
    }
}
