//! The photos' exposures as the user sees and decides them: a table, and edits of `colour` in
//! `project.json`.

use std::collections::BTreeMap;
use std::f64::consts::LN_2;
use std::path::Path;

use serde::Serialize;

use super::budget::default_memory;
use super::gains::{photo_estimate, photo_gains};
use super::named::place_of_photo;
use super::open::Opened;
use crate::document::{Colour, Stack};
use crate::error::{Error, Result};
use crate::io::stack_store::StackStore;
use crate::projection::exposure::Estimate;
use crate::projection::{Exposure, PhotoId};
use crate::scene::Site;
use crate::task::Task;

/// One decision. Photos are named as people type them ([`place_of_photo`]).
#[derive(Debug, Clone, PartialEq)]
pub enum ColourEdit {
    /// Nothing is decided any more.
    Reset,
    /// The photo's gain, in stops, R, G, B ([`Colour::fixed`]).
    Fix(String, [f64; 3]),
    /// The photo is not asked when gains are estimated.
    LeaveOut(String),
    /// Nothing is decided about the photo's gain any more.
    Free(String),
    /// The photo whose exposure pictures come out with; none: that of the photos near by.
    Reference(Option<String>),
    /// Exposures are evened out, or photos taken as they are.
    Even(bool),
    /// Falling off of light towards the corners is taken out, or not.
    Vignetting(bool),
    /// Light that was added everywhere is taken out, or not.
    Offset(bool),
}

/// `colour` after the edits, one after the other.
///
/// # Errors
/// [`Error::Request`] for photos that the site does not have, all at once, and for gains out of range.
pub fn edited(colour: &Colour, edits: &[ColourEdit], site: &Site) -> Result<Colour> {
    let mut edited = colour.clone();
    let errors = edits.iter().filter_map(|edit| apply(&mut edited, edit, site).err()).collect();
    match (Error::of_all(errors), edited.problem()) {
        (Some(error), _) => Err(error),
        (None, Some(problem)) => Err(Error::Request(problem)),
        (None, None) => Ok(edited),
    }
}

fn apply(colour: &mut Colour, edit: &ColourEdit, site: &Site) -> Result<()> {
    let full = |name: &str| Ok(site.photos[place_of_photo(site, name)?].name.clone());
    match edit {
        ColourEdit::Reset => *colour = Colour::default(),
        ColourEdit::Fix(photo, stops) => drop(colour.fixed.insert(full(photo)?, *stops)),
        ColourEdit::LeaveOut(photo) => drop(colour.left_out.insert(full(photo)?)),
        // Decisions outlive their photos: what is written may be taken back by its whole name.
        ColourEdit::Free(photo) if colour.named().contains(photo.as_str()) => colour.free(photo),
        ColourEdit::Free(photo) => colour.free(&full(photo)?),
        ColourEdit::Reference(photo) => colour.reference = photo.as_deref().map(full).transpose()?,
        ColourEdit::Even(even) => colour.even = *even,
        ColourEdit::Vignetting(vignetting) => colour.vignetting = *vignetting,
        ColourEdit::Offset(offset) => colour.offset = *offset,
    }
    Ok(())
}

/// The exposure that pictures of the project come out with, if nothing else is asked for: the
/// reference's, where there is one, else that of the photos near each view.
pub fn usual_exposure(opened: &Opened) -> Exposure {
    reference(&opened.project.colour, &opened.site).map_or(Exposure::Near, Exposure::Of)
}

/// The reference, if the site has it.
pub fn reference(colour: &Colour, site: &Site) -> Option<PhotoId> {
    let name = colour.reference.as_ref()?;
    let place = site.photos.iter().position(|photo| photo.name == *name)?;
    Some(PhotoId(place as u32))
}

/// What the photos' linear colours have to be multiplied with to come out alike, R, G, B, by name: as the
/// reference has it, where there is one, else in the common exposure.
///
/// # Errors
/// [`Error::Cancelled`].
pub fn even_factors(folder: &Path, opened: &Opened, task: &Task) -> Result<BTreeMap<String, [f64; 3]>> {
    let Opened { site, project, .. } = opened;
    let stacks = stacks(folder, site);
    let gains = photo_gains(site, &stacks, &project.colour, folder, default_memory(), task)?.of_photo;
    let names = site.photos.iter().map(|photo| photo.name.clone());
    Ok(names.zip(factors(&gains, &project.colour, site)).collect())
}

/// What the photos' linear colours have to be multiplied with to come out alike, R, G, B, in the site's order. `gains`:
/// the photos' own, as natural logarithms.
pub fn factors(gains: &[[f64; 3]], colour: &Colour, site: &Site) -> Vec<[f64; 3]> {
    let to = reference(colour, site).map_or([0.0; 3], |photo| gains[photo.0 as usize]);
    gains.iter().map(|gain| [0, 1, 2].map(|c| (to[c] - gain[c]).exp())).collect()
}

/// The photos' exposures. Logarithms are in stops: factors of 2 in linear light.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ColourReport {
    /// Exposures are evened out.
    pub even: bool,
    /// Vignetting or offsets are taken out.
    pub optics: bool,
    /// In the site's order.
    pub photos: Vec<PhotoColour>,
    /// Surface points that two photos or more show.
    pub points: usize,
    /// Comparisons of two photos at a point.
    pub pairs: usize,
    /// Groups of photos that share points: between groups nothing is known.
    pub groups: usize,
    /// Median absolute log ratio, R, G, B, photos as they are.
    pub before: [f64; 3],
    /// The same once the estimated gains are taken out.
    pub after: [f64; 3],
    /// How much exposures follow what a meter reads, R, G, B: 0 not at all, 1 wholly.
    pub metered: [f64; 3],
}

/// One photo's.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhotoColour {
    /// Its name.
    pub photo: String,
    /// By how much it is brighter than the common exposure, R, G, B, as it is shown and filled with.
    pub stops: [f64; 3],
    /// What the photos themselves say; none where it shares no point with another one.
    pub estimated: Option<[f64; 3]>,
    /// The gain was decided.
    pub fixed: bool,
    /// It takes no part in the estimate.
    pub left_out: bool,
    /// Pictures come out with its exposure.
    pub reference: bool,
    /// By how much its corners are darker than its middle.
    pub corner: f64,
    /// Light that was added everywhere, of white; linear, not in stops.
    pub offset: f64,
    /// Surface points that it shares with others.
    pub points: u32,
    /// Median of the absolute log ratios that the estimate leaves.
    pub residual: f64,
}

/// Estimates the exposures, or takes them from `cache/`, and says what holds for each photo.
///
/// # Errors
/// [`Error::Cancelled`].
pub fn colour_report(folder: &Path, opened: &Opened, task: &Task) -> Result<ColourReport> {
    let Opened { site, project, .. } = opened;
    note_strangers(&project.colour, site, task);
    let estimate = estimate(folder, opened, &project.colour, task)?;
    Ok(told_of(&estimate, &project.colour, site))
}

/// What holds for each photo by an estimate and what was decided.
pub fn told_of(estimate: &Estimate, colour: &Colour, site: &Site) -> ColourReport {
    let photos = (0..site.photos.len()).map(|place| photo_colour(place, site, colour, estimate));
    ColourReport {
        even: colour.even,
        optics: colour.vignetting || colour.offset,
        photos: photos.collect(),
        points: estimate.points,
        pairs: estimate.pairs,
        groups: estimate.components,
        before: estimate.before.map(in_stops),
        after: estimate.after.map(in_stops),
        metered: estimate.gains.meter.follows,
    }
}

/// Estimates the exposures, or takes them from `cache/`, for [`told_of`] and [`super::gains::decided_gains`].
///
/// # Errors
/// [`Error::Cancelled`].
pub fn estimate(folder: &Path, opened: &Opened, colour: &Colour, task: &Task) -> Result<Estimate> {
    let stacks = stacks(folder, &opened.site);
    photo_estimate(&opened.site, &stacks, colour, folder, default_memory(), task)
}

fn in_stops(log: f64) -> f64 {
    log / LN_2
}

fn photo_colour(place: usize, site: &Site, colour: &Colour, estimate: &Estimate) -> PhotoColour {
    let id = PhotoId(place as u32);
    let name = &site.photos[place].name;
    let estimated = estimate.gains.of_photo[place].map(in_stops);
    let fixed = colour.fixed.get(name).copied();
    PhotoColour {
        photo: name.clone(),
        stops: if colour.even { fixed.unwrap_or(estimated) } else { [0.0; 3] },
        estimated: (!estimate.alone.contains(&id)).then_some(estimated),
        fixed: fixed.is_some(),
        left_out: colour.left_out.contains(name),
        reference: reference(colour, site) == Some(id),
        corner: in_stops(-estimate.gains.optics[place].log_light(1.0)),
        offset: estimate.gains.optics[place].offset,
        points: estimate.grounds[place].points,
        residual: in_stops(estimate.grounds[place].residual),
    }
}

/// A decision about a photo that is not there now holds again once it is back.
fn note_strangers(colour: &Colour, site: &Site, task: &Task) {
    let known = |name: &&str| site.photos.iter().any(|photo| photo.name == *name);
    for name in colour.named().into_iter().filter(|name| !known(name)) {
        task.note(format!(
            "project.json has colour settings for {name}, which is not among the photos \
             (`quadratura colour --free {name}` removes them)"
        ));
    }
}

/// The current stacks, which the cache is known by; a broken one is as good as none here.
fn stacks(folder: &Path, site: &Site) -> Vec<Option<Stack>> {
    let store = StackStore::new(folder);
    site.photos.iter().map(|photo| store.current(&photo.name).ok().flatten()).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DMat3, DVec3};

    use super::*;
    use crate::geometry::Pose;
    use crate::scene::synthetic::centred;
    use crate::scene::{Model, Photo};

    fn site() -> Site {
        let photo = |name: &str| Photo {
            name: name.into(),
            camera: centred(4, 3, 3.0),
            pose: Pose { rotation: DMat3::IDENTITY, translation: DVec3::ZERO },
            file: "nowhere".into(),
            masks: Vec::new(),
        };
        Site { photos: ["a.jpg", "b.jpg"].map(photo).to_vec(), model: Arc::new(Model::default()) }
    }

    #[test]
    fn edits_are_kept_by_whole_names_and_each_can_be_taken_back() {
        use ColourEdit::{Even, Fix, Free, LeaveOut, Reference, Reset};
        let edits =
            [Fix("a".into(), [0.5; 3]), LeaveOut("b".into()), Reference(Some("b".into())), Even(false)];
        let all = edited(&Colour::default(), &edits, &site()).unwrap();
        assert!(all.fixed["a.jpg"] == [0.5; 3] && all.left_out.contains("b.jpg") && !all.even);
        assert_eq!(reference(&all, &site()), Some(PhotoId(1)));
        let back = [Free("a".into()), Free("b".into()), Reference(None), Even(true)];
        assert!(edited(&all, &back, &site()).unwrap().is_default());
        assert!(edited(&all, &[Reset], &site()).unwrap().is_default());
    }

    #[test]
    fn wrong_names_are_told_all_at_once_and_a_photo_that_is_gone_can_be_forgotten() {
        let wrong = [ColourEdit::LeaveOut("x".into()), ColourEdit::Fix("y".into(), [0.0; 3])];
        let told = edited(&Colour::default(), &wrong, &site()).unwrap_err().to_string();
        assert!(told.contains("no photo x") && told.contains("no photo y"), "{told}");
        let mut colour = Colour::default();
        colour.left_out.insert("gone.jpg".into());
        let free = [ColourEdit::Free("gone.jpg".into())];
        assert!(edited(&colour, &free, &site()).unwrap().is_default());
    }
}
