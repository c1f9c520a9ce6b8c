//! Writes the folder.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::json::{DepthError, FORMAT, JSON, LayerEntry, LayersFile, MAPPING, MOST_LAYERS, NEAREST, VERSION};
use super::picture_kind::{HELD, PictureKind};
use crate::file::{LdiCamera, SurfaceEntry};
use crate::{Ldi, ResolutionLevel};
use quadratura_base::error::{Error, Result};
use quadratura_files::atomic::{create_folder_with, replace_folder_with, write_atomically};
use quadratura_files::free_path::free_path;
use quadratura_files::hash::{hash_bytes, hash_file};
use quadratura_files::png_error::io_error;

/// A folder that was written.
#[derive(Debug, Clone, PartialEq)]
pub struct WrittenLayers {
    /// The folder.
    pub folder: PathBuf,
    /// What has the folder's name, was changed or made by others, and was therefore kept.
    pub spared: Vec<PathBuf>,
    /// The number of layers.
    pub layers: usize,
    /// The number of depth pixels.
    pub depth_pixels: u64,
    /// The size of all files in bytes.
    pub bytes: u64,
    /// The error that 16 bits of depth make.
    pub error: DepthError,
}

/// Writes the first level of a layered depth image as a folder of pictures, whole or not at all. Where the folder's name is
/// taken by anything but an unchanged folder of this program, it gets the next free one: `NAME-2` and so on. The bytes depend
/// on the content alone.
///
/// # Errors
/// [`Error::Request`] for more than 255 layers; [`Error::Io`].
pub fn write_ldi_layers(folder: &Path, ldi: &Ldi) -> Result<WrittenLayers> {
    let level = &ldi.levels[0];
    let layers = level.histogram().len() - 1;
    if layers > MOST_LAYERS {
        let found = format!("{}: it was not written: {layers} layers", folder.display());
        return Err(Error::Request(format!(
            "{found}; expected {MOST_LAYERS} at most; make it with fewer `--layers`"
        )));
    }
    let free = free_path(folder, |path| is_empty(path) || is_unchanged(path));
    let write = |new: &Path| write_files(new, ldi, layers);
    let (json, bytes) = match free.path.exists() && !is_empty(&free.path) {
        true => replace_folder_with(&free.path, write)?,
        false => create_folder_with(&free.path, write)?,
    };
    let depth_pixels = level.len() as u64;
    Ok(WrittenLayers {
        folder: free.path,
        spared: free.spared,
        layers,
        depth_pixels,
        bytes,
        error: json.error,
    })
}

/// Returns whether a path is an empty folder.
fn is_empty(path: &Path) -> bool {
    fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_none())
}

/// Returns whether this program wrote a folder and nobody has changed it since: no file is more, less or different.
fn is_unchanged(folder: &Path) -> bool {
    let Ok(bytes) = fs::read(folder.join(JSON)) else { return false };
    let Ok(json) = serde_json::from_slice::<LayersFile>(&bytes) else { return false };
    let Ok(entries) = fs::read_dir(folder) else { return false };
    let files: BTreeMap<&String, &String> = json.layers.iter().flat_map(|layer| &layer.files).collect();
    let names = entries.map(|entry| entry.map(|entry| entry.file_name().to_string_lossy().into_owned()));
    let Ok(names) = names.collect::<std::io::Result<Vec<String>>>() else { return false };
    let known = names.iter().all(|name| name == JSON || files.contains_key(name));
    let same =
        |(name, hash): (&&String, &&String)| hash_file(folder.join(name)).is_ok_and(|found| found == **hash);
    json.format == FORMAT && json.to_bytes() == bytes && known && files.iter().all(same)
}

/// Writes all files into a new folder; returns what `ldi.json` says, and their size in bytes.
fn write_files(folder: &Path, ldi: &Ldi, layers: usize) -> Result<(LayersFile, u64)> {
    let level = &ldi.levels[0];
    let depths = level.inverse_depths.iter().copied();
    let near = depths.clone().reduce(f32::max).unwrap_or(0.0);
    let far = depths.reduce(f32::min).unwrap_or(0.0);
    let written = (0..layers).into_par_iter().map(|layer| write_layer(folder, level, layer, [near, far]));
    let written = written.collect::<Vec<_>>().into_iter().collect::<Result<Vec<_>>>()?;
    let bytes: u64 = written.iter().map(|(_, bytes)| bytes).sum();
    let json = LayersFile {
        format: FORMAT.to_owned(),
        version: VERSION,
        inputs: ldi.inputs.clone(),
        kind: ldi.kind.name().to_owned(),
        camera: LdiCamera::of(&ldi.camera, &ldi.pose),
        photo_rect: ldi.photo_rect,
        gain: ldi.gain,
        near,
        far,
        mapping: MAPPING.to_owned(),
        error: DepthError::of(ldi, near, far),
        layers: written.into_iter().map(|(entry, _)| entry).collect(),
        surfaces: ldi.surfaces.iter().map(SurfaceEntry::of).collect(),
        sources: ldi.sources.clone(),
        report: ldi.report.clone(),
        hash: String::new(),
    };
    let text = json.to_bytes();
    write_atomically(folder.join(JSON), &text)?;
    Ok((json, bytes + text.len() as u64))
}

/// Writes the pictures of a layer; returns their size in bytes, too.
fn write_layer(
    folder: &Path,
    level: &ResolutionLevel,
    layer: usize,
    near_and_far: [f32; 2],
) -> Result<(LayerEntry, u64)> {
    let size = [level.camera.width, level.camera.height];
    let (held, samples) = samples(level, layer, near_and_far);
    let mut entry = LayerEntry { depth_pixels: held, files: BTreeMap::new() };
    let mut bytes = 0;
    for (picture, samples) in PictureKind::ALL.into_iter().zip(samples) {
        let name = picture.file_name(layer);
        let file = folder.join(&name);
        let png =
            picture.encoded(size, &samples).map_err(|error| Error::io(&file, "write it")(io_error(error)))?;
        write_atomically(&file, &png)?;
        bytes += png.len() as u64;
        entry.files.insert(name, hash_bytes(&png));
    }
    Ok((entry, bytes))
}

/// Returns the number of depth pixels of a layer and the samples of its pictures, all of them 0 where there is none.
fn samples(level: &ResolutionLevel, layer: usize, [near, far]: [f32; 2]) -> (u64, [Vec<u8>; 3]) {
    let width = level.camera.width as usize;
    let pixels = width * level.camera.height as usize;
    let [mut colours, mut depths, mut surfaces] = [4, 2, 6].map(|bytes| vec![0u8; bytes * pixels]);
    let mut held = 0;
    for y in 0..level.camera.height {
        for mut indices in level.layered_pixels(y) {
            let Some(index) = indices.nth(layer) else { continue };
            let at = y as usize * width + usize::from(level.columns[index]);
            let pixel = level.pixel(index);
            colours[4 * at..4 * at + 4].copy_from_slice(&pixel.colour);
            depths[2 * at..2 * at + 2]
                .copy_from_slice(&value_of(pixel.inverse_depth, near, far).to_be_bytes());
            let info = [pixel.surface, u16::from(pixel.splat.0), HELD].map(u16::to_be_bytes);
            surfaces[6 * at..6 * at + 6].copy_from_slice(info.as_flattened());
            held += 1;
        }
    }
    (held, [colours, depths, surfaces])
}

/// Returns the value of 16 bits that stands for an inverse depth.
fn value_of(inverse_depth: f32, near: f32, far: f32) -> u16 {
    let [depth, near, far] = [inverse_depth, near, far].map(f64::from);
    if near > far { ((depth - far) / (near - far) * NEAREST).round() as u16 } else { 0 }
}
