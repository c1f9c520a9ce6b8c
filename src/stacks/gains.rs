//! The photos' exposure gains, estimated once from the photos and then cached in `cache/`. The user's decisions are
//! applied to them whenever they are used.

use std::borrow::Borrow;
use std::f64::consts::LN_2;
use std::path::{Path, PathBuf};

use glam::DVec2;

use quadratura_base::error::{Error, Message, Result};
use quadratura_base::scene::{Photo, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::{ColourDecisions, Stack};
use quadratura_files::cached::{CachedKind, read_cached, write_cached};
use quadratura_files::hash::hash_bytes;
use quadratura_io::unmasked::read_unmasked;
use quadratura_projection::exposure::patch::patch_colour;
use quadratura_projection::exposure::{
    Estimate, ExposureOptions, LightGroups, MeasuredColours, PatchColour, RayVisibility, Vignetting,
    estimate_gains,
};
use quadratura_projection::{Gains, Projector};
use quadratura_sites::budget::Budget;
use quadratura_sites::shared::Shared;

/// The file `cache/gains.bin`.
const CACHED: CachedKind = CachedKind { name: "gains", version: 10 };

/// The version of the data that [`inputs`] hashes, and of the results that are made from them.
const INPUTS_VERSION: u32 = 3;

/// Returns the gains with which a project's photos are shown and used for filling, in the site's order: the
/// estimate ([`photo_estimate`]) with the decisions in `colour` applied.
///
/// # Errors
/// Returns the errors of [`photo_estimate`].
pub fn photo_gains(
    site: &Site,
    stacks: &[Option<impl Borrow<Stack>>],
    colour: &ColourDecisions,
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

/// Returns the cached estimate if it was made from the same stacks and without the same photos; otherwise estimates
/// the gains and caches them. `stacks` are in the site's order; only their input hashes are used. A photo that
/// cannot be read is noted and gets gain 0. `memory` is the budget in bytes for photos decoded at the same time.
///
/// # Errors
/// Returns [`Error::Cancelled`] when the task was cancelled. A cache that cannot be written is only noted.
pub fn photo_estimate(
    site: &Site,
    stacks: &[Option<impl Borrow<Stack>>],
    colour: &ColourDecisions,
    folder: &Path,
    memory: u64,
    task: &Task,
) -> Result<Estimate> {
    let _lock = match Shared::find(folder, || known_estimate(site, stacks, colour, folder), task)? {
        Shared::Known(known) => return Ok(known),
        Shared::Missing(lock) => lock,
    };
    let estimate = estimate_of_photos(site, colour, memory, task)?;
    let inputs = estimate_inputs(site, stacks, colour);
    if let Err(error) = write_cached(&cached_file(folder), CACHED, &inputs, &estimate) {
        task.note(Message::from("the gains cannot be cached: ").and(&error));
    }
    Ok(estimate)
}

/// Applies decisions to an estimate: fixed gains replace estimated ones. All gains are 0 where exposures are not
/// matched.
pub fn decided_gains(estimate: &Estimate, colour: &ColourDecisions, site: &Site) -> Gains {
    if !colour.even {
        return Gains::none(site.photos.len());
    }
    let mut gains = estimate.gains.clone();
    decide(&mut gains, colour, site);
    if let Some(blended) = &mut gains.light.blended {
        decide(blended, colour, site);
    }
    gains
}

/// Applies the rule that the user has set, and the gains of photos that are fixed; optics and groups stay as estimated.
fn decide(gains: &mut Gains, colour: &ColourDecisions, site: &Site) {
    gains.rule = colour.exposure.unwrap_or(gains.rule);
    for (photo, gain) in site.photos.iter().zip(&mut gains.of_photo) {
        if let Some(stops) = colour.fixed.get(&photo.name) {
            *gain = stops.map(|stops| stops * LN_2);
        }
    }
}

/// Estimates the gains from the photos' files, whatever is cached. Photos that `colour` leaves out are not read.
///
/// # Errors
/// Returns [`Error::Cancelled`] when the task was cancelled.
pub fn estimate_of_photos(
    site: &Site,
    colour: &ColourDecisions,
    memory: u64,
    task: &Task,
) -> Result<Estimate> {
    let measured = measured_colours(site, colour, memory, task)?;
    Ok(task.timed("estimate gains", || estimated(site, &measured, &[], colour)))
}

/// Estimates the gains from measured colours, as if the site did not have the photos in `left_out`.
fn estimated(
    site: &Site,
    measured: &MeasuredColours,
    left_out: &[PhotoId],
    colour: &ColourDecisions,
) -> Estimate {
    let groups = decided_groups(colour, site);
    let mut estimate =
        estimate_gains(&projectors(site), measured, left_out, groups.as_ref(), &options(colour));
    round(&mut estimate.gains);
    estimate
}

/// Rounds gains and optics to steps that nobody sees, half a step of 8 bits in white. All gains are estimated together, so a
/// mask in one photo moves all of them a little; rounded, most stay what they were, and what was made with them holds.
fn round(gains: &mut Gains) {
    const STEPS: f64 = 512.0;
    /// Light added everywhere is seen in the dark, where a step of 8 bits is a thirteenth of that in white.
    const OFFSET_STEPS: f64 = 32768.0;
    let rounded = |value: &mut f64| *value = (*value * STEPS).round() / STEPS;
    gains.of_photo.iter_mut().flatten().for_each(rounded);
    for optics in &mut gains.optics {
        optics.falloff.iter_mut().for_each(rounded);
        optics.offset = (optics.offset * OFFSET_STEPS).round() / OFFSET_STEPS;
    }
    gains.light.blended.iter_mut().for_each(|blended| round(blended));
}

/// Returns the groups of light that are decided; `None` where they are found.
pub fn decided_groups(colour: &ColourDecisions, site: &Site) -> Option<LightGroups> {
    let groups = colour.groups.as_ref()?;
    let group = |photo: &Photo| groups.values().position(|photos| photos.contains(&photo.name));
    let of_photo: Vec<u32> =
        site.photos.iter().map(|photo| group(photo).map_or(0, |at| at as u32 + 1)).collect();
    Some(LightGroups::new(&of_photo))
}

/// Returns the cached estimate of a site, if it is that of these stacks and decisions. Nothing is computed.
pub fn known_estimate(
    site: &Site,
    stacks: &[Option<impl Borrow<Stack>>],
    colour: &ColourDecisions,
    folder: &Path,
) -> Option<Estimate> {
    read_cached(&cached_file(folder), CACHED, &estimate_inputs(site, stacks, colour))
}

fn cached_file(folder: &Path) -> PathBuf {
    folder.join("cache/gains.bin")
}

/// Measures the photos' colours at common surface points. Photos that `colour` leaves out are not read.
///
/// # Errors
/// Returns [`Error::Cancelled`] when the task was cancelled.
pub fn measured_colours(
    site: &Site,
    colour: &ColourDecisions,
    memory: u64,
    task: &Task,
) -> Result<MeasuredColours> {
    let projectors = projectors(site);
    let options = options(colour);
    let budget = Budget::new(memory);
    let colours = |photo: PhotoId, centers: &[DVec2]| {
        let photo = site.photo(photo);
        if colour.left_out.contains(&photo.name) {
            return Ok(vec![None; centers.len()]);
        }
        let measured = budget.with(decoded_bytes(photo), || colours_of(photo, centers, &options, task));
        measured.or_else(|error| unmeasured(photo, centers, &error, task))
    };
    let visibility = RayVisibility::new(&site.model, &projectors);
    let measured = MeasuredColours::measure(&projectors, &visibility, &colours, &options, task)?;
    Ok(MeasuredColours { camera_logs: camera_logs(site, colour), ..measured })
}

/// Returns the exposures that cameras wrote down, as natural logarithms, but for photos that `colour` leaves out.
fn camera_logs(site: &Site, colour: &ColourDecisions) -> Vec<Option<f64>> {
    let log = |photo: &Photo| photo.exposure.filter(|_| !colour.left_out.contains(&photo.name))?.log();
    site.photos.iter().map(log).collect()
}

fn projectors(site: &Site) -> Vec<Projector> {
    let projector =
        |photo: &Photo| Projector { name: photo.name.clone(), camera: photo.camera, pose: photo.pose };
    site.photos.iter().map(projector).collect()
}

fn options(colour: &ColourDecisions) -> ExposureOptions {
    let vignetting = match colour.vignetting {
        None => Vignetting::Kept,
        Some(true) => Vignetting::Removed,
        Some(false) => Vignetting::Ignored,
    };
    let offset = colour.offset;
    ExposureOptions { vignetting, offset, ..ExposureOptions::default() }
}

/// The gains of a site, and of the site without some of its photos.
pub struct SiteGains {
    site: Site,
    colour: ColourDecisions,
    memory: u64,
    whole: Gains,
    /// The measured colours, once they were needed.
    measured: Option<MeasuredColours>,
}

impl SiteGains {
    /// Returns the gains as [`photo_gains`] does.
    ///
    /// # Errors
    /// Returns the errors of [`photo_gains`].
    pub fn open(
        site: &Site,
        stacks: &[Option<impl Borrow<Stack>>],
        colour: &ColourDecisions,
        folder: &Path,
        memory: u64,
        task: &Task,
    ) -> Result<Self> {
        let whole = photo_gains(site, stacks, colour, folder, memory, task)?;
        Ok(Self { site: site.clone(), colour: colour.clone(), memory, whole, measured: None })
    }

    /// Returns gains of 0, with and without any photos.
    pub fn none(site: &Site) -> Self {
        let colour = ColourDecisions { even: false, ..ColourDecisions::default() };
        Self { site: site.clone(), colour, memory: 0, whole: Gains::none(site.photos.len()), measured: None }
    }

    /// Replaces the gains estimated from all photos, after a decision.
    pub fn replace_whole(&mut self, gains: Gains) {
        self.whole = gains;
    }

    /// Returns the gains estimated from all photos.
    pub fn whole(&self) -> &Gains {
        &self.whole
    }

    /// Returns the gains that are estimated as if the site did not have these photos, whose own gains are 0 then.
    ///
    /// # Errors
    /// Returns the errors of [`photo_gains`].
    pub fn without(&mut self, photos: &[PhotoId], task: &Task) -> Result<Gains> {
        if photos.is_empty() || !self.colour.even {
            return Ok(self.whole.clone());
        }
        let measured = match self.measured.take() {
            Some(measured) => measured,
            None => measured_colours(&self.site, &self.colour, self.memory, task)?,
        };
        let measured = self.measured.insert(measured);
        let estimate = estimated(&self.site, measured, photos, &self.colour);
        Ok(decided_gains(&estimate, &self.colour, &self.site))
    }
}

/// Returns the memory of a decoder in bytes: the input, the samples, and a copy while they are rotated.
fn decoded_bytes(photo: &Photo) -> u64 {
    u64::from(photo.camera.width) * u64::from(photo.camera.height) * 8
}

/// Measures a photo's colours around the given points.
fn colours_of(
    photo: &Photo,
    centers: &[DVec2],
    options: &ExposureOptions,
    task: &Task,
) -> Result<Vec<PatchColour>> {
    task.check_cancelled()?;
    let pixels = read_unmasked(photo)?;
    Ok(centers.iter().map(|center| patch_colour(&pixels, *center, options.half_patch_px)).collect())
}

/// Notes a photo that cannot be read, and returns no colours for it, unless the task was cancelled. The reason is a
/// detail, because whatever builds the photo's stack fails with it.
fn unmeasured(photo: &Photo, centers: &[DVec2], error: &Error, task: &Task) -> Result<Vec<PatchColour>> {
    task.check_cancelled()?;
    let task = task.with_subject(&photo.name);
    task.note("the exposure of this photo is unknown, because it cannot be read");
    task.detail(error.to_string());
    Ok(vec![None; centers.len()])
}

/// Returns the hash of what an estimate depends on. Stacks contain the hash of their pixels, camera, model and
/// program; decisions about layers have no influence. Photos without a stack are represented by their camera alone,
/// so the gains are estimated again once they have one.
pub fn inputs(site: &Site, stacks: &[Option<impl Borrow<Stack>>]) -> String {
    inputs_of_stamps(site, &stamps(stacks))
}

/// Returns the same of the inputs of the photos' stacks ([`Stack::inputs`]), in the site's order.
pub fn inputs_of_stamps(site: &Site, stamps: &[Option<String>]) -> String {
    let photos: Vec<_> =
        site.photos.iter().zip(stamps).map(|(photo, stamp)| of_photo(photo, stamp)).collect();
    let text = serde_json::to_vec(&(env!("CARGO_PKG_VERSION"), INPUTS_VERSION, photos));
    hash_bytes(&text.expect("plain data is JSON"))
}

/// Returns what each stack was made from.
pub fn stamps(stacks: &[Option<impl Borrow<Stack>>]) -> Vec<Option<String>> {
    stacks.iter().map(|stack| stack.as_ref().map(|stack| stack.borrow().inputs().to_owned())).collect()
}

/// Returns the same for each photo, in the site's order.
pub fn photo_inputs(site: &Site, stacks: &[Option<impl Borrow<Stack>>]) -> Vec<String> {
    let hash = |(photo, stamp): (&Photo, &Option<String>)| {
        let text = serde_json::to_vec(&(env!("CARGO_PKG_VERSION"), INPUTS_VERSION, of_photo(photo, stamp)));
        hash_bytes(&text.expect("plain data is JSON"))
    };
    site.photos.iter().zip(&stamps(stacks)).map(hash).collect()
}

/// Returns what [`inputs`] hashes of a photo with the inputs of its stack.
fn of_photo(photo: &Photo, stamp: &Option<String>) -> impl serde::Serialize {
    let camera = (photo.camera.width, photo.camera.height, photo.camera.matrix_rows());
    let pose = (photo.pose.rotation_rows(), photo.pose.translation);
    (photo.name.clone(), camera, pose, stamp.clone())
}

/// Returns the decisions about the gains themselves, without the exposure of views, as JSON; empty where there are
/// none.
pub fn decisions(colour: &ColourDecisions) -> String {
    let of_gains = ColourDecisions { reference: None, exposure: None, ..colour.clone() };
    if of_gains.is_default() {
        String::new()
    } else {
        serde_json::to_string(&of_gains).expect("plain data is JSON")
    }
}

/// Returns the hash of [`inputs`], of which photos are left out, of what cameras wrote down, and of which corrections are estimated.
fn estimate_inputs(site: &Site, stacks: &[Option<impl Borrow<Stack>>], colour: &ColourDecisions) -> String {
    let left_out = site.photos.iter().map(|photo| colour.left_out.contains(&photo.name));
    let left_out: Vec<bool> = left_out.collect();
    let (groups, camera) = (&colour.groups, camera_logs(site, colour));
    let text = serde_json::to_vec(&(
        inputs(site, stacks),
        left_out,
        camera,
        colour.vignetting,
        colour.offset,
        groups,
    ))
    .expect("plain data is JSON");
    hash_bytes(&text)
}
