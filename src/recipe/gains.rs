//! The photos' exposure gains: estimated once from the photos themselves, then kept in `cache/`; what the
//! user decided about them comes on top, whenever they are used.

use std::f64::consts::LN_2;
use std::path::Path;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::budget::Budget;
use crate::document::{Colour, Stack};
use crate::error::{Error, Result};
use crate::io::atomic::write_atomically;
use crate::io::hash::hash_bytes;
use crate::io::json::{read_json, to_json};
use crate::io::photo::read_shown;
use crate::projection::exposure::patch::patch_colour;
use crate::projection::exposure::{Estimate, ExposureOptions, PatchColour, RayVisibility, estimate_gains};
use crate::projection::{Gains, PhotoId, Projector};
use crate::scene::{Photo, Site};
use crate::task::Task;

/// `cache/gains.json`.
#[derive(Debug, Serialize, Deserialize)]
struct Kept {
    version: u32,
    /// Hash of all that they were made of.
    inputs: String,
    /// In the site's order.
    photos: Vec<String>,
    estimate: Estimate,
}

/// Of the file.
const VERSION: u32 = 3;
/// Of what [`inputs`] hashes, and of what is made of it.
const INPUTS_VERSION: u32 = 1;
const LARGEST: u64 = 64 << 20;

/// The gains that a project's photos are shown and filled with, in the site's order: the estimate
/// ([`photo_estimate`]) and what `colour` says against it.
///
/// # Errors
/// As [`photo_estimate`].
pub fn photo_gains(
    site: &Site,
    stacks: &[Option<Stack>],
    colour: &Colour,
    folder: &Path,
    memory: u64,
    task: &Task,
) -> Result<Gains> {
    if !colour.even {
        return Ok(Gains::none(site.photos.len()));
    }
    let estimate = photo_estimate(site, stacks, colour, folder, memory, task)?;
    Ok(decided_gains(&estimate, colour, site))
}

/// The estimate in `cache/` if it was made of the same stacks and the same photos were left out, else a new
/// one, which is put there. `stacks` as in the site; only what they were made of is looked at. A photo that
/// cannot be read is noted and gets gain 0. `memory`: bytes that photos decoded at the same time may take.
///
/// # Errors
/// [`Error::Cancelled`]. A cache that cannot be written is a note.
pub fn photo_estimate(
    site: &Site,
    stacks: &[Option<Stack>],
    colour: &Colour,
    folder: &Path,
    memory: u64,
    task: &Task,
) -> Result<Estimate> {
    let file = folder.join("cache/gains.json");
    let inputs = estimate_inputs(site, stacks, colour);
    if let Some(kept) = kept_estimate(&file, &inputs) {
        return Ok(kept);
    }
    let estimate = estimate_of_photos(site, colour, memory, task)?;
    if let Err(error) = keep(&file, inputs, site, &estimate) {
        task.note(format!("the gains cannot be cached: {error}"));
    }
    Ok(estimate)
}

/// What `colour` makes of an estimate: fixed gains in the place of estimated ones, the others as they are; none where
/// exposures are not evened out.
pub fn decided_gains(estimate: &Estimate, colour: &Colour, site: &Site) -> Gains {
    if !colour.even {
        return Gains::none(site.photos.len());
    }
    let mut gains = estimate.gains.clone();
    for (photo, gain) in site.photos.iter().zip(&mut gains.of_photo) {
        if let Some(stops) = colour.fixed.get(&photo.name) {
            *gain = stops.map(|stops| stops * LN_2);
        }
    }
    gains
}

/// The estimate from the photos' files, whatever is in the cache. Photos that `colour` leaves out are not
/// looked at.
///
/// # Errors
/// [`Error::Cancelled`].
pub fn estimate_of_photos(site: &Site, colour: &Colour, memory: u64, task: &Task) -> Result<Estimate> {
    let projector =
        |photo: &Photo| Projector { name: photo.name.clone(), camera: photo.camera, pose: photo.pose };
    let projectors: Vec<Projector> = site.photos.iter().map(projector).collect();
    let Colour { vignetting, offset, .. } = *colour;
    let options = ExposureOptions { vignetting, offset, ..ExposureOptions::default() };
    let budget = Budget::new(memory);
    let colours = |photo: PhotoId, centers: &[DVec2]| {
        let photo = &site.photos[photo.0 as usize];
        if colour.left_out.contains(&photo.name) {
            return Ok(vec![None; centers.len()]);
        }
        let measured = budget.with(decoded_bytes(photo), || colours_of(photo, centers, &options, task));
        measured.or_else(|error| unmeasured(photo, centers, &error, task))
    };
    let visibility = RayVisibility::new(&site.model, &projectors);
    estimate_gains(&projectors, &visibility, &colours, &options, task)
}

/// What a decoder holds at once: input, samples, and a copy while they are turned.
fn decoded_bytes(photo: &Photo) -> u64 {
    u64::from(photo.camera.width) * u64::from(photo.camera.height) * 8
}

fn colours_of(
    photo: &Photo,
    centers: &[DVec2],
    options: &ExposureOptions,
    task: &Task,
) -> Result<Vec<PatchColour>> {
    task.go_on()?;
    let pixels = read_shown(photo)?;
    Ok(centers.iter().map(|center| patch_colour(&pixels, *center, options.half_patch_px)).collect())
}

fn unmeasured(photo: &Photo, centers: &[DVec2], error: &Error, task: &Task) -> Result<Vec<PatchColour>> {
    task.go_on()?;
    task.of(&photo.name).note(format!("the exposure of this photo is unknown: {error}"));
    Ok(vec![None; centers.len()])
}

/// Stacks know what they were made of: pixels, camera, model, program. What was decided about their layers
/// changes nothing here. Photos without one are told by
/// their camera alone; once they have a stack the gains are made anew.
pub(super) fn inputs(site: &Site, stacks: &[Option<Stack>]) -> String {
    let of_photo = |(photo, stack): (&Photo, &Option<Stack>)| {
        let camera = (photo.camera.width, photo.camera.height, photo.camera.matrix_rows());
        let pose = (photo.pose.rotation_rows(), photo.pose.translation);
        (photo.name.clone(), camera, pose, stack.as_ref().map(|stack| stack.ground().to_owned()))
    };
    let photos: Vec<_> = site.photos.iter().zip(stacks).map(of_photo).collect();
    let text =
        serde_json::to_vec(&(env!("CARGO_PKG_VERSION"), INPUTS_VERSION, photos)).expect("plain data is JSON");
    hash_bytes(&text)
}

/// What was decided about the gains themselves, not about the exposure of pictures; empty where nothing was.
pub(super) fn decisions(colour: &Colour) -> String {
    let of_gains = Colour { reference: None, ..colour.clone() };
    if of_gains.is_default() {
        String::new()
    } else {
        serde_json::to_string(&of_gains).expect("plain data is JSON")
    }
}

/// [`inputs`], the photos of the site that are left out, and what else is estimated.
fn estimate_inputs(site: &Site, stacks: &[Option<Stack>], colour: &Colour) -> String {
    let left_out = site.photos.iter().map(|photo| colour.left_out.contains(&photo.name));
    let left_out: Vec<bool> = left_out.collect();
    let text = serde_json::to_vec(&(inputs(site, stacks), left_out, colour.vignetting, colour.offset))
        .expect("plain data is JSON");
    hash_bytes(&text)
}

/// A cache that is missing, broken or of something else is no cache.
fn kept_estimate(file: &Path, inputs: &str) -> Option<Estimate> {
    let kept: Kept = read_json(file, LARGEST, "it is computed again").ok()?;
    (kept.version == VERSION && kept.inputs == inputs).then_some(kept.estimate)
}

fn keep(file: &Path, inputs: String, site: &Site, estimate: &Estimate) -> Result<()> {
    let folder = file.parent().expect("it lies in cache/");
    std::fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    let photos = site.photos.iter().map(|photo| photo.name.clone()).collect();
    let kept = Kept { version: VERSION, inputs, photos, estimate: estimate.clone() };
    write_atomically(file, &to_json(&kept))
}
