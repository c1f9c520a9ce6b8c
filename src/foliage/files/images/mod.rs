//! Reads and writes the images of a plant: a folder with `images.json`, which lists them, and a file for each view; and how open its
//! crown is.

mod inputs;
mod mbuffer;
mod openness;

use std::collections::BTreeMap;
use std::path::Path;

use glam::Vec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

pub use self::inputs::{images_hash, plant_hash};
pub use self::mbuffer::{mbuffer_bytes, parse_mbuffer, read_mbuffer, write_mbuffer};
pub use self::openness::{read_openness, write_openness};
use crate::{BakeOptions, Directions, ImageCopy, LightCorrection, MBuffer, ObjectImages, PlantImages};
use quadratura_base::error::{Error, Result};
use quadratura_files::atomic::{replace_folder_with, write_atomically};
use quadratura_files::json::{read_json, to_json};

/// The value of `format`.
const FORMAT: &str = "quadratura-plant-images";
/// The version that this program writes; it reads no other.
const VERSION: u32 = 4;
/// The file that lists the others.
const JSON: &str = "images.json";
/// The largest `images.json`.
const LARGEST_JSON: u64 = 1 << 26;
/// The remedy for what is wrong in these files: they are derived.
const REMEDY: &str = "remove the folder, so that the images are made again";

/// What `images.json` says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct ImagesFile {
    format: String,
    version: u32,
    /// Hash of everything that the images were made of.
    inputs: String,
    options: BakeOptions,
    /// The number of sub-objects of the plant.
    sub_objects: usize,
    objects: Vec<ObjectEntry>,
}

/// The first fields of `images.json` in any version.
#[derive(Debug, Deserialize)]
struct Head {
    format: String,
    version: u32,
}

/// A sub-object with images.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct ObjectEntry {
    /// Its index among the plant's.
    object: usize,
    /// Light let through over light reflected, of its leaves.
    through: [f32; 3],
    copies: Vec<CopyEntry>,
}

/// One resolution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct CopyEntry {
    delta: f64,
    side: u32,
    /// The factor on the light of its samples, R, G, B.
    gain: [f32; 3],
    /// For each direction the mean length of the mean normals of leaves.
    lengths: Vec<f32>,
}

/// Writes images into a folder, whole or not at all; what this program wrote there before is replaced. `inputs` is the hash of
/// everything that they were made of. Returns their size in bytes.
///
/// # Errors
/// [`quadratura_base::Error::Io`].
pub fn write_plant_images(
    folder: &Path,
    images: &PlantImages,
    options: &BakeOptions,
    inputs: &str,
) -> Result<u64> {
    let with_images =
        || images.objects.iter().enumerate().filter_map(|(index, of)| Some((index, of.as_ref()?)));
    let copy = |ImageCopy { delta, side, correction, .. }: &ImageCopy| CopyEntry {
        delta: *delta,
        side: *side,
        gain: correction.gain.to_array(),
        lengths: correction.lengths.clone(),
    };
    let objects = with_images().map(|(object, of)| ObjectEntry {
        object,
        through: of.through.to_array(),
        copies: of.copies.iter().map(copy).collect(),
    });
    let json = ImagesFile {
        format: FORMAT.into(),
        version: VERSION,
        inputs: inputs.into(),
        options: BakeOptions { from_parts: images.from_parts, ..*options },
        sub_objects: images.objects.len(),
        objects: objects.collect(),
    };
    replace_folder_with(folder, |new| {
        let views = with_images().flat_map(|(object, of)| {
            let copies = of.copies.iter().enumerate();
            copies.flat_map(move |(index, copy)| {
                copy.views
                    .iter()
                    .enumerate()
                    .map(move |(direction, view)| (object, index, copy.side, direction, view))
            })
        });
        let views: Vec<_> = views.collect();
        let sizes = views.par_iter().map(|(object, index, side, direction, view)| {
            write_mbuffer(&new.join(name(*object, *index, images.directions, *direction)), view, *side)
        });
        let bytes: u64 = sizes.collect::<Result<Vec<u64>>>()?.iter().sum();
        let text = to_json(&json);
        write_atomically(new.join(JSON), &text)?;
        Ok(bytes + text.len() as u64)
    })
}

/// Reads the images of a plant of `sub_objects` if those in a folder were made of `inputs` with these options, from parts or not; `None`
/// where they were made of others, or there are none.
///
/// # Errors
/// [`quadratura_base::Error::Input`] for damaged files; [`quadratura_base::Error::Io`].
pub fn read_plant_images(
    folder: &Path,
    sub_objects: usize,
    options: &BakeOptions,
    inputs: &str,
) -> Result<Option<PlantImages>> {
    let Some(json) = listed(folder, sub_objects, options, inputs)? else { return Ok(None) };
    let entries: BTreeMap<usize, &ObjectEntry> = json.objects.iter().map(|of| (of.object, of)).collect();
    let objects = (0..json.sub_objects)
        .map(|object| entries.get(&object).map(|of| of_entry(folder, options.directions, of)).transpose());
    let BakeOptions { directions, from_parts, .. } = json.options;
    Ok(Some(PlantImages { directions, from_parts, objects: objects.collect::<Result<_>>()? }))
}

/// Returns whether the images in a folder are of a plant of `sub_objects`, made of `inputs` with these options. Their files are not
/// read.
pub fn is_made_of(folder: &Path, sub_objects: usize, options: &BakeOptions, inputs: &str) -> bool {
    listed(folder, sub_objects, options, inputs).is_ok_and(|listed| listed.is_some())
}

fn listed(
    folder: &Path,
    sub_objects: usize,
    options: &BakeOptions,
    inputs: &str,
) -> Result<Option<ImagesFile>> {
    let file = folder.join(JSON);
    if !file.exists() {
        return Ok(None);
    }
    // Other versions have other fields.
    let head: Head = read_json(&file, LARGEST_JSON, REMEDY)?;
    if head.format != FORMAT || head.version != VERSION {
        return Ok(None);
    }
    let json: ImagesFile = read_json(&file, LARGEST_JSON, REMEDY)?;
    for entry in &json.objects {
        if let Some(found) = fault(entry, sub_objects, json.options.directions.count()) {
            return Err(Error::input(&file, "objects", found, REMEDY));
        }
    }
    // Images from parts serve as others do.
    let wanted = BakeOptions { from_parts: json.options.from_parts, ..*options };
    let is_of_these = json.inputs == inputs && json.options == wanted && json.sub_objects == sub_objects;
    Ok(is_of_these.then_some(json))
}

/// Returns what is wrong with the numbers of a sub-object's images.
fn fault(entry: &ObjectEntry, sub_objects: usize, directions: usize) -> Option<String> {
    let ObjectEntry { object, through, copies } = entry;
    let is_share = |share: &f32| share.is_finite() && *share >= 0.0;
    let is_lit = |copy: &CopyEntry| {
        let numbers = copy.gain.iter().chain(&copy.lengths);
        copy.lengths.len() == directions && numbers.into_iter().all(is_share)
    };
    let is_size = |copy: &CopyEntry| copy.delta.is_finite() && copy.delta > 0.0 && copy.side > 0;
    let is_sound = *object < sub_objects
        && through.iter().all(is_share)
        && !copies.is_empty()
        && copies.iter().all(is_size)
        && copies.iter().all(is_lit)
        && copies.is_sorted_by(|finer, coarser| finer.delta < coarser.delta);
    (!is_sound).then(|| format!("images of sub-object {object} that no plant of {sub_objects} has"))
}

fn of_entry(folder: &Path, directions: Directions, entry: &ObjectEntry) -> Result<ObjectImages> {
    let copies = entry.copies.iter().enumerate().map(|(index, CopyEntry { delta, side, gain, lengths })| {
        let file = |direction: usize| folder.join(name(entry.object, index, directions, direction));
        let views =
            (0..directions.count()).into_par_iter().map(|direction| read_mbuffer(&file(direction), *side));
        let correction = LightCorrection { gain: Vec3::from(*gain), lengths: lengths.clone() };
        let views = views.collect::<Result<Vec<MBuffer>>>()?;
        Ok(ImageCopy { delta: *delta, side: *side, views, correction })
    });
    Ok(ObjectImages { copies: copies.collect::<Result<_>>()?, through: entry.through.into() })
}

/// Returns the name of the file of the view from a direction.
fn name(object: usize, copy: usize, directions: Directions, direction: usize) -> String {
    let (latitude, longitude) = directions.angles(direction);
    format!("{object:03}-{copy}.{latitude}.{longitude}.mb")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MSample, NormalCode};

    /// Images of one of two sub-objects, whose views differ.
    fn images(directions: Directions) -> PlantImages {
        let view = |direction: usize| MBuffer {
            counts: vec![0, 1, 0, 2],
            samples: [1, 2, 9]
                .map(|depth| MSample {
                    depth: depth + direction as u16,
                    colour: [direction as u8, 2, 3],
                    normal: NormalCode(7),
                    mask: 0x8001,
                })
                .to_vec(),
        };
        let lengths = (0..directions.count()).map(|direction| 1.0 - 0.01 * direction as f32).collect();
        let correction = LightCorrection { gain: Vec3::new(0.9, 1.1, 1.0), lengths };
        let views = (0..directions.count()).map(view).collect();
        let copy = ImageCopy { delta: 0.1, side: 2, views, correction };
        let of = ObjectImages { copies: vec![copy], through: [0.25, 0.5, 1.0].into() };
        PlantImages { directions, from_parts: false, objects: vec![None, Some(of)] }
    }

    #[test]
    fn images_of_both_kinds_are_read_as_they_were_written_and_not_as_the_other_kind() {
        for (options, other, files) in
            [(BakeOptions::SLABS, BakeOptions::LAYERS, 6), (BakeOptions::LAYERS, BakeOptions::SLABS, 22)]
        {
            let folder = tempfile::tempdir().unwrap();
            let folder = folder.path().join("images");
            let written = images(options.directions);
            write_plant_images(&folder, &written, &options, "hash").unwrap();
            // One file a view, and the one that lists them.
            assert_eq!(std::fs::read_dir(&folder).unwrap().count(), files + 1);
            assert_eq!(read_plant_images(&folder, 2, &options, "hash").unwrap(), Some(written));
            assert_eq!(read_plant_images(&folder, 2, &other, "hash").unwrap(), None);
            assert_eq!(read_plant_images(&folder, 2, &options, "another").unwrap(), None);
        }
    }

    #[test]
    fn images_of_before_light_was_corrected_are_not_read() {
        let (folder, options) = (tempfile::tempdir().unwrap(), BakeOptions::SLABS);
        let folder = folder.path().join("images");
        write_plant_images(&folder, &images(options.directions), &options, "hash").unwrap();
        assert!(is_made_of(&folder, 2, &options, "hash"));
        let file = folder.join(JSON);
        let mut json: serde_json::Value = read_json(&file, LARGEST_JSON, REMEDY).unwrap();
        json["version"] = 1.into();
        let copy = json["objects"][0]["copies"][0].as_object_mut().unwrap();
        assert!(copy.remove("gain").is_some() && copy.remove("lengths").is_some());
        std::fs::write(&file, json.to_string()).unwrap();
        assert_eq!(read_plant_images(&folder, 2, &options, "hash").unwrap(), None);
        assert!(!is_made_of(&folder, 2, &options, "hash"));
        // In this version, they are missing.
        json["version"] = VERSION.into();
        std::fs::write(&file, json.to_string()).unwrap();
        assert!(read_plant_images(&folder, 2, &options, "hash").is_err());
    }

    #[test]
    fn options_of_before_there_were_slabs_are_those_of_m_buffers() {
        let options =
            serde_json::from_str(r#"{"layers": 8, "side": 192, "least_side": 96, "most_side": 384}"#);
        assert_eq!(options.ok(), Some(BakeOptions::LAYERS));
    }
}
